"""Everything that is known of the pictures before a model is sought, in square pixels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from ..boundary.circle import Boundary
from ..boundary.detect import find_boundary
from ..errors import CalibrationError, InputError, UsageError
from .fit.plumb_line import Prior
from .fit.view import View
from .image.content import content_masks
from .image.edges import EdgePoints, find_edges_apart
from .image.picture import Grey, Image, Mask, Picture, checked, fields, to_grey
from .image.sampling import from_reduced, reduced
from .spec import CalibrationSpec
from .straightness import Floats

# Edges are sought on a picture of at most so many pixels; they are measured on the full one.
MOST_PIXELS = 2_500_000
# Fewer edge points than this in all pictures together show no pattern.
FEWEST_EDGES = 50


@dataclass(frozen=True)
class Scene:
    """The views of all pictures, and what they share: circle, frame, belief about the centre, content."""

    views: list[View]
    boundary: Boundary | None
    size: tuple[int, int]  # of the frame, in its own pixels
    square_size: tuple[float, float]
    prior: Prior
    content: Mask  # of all pictures together

    def content_radius(self, center: Floats) -> float:
        """The distance from ``center`` to the farthest pixel where edges were looked for, px."""
        y, x = np.nonzero(self.content[::4, ::4])
        aspect = self.square_size[0] / self.size[0]
        return float(np.hypot(4 * x * aspect - center[0], 4 * y - center[1]).max())


def look_at(images: Sequence[Image], spec: CalibrationSpec) -> Scene:
    """Find circle, content and edges of each picture, any that ``picture.checked`` takes.

    Raises InputError for others, and CalibrationError where no edge is seen.
    """
    if not images:
        raise InputError("no picture to calibrate from")
    images = [checked(image) for image in images]
    if len({image.shape[:2] for image in images}) > 1:
        raise InputError("the pictures differ in size: all must be of one lens at one setting")
    h, w = images[0].shape[:2]
    _check_fits(spec, (w, h))
    views, boundaries = [], []
    everywhere = np.zeros((h, w), bool)
    for number, image in enumerate(images):
        grey = to_grey(image)
        boundary = find_boundary(np.rint(grey).astype(np.uint8), spec.aspect)
        boundaries.append(boundary)
        content, beyond = content_masks(grey, boundary, spec.aspect, spec.roi)
        everywhere |= content
        parts = fields(grey)
        for first_row, field in enumerate(parts):
            (edges, outer), step = _edges(Picture(field, content, beyond), spec.aspect)
            shown = _square(field, spec.aspect)
            own = first_row if len(parts) > 1 else None
            views.append(View(shown, edges, number, step, outer, own))
    if sum(len(view.edges) for view in views) < FEWEST_EDGES:
        where = "" if spec.roi is None else f" in --roi {','.join(map(str, spec.roi))}"
        raise CalibrationError(
            f"no edges found{where}: a sharp, evenly lit picture of a chessboard or of straight lines is"
            " needed"
        )
    views = [view for view in views if len(view.edges) > 0]
    square = (w * spec.aspect, float(h))
    return Scene(views, _widest(boundaries), (w, h), square, _prior(spec, (w, h)), everywhere)


def _check_fits(spec: CalibrationSpec, size: tuple[int, int]) -> None:
    """Refuse a region or a centre that lies off a picture of ``size`` (width, height) px."""
    w, h = size
    if spec.roi is not None:
        x, y, width, height = spec.roi
        if x + width > w or y + height > h:
            raise UsageError(
                f"--roi {x},{y},{width},{height} reaches beyond the {w}x{h} px picture"
            )
    if isinstance(spec.center, tuple):
        x_, y_ = spec.center
        if not (0 <= x_ < w and 0 <= y_ < h):
            raise UsageError(f"--center {x_:g},{y_:g} lies outside the {w}x{h} px picture")


def _edges(picture: Picture, pixel_aspect: float) -> tuple[list[EdgePoints], int]:
    """Edge points in square pixels, of the content and beyond it.

    Returns also how many times smaller the picture is on which they were sought.
    """
    h, w = picture.grey.shape
    step = int(np.ceil(np.sqrt(h * w / MOST_PIXELS)))
    if step > 1:
        rows, columns = slice(None, h // step * step, step), slice(None, w // step * step, step)
        beyond = None if picture.beyond is None else picture.beyond[rows, columns]
        picture = Picture(reduced(picture.grey, step), picture.content[rows, columns], beyond)
    found = []
    for edges in find_edges_apart(picture):
        points = from_reduced(edges.points, step)
        gradients = edges.gradients / (pixel_aspect, 1.0)
        gradients /= np.maximum(np.linalg.norm(gradients, axis=1), 1e-12)[:, None]
        found.append(EdgePoints(points * (pixel_aspect, 1.0), gradients))
    return found, step


def _square(grey: Grey, pixel_aspect: float) -> Grey:
    """Stretch a picture so that its pixels are square; the first pixel's centre stays in place."""
    if pixel_aspect == 1:
        return grey
    h, w = grey.shape
    size = (round((w - 1) * pixel_aspect) + 1, h)
    stretch = np.array([[pixel_aspect, 0, 0], [0, 1, 0]], np.float64)
    return np.asarray(
        cv2.warpAffine(grey, stretch, size, flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE),
        np.float32,
    )


def _widest(boundaries: Sequence[Boundary | None]) -> Boundary | None:
    """The boundary seen best; the pictures share one."""
    seen = [b for b in boundaries if b is not None]
    return max(seen, key=lambda b: b.visible) if seen else None


def _prior(spec: CalibrationSpec, size: tuple[int, int]) -> Prior:
    """The article's region for the centre, 0.1 W x 0.1 H, as two standard deviations either way.

    ``size`` (width, height) is in the frame's own pixels.
    """
    # Between the first pixel's centre and the last one's, which lie at 0 and at w - 1 before x is stretched.
    w, h = size
    middle = (spec.aspect * (w - 1) / 2, (h - 1) / 2)
    spread = (spec.aspect * w * spec.center_region / 2, h * spec.center_region / 2)
    if spec.center == "free":
        return Prior(middle, spread)
    if isinstance(spec.center, tuple):
        return Prior((spec.center[0] * spec.aspect, spec.center[1]), (0.0, 0.0))
    return Prior(middle, (0.0, 0.0))
