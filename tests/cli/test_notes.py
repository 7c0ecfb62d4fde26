"""Notes for the user on standard error."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import pytest

from endocal.cli.options import note
from endocal.synth.board import render_board

from ..calibration.scenes import board


def test_a_note_that_cannot_be_told_does_no_harm(monkeypatch: pytest.MonkeyPatch) -> None:
    if not Path("/dev/full").exists():
        pytest.skip("no /dev/full here")
    with open("/dev/full", "w", buffering=1) as full:
        monkeypatch.setattr("sys.stderr", full)
        note("done")
        with pytest.raises(OSError, match="No space left"):
            full.close()


@pytest.mark.parametrize("pages", [1, 2])
def test_pages_that_are_not_looked_at_are_named(
    endocal: Callable[..., Any], tmp_path: Path, pages: int
) -> None:
    scene = board(size=(320, 240), center=(162.0, 118.0), square=21.0, lam=-1e-5)
    written = cv2.imwritemulti(str(tmp_path / "board.tif"), [render_board(scene)] * pages)
    assert written
    done = endocal("calibrate", tmp_path / "board.tif", "-o", tmp_path / "cal.toml")
    assert done.code == 0, done.err
    assert ("board.tif holds 2 pages: only the first is looked at" in done.err) == (pages > 1)
