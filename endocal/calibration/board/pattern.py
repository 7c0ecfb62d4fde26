"""Which measured points belong to the pattern, and which lines are one line found twice."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ..measure.profiles import Measured
from ..straightness import Floats, Labels, Undistorted, fit_lines
from .lattice import Crossings, joined

# A side must hold for this many profiles in a row to count as a square of a chessboard.
SHORTEST_RUN = 4
# A line of a chessboard meets at least this many others, and a board shows at least this many lines.
FEWEST_CROSSINGS = 3
FEWEST_BOARD_LINES = 6
# Two lines that change sides within this many px of each other cross there: near a crossing the edge is
# too weak to be measured, so that either change is known to a few px.
CROSSING = 8.0
# The direction of a line at a crossing is taken over so many profiles to both sides.
DIRECTION = 6
# Near a crossing, px along the line from the last profile on its side, and at most this share of a square.
CLEAR, CLEAR_SHARE = 2.5, 0.2
# Points of two lines nearer to each other than this, px, where the lines run along each other (the cosine of
# their angle), are one edge measured twice; a line with this share of such points is none of its own.
TWICE, ALONG, MOST_AGAIN = 1.5, 0.95, 0.3
# Two lines that cross at a smaller angle than this one's sine are pieces of one.
LEAST_SINE = 0.2
# A line goes on beyond its last crossing by one square, which perspective may stretch by this much.
LAST_SQUARE = 1.4


@dataclass(frozen=True)
class _Changes:
    """Where lines change sides: places (m, 2) px, line labels (m,), indices (m,) into the points.

    In order along the lines, whose directions there, unit vectors (m, 2), are ``ways``.
    """

    places: Floats
    labels: Labels
    index: Labels
    ways: Floats

    @property
    def rank(self) -> Labels:
        """The number of each change on its line."""
        return np.arange(len(self.labels)) - np.searchsorted(self.labels, self.labels)


def on_board(measured: Measured) -> NDArray[np.bool_] | None:
    """Which points (n,) lie on a chessboard; None where no chessboard is there.

    At every corner of a chessboard two lines cross and both change sides. The largest set of lines that
    such crossings connect is the board; each line belongs to it from its first crossing to its last, and
    one square beyond. Other straight things in the room may be bent, or be the rim's, and are left out.
    """
    if len(measured.points) == 0:
        return None
    changes = _changes_of_side(measured)
    count = int(measured.labels.max()) + 1
    crossing, board = _crossings(changes, count)
    for _ in range(3):
        met = np.bincount(changes.labels[crossing], minlength=count)
        board &= met >= FEWEST_CROSSINGS
        if np.count_nonzero(board) < FEWEST_BOARD_LINES:
            return None
        crossing, board = _crossings(changes, count, board)
    return _between_crossings(measured, changes, crossing, board)


def join_pieces(measured: Measured) -> Measured:
    """Give one label to the pieces of each line of a chessboard, where a model broke it."""
    if len(measured.points) == 0:
        return measured
    crossings = crossings_of(measured)
    if len(crossings.lines) == 0:
        return measured
    count = int(measured.labels.max()) + 1
    becomes = joined(crossings, count)
    if np.array_equal(becomes, np.arange(count)):
        return measured
    return _in_order(measured, becomes[measured.labels])


def crossings_of(measured: Measured) -> Crossings:
    """Return where two lines both change sides; places are good to a px or two."""
    changes = _changes_of_side(measured)
    pairs = _meetings(changes)
    turn = np.sign(_sine(changes, pairs)).astype(np.intp)
    places = changes.places[pairs].mean(axis=1)
    return Crossings(changes.labels[pairs], changes.rank[pairs], turn, places)


def _in_order(measured: Measured, labels: Labels) -> Measured:
    """The points with new labels, numbered from 0, in order along the chords of their lines."""
    labels = np.unique(labels, return_inverse=True)[1].astype(np.intp)
    along = np.empty(len(labels))
    sides = measured.sides.copy()
    for line in range(int(labels.max()) + 1):
        own = labels == line
        middle = measured.points[own].mean(axis=0)
        chord = np.linalg.svd(measured.points[own] - middle, full_matrices=False)[2][0]
        along[own] = (measured.points[own] - middle) @ chord
        for piece in np.unique(measured.labels[own]):
            points = np.flatnonzero(measured.labels == piece)
            # Gone along the other way, left is right.
            sides[points] *= 1 if along[points[-1]] >= along[points[0]] else -1
    order = np.lexsort((along, labels))
    return replace(measured, sides=sides).in_order(order, labels[order])


def _changes_of_side(measured: Measured) -> _Changes:
    new_line = np.diff(measured.labels, prepend=-1) != 0
    starts = np.flatnonzero(new_line | (np.diff(measured.sides, prepend=0) != 0))
    ends = np.append(starts[1:], len(measured.labels))
    keep = ends - starts >= SHORTEST_RUN
    starts, ends = starts[keep], ends[keep]
    label, side = measured.labels[starts], measured.sides[starts]
    changed = (label[1:] == label[:-1]) & (side[1:] != side[:-1])
    before, after = measured.points[ends[:-1] - 1], measured.points[starts[1:]]
    index, labels = starts[1:][changed], label[1:][changed]
    return _Changes(((before + after) / 2)[changed], labels, index, _ways(measured, index, labels))


def clear_of_crossings(measured: Measured) -> NDArray[np.bool_]:
    """Which points (n,) lie far enough from where their line crosses another to be told without bias.

    Two edges that cross at a slant draw each other off their courses, as far as smoothing and blur reach.
    """
    if len(measured.points) == 0:
        return np.ones(0, bool)
    new_line = np.diff(measured.labels, prepend=-1) != 0
    changed = (np.diff(measured.sides, prepend=0) != 0) & ~new_line
    steps = np.linalg.norm(np.diff(measured.points, axis=0, prepend=measured.points[:1]), axis=1)
    along = np.cumsum(steps)
    crossed = changed & (steps <= CROSSING)
    first = np.flatnonzero(measured.edge_starts())
    last = np.append(first[1:], len(along)) - 1
    count = last - first + 1
    length = along[last] - along[first]
    at_crossing = np.minimum(CLEAR, CLEAR_SHARE * length)
    low = along[first] + np.where(crossed[first], at_crossing, 0)
    goes_on = np.append(crossed[first[1:]], False)
    high = along[last] - np.where(goes_on, at_crossing, 0)
    return (along >= np.repeat(low, count)) & (along <= np.repeat(high, count))


def measured_once(measured: Measured) -> NDArray[np.bool_]:
    """Which points (n,) are on lines that are not, for a good part, longer lines found again."""
    keep = np.ones(len(measured.points), bool)
    if len(keep) == 0:
        return keep
    pairs = cKDTree(measured.points).query_pairs(TWICE, output_type="ndarray").reshape(-1, 2)
    pairs = pairs[measured.labels[pairs[:, 0]] != measured.labels[pairs[:, 1]]]
    ways = _ways(measured, np.arange(len(keep)), measured.labels)
    a, b = pairs[np.abs(np.einsum("ij,ij->i", ways[pairs[:, 0]], ways[pairs[:, 1]])) > ALONG].T
    lengths = np.bincount(measured.labels)
    shorter = np.where(lengths[measured.labels[a]] < lengths[measured.labels[b]], a, b)
    again = np.zeros(len(keep), bool)
    again[shorter] = True
    share = np.bincount(measured.labels, again) / lengths
    return np.asarray(~again & (share < MOST_AGAIN)[measured.labels])


def _ways(measured: Measured, index: Labels, labels: Labels) -> Floats:
    """The directions, unit vectors (m, 2), in which the points of lines follow each other at ``index``."""
    first = np.searchsorted(measured.labels, labels)
    last = np.searchsorted(measured.labels, labels, side="right") - 1
    ahead = measured.points[np.minimum(index + DIRECTION, last)]
    way = ahead - measured.points[np.maximum(index - DIRECTION, first)]
    return way / np.maximum(np.linalg.norm(way, axis=1), 1e-12)[:, None]


def _meetings(changes: _Changes) -> Labels:
    """Pairs (k, 2) of changes of different lines at one place."""
    pairs = cKDTree(changes.places).query_pairs(CROSSING, output_type="ndarray").reshape(-1, 2)
    different = changes.labels[pairs[:, 0]] != changes.labels[pairs[:, 1]]
    return np.asarray(pairs[different & (np.abs(_sine(changes, pairs)) > LEAST_SINE)], np.intp)


def _sine(changes: _Changes, pairs: Labels) -> Floats:
    """The sine (k,) of the angle from the first line's direction to the second's."""
    (ax, ay), (bx, by) = changes.ways[pairs[:, 0]].T, changes.ways[pairs[:, 1]].T
    return np.asarray(ax * by - ay * bx)


def _crossings(
    changes: _Changes, count: int, among: NDArray[np.bool_] | None = None
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Which changes (m,) are crossings of two lines, and which lines (n,) hang together by them."""
    pairs = _meetings(changes)
    a, b = changes.labels[pairs].T
    if among is not None:
        real = among[a] & among[b]
        pairs, a, b = pairs[real], a[real], b[real]
    graph = coo_array((np.ones(len(a)), (a, b)), shape=(count, count))
    _, component = connected_components(graph, directed=False)
    largest = np.bincount(component[a], minlength=1).argmax() if len(a) else 0
    crossing = np.zeros(len(changes.labels), bool)
    crossing[pairs.ravel()] = True
    return crossing, component == largest


def _between_crossings(
    measured: Measured,
    changes: _Changes,
    crossing: NDArray[np.bool_],
    board: NDArray[np.bool_],
) -> NDArray[np.bool_]:
    keep = np.zeros(len(measured.points), bool)
    steps = np.linalg.norm(np.diff(measured.points, axis=0, prepend=measured.points[:1]), axis=1)
    along = np.cumsum(steps)
    for line in np.flatnonzero(board):
        own = np.flatnonzero(measured.labels == line)
        at = np.sort(along[changes.index[crossing & (changes.labels == line)]])
        if len(at) < FEWEST_CROSSINGS:  # the last line that it met has just been dropped
            continue
        first = at[0] - LAST_SQUARE * (at[1] - at[0])
        last = at[-1] + LAST_SQUARE * (at[-1] - at[-2])
        keep[own[(along[own] >= first) & (along[own] <= last)]] = True
    return keep


def merge_twins(points: Floats, labels: Labels, params: Floats, distance: float) -> Labels:
    """Give one label to lines that run within ``distance`` px of each other where they overlap.

    Noise can split the points of one line among two; measured twice, they would count twice.
    """
    count = int(labels.max()) + 1
    under = Undistorted.of(points, params)
    lines = fit_lines(under.u, labels, count, under.denominator**2)
    sizes = np.bincount(labels, minlength=count)
    order = np.argsort(-sizes)
    becomes = np.arange(count)
    scale = under.scale(lines.normals[labels])
    members = np.split(np.argsort(labels, kind="stable"), np.cumsum(sizes)[:-1])
    for position, i in enumerate(order):
        if becomes[i] != i:
            continue
        turned = np.abs(lines.normals @ lines.normals[i])
        for j in order[position + 1 :]:
            if becomes[j] != j or turned[j] < 0.97:
                continue
            mine = members[j]
            off = np.abs(under.u[mine] @ lines.normals[i] - lines.offsets[i]) / scale[mine]
            if np.quantile(off, 0.8) < distance:
                becomes[j] = i
    return np.unique(becomes[labels], return_inverse=True)[1].astype(np.intp)
