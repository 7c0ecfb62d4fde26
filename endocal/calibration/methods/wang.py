"""Wang: lambda and centre from the circle arcs that lines become (Wang, Qiu & Shao 2009).

A. Wang, T. Qiu, L. Shao, "A Simple Method of Radial Distortion Correction with Centre of Distortion
Estimation", Journal of Mathematical Imaging and Vision 35 (2009) 165-172, doi:10.1007/s10851-009-0162-1.
Under the division model a straight line is seen as a circle arc, x^2 + y^2 + A x + B y + C = 0. A circle is
fitted to each chosen line by least squares of the distances (Levenberg and Marquardt), and since
cx^2 + cy^2 + A cx + B cy + C = 1 / lam for all of them, three arcs give centre and lambda.

What is left open, and what is done here: circles as a (x^2 + y^2) + b x + c y + d = 0 with
b^2 + c^2 - 4 a d = 1 (Pratt 1987), which a line seen straight has too, with a = 0. Then
a t + b cx + c cy + d = 0 with t = |c|^2 - 1 / lam is linear in (cx, cy, t); more than three arcs are solved
for by least squares, each weighted by how well its fit knows that sum, and the less the farther it is off, as
a line chosen wrongly would be. The lines are those of ``--lines``, else MOST_LINES that our own line finder
sees, those of most points: as many as were chosen by hand for the article under comparison ("Wang17").
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from ...errors import CalibrationError
from ..fit.plumb_line import Prior
from ..search import Found
from ..straightness import Floats, residuals
from .chosen import chosen_lines
from .task import Task

MOST_LINES = 17
FEWEST_LINES = 3
FEWEST_POINTS = 3
# A line of so few points says nothing about its own noise; edges are found to about so many px.
LEAST_NOISE = 0.05
ROUNDS = 10


@dataclass(frozen=True)
class Arc:
    """(b, c, d, a) of a circle, in units of px, and the covariance (4, 4) of these."""

    coefficients: Floats
    covariance: Floats


def solve(task: Task) -> Found:
    """Return the model; CalibrationError where there are too few lines, or none is bent."""
    lines = [line for line in chosen_lines(task) if len(line) >= FEWEST_POINTS]
    if task.lines is None:
        lines = lines[:MOST_LINES]
    needed = 1 if task.prior.fixed else FEWEST_LINES
    if len(lines) < needed:
        raise CalibrationError(
            f"only {len(lines)} lines: the method wang needs {needed} or more, of {FEWEST_POINTS} points each"
        )
    params = model_of([fit_arc(line) for line in lines], task.prior)
    points = np.concatenate(lines)
    labels = np.repeat(np.arange(len(lines)), [len(line) for line in lines])
    return Found(params, float(np.sqrt((residuals(points, labels, params) ** 2).mean())), 1)


def fit_arc(points: Floats) -> Arc:
    """Fit a circle, or a straight line, to points (n, 2) px by their distances to it."""
    middle = points.mean(axis=0)
    unit = float(np.abs(points - middle).max()) or 1.0
    x, y = ((points - middle) / unit).T
    q = x * x + y * y

    def coefficients(params: Floats) -> Floats:
        a, turn, d = params
        # Pratt's norm, as far as a step of the fit leaves it one.
        size = np.sqrt(max(1 + 4 * a * d, 1e-12))
        return np.array([size * np.cos(turn), size * np.sin(turn), d, a])

    def distances(params: Floats) -> Floats:
        b, c, d, a = coefficients(params)
        f = a * q + b * x + c * y + d
        return np.asarray(2 * f / (1 + np.sqrt(np.maximum(1 + 4 * a * f, 0))))

    _, _, directions = np.linalg.svd(np.stack([x, y], axis=1), full_matrices=True)
    turn = float(np.arctan2(directions[1, 1], directions[1, 0]))
    fit = least_squares(distances, np.array([0.0, turn, 0.0]), method="lm")
    noise = np.sqrt(2 * fit.cost / max(len(points) - 3, 1))
    covariance = np.linalg.pinv(fit.jac.T @ fit.jac) * max(noise, LEAST_NOISE / unit) ** 2
    slope = np.stack(
        [(coefficients(fit.x + e) - coefficients(fit.x - e)) / 2e-6 for e in 1e-6 * np.eye(3)],
        axis=1,
    )
    # Back to px: (x - mx) / unit for x, the whole times unit so that the norm stays 1.
    mx, my = middle
    back = np.array(
        [
            [1, 0, 0, -2 * mx / unit],
            [0, 1, 0, -2 * my / unit],
            [-mx, -my, unit, (mx * mx + my * my) / unit],
            [0, 0, 0, 1 / unit],
        ]
    )
    spread = back @ slope
    return Arc(back @ coefficients(fit.x), spread @ covariance @ spread.T)


def model_of(arcs: Sequence[Arc], prior: Prior) -> Floats:
    """Return (lam px^-2, cx px, cy px) of the arcs; a centre that ``prior`` gives is kept.

    CalibrationError where the arcs do not tell it.
    """
    free = [3] if prior.fixed else [0, 1, 3]
    rows = np.stack([arc.coefficients for arc in arcs])
    at = np.array([*prior.center, 1.0, 0.0])
    # t has another size than a centre: columns are brought to one.
    unit = np.maximum(np.abs(rows).max(axis=0), 1e-300)
    weights = np.ones(len(arcs))
    for _ in range(ROUNDS):
        fixed = [i for i in range(4) if i not in free]
        off = rows[:, fixed] @ at[fixed]
        scaled = weights[:, None] * rows[:, free] / unit[free]
        solution, _, rank, _ = np.linalg.lstsq(scaled, -weights * off, rcond=1e-10)
        if rank < len(free):
            raise CalibrationError(
                "the lines do not tell the lens: bent ones in two directions are needed"
            )
        at[free] = solution / unit[free]
        sigma = np.sqrt([float(at @ arc.covariance @ at) for arc in arcs])
        z = rows @ at / sigma
        typical = max(float(np.median(np.abs(z))) / 0.6745, 1.0)
        weights = 1 / (sigma * np.sqrt(1 + (z / (3 * typical)) ** 2))
    inverse = at[0] ** 2 + at[1] ** 2 - at[3]
    if not np.isfinite(inverse) or inverse == 0:
        raise CalibrationError("the lines do not tell the lens: they are seen straight")
    return np.array([1 / inverse, at[0], at[1]])
