"""Where measured lines run, summed up: what the points of a line say of any straight line near them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..measure.profiles import Measured
from ..straightness import (
    Floats,
    Labels,
    Lines,
    Totals,
    Undistorted,
    fit_lines_by,
    leftward,
    two_sided,
)


@dataclass(frozen=True)
class LinePlaces:
    """The places of n lines under a model, relative to its centre.

    A line l (3,), a unit normal and minus the offset in px, departs from the points' own best fit by
    ``sums`` (n, 2, 3) times l: two independent numbers, in px times the root of ``mass`` (n,), the sum of the
    points' weights; their squares add up to those of the distances that the departure means, in px of the
    picture as it is. Growth takes off ``growth`` (n, 2, g) times how much there is of each of its columns.
    ``normals`` (n, 2), ``offsets`` (n,) px: the best fit. ``moved`` (2, m): how the two numbers of
    its line grow as a point goes to the left, by px.
    """

    sums: Floats
    growth: Floats
    mass: Floats
    normals: Floats
    offsets: Floats
    moved: Floats

    @classmethod
    def of(
        cls, m: Measured, lines: Labels, params: Floats, weights: Floats, columns: Floats
    ) -> LinePlaces:
        """Sum up the points of ``lines`` (n,) under a model, with ``weights`` (m,) and growth (m, g)."""
        at = Undistorted.of(m.points, params)
        total = Totals(m.labels, int(m.labels.max()) + 1)
        own = fit_lines_by(at.u, m.labels, weights * at.denominator**2, total)
        # To the left of each: a fitted normal turns round as a line turns past some direction.
        left = leftward(m.points, m.labels, own.normals)
        own = Lines(own.normals * left[:, None], own.offsets * left)
        normals = own.normals.take(m.labels, axis=0)
        scale = at.scale(normals)
        along = (normals[:, 1] * at.u[:, 0] - normals[:, 0] * at.u[:, 1]) / scale

        def apart_from(column: Floats, values: Floats) -> Floats:
            size = np.maximum(total(weights * column**2), 1e-12)
            return values - column * (total(weights * values * column) / size)[m.labels]

        # How far apart the edges of both sides are belongs to each line, as its place and direction do.
        both_sides = two_sided(m.sides, m.labels)
        place = apart_from(both_sides, 1 / scale)
        turn = apart_from(place, apart_from(both_sides, along))
        sums, growth, moved = [], [], []
        for column in (place, turn):
            unit = column / np.sqrt(np.maximum(total(weights * column**2), 1e-12))[m.labels]
            over = weights * unit
            sums.append([total(over * v / scale)[lines] for v in (*at.u.T, np.ones(len(scale)))])
            growth.append([total(over * c)[lines] for c in columns.T])
            moved.append(over)
        return cls(
            np.array(sums).transpose(2, 0, 1),
            np.array(growth).reshape(2, -1, len(lines)).transpose(2, 0, 1),
            total(weights)[lines],
            own.normals[lines],
            own.offsets[lines],
            np.array(moved),
        )

    def off(self, lines: Floats, grown: Floats) -> Floats:
        """How far ``lines`` (n, 3) depart from the points' own, (n, 2), with so much of each growth."""
        same_way = np.einsum("ni,ni->n", self.normals, lines[:, :2]) >= 0
        turned = np.where(same_way[:, None], lines, -lines)
        return np.asarray(np.einsum("nij,nj->ni", self.sums, turned) - self.growth @ grown)
