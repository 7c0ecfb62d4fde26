"""Find the visible circle of an endoscope picture (Lee et al. 2013, section IV-B, made robust).

The article thresholds the frame, traces the outermost contour and fits a circle to it. Here the threshold
comes from the frame's own black, the outermost points of some rows and columns stand for the contour, a
consensus keeps instruments, logos and dark tissue out, and the rim itself is then measured at full size
along radii. A circle counts only where the outside is dark: see ``_is_content_limit``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from .circle import Boundary
from .coarse import Luma, Samples, first_circle, thin
from .disc import Box, disc_area, visible_fraction, whole_frame
from .fade import look_faded
from .fit import Circle
from .rim import DIRECTIONS, Rim, look

# A rim with this much of its fall in the middle of the window is a step; a fade has a half of it there.
_SHARP = 0.6


# Glare has died away this far out, in radii of the circle. From there on the outside is flat: its smoothed
# samples differ by no more than this and what noise explains. To judge that takes this many samples.
_FAR, _FLAT, _ENOUGH = 1.12, 4.0, 12


# A rim found further off than this, in halves of the window, is looked at again from where it is.
_NEAR = 0.25


@dataclass(frozen=True)
class BoundarySpec:
    """What counts as a visible circle."""

    min_diameter: float = 0.25  # of the frame's shorter side
    max_diameter: float = 1.5  # of the frame's diagonal
    min_visible: float = 0.10  # of the circumference, in the frame
    min_support: float = 0.30  # of the visible circumference, where the rim is seen
    glare: tuple[float, ...] = (
        0.10,
        0.25,
    )  # thresholds to try besides, from black to bright content
    min_evidence: float = 14.0  # natural logarithm of the odds against a chance agreement
    max_black: float = 64.0  # level of the darkest corner, of 255
    min_agreement: float = 0.60  # of the edges that are met from outside, those on the circle
    max_bright_outside: float = 0.12  # of the outside: logos and text


class Located(NamedTuple):
    """A boundary, and one standard deviation of its diameter in px."""

    boundary: Boundary
    diameter_sigma: float


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
    located = locate_boundary(image, pixel_aspect, spec, guess)
    return None if located is None else located.boundary


def locate_boundary(
    image: NDArray[np.uint8] | NDArray[np.uint16],
    pixel_aspect: float = 1.0,
    spec: BoundarySpec = BoundarySpec(),
    guess: Boundary | None = None,
) -> Located | None:
    """Find the boundary as ``find_boundary`` does, and say how well its diameter is known."""
    luma = _luma(image)
    samples = thin(luma)
    if samples is None or samples.dark.level > spec.max_black:
        return None
    h, w = luma.shape
    size = (w * pixel_aspect, float(h))
    radii = (spec.min_diameter * min(size) / 2, spec.max_diameter * math.hypot(*size) / 2)
    if guess is not None:
        box = whole_frame(samples.size, pixel_aspect)
        search = _Search(luma, samples, pixel_aspect, spec, radii)
        circle = Circle(guess.center[0] * pixel_aspect, guess.center[1], guess.diameter / 2)
        rim = search.narrow(circle, box)
        if rim is not None and rim.sharpness > _SHARP and search.is_content_limit(rim, box):
            return _located(rim, box, pixel_aspect)
    for search in _searches(luma, samples, pixel_aspect, spec, radii):
        found = first_circle(search.samples, pixel_aspect, radii)
        if found is None:
            continue
        circle, box = found
        rim = search.measure(circle, box)
        if rim is not None:
            return _located(rim, box, pixel_aspect)
    return None


def _searches(
    luma: Luma,
    samples: Samples,
    pixel_aspect: float,
    spec: BoundarySpec,
    radii: tuple[float, float],
) -> Iterator[_Search]:
    """Yield the search with the lowest threshold, then those that bear glare outside the circle."""
    yield _Search(luma, samples, pixel_aspect, spec, radii)
    bright = float(np.percentile(samples.values, 95))
    last = samples.dark.threshold
    for share in spec.glare:
        threshold = samples.dark.level + share * (bright - samples.dark.level)
        if threshold > 1.2 * last:
            last = threshold
            raised = samples._replace(dark=samples.dark.raised(threshold))
            yield _Search(luma, raised, pixel_aspect, spec, radii)


@dataclass(frozen=True)
class _Search:
    """One frame's samples, and the ways to measure and to judge a circle on it."""

    luma: Luma
    samples: Samples
    pixel_aspect: float
    spec: BoundarySpec
    radii: tuple[float, float]

    def measure(self, circle: Circle, box: Box) -> Rim | None:
        """Measure the rim near a first circle; None where it is no limit of the content."""
        rim = self.narrow(circle, box)
        if rim is not None and rim.sharpness > _SHARP and self.is_content_limit(rim, box):
            return rim
        # The faded rim comes first: the slope of a fade passes for a soft step, further in.
        faded = self.faded(circle, box)
        if faded is not None and self.is_content_limit(faded, box):
            return faded
        wide = self.wide(circle, box)
        sharp = None if wide is None else self.narrow(wide.circle, box)
        for again in (rim, sharp, wide):
            if again is not None and self.is_content_limit(again, box):
                return again
        return None

    def narrow(self, circle: Circle, box: Box) -> Rim | None:
        """Measure the rim of a circle that is known to about a coarse sample."""
        return self._look_twice(
            circle, max(6.0, 1.5 * self.samples.step, 0.02 * circle.radius), box
        )

    def wide(self, circle: Circle, box: Box) -> Rim | None:
        """Measure a soft rim, or one whose glow or unevenness led the first circle astray."""
        return self._look_twice(
            circle, max(12.0, 3.0 * self.samples.step, 0.06 * circle.radius), box
        )

    def _look_twice(self, circle: Circle, half: float, box: Box) -> Rim | None:
        """Measure the rim, and again from there where it lies far off in the window."""
        rim = look(self.luma, circle, half, box, self.samples.dark, self.pixel_aspect)
        if rim is None or math.dist(rim.circle, circle) < _NEAR * half:
            return rim
        return look(self.luma, rim.circle, half, box, self.samples.dark, self.pixel_aspect)

    def faded(self, circle: Circle, box: Box) -> Rim | None:
        """Measure a rim that the light fades out at, without a step."""
        return look_faded(self.luma, circle, box, self.samples.dark, self.pixel_aspect)

    def is_content_limit(self, rim: Rim, box: Box) -> bool:
        """Tell the content's limit from a round thing in the picture.

        The circle must be seen over enough of itself, few edges may contradict it, and everything
        outside it, near and far, must be as dark as the darkest corner.
        """
        spec, circle = self.spec, rim.circle
        if not self.radii[0] <= circle.radius <= self.radii[1]:
            return False
        if visible_fraction(circle, box) < spec.min_visible:
            return False
        return (
            rim.on_circle >= max(spec.min_support * rim.visible, 0.06 * DIRECTIONS)
            and rim.on_circle >= spec.min_agreement * rim.edges
            and rim.dark >= (1 - spec.max_bright_outside) * rim.visible
            and rim.evidence >= spec.min_evidence
            and self._is_dark_outside(circle, box)
        )

    def _is_dark_outside(self, circle: Circle, box: Box) -> bool:
        """Say whether the samples outside are dark; glare is borne near the circle, but must have died away
        further out: else it is a dark scene about something round.
        """
        values, step, dark = self.samples.values, self.samples.step, self.samples.dark
        x = np.arange(0, values.shape[1], 2, dtype=np.float32) * np.float32(
            step * self.pixel_aspect
        )
        y = np.arange(0, values.shape[0], 2, dtype=np.float32) * np.float32(step)
        x -= np.float32(circle.x)
        y -= np.float32(circle.y)
        distance2 = x * x + (y * y)[:, None]
        thinned = values[::2, ::2]
        near = thinned[distance2 > (1.02 * circle.radius + 2 * step) ** 2]
        if np.count_nonzero(near > dark.threshold) > self.spec.max_bright_outside * len(near):
            return False
        far = thinned[distance2 > (_FAR * circle.radius) ** 2]
        if len(far) < _ENOUGH:
            return not dark.has_glare
        low, high = np.percentile(far, (10, 100 * (1 - self.spec.max_bright_outside)))
        return bool(high - low <= _FLAT + dark.noise)


def boundary_of(
    center: tuple[float, float], diameter: float, size: tuple[int, int], pixel_aspect: float = 1.0
) -> Boundary:
    """Return the boundary with this circle, (x, y) and px, in a frame of ``size`` (width, height) px."""
    circle = Circle(center[0] * pixel_aspect, center[1], diameter / 2)
    return _boundary(circle, whole_frame(size, pixel_aspect), pixel_aspect)


def _located(rim: Rim, box: Box, pixel_aspect: float) -> Located:
    return Located(_boundary(rim.circle, box, pixel_aspect), 2 * rim.radius_sigma)


def _boundary(circle: Circle, box: Box, pixel_aspect: float) -> Boundary:
    return Boundary(
        (circle.x / pixel_aspect, circle.y),
        2 * circle.radius,
        disc_area(circle, box) / pixel_aspect,
        visible_fraction(circle, box),
    )


def _luma(image: NDArray) -> NDArray[np.uint8]:
    """Return 8-bit luma; a deeper picture is scaled by the depth that its brightest value needs."""
    if image.ndim == 3:
        image = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    if image.dtype == np.uint8:
        return image
    depth = max(int(image.max()).bit_length(), 8)
    return (image >> (depth - 8)).astype(np.uint8)
