"""Where lines run in the distorted picture: places along them, and which way is across."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ...model import DivisionModel
from ..straightness import Floats, Labels, Undistorted, fit_lines

# A line is followed by the medians of its points over so many places.
FOLLOWED = 16
# More places than this add time and hardly any accuracy: beyond, they are spaced wider than a pixel. On 12
# megapixels, boards of more than thirty squares are told up to a third less well than by 40 000.
MOST_PLACES = 30_000


@dataclass(frozen=True)
class Courses:
    """Places ``at`` (m, 2) px in order along lines, their labels ``owner`` (m,), unit ``normals`` (m, 2)."""

    at: Floats
    owner: Labels
    normals: Floats


def courses(points: Floats, labels: Labels, params: Floats, follow: bool) -> Courses:
    """Return places 1 px apart or more from each line's first point to its last.

    ``points`` (n, 2) px with ``labels`` (n,) lie on lines that are straight under ``params`` (lam, cx, cy[,
    lam2]); with ``follow``, the places are where the points run, which is elsewhere for a lens that departs
    from the model.
    """
    at, owner = _along_lines(points, labels, params)
    normals = normals_of(at, owner, points, labels, params)
    if follow:
        at = at + _departures(at, owner, points, labels, params)[:, None] * normals
    return Courses(at, owner, normals)


def _along_lines(points: Floats, labels: Labels, params: Floats) -> tuple[Floats, Labels]:
    under = Undistorted.of(points, params)
    count = int(labels.max()) + 1
    lines = fit_lines(under.u, labels, count, under.denominator**2)
    model = DivisionModel(params[0], (0.0, 0.0), (1, 1), lam2=params[3] if len(params) > 3 else 0.0)
    found = []
    for i in range(count):
        tangent = np.array([lines.normals[i, 1], -lines.normals[i, 0]])
        t = under.u[labels == i] @ tangent
        # Even steps near the centre would be wide ones at the rim: step by distorted length.
        t = np.linspace(t.min(), t.max(), 129)
        foot = lines.offsets[i] * lines.normals[i]
        d = _distorted(foot + t[:, None] * tangent, model)
        length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(d, axis=0), axis=1))])
        if not np.isfinite(length[-1]):  # it runs past where the model folds: no place to measure
            continue
        found.append((i, foot, tangent, t, length))
    spacing = max(1.0, sum(course[-1][-1] for course in found) / MOST_PLACES)
    places, owners = [np.empty((0, 2))], [np.empty(0, np.intp)]
    for i, foot, tangent, t, length in found:
        steps = np.interp(np.arange(spacing / 2, length[-1], spacing), length, t)
        places.append(_distorted(foot + steps[:, None] * tangent, model) + params[1:3])
        owners.append(np.full(len(steps), i, np.intp))
    return np.concatenate(places), np.concatenate(owners)


def _distorted(u: Floats, model: DivisionModel) -> Floats:
    """Undistorted offsets (n, 2) from the centre to distorted ones."""
    return u * model.radial_ratio((u * u).sum(axis=1))[:, None]


def normals_of(at: Floats, owner: Labels, points: Floats, labels: Labels, params: Floats) -> Floats:
    """Unit normals (n, 2), in the distorted picture, of the lines at the places ``at``."""
    under = Undistorted.of(points, params)
    lines = fit_lines(under.u, labels, int(labels.max()) + 1, under.denominator**2)
    here = Undistorted.of(at, params)
    normals = here.pulled_back(lines.normals[owner])
    return normals / np.linalg.norm(normals, axis=1)[:, None]


def leading(points: Floats, labels: Labels, across: Floats) -> Floats:
    """Signs (n,): +1 where the normals ``across`` (n, 2) point to the left of the way that points go."""
    steps = np.gradient(points, axis=0)
    along = across[:, 1] * steps[:, 0] - across[:, 0] * steps[:, 1]
    ahead = np.bincount(labels, np.clip(along, -1, 1)) >= 0
    return np.where(ahead, 1.0, -1.0)[labels]


def _departures(
    at: Floats, owner: Labels, points: Floats, labels: Labels, params: Floats
) -> Floats:
    """How far (m,) px, along the normals, the points of lines run from the model's places ``at`` (m, 2)."""
    under = Undistorted.of(points, params)
    lines = fit_lines(under.u, labels, int(labels.max()) + 1, under.denominator**2)
    normals = lines.normals[labels]
    off = np.einsum("ij,ij->i", normals, under.u) - lines.offsets[labels]
    off /= under.scale(normals)
    # Where along the line: the nearest of its places, which are in order.
    nearest = np.full(len(points), -1)
    for line in np.unique(owner):
        here, own = np.flatnonzero(owner == line), labels == line
        nearest[own] = here[cKDTree(at[here]).query(points[own])[1]]
    # Places since the line's first one, and a line's bins after those of the lines before.
    since = np.arange(len(at)) - np.searchsorted(owner, owner)
    bins = np.cumsum(since % FOLLOWED == 0) - 1
    seen = nearest >= 0
    known, middles = _medians(bins[nearest[seen]], off[seen])
    out = np.zeros(len(at))
    for line in np.unique(owner):
        here = owner == line
        first = bins[here][0]
        own = (known >= first) & (known <= bins[here][-1])
        out[here] = np.interp(since[here], (known[own] - first + 0.5) * FOLLOWED, middles[own])
    return out


def _medians(bins: Labels, values: Floats) -> tuple[Labels, Floats]:
    """The bins that hold values (n,), and the median of each one's."""
    order = np.lexsort((values, bins))
    known, first, count = np.unique(bins[order], return_index=True, return_counts=True)
    low, high = values[order[first + (count - 1) // 2]], values[order[first + count // 2]]
    return known, (low + high) / 2
