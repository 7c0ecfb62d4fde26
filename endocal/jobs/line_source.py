"""Where the lines come from that a model is measured on."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..calibration.board.corners import find_board
from ..calibration.calibrate import calibrate_jointly
from ..calibration.evaluate import LinePoints
from ..calibration.fit.plumb_line import inlying
from ..calibration.scene import Image, look_at
from ..calibration.spec import CalibrationSpec, Lines, check_lines
from ..calibration.straightness import Floats, Labels
from ..errors import CalibrationError, UsageError

# Of the corners that --board tells of, so great a share each way is in view at least.
LEAST_SEEN = 0.5


@dataclass(frozen=True)
class LineSource:
    """Lines that somebody chose, or a chessboard's rows and columns, or those that the pictures show.

    ``board`` is (columns, rows) of its inner corners; up to half each way may be out of view. With neither,
    the lines are found by a calibration of the picture, which knows nothing of the model that is measured on
    them.
    """

    lines: Lines | None = None
    board: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        if self.lines is not None and self.board is not None:
            raise UsageError("--lines and --board both say where the lines are: give one")
        if self.lines is not None:
            check_lines(self.lines)
        if self.board is not None and min(self.board) < 3:
            raise UsageError("--board: 3 inner corners each way are the least")

    def find(self, image: Image, spec: CalibrationSpec) -> LinePoints:
        """Return the lines of a picture, seen with ``spec``; CalibrationError where there are none."""
        if self.lines is not None:
            return LinePoints.of([np.array(line) for line in self.lines])
        if self.board is not None:
            return _on_board(image, self.board, spec)
        found = calibrate_jointly([image], replace(spec, method="hewg", refine=True, lines=None))
        refined = found.workings.refined
        assert refined is not None, "a refined calibration has lines"
        # Those that lie on their lines: what a line's profiles met besides is none of it.
        measured = refined.measured.take(inlying(refined.fit.residuals, refined.fit.sigma))
        return LinePoints(measured.points / (spec.aspect, 1.0), measured.labels, measured.sides)


def _on_board(image: Image, counts: tuple[int, int], spec: CalibrationSpec) -> LinePoints:
    lines: list[Floats] = []
    for view in look_at([image], spec).views:
        board = find_board(view.grey)
        if board is None:
            continue
        _check_counts(np.ptp(board.corners.places, axis=0) + 1, counts)
        lines += [line / (spec.aspect, 1.0) for line in board.lines()]
    if not lines:
        raise CalibrationError("no chessboard found: leave --board out, or give --lines")
    return LinePoints.of(lines)


def _check_counts(seen: Labels, counts: tuple[int, int]) -> None:
    """Refuse a board of ``seen`` (columns, rows) that is not one of ``counts``, whichever way it lies."""
    said = f"--board {counts[0]}x{counts[1]} says"
    has = f"the chessboard has {seen[0]}x{seen[1]} inner corners"
    pairs = list(zip(sorted(seen), sorted(counts), strict=True))
    if any(a > b for a, b in pairs):
        raise CalibrationError(f"{has}, more than {said}")
    if any(a < LEAST_SEEN * b for a, b in pairs):
        raise CalibrationError(f"{has} in view, less than half of what {said}: is it this board?")
