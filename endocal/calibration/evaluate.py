"""How straight a model makes lines: the article's measure, and one that magnification does not move."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..model import DivisionModel
from .straightness import Floats, Labels, fit_lines, residuals, root_mean_square


@dataclass(frozen=True)
class LinePoints:
    """Points known to lie on straight lines.

    ``points`` (n, 2) px of the frame; ``labels`` (n,) of their lines, from 0; ``sides`` (n,), +1 or -1, on
    which side of its line a point of an edge is bright, where that is known: bright squares seem to grow.
    """

    points: Floats
    labels: Labels
    sides: Floats | None = None

    @classmethod
    def of(cls, lines: Sequence[Floats]) -> LinePoints:
        """Take the points (n, 2) px of each line."""
        labels = np.repeat(np.arange(len(lines)), [len(line) for line in lines])
        return cls(np.concatenate(lines), labels.astype(np.intp))

    @property
    def count(self) -> int:
        """How many lines there are."""
        return int(self.labels.max()) + 1


@dataclass(frozen=True)
class Evaluation:
    """How straight a model makes lines; root mean squares over all points, in px.

    ``rmse`` is the article's: in undistorted px, each line fitted by total least squares. A model that
    shrinks the picture lowers it. ``straightness`` is in px of the distorted picture, each distance divided
    by the magnification there. Both are infinite where the model folds before a point. ``_before``: without
    a model.
    """

    lines: int
    points: int
    rmse_before: float
    rmse: float
    straightness_before: float
    straightness: float


def evaluate(lines: LinePoints, model: DivisionModel) -> Evaluation:
    """Measure how straight ``model`` makes lines."""
    aspect = np.array([model.pixel_aspect, 1.0])
    square = lines.points * aspect
    undistorted = model.undistort(lines.points) * aspect
    params = np.array([model.lam, *(np.array(model.center) * aspect), model.lam2])
    none = np.array([0.0, *params[1:3]])
    folded = not np.all(np.isfinite(undistorted))
    return Evaluation(
        lines=lines.count,
        points=len(square),
        rmse_before=_rmse(square, lines),
        rmse=math.inf if folded else _rmse(undistorted, lines),
        straightness_before=root_mean_square(
            residuals(square, lines.labels, none, sides=lines.sides)
        ),
        straightness=math.inf
        if folded
        else root_mean_square(residuals(square, lines.labels, params, sides=lines.sides)),
    )


def _rmse(points: Floats, lines: LinePoints) -> float:
    """The article's RMSE of points (n, 2), px: distances to their lines by total least squares."""
    found = fit_lines(points, lines.labels, lines.count, np.ones(len(points)))
    normals = found.normals[lines.labels]
    return root_mean_square(np.einsum("ij,ij->i", normals, points) - found.offsets[lines.labels])
