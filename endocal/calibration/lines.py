"""Which edge points lie on one straight line, given a model: peaks of the vote map, strongest first."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from .edges import EdgePoints
from .straightness import Floats, Labels, Undistorted

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
    count = failures = 0
    free = np.zeros(len(edges), bool)
    free[pool] = True
    while count < MOST_LINES and failures < PATIENCE:
        peak = votes.strongest()
        if peak is None:
            break
        members = _members(edges, at, normals, votes.candidates(peak, free), peak, spec)
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
        self.row = np.full(total, -10, np.intp)
        self.column = np.full(total, -10, np.intp)
        self.row[pool[fits]], self.column[pool[fits]] = row[fits], column[fits]
        self.map = np.zeros((ANGLE_BINS, self.columns), np.float32)
        self._add(pool[fits], 1.0)
        self._smooth()

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
        mirrored = self.columns - 1 - peak.column
        near |= (turn >= ANGLE_BINS - 2) & (np.abs(self.column - mirrored) <= 3)
        return np.nonzero(near & free)[0]

    def strike(self, peak: _Peak) -> None:
        rows = slice(max(0, peak.row - 1), peak.row + 2)
        columns = slice(max(0, peak.column - 1), peak.column + 2)
        self.map[rows, columns] = 0
        self._smooth()

    def remove(self, members: Labels) -> None:
        self._add(members[self.row[members] >= 0], -1.0)
        np.maximum(self.map, 0, out=self.map)
        self._smooth()

    def _add(self, points: Labels, amount: float) -> None:
        cells = self.row[points] * self.columns + self.column[points]
        added = np.bincount(cells, minlength=self.map.size).reshape(self.map.shape)
        self.map += np.float32(amount) * added.astype(np.float32)

    def _smooth(self) -> None:
        """Sum 3x3 neighbours; above the first row lies the last one, turned round."""
        wrapped = np.vstack([self.map[-1:, ::-1], self.map, self.map[:1, ::-1]])
        self.smooth = cv2.boxFilter(
            wrapped, -1, (3, 3), normalize=False, borderType=cv2.BORDER_CONSTANT
        )[1:-1]


def _members(
    edges: EdgePoints,
    at: Undistorted,
    normals: Floats,
    near: Labels,
    peak: _Peak,
    spec: LineSpec,
) -> Labels | None:
    """The candidates on the line through a peak, fitted in three rounds; None where it is no line."""
    if len(near) < spec.points:
        return None
    normal = np.array([np.cos(peak.angle), np.sin(peak.angle)])
    offset = peak.offset
    u, d = at.u[near], at.d[near]
    denominator, slope = at.denominator[near], at.slope[near]
    gradient = normals[near]
    members = near
    for reach, turn in ((4.0, 2.0), (2.0, 1.5), (1.0, 1.0), (1.0, 1.0)):
        along = d @ normal
        pull = 2 * slope * along / denominator**2
        scale = np.hypot(*(normal / denominator[:, None] - pull[:, None] * d).T)
        inside = np.abs(u @ normal - offset) < reach * spec.distance * scale
        inside &= np.abs(gradient @ normal) > np.cos(min(turn * spec.angle, 0.5))
        if np.count_nonzero(inside) < spec.points:
            return None
        members = near[inside]
        normal, offset = _fit(u[inside], denominator[inside] ** 2)
    tangent = np.array([normal[1], -normal[0]])
    if np.ptp(edges.points[members] @ tangent) < spec.span:
        return None
    return members


def _fit(u: Floats, weights: Floats) -> tuple[Floats, float]:
    """Weighted total least squares: unit normal and offset."""
    mean = weights @ u / weights.sum()
    x, y = (u - mean).T
    wx, wy = weights * x, weights * y
    turn = 0.5 * np.arctan2(2 * (wx @ y), wx @ x - wy @ y)
    normal = np.array([-np.sin(turn), np.cos(turn)])
    return normal, float(normal @ mean)
