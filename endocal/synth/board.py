"""A pattern seen through a lens of the division model, or a fisheye, with its truth.

Every sample of the distorted picture is undistorted (eq. 4) and carried to the pattern's plane, where the
pattern is known exactly: no picture is ever resampled, so edges lie where the model puts them.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from ..errors import UsageError
from ..model import DivisionModel, Points
from .camera import Camera, ContentCircle, Light, Picture, to_grey_levels
from .fisheye import Fisheye
from .noise import fractal_noise
from .objects import Highlight, Instrument
from .pattern import BACKGROUND, Pattern, Pose
from .rays import offsets, pixel_rays
from .sampling import Coordinates, pixel_averages

Homography = NDArray[np.float64]


@dataclass(frozen=True)
class Overlay:
    """Text that a recorder burns into the picture; ``position`` (x, y) px is its lower left corner."""

    text: str
    position: tuple[int, int]
    scale: float = 0.5
    level: int = 235


@dataclass(frozen=True)
class BoardScene:
    """Everything that makes one picture of a pattern.

    Instruments are painted through a division model only.
    ``clutter`` is the relative depth of the background's random cloudiness, 0 to 1. ``comb`` (dx, dy) is
    how far the scene moves between the two fields of an interlaced frame, in undistorted px: half back
    for the even rows, half on for the odd ones; (0, 0) is a progressive frame.
    """

    model: DivisionModel | Fisheye
    pattern: Pattern
    pose: Pose
    circle: ContentCircle | None = None
    camera: Camera = field(default_factory=Camera)
    instruments: tuple[Instrument, ...] = ()
    highlights: tuple[Highlight, ...] = ()
    overlays: tuple[Overlay, ...] = ()
    clutter: float = 0.0
    comb: tuple[float, float] = (0.0, 0.0)
    seed: int = 0

    @property
    def division(self) -> DivisionModel:
        """The lens, which is a division model; UsageError where it is another one."""
        if isinstance(self.model, DivisionModel):
            return self.model
        raise UsageError("the scene's lens is a fisheye: no division model is its truth")


def render_board(scene: BoardScene) -> Picture:
    """Render the picture: uint8, (h, w) grey, or (h, w, 3) BGR where the camera has a tint."""
    rng = np.random.default_rng(scene.seed)
    camera, model = scene.camera, scene.model
    background = _cloudy_background(scene, rng)

    def seen(shift: tuple[float, float]) -> Light:
        light = board_light(scene, background, shift)
        return camera.focus(light, scene.circle, model.pixel_aspect)

    if scene.comb == (0.0, 0.0):
        light = seen((0.0, 0.0))
    else:
        dx, dy = scene.comb[0] / 2, scene.comb[1] / 2
        light = seen((-dx, -dy))
        light[1::2] = seen((dx, dy))[1::2]
    level = camera.expose(light, scene.circle, model.pixel_aspect, rng)
    picture = to_grey_levels(level)
    for item in scene.overlays:
        color = (item.level,) * (3 if picture.ndim == 3 else 1)
        cv2.putText(picture, item.text, item.position, cv2.FONT_HERSHEY_SIMPLEX, item.scale, color)
    return camera.compress(picture)


def true_corners(scene: BoardScene) -> tuple[Points, NDArray[np.bool_]]:
    """Where the inner corners are seen, (rows - 1, cols - 1, 2) distorted px, and which are visible."""
    points = project(scene, scene.pattern.inner_corners())
    return points, visible(scene, points)


def true_lines(scene: BoardScene, samples: int = 200) -> list[Points]:
    """Points along each inner line, (n, 2) distorted px each: the visible ones of ``samples``, at least 2."""
    found = []
    for line in scene.pattern.lines(samples):
        points = project(scene, line)
        points = points[visible(scene, points)]
        if len(points) >= 2:
            found.append(points)
    return found


def project(scene: BoardScene, plane: Points) -> Points:
    """Map plane coordinates (..., 2), in squares, to distorted px; NaN where they are behind the camera."""
    model = scene.model
    image = np.concatenate([plane, np.ones_like(plane[..., :1])], -1) @ homography(scene).T
    with np.errstate(divide="ignore", invalid="ignore"):
        offset = np.where(image[..., 2:] > 0, image[..., :2] / image[..., 2:], np.nan)
    return model.distort(offset / (model.pixel_aspect, 1.0) + model.center)


def plane_coordinates(scene: BoardScene, points: Points) -> Points:
    """Map distorted px (..., 2) to plane coordinates in squares; NaN where the plane is not seen."""
    back = _inverse(homography(scene))
    ux, uy = offsets(scene.model, points[..., 0], points[..., 1])
    return np.stack(_onto_plane(back, ux, uy), axis=-1)


def visible(scene: BoardScene, points: Points) -> NDArray[np.bool_]:
    """Which distorted points (..., 2) lie in the frame, in the circle, and behind no instrument."""
    model = scene.model
    w, h = model.size
    x, y = points[..., 0], points[..., 1]
    with np.errstate(invalid="ignore"):
        seen = (x >= 0) & (x <= w - 1) & (y >= 0) & (y <= h - 1)
        if scene.circle:
            ox, oy = scene.circle.center
            dx, dy = (x - ox) * model.pixel_aspect, y - oy
            seen &= dx * dx + dy * dy < (scene.circle.diameter / 2) ** 2
    for item in scene.instruments:
        ux, uy = offsets(model, x, y)
        seen &= ~item.covers(ux / scene.pose.focal, uy / scene.pose.focal)
    return seen


def homography(scene: BoardScene, shift: tuple[float, float] = (0.0, 0.0)) -> Homography:
    """Return (3, 3) from plane coordinates to undistorted offsets from the centre, moved by ``shift`` px."""
    model = scene.model
    middle = (model.undistort(scene.pose.center) - model.center) * (model.pixel_aspect, 1.0)
    moved = np.array([[1, 0, shift[0]], [0, 1, shift[1]], [0, 0, 1]], float)
    return moved @ scene.pose.homography(middle)


def board_light(
    scene: BoardScene, background: Light | None = None, shift: tuple[float, float] = (0.0, 0.0)
) -> Light:
    """Average the scene's radiance over each pixel, before the camera: float32 (H, W) or (H, W, 3).

    (H, W) is the frame widened by the camera's reach on each side. ``background`` is the radiance seen
    around the sheet, of that size and grey or BGR; None for the pattern's own, even one. ``shift`` moves the
    pattern, in undistorted px.
    """
    model, pattern, reach = scene.model, scene.pattern, scene.camera.reach
    back = _inverse(homography(scene, shift))

    def labels(x: Coordinates, y: Coordinates) -> NDArray[np.int32]:
        ux, uy = offsets(model, x, y)
        return pattern.labels(*_onto_plane(back, ux, uy))

    table = pattern.radiances
    if background is not None:
        # Two columns: radiance without the background, and the background's share of the pixel.
        table = np.stack([table, np.zeros_like(table)], axis=1)
        table[BACKGROUND] = 0, 1
    w, h = model.size
    light = pixel_averages(labels, table, (-reach, -reach), (h + 2 * reach, w + 2 * reach))
    if background is not None:
        own, share = light[..., 0], light[..., 1]
        if background.ndim == 3:
            own, share = own[..., None], share[..., None]
        light = own + share * background
    for spot in scene.highlights:
        spot.add_to(light, (-reach, -reach))
    if scene.instruments:
        rays = pixel_rays(scene.division, scene.pose.focal, reach)
        for item in scene.instruments:
            item.paint(light, rays)
    return light


def _onto_plane(
    back: Homography, ux: Coordinates, uy: Coordinates
) -> tuple[Coordinates, Coordinates]:
    """Plane coordinates of undistorted offsets through the inverse homography; NaN beyond the horizon."""
    (a, b, c), (d, e, f), (g, h, i) = back.tolist()
    depth = g * ux + h * uy + i
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = 1 / depth
        inverse[~(depth > 0)] = np.nan
        return (a * ux + b * uy + c) * inverse, (d * ux + e * uy + f) * inverse


def _inverse(homography: Homography) -> Homography:
    return np.asarray(np.linalg.inv(homography), np.float64)


def _cloudy_background(scene: BoardScene, rng: np.random.Generator) -> Light | None:
    """Cloudy radiance around the sheet, float32, over the widened frame; None where it is even."""
    if scene.clutter == 0:
        return None
    reach = scene.camera.reach
    w, h = (n + 2 * reach for n in scene.model.size)
    clouds = fractal_noise(rng, (w, h), {4: 1.0, 9: 0.6, 20: 0.3})
    return scene.pattern.background * np.maximum(1 + scene.clutter * clouds, 0)
