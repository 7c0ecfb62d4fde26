"""Find the visible circle of an endoscope picture (Lee et al. 2013, section IV-B, made robust).

The article thresholds the frame, traces the outermost contour and fits a circle to it. Here the threshold
comes from the frame's own black, the outermost points of some rows and columns stand for the contour, a
consensus keeps instruments, logos and dark tissue out, and the rim itself is then measured at full size
along radii. A circle counts only where it limits the content: outside it must be dark all along.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .bars import picture_between_bars
from .circle import Boundary
from .coarse import Samples, thin
from .departure import RimPoints, radius_departure
from .disc import Box, disc_area, visible_fraction, whole_frame
from .fit import Circle
from .frame import Frame, frame_of
from .outside import Dark, blocks_of, darkest_corner
from .panel import picture_between_panels
from .rim import Rim
from .search import BoundarySpec, Search

# A frame of fewer pixels than this each way shows no circle.
_LEAST_SIDE = 20


class Located(NamedTuple):
    """A boundary, and how well its diameter and its centre are known, in px of the height.

    The sigmas are one standard deviation from frame to frame; ``points`` are what the circle was fitted to,
    None for one that was not fitted to a rim.
    """

    boundary: Boundary
    diameter_sigma: float
    center_sigma: float
    points: RimPoints | None = None

    @property
    def shape_sigma(self) -> float:
        """What a rim that is no perfect circle adds where only a part of it is seen, px.

        One standard deviation; the error is the same in every frame that shows the same part.
        """
        if self.points is None:
            return 0.0
        return 2 * radius_departure(self.points, self.boundary.diameter / 2)

    @property
    def uncertainty(self) -> float:
        """One standard deviation of the diameter from that of the whole rim, px."""
        return math.hypot(self.diameter_sigma, self.shape_sigma)


def find_boundary(
    image: NDArray[np.uint8] | NDArray[np.uint16],
    pixel_aspect: float = 1.0,
    spec: BoundarySpec = BoundarySpec(),
    guess: Boundary | None = None,
) -> Boundary | None:
    """Find the circular limit of the content, or None where there is none.

    ``image`` is (h, w) luma or (h, w, 3) BGR, uint8 or uint16; ``pixel_aspect`` is a pixel's width over its
    height. ``guess`` is where the circle was a moment ago: it is looked at first, and saves time when the
    circle is still near there.
    """
    found = _search(image, pixel_aspect, spec, guess)
    return None if found is None else _boundary(found[0].circle, found[1], pixel_aspect)


def locate_boundary(
    image: NDArray[np.uint8] | NDArray[np.uint16],
    pixel_aspect: float = 1.0,
    spec: BoundarySpec = BoundarySpec(),
    guess: Boundary | None = None,
) -> Located | None:
    """Find the boundary as ``find_boundary`` does, and say how well its diameter is known."""
    found = _search(image, pixel_aspect, spec, guess)
    if found is None:
        return None
    rim, box = found
    boundary = _boundary(rim.circle, box, pixel_aspect)
    return Located(boundary, 2 * rim.radius_sigma, rim.center_sigma, rim.points)


def _search(
    image: NDArray[np.uint8] | NDArray[np.uint16],
    pixel_aspect: float,
    spec: BoundarySpec,
    guess: Boundary | None,
) -> tuple[Rim, Box] | None:
    """Find the rim and the box that holds the content, in square pixels."""
    frame = frame_of(image, pixel_aspect)
    between = picture_between_bars(frame)
    return (between and _in_part(frame, between, spec, guess)) or _in_whole(frame, spec, guess)


def _in_whole(frame: Frame, spec: BoundarySpec, guess: Boundary | None) -> tuple[Rim, Box] | None:
    """Find the rim in the frame, or in what panels leave of it."""
    if min(frame.size) < _LEAST_SIDE:
        return None
    dark, samples = darkest_corner(frame), None
    if dark.level <= spec.max_black:
        search = Search(frame, dark, blocks_of(frame), spec)
        found = None if guess is None else search.near(_circle(guess, frame.pixel_aspect))
        if found is None:
            samples = thin(frame)
            found = search.anywhere(samples)
        if found is not None:
            return found
    return _beside_panels(frame, dark, samples or thin(frame), spec)


def _beside_panels(
    frame: Frame, dark: Dark, samples: Samples, spec: BoundarySpec
) -> tuple[Rim, Box] | None:
    """Find the rim in what panels leave of the frame, if there are any."""
    left = picture_between_panels(samples, dark.contrast)
    if left is None:
        return None
    rows, columns = (slice(s.start * samples.step, s.stop * samples.step) for s in left)
    return _in_part(frame, (rows, columns), spec)


def _in_part(
    frame: Frame, part: tuple[slice, slice], spec: BoundarySpec, guess: Boundary | None = None
) -> tuple[Rim, Box] | None:
    """Find the rim in these rows and columns, px, of a frame."""
    rows, columns = part
    picture = frame._replace(luma=frame.luma[rows, columns])
    if min(picture.size) < _LEAST_SIDE:
        return None
    dark = darkest_corner(picture)
    if dark.level > spec.max_black:
        return None
    x, y = columns.start * frame.pixel_aspect, float(rows.start)
    search, found = Search(picture, dark, blocks_of(picture), spec), None
    if guess is not None:
        whole = _circle(guess, frame.pixel_aspect)
        found = search.near(whole._replace(x=whole.x - x, y=whole.y - y))
    found = found or search.anywhere(thin(picture))
    if found is None:
        return None
    rim, box = found
    circle = rim.circle._replace(x=rim.circle.x + x, y=rim.circle.y + y)
    moved = Box(box.left + x, box.top + y, box.right + x, box.bottom + y)
    return rim._replace(circle=circle), moved


def _circle(boundary: Boundary, pixel_aspect: float) -> Circle:
    x, y = boundary.center
    return Circle(x * pixel_aspect, y, boundary.diameter / 2)


def boundary_of(
    center: tuple[float, float], diameter: float, size: tuple[int, int], pixel_aspect: float = 1.0
) -> Boundary:
    """Return the boundary with this circle, (x, y) and px, in a frame of ``size`` (width, height) px."""
    circle = Circle(center[0] * pixel_aspect, center[1], diameter / 2)
    return _boundary(circle, whole_frame(size, pixel_aspect), pixel_aspect)


def _boundary(circle: Circle, box: Box, pixel_aspect: float) -> Boundary:
    return Boundary(
        (circle.x / pixel_aspect, circle.y),
        2 * circle.radius,
        disc_area(circle, box) / pixel_aspect,
        visible_fraction(circle, box),
    )
