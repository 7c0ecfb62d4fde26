"""Edges measured again, to sub-pixel, on profiles across the lines that a model predicts.

A line of a chessboard changes sides at every crossing. Its edge point on a profile across the *line* stays
unbiased there, where the gradient of the blurred crossing turns away from the line's normal.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ..model import DivisionModel
from .picture import Grey
from .sampling import sample
from .straightness import Floats, Labels, Undistorted, fit_lines

# Smoothing of the picture before profiles are taken, px (sigma), for sharp pictures and for noisy ones: what
# noise does to an edge is least when it is smoothed by about twice its own blur. And how many neighbouring
# profiles along a line are averaged (their derivatives, with sign).
FINE, WIDE = 1.2, 1.7
NEIGHBORS = 5
# A profile counts where its edge has this share of the line's usual strength: less near a crossing.
LEAST_STRENGTH = 0.4
# A line is followed by the medians of its points over so many profiles.
FOLLOWED = 16
# More profiles than this add time and no accuracy: beyond, they are spaced wider than a pixel.
MOST_PROFILES = 40_000


@dataclass(frozen=True)
class Measured:
    """Edge points in order along their lines.

    ``points`` (n, 2) px; ``labels`` (n,) of their lines; ``sides`` (n,), +1 or -1: which side is bright.
    """

    points: Floats
    labels: Labels
    sides: Floats

    @classmethod
    def none(cls) -> Measured:
        """No point at all."""
        return cls(np.empty((0, 2)), np.empty(0, np.intp), np.empty(0))

    def take(self, chosen: NDArray[np.bool_]) -> Measured:
        """Return some of the points, by mask, with labels renumbered from 0."""
        labels = np.unique(self.labels[chosen], return_inverse=True)[1].astype(np.intp)
        return Measured(self.points[chosen], labels, self.sides[chosen])

    def thinned(self, most: int) -> Measured:
        """Return every second, third, … point, so that about ``most`` remain."""
        step = len(self.points) // most
        if step < 2:
            return self
        return self.take(np.arange(len(self.points)) % step == 0)


def smooth_for_profiles(grey: Grey, sigma: float) -> Grey:
    """The picture that ``measure`` samples, smoothed by ``sigma`` px."""
    return np.asarray(cv2.GaussianBlur(grey, (0, 0), sigma, borderType=cv2.BORDER_REPLICATE))


def measure(
    smooth: Grey,
    points: Floats,
    labels: Labels,
    params: Floats,
    reach: int,
    follow: bool = False,
) -> Measured:
    """Measure the lines through ``points`` (n, 2) with ``labels`` (n,) again, one profile a pixel.

    ``reach`` px to both sides of where ``params`` (lam, cx, cy[, lam2]) says a line runs; with ``follow``, of
    where its points run, which is elsewhere for a lens that departs from the model.
    """
    at, owner = _along_lines(points, labels, params)
    normals = _normals(at, owner, points, labels, params)
    if follow:
        at = at + _departures(at, owner, points, labels, params)[:, None] * normals
    offsets = np.arange(-reach - 1, reach + 2, dtype=np.float64)
    levels = sample(smooth, at[:, None] + offsets[:, None] * normals[:, None])
    across = _average_along((levels[:, 2:] - levels[:, :-2]) / 2, owner)
    index, rows = np.abs(across).argmax(axis=1), np.arange(len(across))
    peak = across[rows, index]
    sides = np.sign(peak).astype(np.float64)
    strength = np.abs(peak)
    count = int(labels.max()) + 1
    usual = np.array(
        [np.median(strength[owner == i]) if np.any(owner == i) else 0 for i in range(count)]
    )
    good = (index > 0) & (index < 2 * reach) & (strength > LEAST_STRENGTH * usual[owner])
    h, w = smooth.shape
    far = at + np.sign(normals) * (reach + 2)
    near = at - np.sign(normals) * (reach + 2)
    for end in (near, far):
        good &= (end >= 0).all(axis=1) & (end[:, 0] <= w - 1) & (end[:, 1] <= h - 1)
    rows, index = rows[good], index[good]
    before, after = across[rows, index - 1], across[rows, index + 1]
    top = before - 2 * peak[good] + after
    shift = (before - after) / 2 / np.where(np.abs(top) < 1e-6, 1e-6, top)
    offset = index - reach + np.clip(shift, -0.75, 0.75)
    return Measured(at[good] + offset[:, None] * normals[good], owner[good], sides[good])


def _along_lines(points: Floats, labels: Labels, params: Floats) -> tuple[Floats, Labels]:
    """Places, 1 px apart or more, from each line's first point to its last, and their lines."""
    under = Undistorted.of(points, params)
    count = int(labels.max()) + 1
    lines = fit_lines(under.u, labels, count, under.denominator**2)
    model = DivisionModel(params[0], (0.0, 0.0), (1, 1), lam2=params[3] if len(params) > 3 else 0.0)
    courses = []
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
        courses.append((i, foot, tangent, t, length))
    spacing = max(1.0, sum(course[-1][-1] for course in courses) / MOST_PROFILES)
    places, owners = [np.empty((0, 2))], [np.empty(0, np.intp)]
    for i, foot, tangent, t, length in courses:
        steps = np.interp(np.arange(spacing / 2, length[-1], spacing), length, t)
        places.append(_distorted(foot + steps[:, None] * tangent, model) + params[1:3])
        owners.append(np.full(len(steps), i, np.intp))
    return np.concatenate(places), np.concatenate(owners)


def _distorted(u: Floats, model: DivisionModel) -> Floats:
    """Undistorted offsets (n, 2) from the centre to distorted ones."""
    return u * model.radial_ratio((u * u).sum(axis=1))[:, None]


def _normals(at: Floats, owner: Labels, points: Floats, labels: Labels, params: Floats) -> Floats:
    """Unit normals (n, 2), in the distorted picture, of the lines at the places ``at``."""
    under = Undistorted.of(points, params)
    lines = fit_lines(under.u, labels, int(labels.max()) + 1, under.denominator**2)
    here = Undistorted.of(at, params)
    normals = here.pulled_back(lines.normals[owner])
    return normals / np.linalg.norm(normals, axis=1)[:, None]


def _departures(
    at: Floats, owner: Labels, points: Floats, labels: Labels, params: Floats
) -> Floats:
    """How far (m,) px, along the normals, the points of lines run from the model's places ``at`` (m, 2)."""
    under = Undistorted.of(points, params)
    lines = fit_lines(under.u, labels, int(labels.max()) + 1, under.denominator**2)
    normals = lines.normals[labels]
    off = np.einsum("ij,ij->i", normals, under.u) - lines.offsets[labels]
    off /= under.scale(normals)
    out = np.zeros(len(at))
    for i in range(len(lines.offsets)):
        here, own = owner == i, labels == i
        if not here.any():
            continue
        # Where along the line: the nearest of its places, which are in order.
        along = cKDTree(at[here]).query(points[own])[1]
        bins = along // FOLLOWED
        known = np.unique(bins)
        middles = [np.median(off[own][bins == b]) for b in known]
        out[here] = np.interp(np.arange(np.count_nonzero(here)), (known + 0.5) * FOLLOWED, middles)
    return out


def _average_along(across: NDArray[np.floating], owner: Labels) -> Floats:
    """Average each profile with its neighbours on the same line."""
    half = NEIGHBORS // 2
    total = across.astype(np.float64)
    for step in range(1, half + 1):
        same = (owner[step:] == owner[:-step])[:, None]
        total[step:] += np.where(same, across[:-step], 0)
        total[:-step] += np.where(same, across[step:], 0)
    return total / NEIGHBORS
