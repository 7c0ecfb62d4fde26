"""HTRDC: the model under which one line gathers the largest vote (Cucchiara et al. 2003).

R. Cucchiara, C. Grana, A. Prati, R. Vezzani, "A Hough transform-based method for radial lens distortion
correction", Proc. 12th Int. Conf. on Image Analysis and Processing (2003) 182-187,
doi:10.1109/ICIAP.2003.1234047: in a region with a single line, the Hough transform of the undistorted edge
points has its highest peak where the line is straight. The distortion centre is given. The parameter is
sampled, and its range narrowed around the best sample.

What is left open, and what is done here: the division model in the place of their polynomial, as in the
article under comparison; every edge point votes for every direction, in HEwoG's cells; the search is
Algorithm 1 with lambda alone, and twice its samples, since one axis costs so little; equal peaks, which
whole votes often are, are told apart by the mean square vote; the centre is the one given, else the
middle of the region that other methods search. The line is that of ``--lines`` that is bent most, else, with
``--roi``, all that the region holds, else the most bent of those that our own line finder sees, so that it
needs no clicks: a line through the centre stays straight and tells nothing.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...errors import CalibrationError
from ..search import Found, search
from ..straightness import Floats
from .chosen import chosen_lines
from .grid import Measure, over_grid
from .hewog import undistorted, vote_map
from .task import Task

ANGLES = 360
STEP = 1.0
FARTHEST = 2.0
MOST_POINTS = 3000
FEWEST_POINTS = 20


def solve(task: Task) -> Found:
    """Return the model; CalibrationError where no line is found."""
    x, y = task.prior.center
    region = replace(task.region, x=(x, x), y=(y, y))
    measure = prepare(_one_line(task), task.size)
    spec = task.spec
    return search(measure, region, 2 * spec.samples, spec.epsilon, spec.max_rounds)


def prepare(points: Floats, size: tuple[float, float]) -> Measure:
    """Return minus the share of the points (n, 2) px of one line that the fullest cell gathers."""
    middle = (points.max(axis=0) + points.min(axis=0)) / 2
    reach = float(np.linalg.norm(points - middle, axis=1).max())
    step = STEP * max(1.0, size[1] / 540)
    n = len(points)

    def cost(lam: float, cx: float, cy: float) -> float:
        offsets = undistorted(points, lam, cx, cy)
        if len(offsets) < min(FEWEST_POINTS, n):
            return 0.0
        far = float(np.hypot(*(middle - (cx, cy)))) + reach
        half = int(np.ceil(FARTHEST * far / step))
        votes = vote_map(offsets, ANGLES, step, half)
        return -(float(votes.max()) + float((votes.astype(np.float64) ** 2).mean()) / n**2) / n

    return over_grid(cost)


def bend(line: Floats) -> float:
    """Return the root mean square distance of points (n, 2) from the straight line among them, px."""
    centred = line - line.mean(axis=0)
    return float(np.linalg.svd(centred, compute_uv=False)[-1] / np.sqrt(len(line)))


def _one_line(task: Task) -> Floats:
    if task.lines is None and task.spec.roi is not None:
        line = np.concatenate([view.edges.points for view in task.views])
    else:
        line = max(chosen_lines(task), key=bend)
    if len(line) < 3:
        raise CalibrationError(f"the line has {len(line)} points: the method htrdc needs 3 or more")
    if len(line) > MOST_POINTS:
        line = line[np.random.default_rng(0).permutation(len(line))[:MOST_POINTS]]
    return line
