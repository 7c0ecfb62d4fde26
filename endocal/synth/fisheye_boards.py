"""Random boards seen through circular fisheyes of several makes, none of which a division model need fit.

The distribution, by ``fisheye_board(seed)``:

- Frames from 720x576 to 1280x960, with a content circle that the frame cuts at top and bottom.
- A quarter of the lenses each: equidistant or equisolid; by a series of Kannala and Brandt on either side of
  equidistant; stereographic, which *is* a division model; a division model. The circle's rim lies 84 to 95
  degrees off the axis.
- Boards of 7 to 12 by 6 to 9 squares, as near as 0.4 of their longer side, up to 60 degrees off the axis and
  turned by up to 55 degrees from facing the lens. All inner corners are in view, some right at the rim.
- Blur, vignetting, gamma and over-exposure, noise, JPEG, a cloudy room.
"""

from __future__ import annotations

import math

import numpy as np

from ..model import DivisionModel
from .board import BoardScene, true_corners
from .camera import Camera, ContentCircle
from .fisheye import Fisheye
from .pattern import Pattern, Pose

SIZES = ((1032, 778), (748, 480), (1280, 960), (720, 576))
# Of the frame's height: how far corners stay from rim and border, and the least mean side of a square.
MARGIN, LEAST_SQUARE = 0.02, 0.035
# No side is shorter than this, px.
SHORTEST = 8.0
# A board turned farther than this from the picture's plane, degrees, is drawn again.
STEEPEST = 85.0


def fisheye_board(seed: int) -> BoardScene:
    """Draw scene number ``seed``; the same seed gives the same scene and the same picture."""
    rng = np.random.default_rng(seed)
    model, radius, focal = _lens(rng)
    h = model.size[1]
    aside = rng.uniform(-0.01, 0.01, 2) * h
    light = rng.uniform(0.6, 1.3)
    pattern = Pattern(
        cols=int(rng.integers(7, 13)),
        rows=int(rng.integers(6, 10)),
        dark=0.08 * min(light, 1),
        light=light,
        background=light * rng.uniform(0.2, 0.9),
    )
    camera = Camera(
        blur=rng.uniform(0.4, 1.3),
        vignetting=rng.uniform(0, 0.5),
        vignetting_radius=radius,
        gamma=rng.uniform(1, 2.2),
        noise=rng.uniform(0.5, 5),
        jpeg=int(rng.integers(80, 101)),
    )
    x, y = np.array(model.center) + aside
    circle = ContentCircle((float(x), float(y)), 2 * radius, rng.uniform(2, 12))
    clutter = rng.uniform(0.1, 0.6)
    while True:
        pose = _pose(rng, model, focal, max(pattern.cols, pattern.rows))
        if pose is None:
            continue
        scene = BoardScene(model, pattern, pose, circle, camera, clutter=clutter, seed=seed)
        if _in_view(scene, radius):
            return scene


def _lens(rng: np.random.Generator) -> tuple[DivisionModel | Fisheye, float, float]:
    """Draw the lens, the radius of its circle, px, and its focal length, px."""
    w, h = size = SIZES[rng.integers(len(SIZES))]
    radius = rng.uniform(0.56, 0.66) * h
    dx, dy = rng.uniform(-0.03, 0.03, 2) * (w, h)
    center = ((w - 1) / 2 + dx, (h - 1) / 2 + dy)
    kind = ("plain", "series", "stereographic", "division")[rng.integers(4)]
    rim = math.radians(rng.uniform(84, 95))
    if kind == "division":
        # lam focal^2 = -1/3, as of an equidistant lens near the axis; a plane holds no more than 90 degrees.
        tangent = math.tan(min(rim, math.radians(87)))
        focal = radius * (1 + math.sqrt(1 + 4 / 3 * tangent**2)) / (2 * tangent)
        return DivisionModel(-1 / 3 / focal**2, center, size), radius, focal
    k = (rng.uniform(-0.08, 0.02), rng.uniform(-0.01, 0.015)) if kind == "series" else ()
    named = ("equidistant", "equisolid")[rng.integers(2)] if kind == "plain" else kind
    projection = "equidistant" if kind == "series" else named
    focal = radius / float(Fisheye(projection, 1.0, center, size, k=k).radius(np.array(rim)))
    return Fisheye(projection, focal, center, size, k=k), radius, focal


def _pose(
    rng: np.random.Generator, model: DivisionModel | Fisheye, focal: float, side: int
) -> Pose | None:
    """Draw where a board ``side`` squares long stands; None where it is seen edge on."""
    a, b = math.radians(60) * math.sqrt(rng.random()), rng.uniform(0, 2 * math.pi)
    turned, towards = math.radians(rng.uniform(0, 55)), rng.uniform(0, 2 * math.pi)
    distance, rotation = rng.uniform(0.4, 1.1) * side, rng.uniform(0, 360)
    ray = np.array([math.sin(a) * math.cos(b), math.sin(a) * math.sin(b), math.cos(a)])
    outward = np.array([math.cos(a) * math.cos(b), math.cos(a) * math.sin(b), -math.sin(a)])
    across = np.array([-math.sin(b), math.cos(b), 0.0])
    lean = math.cos(towards) * outward + math.sin(towards) * across
    normal = math.cos(turned) * ray + math.sin(turned) * lean
    if normal[2] < math.cos(math.radians(STEEPEST)):
        return None
    x, y = model.distort(focal * ray[:2] / ray[2] + model.center)
    return Pose(
        center=(float(x), float(y)),
        square=focal / (distance * float(ray[2])),
        tilt=math.degrees(math.acos(normal[2])),
        tilt_axis=math.degrees(math.atan2(normal[0], -normal[1])),
        rotation=rotation,
        focal=focal,
    )


def _in_view(scene: BoardScene, radius: float) -> bool:
    """Whether all inner corners are seen, clear of rim and border, and the squares are large enough."""
    w, h = scene.model.size
    corners, seen = true_corners(scene)
    margin = MARGIN * h
    if not seen.all() or np.any(corners < margin) or np.any(corners > (w - margin, h - margin)):
        return False
    if np.linalg.norm(corners - scene.model.center, axis=-1).max() > radius - margin:
        return False
    sides = [np.linalg.norm(np.diff(corners, axis=axis), axis=-1).ravel() for axis in (0, 1)]
    every = np.concatenate(sides)
    return bool(every.min() > SHORTEST and every.mean() > LEAST_SQUARE * h)
