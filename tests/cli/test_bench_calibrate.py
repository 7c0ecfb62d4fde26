"""``endocal bench calibrate`` prints what was measured, and says where two searches disagree."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from endocal.benchmarks import calibrate
from endocal.benchmarks.calibrate import (
    ArticleTime,
    CalibrateReport,
    Command,
    Minimum,
    Row,
    Seconds,
)

MINIMUM = Minimum(-1e-6, (360.0, 270.0), 6.0)
ROW = Row(
    ArticleTime(6100, 1.653, 0.531), Seconds(0.2, 0.1, 0.15), Seconds(5, 5, 4.5), MINIMUM, MINIMUM
)


@pytest.fixture
def measured(monkeypatch: pytest.MonkeyPatch) -> CalibrateReport:
    other = replace(ROW, plain_found=replace(MINIMUM, entropy=5.0))
    report = CalibrateReport(10, 1e-9, 3, (ROW, other), Command((768, 576), Seconds(1.2, 1.1, 1.0)))
    monkeypatch.setattr(calibrate, "run", lambda repeats, progress: report)
    return report


def test_the_rows_hold_times_ratios_and_the_minimum(
    endocal: Callable[..., Any], measured: CalibrateReport
) -> None:
    done = endocal("bench", "calibrate")
    assert done.code == 0
    first, second = [line for line in done.out.splitlines() if line.strip().startswith("6100")]
    for text in ("0.200 / 0.100 / 0.150", "1.653 (11.0x)", "0.531", "(30.0x)", "the same minimum"):
        assert text in first, text
    assert "ANOTHER MINIMUM" in second
    assert "768x576 board, all of it: 1.20 / 1.10 / 1.00" in done.out


def test_as_json(endocal: Callable[..., Any], measured: CalibrateReport) -> None:
    data = json.loads(endocal("bench", "calibrate", "--json").out)
    assert data == json.loads(json.dumps(measured.data()))
    assert [row["same_minimum"] for row in data["rows"]] == [True, False]
