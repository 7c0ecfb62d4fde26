"""Zoom logs: written, read, edited."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from endocal.errors import InputError, UsageError
from endocal.jobs.zoom_log import RecordedZoom, ZoomRecord, zoom_log
from endocal.model import DivisionModel

MODEL = DivisionModel(-1.23456789e-6, (320.12345, 240.0), (640, 480))


@pytest.mark.parametrize("name", ["log.csv", "log.jsonl"])
def test_what_is_written_is_read_back(tmp_path: Path, name: str) -> None:
    path = str(tmp_path / name)
    with zoom_log(path, overwrite=False, inputs=()) as log:
        for i in range(10):
            log.add(ZoomRecord(i, i / 25, 400.0 + i, "rim", MODEL, 1e-3))
    recorded = RecordedZoom(path)
    assert [recorded.diameter(i, i / 25) for i in range(10)] == pytest.approx(
        [400.0 + i for i in range(10)], abs=1e-3
    )


def test_a_shift_is_read_back_and_none_where_there_is_none(tmp_path: Path) -> None:
    for name in ("log.csv", "log.jsonl"):
        path = str(tmp_path / name)
        with zoom_log(path, overwrite=False, inputs=()) as log:
            for i in range(3):
                shift = (2.0 * i, -1.0 * i)
                log.add(ZoomRecord(i, i / 25, 400.0, "rim", MODEL, 1e-3, shift))
        assert RecordedZoom(path).shift(1, 0.06) == pytest.approx((3.0, -1.5))
    (tmp_path / "short.csv").write_text("frame,diameter,shift_x\n0,400,\n4,400,2\n")
    assert RecordedZoom(str(tmp_path / "short.csv")).shift(2, None) == pytest.approx((1.0, 0.0))


@pytest.mark.parametrize("name", ["log.csv", "log.jsonl"])
def test_an_uncertainty_is_read_back_and_unknown_where_none_is_told(
    tmp_path: Path, name: str
) -> None:
    path = str(tmp_path / name)
    with zoom_log(path, overwrite=False, inputs=()) as log:
        for i, doubt in enumerate((0.02, 0.1, math.nan, -1.0, math.inf)):
            log.add(ZoomRecord(i, i / 25, 400.0, "held", MODEL, doubt))
    recorded = RecordedZoom(path)
    told = [recorded.uncertainty(0, t) for t in (0.0, 0.02, 0.04)]
    assert told == pytest.approx([0.02, 0.06, 0.1])
    assert all(math.isnan(recorded.uncertainty(0, t)) for t in (0.08, 0.12, 0.16, 9.0))


def test_rows_are_interpolated_as_ratios_and_held_at_the_ends(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("time,diameter\n1.0,100\n3.0,400\n")
    recorded = RecordedZoom(str(path))
    assert [recorded.diameter(0, t) for t in (0.0, 1.0, 2.0, 3.0, 9.0)] == pytest.approx(
        [100, 100, 200, 400, 400]
    )


def test_rows_without_a_time_count_by_frame(tmp_path: Path) -> None:
    path = tmp_path / "log.jsonl"
    path.write_text('{"frame": 0, "diameter": 100}\n\n{"frame": 4, "diameter": 100}\n')
    assert RecordedZoom(str(path)).diameter(2, None) == pytest.approx(100)


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.csv", "", "holds no row"),
        ("a.csv", "time,width\n1,2\n", "line 2: needs a diameter"),
        ("a.csv", "time,diameter\n1,abc\n", "line 2: needs a diameter"),
        ("a.csv", "time,diameter\n1,-5\n", "line 2: the diameter -5 px is that of no circle"),
        ("a.csv", "time,diameter\n1,nan\n", "that of no circle"),
        ("a.csv", "time,diameter\n1,1e308\n", "that of no circle"),
        ("a.csv", "time,diameter,shift_x\n1,5,much\n", "line 2: shift_x and shift_y are"),
        ("a.csv", "time,diameter,shift_y\n1,5,inf\n", "line 2: shift_x and shift_y are"),
        ("a.csv", "diameter\n5\n", "every row needs a time or a frame"),
        ("a.jsonl", '{"time": 1}\n', "line 1: needs a diameter"),
        ("a.jsonl", "[1, 2]\n", "line 1: needs a diameter"),
        ("a.jsonl", "time 1\n", "line 1: needs a diameter"),
        ("a.jsonl", '{"time": 1, "diameter": true}\n', "line 1: needs a diameter"),
        ("a.jsonl", '{"time": false, "diameter": 400}\n', "line 1: needs a diameter"),
        ("a.jsonl", '{"time": 1, "diameter": [400]}\n', "line 1: needs a diameter"),
        ("a.jsonl", '{"frame": 1e999, "diameter": 400}\n', "line 1: the frame inf is no"),
        ("a.jsonl", f'{{"frame": 1{"0" * 400}, "diameter": 400}}\n', "line 1: the frame inf is no"),
        (
            "a.jsonl",
            f'{{"frame": 0, "diameter": 1{"0" * 400}}}\n',
            "line 1: the diameter inf px is",
        ),
        ("a.jsonl", f'{{"frame": 1{"0" * 5000}, "diameter": 4}}\n', "line 1: needs a diameter"),
        ("a.jsonl", f"\n{'[' * 100_000}\n", "line 2: needs a diameter"),
        ("a.csv", f"time,diameter\n1,400\n2,{'4' * 131_073}\n", "line 3: is no CSV"),
        ("a.csv", "frame,diameter\n0.5,400\n", "line 2: the frame 0.5 is no whole number"),
        (
            "a.csv",
            "time,diameter\n0,400\n\nnan,400\n",
            "line 4: the time nan s is that of no frame",
        ),
        ("a.csv", "time,diameter\n0,400\ninf,400\n", "line 3: the time inf s is that of no frame"),
        ("a.csv", "frame,time,diameter\n0,0,4\n1,,4\n", "line 3: has no time, where other"),
        (
            "a.csv",
            "time,diameter\n1,40\n0,30\n1,41\n",
            "line 4: says 41 px of 1 s, where line 2 .* 40",
        ),
        ("a.csv", "frame,diameter\n3,40\n3,41\n", "line 3: says 41 px of frame 3, where line 2"),
    ],
)
def test_a_wrong_log_is_refused_by_line(tmp_path: Path, name: str, text: str, words: str) -> None:
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(InputError, match=words):
        RecordedZoom(str(path))


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.csv", "time,diameter\r\n0,400\r\n"),
        ("a.jsonl", '{"time": 0, "diameter": 400}\n'),
    ],
)
def test_a_byte_order_mark_is_no_part_of_the_text(tmp_path: Path, name: str, text: str) -> None:
    path = tmp_path / name
    path.write_text(text, encoding="utf-8-sig")
    recorded = RecordedZoom(str(path))
    assert recorded.by_time
    assert recorded.diameter(0, 0.0) == pytest.approx(400)


def test_an_instant_may_come_twice_if_it_says_the_same_or_is_two_frames(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("frame,time,diameter\n0,1,400\n0,1,400.001\n1,1,420\n2,2,440\n")
    assert RecordedZoom(str(path)).diameter(2, 2.0) == pytest.approx(440)


def test_numbers_that_need_not_be_there_may_be_anything(tmp_path: Path) -> None:
    path = tmp_path / "log.jsonl"
    path.write_text(f'{{"frame": 0, "diameter": 400, "lambda": 1{"0" * 400}, "source": 3}}\n')
    assert RecordedZoom(str(path)).diameter(0, None) == pytest.approx(400)


def test_other_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="No such file"):
        RecordedZoom(str(tmp_path / "missing.csv"))
    (tmp_path / "bytes.csv").write_bytes(b"\xff\xfe\x00diameter")
    with pytest.raises(InputError, match="no text file"):
        RecordedZoom(str(tmp_path / "bytes.csv"))
    with pytest.raises(UsageError, match=r"is \.csv or \.jsonl"):
        RecordedZoom(str(tmp_path / "log.txt"))


def test_a_log_of_a_failed_run_is_not_left(tmp_path: Path) -> None:
    def fail() -> None:
        with zoom_log(str(tmp_path / "a.csv"), False, ()) as log:
            log.add(ZoomRecord(0, None, 400.0, "rim", MODEL, 1e-3))
            raise ValueError("stop")

    with pytest.raises(ValueError, match="stop"):
        fail()
    assert list(tmp_path.iterdir()) == []
