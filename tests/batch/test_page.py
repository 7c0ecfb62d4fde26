"""The page on a batch says what became of each recording, whatever the names."""

from __future__ import annotations

from typing import Any

from endocal.batch.page import report_page
from endocal.batch.report import BatchReport, Line

FACTS: dict[str, Any] = {
    "frames": 250,
    "seconds": 5.0,
    "duration": 10.0,
    "zoom": {"rim": 200, "held": 50},
    "diameters": [401.2, 520.4],
    "warnings": ["3 damaged packets"],
    "notes": ["is rescaled"],
}


def page(*lines: Line, **values: Any) -> str:
    plain: dict[str, Any] = {"out": "out", "missing": (), "notes": (), "workers": "2 processes"}
    times: dict[str, Any] = {"began": "2026-01-01T00:00:00Z", "seconds": 10.0}
    return report_page(BatchReport(lines=lines, **(plain | times | values)))


def test_it_tells_of_each_recording() -> None:
    text = page(Line("a.mp4", "/raw/a.mp4", "done", None, True, FACTS))
    for words in ("1 of 1 recordings are done", "50 fps", "401–520 px", "80%", "20%", "✓"):
        assert words in text, words
    assert "a.mp4: 3 damaged packets" in text
    assert "a.mp4: is rescaled" in text


def test_it_tells_of_failures_first() -> None:
    done = Line("a.mp4", "/raw/a.mp4", "done", None, False, FACTS)
    failed = Line("b.mp4", "/raw/b.mp4", "failed", "/raw/b.mp4: is empty", True)
    left = Line("c.mp4", "/raw/c.mp4", "left", "exists, and is not of this batch", False)
    still = Line("d.mp4", "/raw/d.mp4", "open", None, False)
    text = page(
        done, failed, left, still, missing=("gone.mp4: no such file",), stopped="the disk is full"
    )
    for words in (
        *("1 of 5 recordings are done", "2 failed", "1 left alone", "1 not done yet"),
        *(
            "the run was stopped: the disk is full",
            "/raw/b.mp4: is empty",
            "gone.mp4: no such file",
        ),
        "c.mp4: exists, and is not of this batch",
    ):
        assert words in text, words


def test_what_is_said_of_many_is_said_once() -> None:
    lines = [Line(f"{n}.mp4", "/raw", "done", None, True, FACTS) for n in range(9)]
    text = page(*lines)
    assert text.count("is rescaled") == 1
    assert "0.mp4, 1.mp4, 2.mp4, 3.mp4, 4.mp4 and 4 more: is rescaled" in text


def test_a_batch_of_days_is_told_in_hours() -> None:
    assert "26 h 03 min" in page(Line("a.mp4", "/raw", "done", None, True, FACTS), seconds=93780.0)


def test_names_are_shown_as_they_are() -> None:
    text = page(Line("<script>&\n\udce9.mp4", "/raw", "failed", "<b>: \udce9", True))
    assert "<script>" not in text
    assert "&lt;b&gt;" in text
    text.encode()
