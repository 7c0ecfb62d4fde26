"""The farthest corners of a board, from several looks at it of which each may have missed some.

How far a corner is sent out bounds the model of a wide lens: without the farthest one the model may fold
before it. Of nearer ones the neighbours tell as much, and what a look missed is mostly badly seen.

A look numbers rows and columns from a first one of its own, and either family may be its rows: the corners
that both show tell how one's numbers become the other's.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from ..straightness import Floats, Labels
from .lifted import Corners

# Corners of two looks nearer to each other than this, px, are one.
SAME = 2.0
# Two looks are at one board if they have so many corners in common, and this share of them agrees how one's
# numbers become the other's.
FEWEST_COMMON, MOST_AGREE = 9, 0.8
# Rows and columns may be exchanged, and each counted backwards.
TURNS = [
    np.array(t) @ np.diag(s)
    for t in ([[1, 0], [0, 1]], [[0, 1], [1, 0]])
    for s in ((1, 1), (1, -1), (-1, 1), (-1, -1))
]


def united(looks: Sequence[Corners], center: Floats) -> Corners:
    """Return the corners of the first look, and those of others that lie farther out than any of it.

    That is, farther from ``center`` (2,) px. They are numbered as its own; a look that shows another board,
    or numbers this one otherwise, adds nothing.
    """
    whole = looks[0]
    for look in looks[1:]:
        whole = _with(whole, look, center)
    return whole


def _with(board: Corners, look: Corners, center: Floats) -> Corners:
    if min(len(board.points), len(look.points)) < FEWEST_COMMON:
        return board
    away, nearest = cKDTree(board.points).query(look.points)
    common = away < SAME
    places = _renumbered(look.places, common, board.places[nearest])
    if places is None:
        return board
    taken = {*map(tuple, board.places.tolist())}
    new = ~common & np.array([tuple(place) not in taken for place in places.tolist()])
    reach = np.linalg.norm(board.points - center, axis=1).max()
    new &= np.linalg.norm(look.points - center, axis=1) > reach
    return Corners(
        np.concatenate([board.points, look.points[new]]),
        np.concatenate([board.places, places[new]]),
    )


def _renumbered(places: Labels, common: Labels, wanted: Labels) -> Labels | None:
    """Places (n, 2) numbered so that the ``common`` ones (n,) are as ``wanted`` (n, 2); None: they differ."""
    best, most = None, 0
    for turn in TURNS:
        turned = places @ turn
        shifts = Counter(map(tuple, (wanted - turned)[common].tolist()))
        shift, agree = shifts.most_common(1)[0] if shifts else ((0, 0), 0)
        if agree > most:
            best, most = turned + shift, agree
    enough = max(FEWEST_COMMON, MOST_AGREE * np.count_nonzero(common))
    return best if most >= enough else None
