"""What a batch writes beside its outputs, and reads beside its sources: zoom logs and pages."""

from __future__ import annotations

from pathlib import Path

import pytest

from endocal.batch.plan import DO
from endocal.errors import UsageError
from tests.batch.local import Batch, actions
from tests.jobs.lenses import zoom_table
from tests.video.clips import Clip

BOTH = {"a.mkv": None, "deep/b.mkv": None}


def test_zoom_tables_in_a_batch(batch: Batch) -> None:
    table = zoom_table(batch.folder / "zoom.toml", (64, 48), (30.0, 60.0))
    (batch.folder / "raw" / "a.zoom.csv").write_text("frame,diameter\n0,40\n2,50\n")
    fields = {"calibration": table, "zoom_log": ".log.csv", "zoom_from": ".zoom.csv"}
    report = batch.run(**fields)
    assert len(report.lines) == 2
    lines = {line.place: line for line in report.lines}
    assert lines["a.mkv"].status == "done", lines
    assert lines["a.mkv"].shares() == {"given": 1.0}
    assert lines["a.mkv"].facts["diameters"] == pytest.approx((40, 50))
    assert (batch.out / "a.log.csv").read_text().count("\n") == 4
    assert "b.zoom.csv" in str(lines["deep/b.mkv"].reason)
    # The record of the zoom is an input as well.
    (batch.folder / "raw" / "a.zoom.csv").write_text("frame,diameter\n0,41\n2,50\n")
    assert actions(batch, **fields)["a.mkv"] == (DO, "its calibration has changed")


def test_what_is_missing_beside_an_output_is_made(batch: Batch, sample_data: Path) -> None:
    pytest.importorskip("matplotlib")
    (batch.folder / "raw" / "p.png").write_bytes((sample_data / "board-1.png").read_bytes())
    table = zoom_table(batch.folder / "zoom.toml", (64, 48), (30.0, 60.0))
    log = "frame,diameter\n0,40\n2,50\n"
    for name in ("a.z.csv", "deep/b.z.csv"):
        (batch.folder / "raw" / name).write_text(log)
    fields = {"calibration": table, "zoom_from": ".z.csv", "zoom_log": ".csv", "report": ".html"}
    batch.run(**fields)
    # Beside a picture there is nothing, whatever becomes of that.
    assert set(batch.did(**fields)) <= {"p.png"}
    for name, what in (("a.csv", "zoom log"), ("a.html", "page")):
        (batch.out / name).unlink()
        assert actions(batch, **fields)["a.mkv"] == (DO, f"its {what} is missing")
        assert batch.did(**fields)["a.mkv"] is None
        assert (batch.out / name).exists()
    # The output is gone, and what was beside it is still there.
    (batch.out / "a.mkv").unlink()
    assert batch.did(**fields)["a.mkv"] is None


def test_each_recording_may_have_its_own_page(batch: Batch) -> None:
    pytest.importorskip("matplotlib")
    assert batch.did(report=".html") == BOTH
    assert "64x48" in (batch.out / "deep" / "b.html").read_text()
    assert batch.did(report=".html") == {}
    assert actions(batch)["a.mkv"] == (DO, "its options have changed")


def test_two_recordings_may_not_share_a_file_beside_them(batch: Batch) -> None:
    Clip(frames=3, codec="mpeg4").make(batch.folder / "raw" / "a.mov")
    assert set(batch.did()) == {"a.mkv", "a.mov", "deep/b.mkv"}
    with pytest.raises(UsageError, match=r"a.mkv and a.mov would both write .*a\.html"):
        batch.run(report=".html")
    with pytest.raises(UsageError, match=r"--report .mkv: a report is an HTML page"):
        batch.run(suffix=".mkv", report=".mkv", exclude=("*.mov",))


def test_zoom_options_need_a_zoom_table(batch: Batch) -> None:
    with pytest.raises(UsageError, match="--zoom-log needs a zoom table, and no recording has one"):
        batch.run(zoom_log=".csv")
    assert not batch.out.exists()
