"""Parallel bars of one width: the numbers of their long edges, and the rows of their ends.

Under a model the long edges are straight and run to one vanishing point. Across them they follow each other
at one distance, as perspective has it, the bright side left and right by turns: that tells which were missed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..measure.profiles import Measured
from ..straightness import Floats, Labels, Undistorted, fit_lines, two_sided
from .pencils import pencils_through

# Lines are of one pencil where the vanishing point lies within this angle's sine of their directions.
CONCURRENT = 0.01
# Edges that are numbered, at least; how far each may lie from its place, in distances between them; and the
# share of the pencil's lines that must have a number.
FEWEST_EDGES = 7
MOST_ASIDE = 0.15
MOST_NUMBERED = 0.6
# Neighbours that an edge is numbered by.
NEIGHBORS = 5
# A row of ends shows so many bars at least, and this share of its points lies on bars.
FEWEST_BARS = 3
ON_BARS, EDGE = 0.9, 0.1


@dataclass(frozen=True)
class Bars:
    """Parallel bars: labels and numbers (n,) of their long ``edges``, labels of the ``rows`` of ends."""

    edges: Labels
    numbers: Labels
    rows: Labels


def bars_of(measured: Measured, params: Floats) -> Bars | None:
    """Find the bars among measured lines, which are straight under ``params``; None where there are none."""
    count = int(measured.labels.max()) + 1 if len(measured.labels) else 0
    if count < FEWEST_EDGES:
        return None
    at = Undistorted.of(measured.points, params)
    reach = float(np.abs(at.u).max())
    u = at.u / reach
    fitted = fit_lines(u, measured.labels, count, at.denominator**2)
    lines = np.column_stack([fitted.normals, -fitted.offsets])
    mass = np.bincount(measured.labels, minlength=count)
    middles = np.stack([np.bincount(measured.labels, x, count) / mass for x in u.T], axis=1)
    edges = _largest_pencil(lines, middles, mass)
    if len(edges) < FEWEST_EDGES:
        return None
    across = _across(lines[edges], middles[edges], mass[edges])
    bright = _bright_ahead(measured, u, edges, across)
    order = np.argsort(across.places)
    numbers, kept = _numbered(across.places[order], bright[order])
    if np.count_nonzero(kept) < max(FEWEST_EDGES, MOST_NUMBERED * len(edges)):
        return None
    chosen = edges[order][kept]
    # A bar begins where the bright side is behind.
    dark = numbers[kept] + np.where(bright[order][kept] > 0, 1, 0)
    rows = _rows_of_ends(measured, u, edges, lines[chosen], numbers[kept], int(dark[0]) % 2)
    return Bars(chosen, numbers[kept], rows)


@dataclass(frozen=True)
class _Across:
    """A straight way across a pencil: where its lines cross it, ``places`` (n,), and its direction (2,)."""

    places: Floats
    way: Floats


def _largest_pencil(lines: Floats, middles: Floats, mass: Labels) -> Labels:
    """The lines (n, 3), through ``middles`` (n, 2), that run to one point: those with most points in all."""
    i, j = np.triu_indices(len(lines), 1)
    points = np.cross(lines[i], lines[j])
    points /= np.maximum(np.linalg.norm(points, axis=1), 1e-300)[:, None]
    # How far the vanishing point lies beside the line, seen from the line's middle.
    beside = points @ lines.T
    to = points[:, None, :2] - points[:, None, 2:] * middles[None]
    sine = np.abs(beside) / np.maximum(np.linalg.norm(to, axis=2), 1e-300)
    best = int(np.argmax((sine < CONCURRENT) @ mass))
    return np.flatnonzero(sine[best] < CONCURRENT)


def _across(lines: Floats, middles: Floats, mass: Labels) -> _Across:
    """A way across lines that run alike, through the middle of their points."""
    tensor = np.einsum("n,ni,nj->ij", mass, lines[:, :2], lines[:, :2])
    way = np.linalg.eigh(tensor)[1][:, -1]
    start = np.average(middles, axis=0, weights=mass)
    places = -(lines[:, :2] @ start + lines[:, 2]) / (lines[:, :2] @ way)
    return _Across(places, way)


def _bright_ahead(measured: Measured, u: Floats, edges: Labels, across: _Across) -> Floats:
    """Whether each edge is bright on the far side as one goes across, (n,): +1, or -1; 0 by turns."""
    starts = np.searchsorted(measured.labels, np.append(edges, edges + 1)).reshape(2, -1)
    run = u[starts[1] - 1] - u[starts[0]]
    left = np.sign(np.stack([-run[:, 1], run[:, 0]], axis=1) @ across.way)
    side = np.sign([measured.sides[a:b].mean() for a, b in starts.T])
    by_turns = two_sided(measured.sides, measured.labels)[starts[0]] != 0
    return np.where(by_turns, 0.0, left * side)


def _numbered(places: Floats, bright: Floats) -> tuple[Labels, NDArray[np.bool_]]:
    """Number edges at ``places`` (n,), in order across the bars: numbers (n,), and which (n,) have one."""
    best = np.zeros(len(places), np.intp), np.zeros(len(places), bool)
    for first in range(len(places) - 2):
        if np.all(np.abs(np.diff(bright[first : first + 3])) == 2):
            numbers, known = _counted_from(first, places, bright)
            kept = _in_place(places, numbers, known)
            if np.count_nonzero(kept) > np.count_nonzero(best[1]):
                best = numbers, kept
    return best


def _counted_from(first: int, places: Floats, bright: Floats) -> tuple[Labels, NDArray[np.bool_]]:
    """Count edges from three that follow each other, each where the scale of its neighbours has it."""
    numbers, known = np.zeros(len(places), np.intp), np.zeros(len(places), bool)
    numbers[first : first + 3], known[first : first + 3] = (0, 1, 2), True
    for way, rest in ((1, range(first + 3, len(places))), (-1, range(first - 1, -1, -1))):
        for i in rest:
            if bright[i] == 0:
                continue
            near = np.flatnonzero(known)
            near = near[np.argsort(np.abs(near - i))[:NEIGHBORS]]
            steps = way * (
                _number_at(_scale(numbers[near], places[near]), places[i]) - numbers[near[0]]
            )
            # Every other edge is bright on the same side.
            odd = int(bright[i] != bright[near[0]])
            step = 2 * np.rint((steps - odd) / 2) + odd
            if step >= 1 and abs(step - steps) < 2 * MOST_ASIDE:
                numbers[i], known[i] = numbers[near[0]] + way * int(step), True
    return numbers, known


def _scale(numbers: Labels, places: Floats) -> Floats:
    """(a, b, c) of place = (a + b k) / (1 + c k), three or more numbers k, by least squares."""
    k = numbers.astype(np.float64)
    columns = np.stack([np.ones_like(k), k, -k * places], axis=1)
    return np.asarray(np.linalg.lstsq(columns, places, rcond=None)[0])


def _number_at(scale: Floats, place: float) -> float:
    a, b, c = scale
    return float((place - a) / (b - c * place)) if b != c * place else np.inf


def _in_place(places: Floats, numbers: Labels, known: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which of the edges ``known`` (n,) by number are where one scale for all has them."""
    kept = known
    for _ in range(3):
        if np.count_nonzero(kept) < FEWEST_EDGES:
            break
        scale = _scale(numbers[kept], places[kept])
        k = np.array([_number_at(scale, place) for place in places])
        kept = known & (np.abs(k - numbers) < MOST_ASIDE)
    return kept


def _rows_of_ends(
    measured: Measured, u: Floats, edges: Labels, lines: Floats, numbers: Labels, begin: int
) -> Labels:
    """The lines whose points lie on bars only, on several; bars begin at numbers of parity ``begin``."""
    families, placed = np.zeros(len(lines), np.intp), np.ones(len(lines), bool)
    pencil = pencils_through(lines, families, numbers.astype(np.float64), placed, 1.0)[0]
    rows = []
    for line in np.setdiff1d(np.unique(measured.labels), edges):
        points = u[measured.labels == line]
        k = pencil.numbers_at(points)
        bar = np.floor((k - begin + EDGE) / 2)
        on = (k - begin) - 2 * bar < 1 + EDGE
        inside = (k > numbers.min() - EDGE) & (k < numbers.max() + EDGE)
        if (on & inside).mean() > ON_BARS and len(np.unique(bar[on & inside])) >= FEWEST_BARS:
            rows.append(line)
    return np.array(rows, np.intp)
