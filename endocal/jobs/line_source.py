"""Where the lines come from that a model is measured on."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..calibration.board import find_board
from ..calibration.calibrate import OUTLYING, Image, calibrate_jointly
from ..calibration.evaluate import LinePoints
from ..calibration.scene import look_at
from ..calibration.spec import CalibrationSpec, Lines
from ..calibration.straightness import Floats
from ..errors import CalibrationError, UsageError


@dataclass(frozen=True)
class LineSource:
    """Lines that somebody chose, or a chessboard's rows and columns, or those that the pictures show.

    ``board`` is (columns, rows) of its inner corners. With neither, the lines are found by a calibration of
    the picture, which knows nothing of the model that is measured on them.
    """

    lines: Lines | None = None
    board: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        if self.lines is not None and self.board is not None:
            raise UsageError("--lines and --board both say where the lines are: give one")
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
        limit = OUTLYING * max(refined.fit.sigma, 0.02)
        measured = refined.measured.take(np.abs(refined.fit.residuals) < limit)
        return LinePoints(
            measured.points / (spec.pixel_aspect, 1.0), measured.labels, measured.sides
        )


def _on_board(image: Image, counts: tuple[int, int], spec: CalibrationSpec) -> LinePoints:
    lines: list[Floats] = []
    for view in look_at([image], spec).views:
        board = find_board(view.grey)
        if board is None:
            continue
        seen = np.ptp(board.corners.places, axis=0) + 1
        if any(a > b for a, b in zip(sorted(seen), sorted(counts), strict=True)):
            raise CalibrationError(
                f"the chessboard has {seen[0]}x{seen[1]} inner corners, more than"
                f" --board {counts[0]}x{counts[1]} says"
            )
        lines += [line / (spec.pixel_aspect, 1.0) for line in board.lines()]
    if not lines:
        raise CalibrationError("no chessboard found: leave --board out, or give --lines")
    return LinePoints.of(lines)
