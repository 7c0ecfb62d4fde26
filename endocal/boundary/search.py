"""The search of one frame: from a first circle to a rim, and whether that rim is the content's limit."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from .coarse import Samples, first_circle
from .disc import Box, visible_fraction, whole_frame
from .fade import look_faded
from .fit import Circle
from .frame import Frame
from .outside import Blocks, Dark, ends_at, line_step
from .rim import DIRECTIONS, Rim, dips_between, look

# A rim with this much of its fall in the middle of the window is a step; a fade has a half of it there.
_SHARP = 0.6
# Edges that agree this much better than by chance, as the evidence of each, are a step in any case.
_PLAIN = 0.8
# A rim found further off than this, in halves of the window, is looked at again from where it is.
_NEAR = 0.5
# A ring's circle is wider than that inside it, by this share of its radius at least and seldom by more than a
# quarter. Between them lies a dark gap, on so many of the radii.
_WIDER, _WITHIN, _RING = 0.02, 0.75, 0.12
# To see a ring apart from what it surrounds, content counts above these shares of the way to bright content.
_RING_LEVELS = (0.10, 0.25, 0.50)
# The least radii, of all that are looked along, on which a circle may rest.
_LEAST_SUPPORT = 0.06 * DIRECTIONS


@dataclass(frozen=True)
class BoundarySpec:
    """What counts as a visible circle.

    Diameters are bounded by fractions of the frame's shorter side and of its diagonal. Of the
    circumference, ``min_visible`` must lie in the frame; of that, the rim must be seen over ``min_support``.
    Of the edges that are met from outside, ``min_agreement`` must lie on the circle, and so well that the
    natural logarithm of the odds against chance is ``min_evidence``. The darkest corner must be below
    ``max_black`` (of 255). Of the outside no more than ``max_bright_outside``, and ``logos`` of the whole
    frame besides, may be brighter: burnt-in marks and text. ``glare`` are shares of the way from black to
    bright content that the outside near the circle may reach when nothing is found without.
    """

    min_diameter: float = 0.25
    max_diameter: float = 1.2
    min_visible: float = 0.10
    min_support: float = 0.30
    min_agreement: float = 0.60
    min_evidence: float = 18.0
    max_black: float = 64.0
    max_bright_outside: float = 0.12
    logos: float = 0.005
    glare: tuple[float, ...] = (0.10, 0.25)


@dataclass(frozen=True)
class Search:
    """A frame, its black and its blocks, and the ways to measure and to judge a circle on it."""

    frame: Frame
    dark: Dark
    blocks: Blocks
    spec: BoundarySpec

    @property
    def radii(self) -> tuple[float, float]:
        """The least and the largest radius, px."""
        size = self.frame.square_size
        return (
            self.spec.min_diameter * min(size) / 2,
            self.spec.max_diameter * math.hypot(*size) / 2,
        )

    def near(self, circle: Circle) -> tuple[Rim, Box] | None:
        """Find the rim where it is expected; None where it is not there, or not plainly so."""
        box = whole_frame(self.frame.size, self.frame.pixel_aspect)
        rim = self._narrow(circle, box)
        return (rim, box) if self._is_plain(rim, box) and rim is not None else None

    def anywhere(self, samples: Samples) -> tuple[Rim, Box] | None:
        """Find the rim from the frame's samples alone."""
        for search in self._with_glare(samples, self.spec.glare):
            found = first_circle(self.frame, samples, search.dark.threshold, self.radii)
            if found is None:
                continue
            circle, box = found
            rim = search._measure(circle, box)
            if rim is not None:
                return search._without_ring(samples, rim, box)
        return None

    def _without_ring(self, samples: Samples, rim: Rim, box: Box) -> tuple[Rim, Box] | None:
        """Return the rim, unless it is that of a ring of reflections about the circle.

        Then the circle itself, if it limits the content, or None.
        """
        within = rim.circle._replace(radius=_WITHIN * rim.circle.radius)
        black = self.dark.level
        if dips_between(self.frame, within, rim.circle, black) < _RING:
            return rim, box
        for search in self._with_glare(samples, _RING_LEVELS):
            threshold = search.dark.threshold
            found = first_circle(self.frame, samples, threshold, self.radii, lasting=True)
            if found is None or not _is_inside(found[0], rim.circle):
                continue
            inner = search._narrow(*found)
            if inner is None or not search._is_circle(inner, found[1]):
                continue
            if inner.on_circle * rim.visible < rim.on_circle * inner.visible:
                continue
            if dips_between(self.frame, inner.circle, rim.circle, black) > _RING:
                return (inner, found[1]) if search._is_content_limit(inner, found[1]) else None
        return rim, box

    def _with_glare(self, samples: Samples, shares: tuple[float, ...]) -> Iterator[Search]:
        """Yield this search, and then those that bear glare, up to each of the ``shares``."""
        yield self
        dark = self.dark
        bright = float(np.percentile(samples.values, 95))
        last = dark.threshold
        for share in shares:
            threshold = dark.level + share * (bright - dark.level)
            if threshold > 1.2 * last:
                last = threshold
                yield Search(self.frame, dark.raised(threshold), self.blocks, self.spec)

    def _measure(self, circle: Circle, box: Box) -> Rim | None:
        """Measure the rim near a first circle; None where it is no limit of the content."""
        rim = self._narrow(circle, box)
        if self._is_plain(rim, box):
            return rim
        # The faded rim comes first: the slope of a fade passes for a soft step, further in.
        faded = look_faded(self.frame, circle, box, self.dark)
        if self._is_content_limit(faded, box):
            return faded
        wide = self._wide(circle, box)
        sharp = None if wide is None else self._narrow(wide.circle, box)
        if wide and sharp and wide.on_circle < sharp.on_circle and _differ(wide, sharp):
            # There is a glare beyond a part of the rim, and the wider look has met the glare's border.
            wide = None
        for again in (rim, sharp, wide):
            if self._is_content_limit(again, box):
                return again
        return None

    def _narrow(self, circle: Circle, box: Box) -> Rim | None:
        """Measure the rim of a circle that is known to about a sample."""
        half = max(6.0, 1.5 * line_step(self.frame), 0.02 * circle.radius)
        return self._look_twice(circle, half, box)

    def _wide(self, circle: Circle, box: Box) -> Rim | None:
        """Measure a soft rim, or one whose glow or unevenness led the first circle astray."""
        half = max(12.0, 3.0 * line_step(self.frame), 0.06 * circle.radius)
        return self._look_twice(circle, half, box)

    def _look_twice(self, circle: Circle, half: float, box: Box) -> Rim | None:
        """Measure the rim, and again from there where it lies far off in the window."""
        rim = look(self.frame, circle, half, box, self.dark)
        if rim is None or math.dist(rim.circle, circle) < _NEAR * half:
            return rim
        return look(self.frame, rim.circle, half, box, self.dark)

    def _is_plain(self, rim: Rim | None, box: Box) -> bool:
        """Say whether the rim is a step, for which no softer reading has to be tried."""
        if rim is None or not self._is_content_limit(rim, box):
            return False
        return rim.sharpness > _SHARP or rim.evidence > _PLAIN * rim.on_circle

    def _is_content_limit(self, rim: Rim | None, box: Box) -> bool:
        """Tell the content's limit from a round thing in the picture.

        The circle must be seen over enough of itself, few edges may contradict it, and everything
        outside it, near and far, must be as dark as the darkest corner.
        """
        if rim is None or not self._is_circle(rim, box):
            return False
        share, marks = self.spec.max_bright_outside, self.spec.logos
        return ends_at(rim.circle, self.blocks, self.dark, share, marks)

    def _is_circle(self, rim: Rim | None, box: Box) -> bool:
        """Say whether a circle is plainly seen, over enough of itself, with dark along it."""
        if rim is None:
            return False
        spec, circle, radii = self.spec, rim.circle, self.radii
        return (
            radii[0] <= circle.radius <= radii[1]
            and visible_fraction(circle, box) >= spec.min_visible
            and rim.on_circle >= max(spec.min_support * rim.visible, _LEAST_SUPPORT)
            and rim.on_circle >= spec.min_agreement * rim.edges
            and rim.dark >= (1 - spec.max_bright_outside) * rim.visible
            and rim.evidence >= spec.min_evidence
        )


def _differ(a: Rim, b: Rim) -> bool:
    """Say whether two rims are not those of one circle."""
    return math.dist(a.circle, b.circle) > _WIDER * b.circle.radius


def _is_inside(inner: Circle, outer: Circle) -> bool:
    """Say whether a smaller circle lies inside another; they may touch."""
    farthest = math.hypot(inner.x - outer.x, inner.y - outer.y) + inner.radius
    is_smaller = inner.radius < (1 - _WIDER) * outer.radius
    return is_smaller and farthest < (1 + _WIDER / 2) * outer.radius
