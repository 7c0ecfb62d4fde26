"""Which edge points lie on one straight line, given a model: peaks of the vote map, strongest first."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from ..image.edges import EdgePoints
from ..straightness import Floats, Labels, Undistorted

ANGLE_BINS = 120
MOST_LINES = 90
# Peaks in a row that turned out to be no line before the search gives up.
PATIENCE = 25


@dataclass(frozen=True)
class LineSpec:
    """What makes a line: how near its points are (px, radians), how many at least, over what span (px)."""

    distance: float
    angle: float
    points: int
    span: float


@dataclass(frozen=True)
class Grouping:
    """Labels (n,) of the edge points, -1 for none, and how many lines there are."""

    labels: Labels
    count: int

    @property
    def assigned(self) -> NDArray[np.bool_]:
        """Which points lie on a line."""
        return self.labels >= 0

    def entropy(self) -> float:
        """The entropy (eq. 6) of a vote map with one cell a line and one for each point on none."""
        total = len(self.labels)
        votes = np.bincount(self.labels[self.assigned], minlength=1)
        p = votes[votes > 0] / total
        alone = 1 - p.sum()
        return float(-(p * np.log(p)).sum() + alone * np.log(total))


def group(edges: EdgePoints, params: Floats, spec: LineSpec) -> Grouping:
    """Group edge points into lines that are straight under ``params``."""
    labels = np.full(len(edges), -1, np.intp)
    at = Undistorted.of(edges.points, params)
    # Past the fold, or so near to it that a pixel there covers a large part of the plane, nothing is said.
    pool = np.nonzero(at.denominator > 0.05)[0]
    if len(pool) < spec.points:
        return Grouping(labels, 0)
    normals = at.gradients(edges.gradients)
    angle = np.arctan2(normals[:, 1], normals[:, 0]) % np.pi
    offset = at.u[:, 0] * np.cos(angle) + at.u[:, 1] * np.sin(angle)
    votes = _Votes(angle[pool], offset[pool], pool, len(edges), spec)
    sights = np.stack(
        [
            *at.u.T,
            *at.d.T,
            1 / at.denominator,
            2 * at.slope / at.denominator**2,
            *normals.T,
            at.denominator**2,
        ]
    )
    count = failures = 0
    free = np.zeros(len(edges), bool)
    free[pool] = True
    while count < MOST_LINES and failures < PATIENCE:
        peak = votes.strongest()
        if peak is None:
            break
        members = _members(edges, sights, votes.candidates(peak, free), peak, spec)
        if members is None:
            failures += 1
            votes.strike(peak)
            continue
        labels[members] = count
        free[members] = False
        count += 1
        votes.remove(members)
    return Grouping(labels, count)


@dataclass(frozen=True)
class _Peak:
    row: int
    column: int
    angle: float
    offset: float


class _Votes:
    """The vote map over angle (rows) and offset (columns), with what each point voted for."""

    def __init__(
        self, angle: Floats, offset: Floats, pool: Labels, total: int, spec: LineSpec
    ) -> None:
        self.step = max(2 * spec.distance, 2.0)
        self.least = spec.points / 2
        reach = float(np.quantile(np.abs(offset), 0.995)) + self.step
        self.columns = int(np.ceil(2 * reach / self.step)) + 1
        self.reach = reach
        row = np.minimum((angle * (ANGLE_BINS / np.pi)).astype(np.intp), ANGLE_BINS - 1)
        column = np.floor((offset + reach) / self.step).astype(np.intp)
        fits = (column >= 0) & (column < self.columns)
        self.row = np.full(total, -10, np.int32)
        self.column = np.full(total, -10, np.int32)
        self.row[pool[fits]], self.column[pool[fits]] = row[fits], column[fits]
        # Above the first row lies the last one, turned round, and the first below the last.
        self.wrapped = np.zeros((ANGLE_BINS + 2, self.columns), np.float32)
        self.map = self.wrapped[1:-1]
        self.smooth = np.empty_like(self.map)
        np.add.at(self.map, (row[fits], column[fits]), np.float32(1))
        self._smooth(0, ANGLE_BINS)

    def strongest(self) -> _Peak | None:
        index = int(self.smooth.argmax())
        row, column = divmod(index, self.columns)
        if self.smooth[row, column] < self.least:
            return None
        return _Peak(
            row,
            column,
            (row + 0.5) * np.pi / ANGLE_BINS,
            (column + 0.5) * self.step - self.reach,
        )

    def candidates(self, peak: _Peak, free: NDArray[np.bool_]) -> Labels:
        """Points that voted within two cells of a peak; a line through the wrap turns its offset round."""
        turn = np.abs(self.row - peak.row)
        near = (turn <= 2) & (np.abs(self.column - peak.column) <= 3)
        if not 2 <= peak.row < ANGLE_BINS - 2:
            mirrored = self.columns - 1 - peak.column
            near |= (turn >= ANGLE_BINS - 2) & (np.abs(self.column - mirrored) <= 3)
        return np.flatnonzero(near & free)

    def strike(self, peak: _Peak) -> None:
        rows = slice(max(0, peak.row - 1), peak.row + 2)
        columns = slice(max(0, peak.column - 1), peak.column + 2)
        self.map[rows, columns] = 0
        self._smooth(peak.row - 1, peak.row + 2)

    def remove(self, members: Labels) -> None:
        members = members[self.row[members] >= 0]
        if len(members):
            rows, columns = self.row[members], self.column[members]
            np.subtract.at(self.map, (rows, columns), np.float32(1))
            self.map[rows, columns] = np.maximum(self.map[rows, columns], 0)
            self._smooth(int(rows.min()), int(rows.max()) + 1)

    def _smooth(self, first: int, last: int) -> None:
        """Sum 3x3 neighbours anew where the rows from ``first`` up to ``last`` have changed."""
        if first <= 0 or last >= ANGLE_BINS:
            first, last = 1, ANGLE_BINS - 1
            self.wrapped[0], self.wrapped[-1] = self.map[-1, ::-1], self.map[0, ::-1]
        # Row i of the map is row i + 1 of the wrapped one.
        rows = self.wrapped[first - 1 : last + 3]
        self.smooth[first - 1 : last + 1] = cv2.boxFilter(
            rows, -1, (3, 3), normalize=False, borderType=cv2.BORDER_CONSTANT
        )[1:-1]


def _members(
    edges: EdgePoints, sights: Floats, near: Labels, peak: _Peak, spec: LineSpec
) -> Labels | None:
    """The candidates on the line through a peak, fitted in three rounds; None where it is no line.

    ``sights`` (9, n) are the points' undistorted and distorted offsets from the centre, the inverse of the
    model's denominator, its slope by what the Jacobian has it, undistorted gradients, and the denominator
    squared.
    """
    if len(near) < spec.points:
        return None
    ux, uy, dx, dy, inverse, slope, gx, gy, weights = sights.take(near, axis=1)
    nx, ny = np.cos(peak.angle), np.sin(peak.angle)
    offset = peak.offset
    members = near
    for reach, turn in ((4.0, 2.0), (2.0, 1.5), (1.0, 1.0), (1.0, 1.0)):
        pull = slope * (dx * nx + dy * ny)
        scale = (nx * inverse - pull * dx) ** 2 + (ny * inverse - pull * dy) ** 2
        inside = (ux * nx + uy * ny - offset) ** 2 < (reach * spec.distance) ** 2 * scale
        inside &= np.abs(gx * nx + gy * ny) > np.cos(min(turn * spec.angle, 0.5))
        members = near[inside]
        if len(members) < spec.points:
            return None
        nx, ny, offset = _fit(ux[inside], uy[inside], weights[inside])
    x, y = edges.points[members].T
    if np.ptp(x * ny - y * nx) < spec.span:
        return None
    return members


def _fit(x: Floats, y: Floats, weights: Floats) -> tuple[float, float, float]:
    """Weighted total least squares: unit normal and offset."""
    total = weights.sum()
    mx, my = weights @ x / total, weights @ y / total
    x, y = x - mx, y - my
    wx = weights * x
    turn = 0.5 * math.atan2(2 * (wx @ y), wx @ x - (weights * y) @ y)
    nx, ny = -math.sin(turn), math.cos(turn)
    return nx, ny, nx * mx + ny * my
