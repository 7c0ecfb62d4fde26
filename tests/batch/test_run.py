"""What a batch does again and what not: missing, changed or failed, and nothing else."""

from __future__ import annotations

import json
import os
import sqlite3
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from endocal.batch import fingerprint
from endocal.batch import task as task_module
from endocal.batch.plan import CHECK, DO, KEEP, LEAVE, Plan
from endocal.batch.run import preview_batch, run_batch
from endocal.errors import InputError, OutputError, UsageError
from tests.batch.local import Batch, Seen, actions
from tests.jobs.lenses import calibration
from tests.video.clips import Clip

BOTH = {"a.mkv": None, "deep/b.mkv": None}


def test_a_second_run_does_nothing(batch: Batch) -> None:
    assert batch.did() == BOTH
    before = (batch.out / "a.mkv").stat()
    assert batch.did() == {}
    assert (batch.out / "a.mkv").stat() == before
    assert {a for a, _ in actions(batch).values()} == {KEEP}


def test_what_is_missing_is_made(batch: Batch) -> None:
    batch.run()
    (batch.out / "deep" / "b.mkv").unlink()
    assert actions(batch)["deep/b.mkv"] == (DO, "its output is missing")
    assert list(batch.did()) == ["deep/b.mkv"]


def test_what_has_changed_is_made_anew(batch: Batch) -> None:
    batch.run()
    before = (batch.out / "a.mkv").read_bytes()
    Clip(frames=4).make(batch.folder / "raw" / "a.mkv")
    assert actions(batch)["a.mkv"] == (CHECK, "its input was touched")
    assert list(batch.did()) == ["a.mkv"]
    assert (batch.out / "a.mkv").read_bytes() != before
    assert batch.did() == {}


def test_a_change_that_keeps_size_and_mtime_shows(batch: Batch) -> None:
    """The way of rsync -t, and of whoever wants to hide it: ctime tells."""
    batch.run()
    source = batch.folder / "raw" / "a.mkv"
    seen, data = source.stat(), bytearray(source.read_bytes())
    data[-20] ^= 1
    time.sleep(0.02)
    source.write_bytes(data)
    os.utime(source, ns=(seen.st_atime_ns, seen.st_mtime_ns))
    now = source.stat()
    assert (now.st_size, now.st_mtime_ns) == (seen.st_size, seen.st_mtime_ns)
    assert list(batch.did()) == ["a.mkv"]


def test_what_was_only_touched_stays(batch: Batch) -> None:
    batch.run()
    before = (batch.out / "a.mkv").stat()
    (batch.folder / "raw" / "a.mkv").touch()
    report = batch.run()
    assert (report.done_now, report.count("done")) == (0, 2)
    assert (batch.out / "a.mkv").stat() == before
    assert batch.did() == {}


def test_times_that_may_hide_a_change_are_not_trusted(
    batch: Batch, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fingerprint, "_SETTLED_S", 3600)
    batch.run()
    assert actions(batch)["a.mkv"] == (CHECK, "its input is compared")
    monkeypatch.setattr(fingerprint, "_SETTLED_S", -3600)
    assert set(batch.did()) == set(BOTH)
    assert batch.did() == {}


def test_rehash_compares_everything_and_redo_does_everything(batch: Batch) -> None:
    batch.run()
    assert batch.run(rehash=True).done_now == 0
    assert batch.run(redo=True).done_now == 2


def test_rehash_makes_an_output_anew_that_has_changed(batch: Batch) -> None:
    """A disk that lost a bit changes neither size nor times."""
    batch.run()
    output = batch.out / "a.mkv"
    data = bytearray(output.read_bytes())
    data[-20] ^= 1
    output.write_bytes(data)
    assert batch.run().done_now == 0
    assert actions(batch, rehash=True)["a.mkv"] == (CHECK, "its input and output are compared")
    report = batch.run(rehash=True)
    assert [line.place for line in report.lines if line.now] == ["a.mkv"]
    assert output.read_bytes() != data
    assert batch.run(rehash=True).done_now == 0


def test_another_calibration_or_other_options_make_all_anew(batch: Batch) -> None:
    batch.run()
    options = {"correction": {"device": "numpy", "view": "full"}}
    assert actions(batch, **options)["a.mkv"] == (DO, "its options have changed")
    calibration(batch.folder / "cal.toml", -1.4e-4)
    assert actions(batch)["a.mkv"] == (DO, "its calibration has changed")
    assert batch.did() == BOTH
    # Threads change no output's meaning.
    assert batch.did(threads=2) == {}


def test_a_failure_is_recorded_tried_again_and_can_be_asked_for(batch: Batch) -> None:
    (batch.folder / "raw" / "bad.mp4").write_bytes(b"no video at all, not even nearly")
    report = batch.run()
    assert (report.failures, report.count("done"), report.is_well) == (1, 2, False)
    (line,) = [line for line in report.lines if line.status == "failed"]
    assert "cannot be read as a video" in str(line.reason)
    Clip(frames=3).make(batch.folder / "raw" / "new.mkv")
    (batch.out / "a.mkv").unlink()
    assert list(batch.did(retry_failed=True)) == ["bad.mp4"]
    Clip(frames=3, codec="mpeg4").make(batch.folder / "raw" / "bad.mp4")
    # What is open is told, and is no success.
    report = batch.run(retry_failed=True)
    assert not report.is_well
    assert {line.place: line.reason for line in report.lines if line.status == "open"} == {
        "a.mkv": "its output is missing, and did not fail before",
        "new.mkv": "new, and did not fail before",
    }
    assert (report.failures, report.count("done")) == (0, 2)
    assert set(batch.did()) == {"a.mkv", "new.mkv"}
    assert batch.run(retry_failed=True).is_well


def test_an_output_of_someone_else_is_left_alone(batch: Batch) -> None:
    batch.out.mkdir()
    (batch.out / "a.mkv").write_text("mine")
    assert actions(batch)["a.mkv"] == (LEAVE, "exists, and is not of this batch")
    report = batch.run()
    assert (report.count("left"), report.count("done"), report.is_well) == (1, 1, False)
    assert (batch.out / "a.mkv").read_text() == "mine"
    assert batch.did(overwrite=True) == {"a.mkv": None}
    (batch.out / "a.mkv").write_text("mine again")
    assert actions(batch)["a.mkv"] == (LEAVE, "was changed by someone else")


def test_fail_fast_begins_nothing_more(batch: Batch) -> None:
    # The largest comes first.
    (batch.folder / "raw" / "bad.mp4").write_bytes(bytes(1 << 20))
    report = batch.run(fail_fast=True)
    assert (report.count("failed"), report.count("open")) == (1, 2)
    assert report.stopped == "a recording failed (--fail-fast)"
    # What failed comes last the next time.
    assert list(batch.did(fail_fast=True)) == ["a.mkv", "deep/b.mkv", "bad.mp4"]


def test_a_full_disk_stops_it(batch: Batch, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*arguments: object) -> None:
        raise OutputError("x: the disk is full") from OSError(28, "No space left on device")

    monkeypatch.setattr(task_module, "correct", full)
    report = batch.run()
    assert (report.count("failed"), report.count("open")) == (1, 1)
    assert report.stopped == "the disk is full"


def test_a_recording_that_grows_meanwhile_is_refused(
    batch: Batch, monkeypatch: pytest.MonkeyPatch
) -> None:
    correct = task_module.correct

    def slow(spec: Any, tell: Any) -> Any:
        report = correct(spec, tell)
        with open(spec.input, "ab") as file:
            file.write(b"more")
        return report

    monkeypatch.setattr(task_module, "correct", slow)
    errors = batch.did()
    assert all("is it being recorded still?" in str(e) for e in errors.values())
    assert not (batch.out / "a.mkv").exists()


def test_a_calibration_that_changes_meanwhile_is_told(batch: Batch) -> None:
    """Else outputs would be recorded as made from another calibration than they were."""

    class Meddling(Seen):
        def planned(self, plan: Plan, workers: str) -> None:
            calibration(batch.folder / "cal.toml", -1.4e-4)

    report = run_batch(batch.spec(), Meddling())
    assert report.count("failed") == 2
    assert "cal.toml has changed since the batch began" in str(report.lines[0].reason)
    assert batch.did() == BOTH


def test_pictures_in_the_tree_are_corrected_too(batch: Batch, sample_data: Path) -> None:
    (batch.folder / "raw" / "p.png").write_bytes((sample_data / "board-1.png").read_bytes())
    calibration(batch.folder / "cal.toml", -1e-7, size=(720, 540))
    lens = {"correction": {"device": "numpy", "strict": True}, "exclude": ("*.mkv",)}
    report = batch.run(**lens)
    assert report.count("done") == 1, report.lines
    assert report.lines[0].facts["size_in"] == [720, 540]


def test_nothing_starts_for_a_wrong_calibration(batch: Batch) -> None:
    with pytest.raises(InputError, match="no such file"):
        batch.run(calibration=str(batch.folder / "none.toml"))
    (batch.folder / "m.csv").write_text("files,calibration\nraw/a.mkv,cal.toml\nraw/*,none.toml\n")
    with pytest.raises(InputError, match=r"line 3: the calibration .*none.toml is missing"):
        batch.run(sources=(str(batch.folder / "m.csv"),))
    assert not batch.out.exists()


def test_what_a_manifest_names_in_vain_is_a_failure_at_the_end(batch: Batch) -> None:
    (batch.folder / "m.csv").write_text("files,calibration\nraw/a.mkv,cal.toml\ngone,cal.toml\n")
    report = batch.run(sources=(str(batch.folder / "m.csv"),))
    assert (report.count("done"), report.failures) == (1, 1)
    assert report.missing == ("gone (line 3): no such file",)


def test_the_report_holds_what_earlier_runs_did(batch: Batch) -> None:
    batch.run(include=("a.mkv",))
    batch.run()
    data = json.loads((batch.out / "batch-report.json").read_text())
    counts = data["counts"]
    assert (counts["recordings"], counts["done"], counts["done_now"]) == (2, 2, 1)
    assert [counts[key] for key in ("failed", "left", "open", "missing")] == [0] * 4
    first, second = data["recordings"]
    assert (first["output"], first["now"], second["now"]) == ("a.mkv", False, True)
    assert first["frames"] == 3
    assert first["fps"] > 0


def test_a_report_of_someone_else_is_not_written_over(batch: Batch) -> None:
    batch.out.mkdir()
    (batch.out / "batch-report.html").write_text("mine")
    with pytest.raises(OutputError, match="is not of this batch"):
        batch.run()


@pytest.mark.parametrize("content", [b"SQLite format 3\0 and then noise" * 40, b"words" * 300])
def test_a_damaged_ledger_is_told(batch: Batch, content: bytes) -> None:
    batch.run()
    (batch.out / ".endocal" / "ledger.sqlite").write_bytes(content)
    with pytest.raises(InputError, match=r"ledger.sqlite: .*put it aside"):
        batch.run()


def test_a_ledger_of_another_program_or_time_is_refused(batch: Batch) -> None:
    batch.run()
    path = batch.out / ".endocal" / "ledger.sqlite"
    with sqlite3.connect(path) as other:
        other.execute("PRAGMA user_version = 9")
    with pytest.raises(InputError, match=r"newer endocal \(schema 9\)"):
        batch.run()
    with sqlite3.connect(path) as other:
        other.execute("PRAGMA application_id = 0")
    with pytest.raises(InputError, match="is no ledger"):
        batch.run()


def test_the_ledger_can_be_elsewhere(batch: Batch) -> None:
    state = str(batch.folder / "state")
    assert batch.did(state=state) == BOTH
    assert batch.did(state=state) == {}
    assert not (batch.out / ".endocal" / "ledger.sqlite").exists()
    other = replace(batch.spec(state=state), out=str(batch.folder / "other"))
    with pytest.raises(UsageError, match="give each --out its own"):
        run_batch(other, Seen())


def test_two_ledgers_for_one_directory_collide(batch: Batch) -> None:
    one, two = str(batch.folder / "one"), str(batch.folder / "two")

    class Second(Seen):
        def planned(self, plan: Plan, workers: str) -> None:
            for state in (two, None):
                with pytest.raises(OutputError, match="another batch is at work here"):
                    batch.run(state=state)

    assert run_batch(batch.spec(state=one), Second()).is_well
    # The usual place may be named.
    usual = str(batch.out / ".endocal")
    assert batch.run(state=usual, overwrite=True).is_well


def test_what_failed_after_it_was_done_is_told(batch: Batch) -> None:
    batch.run()
    (batch.folder / "raw" / "a.mkv").write_bytes(b"no video at all, not even nearly")
    line = batch.run().lines[0]
    assert line.status == "failed"
    assert str(line.reason).endswith("(what an earlier run made of it is still there)")
    (batch.out / "a.mkv").unlink()
    assert "is still there" not in str(batch.run().lines[0].reason)


def test_recordings_of_the_ledger_that_are_not_among_the_sources_are_counted(batch: Batch) -> None:
    batch.run()
    report = batch.run(include=("a.mkv",))
    assert report.notes == (
        "1 more recording is in the ledger of --out, and not among these sources",
    )


def test_an_older_version_is_told_and_not_done_again(
    batch: Batch, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(task_module, "__version__", "0.0.9")
    monkeypatch.setattr(task_module.Task, "version", "0.0.9")
    monkeypatch.setattr(task_module.Task.__init__, "__defaults__", ("0.0.9",))
    batch.run()
    monkeypatch.undo()
    (note,) = preview_batch(batch.spec()).notes
    assert "endocal 0.0.9" in note


def test_strange_names_go_all_the_way(batch: Batch) -> None:
    name = os.fsdecode(b"caf\xe9 \xc3\xa4 \n[1].mkv")
    (batch.folder / "raw" / "a.mkv").rename(batch.folder / "raw" / name)
    assert batch.did() == {name: None, "deep/b.mkv": None}
    assert (batch.out / name).exists()
    assert batch.did() == {}
    (first, _) = json.loads((batch.out / "batch-report.json").read_text())["recordings"]
    assert first["output"] == "caf\\udce9 ä \n[1].mkv"
