"""Whether the errors of followed places are each one's own, or shared by neighbours, and whether they last.

Noise and a soft picture give each place an error of its own. What no smooth scene explains is shared by
neighbours: depth, as long as the camera moves on, step after step; what coding a video does to it, by turns.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]

# Patches along the picture's width and height whose places are neighbours of one another.
_PATCHES = (4, 3)
# Fields of a chessboard along a patch: places on black ones are others than those on white ones.
_FIELDS = 4


class _Sums(NamedTuple):
    """How many residuals there are (2, p) and their sums (2, p, 2), by colour and patch; the mean square."""

    number: NDArray[np.intp]
    residual: Points
    square: float


class Likeness:
    """How alike the residuals of neighbours were, averaged over ``remembered`` steps or so.

    ``alike`` is their correlation within a step, ``lasting`` that with those of other places near by in the
    step before: 0 on average where each place's error is its own, and about as often below. None until steps
    have told.
    """

    def __init__(self, remembered: float) -> None:
        self._kept = 1 - 1 / remembered
        self._alike, self._steps = 0.0, 0.0
        self._lasting, self._pairs = 0.0, 0.0
        self._before: _Sums | None = None

    @property
    def alike(self) -> float | None:
        """The correlation of neighbours within a step."""
        return self._alike / self._steps if self._steps else None

    @property
    def lasting(self) -> float | None:
        """The correlation of neighbours from one step to the next."""
        return self._lasting / self._pairs if self._pairs else None

    def learn(self, places: Points, residual: Points, weight: NDArray[np.float64]) -> None:
        """Take in a step: the ``residual`` (n, 2) of ``places`` (n, 2), by what ``weight`` (n,) they fit."""
        fits = weight > 0
        self._alike = self._kept * self._alike + _within(places[fits], residual[fits])
        self._steps = self._kept * self._steps + 1
        # What hardly fits, an instrument's edge, moves on steadily as well, and is no depth.
        now = _sums(places, residual * weight[:, None])
        if self._before is not None:
            self._lasting = self._kept * self._lasting + _between(self._before, now)
            self._pairs = self._kept * self._pairs + 1
        self._before = now


def part_of(correlation: float | None, full: float) -> float:
    """Return which part of residuals a ``correlation`` says is shared; all until one is told."""
    return 1.0 if correlation is None else min(max(correlation / full, 0.0), 1.0)


def _within(places: Points, residual: Points) -> float:
    """Return the correlation of the residuals (n, 2) of places (n, 2) that lie in the same patch."""
    if len(places) < 2:
        return 0.0
    patch = _patch(_field(places) // _FIELDS)
    count = np.bincount(patch)
    sums = [np.bincount(patch, along) for along in residual.T]
    squares = float((residual**2).sum())
    pairs = float((count * (count - 1)).sum())
    if not (pairs and squares):
        return 0.0
    return (float(np.square(sums).sum()) - squares) / pairs / (squares / len(places))


def _between(before: _Sums, now: _Sums) -> float:
    """Return the correlation of residuals in the same patch of two steps, over fields of the other colour.

    A place's own error in the one step has much to do with that in the next: where it was put wrongly it is
    now put right.
    """
    pairs = float((before.number * now.number[::-1]).sum())
    square = np.sqrt(before.square * now.square)
    if not (pairs and square):
        return 0.0
    return float((before.residual * now.residual[::-1]).sum() / pairs / square)


def _sums(places: Points, residual: Points) -> _Sums:
    field = _field(places)
    patches = _PATCHES[0] * _PATCHES[1]
    place = _patch(field // _FIELDS) + patches * (field.sum(axis=1) % 2)
    count = np.bincount(place, minlength=2 * patches).reshape(2, patches)
    sums = [np.bincount(place, along, 2 * patches).reshape(2, patches) for along in residual.T]
    return _Sums(count, np.stack(sums, axis=2), float((residual**2).mean()))


def _field(places: Points) -> NDArray[np.intp]:
    """Return the column and row (n, 2) of the field that each place lies in."""
    lowest, size = places.min(axis=0), np.maximum(np.ptp(places, axis=0), 1e-9)
    fields = np.multiply(_PATCHES, _FIELDS)
    field = np.minimum((places - lowest) / size * fields, fields - 1)
    return np.asarray(field, np.intp)


def _patch(cells: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return the number (n,) of the patch at a column and row (n, 2)."""
    return np.asarray(cells[:, 1] * _PATCHES[0] + cells[:, 0], np.intp)
