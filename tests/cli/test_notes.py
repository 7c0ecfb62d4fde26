"""Notes for the user on standard error."""

from __future__ import annotations

from pathlib import Path

import pytest

from endocal.cli.options import note


def test_a_note_that_cannot_be_told_does_no_harm(monkeypatch: pytest.MonkeyPatch) -> None:
    if not Path("/dev/full").exists():
        pytest.skip("no /dev/full here")
    with open("/dev/full", "w", buffering=1) as full:
        monkeypatch.setattr("sys.stderr", full)
        note("done")
        with pytest.raises(OSError, match="No space left"):
            full.close()
