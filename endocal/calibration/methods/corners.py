"""Corners: the division model of one chessboard's corners (after Melo, Barreto & Falcao 2012).

R. Melo, J. P. Barreto, G. Falcao, "A New Solution for Camera Calibration and Real-Time Image Distortion
Correction in Medical Endoscopy - Initial Technical Evaluation", IEEE Trans. Biomed. Eng. 59 (2012) 634-644,
doi:10.1109/TBME.2011.2177268: the corners of a single picture of a chessboard, a linear solution in lifted
coordinates (``calibration/board/lifted.py``), and its refinement by reprojection.

What is done otherwise here: the board's size is not told, its corners are found as
``calibration/board/corners.py`` says; pixels are square, so that four lifted coordinates do for the source's
six; the refinement moves lambda, centre and homography alone, since correction needs no more. Several
pictures share lambda and centre. The cost is the root mean square distance, px, between the corners and where
the model sees them.
"""

from __future__ import annotations

import numpy as np

from ...errors import CalibrationError
from ..board.corners import find_board
from ..board.lifted import Corners, fit
from ..image.picture import Grey
from ..search import Found
from .task import Task


def solve(task: Task) -> Found:
    """Return the model; CalibrationError where no picture shows a chessboard."""
    shift = np.zeros(2)
    if task.spec.roi is not None:
        shift = np.array([round(task.spec.roi[0] * task.spec.aspect), task.spec.roi[1]])
    boards, starts = [], []
    for view in task.views:
        board = find_board(_looked_at(view.grey, task))
        if board is not None:
            corners = board.corners
            boards.append(Corners(corners.points + shift, corners.places))
            starts.append(board.fit.params + np.array([0.0, *shift]))
    if not boards:
        raise CalibrationError(
            "no chessboard found: the method corners needs one in plain sight, 4 x 3 inner corners or more"
        )
    start = starts[int(np.argmax([len(board.points) for board in boards]))]
    if task.prior.fixed:
        start = np.array([start[0], *task.prior.center])
    final = fit(boards, start, task.prior.fixed)
    rms = float(np.sqrt((final.residuals**2).sum(axis=1).mean()))
    return Found(final.params, rms, 1)


def _looked_at(grey: Grey, task: Task) -> Grey:
    """The part of a view that ``--roi`` names."""
    if task.spec.roi is None:
        return grey
    x, y, width, height = task.spec.roi
    left, right = (round(at * task.spec.aspect) for at in (x, x + width))
    return np.ascontiguousarray(grey[y : y + height, left:right])
