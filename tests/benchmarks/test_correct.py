"""The benchmark of whole corrections: its rows, and peers that are not there."""

from __future__ import annotations

import shutil

import pytest

from endocal.benchmarks.correct import CV2, LENS, OURS, PLAIN, run


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="its peers are ffmpeg's")
def test_every_contender_runs_and_is_weighed() -> None:
    report = run((160, 120), frames=10, rounds=1, device="numpy")
    assert [row.name for row in report.rows] == [PLAIN, LENS, OURS, CV2]
    assert report.missing == ()
    assert all(row.cost.seconds > 0 and row.cost.memory > 1 for row in report.rows)
    assert report.data()["frames"] == 10


def test_a_peer_that_is_not_installed_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "which", lambda name: None)
    report = run((160, 120), frames=10, rounds=1, device="numpy")
    assert [row.name for row in report.rows] == [OURS, CV2]
    assert report.missing == (PLAIN, LENS)
    assert (report.added, report.times_plain) == (None, None)
