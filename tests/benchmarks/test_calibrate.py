"""The calibration benchmark measures what it says: one problem, two ways, one minimum."""

from __future__ import annotations

from dataclasses import replace

import pytest

from endocal.benchmarks import calibrate
from endocal.benchmarks.calibrate import ArticleTime, CalibrateReport
from endocal.errors import EndocalError

SMALL = ((480, 360), (10, 8))
ROW = ArticleTime(500, 0.2, 0.1)


@pytest.fixture(scope="module")
def report() -> CalibrateReport:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(calibrate, "SEARCH_BOARD", SMALL)
        patch.setattr(calibrate, "COMMAND_BOARD", SMALL)
        return calibrate.run(repeats=1, article=[ROW])


def test_both_ways_find_the_same_minimum_near_the_truth(report: CalibrateReport) -> None:
    (row,) = report.rows
    assert row.same_minimum
    truth = calibrate.board(*SMALL).model
    # Bare HEwG, with 500 points, comes within a fifth or so; the refinement is not timed here.
    assert row.found.lam == pytest.approx(truth.lam, rel=0.25)


def test_another_minimum_is_told(report: CalibrateReport) -> None:
    row = report.rows[0]
    elsewhere = replace(row.plain_found, lam=row.plain_found.lam + 2e-9)
    worse = replace(row.plain_found, entropy=row.plain_found.entropy - 0.01)
    assert not replace(row, plain_found=elsewhere).same_minimum
    assert not replace(row, plain_found=worse).same_minimum


def test_the_report_as_data_has_the_ratios(report: CalibrateReport) -> None:
    data = report.data()
    row = data["rows"][0]
    assert row["times_article"] == pytest.approx(0.2 / row["endocal"]["processor"])
    assert row["times_plain"] == pytest.approx(
        row["plain"]["processor"] / row["endocal"]["processor"]
    )
    assert data["command"]["time"]["median"] > 0


def test_more_points_than_there_are_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(calibrate, "SEARCH_BOARD", SMALL)
    with pytest.raises(EndocalError, match="edge points, not 1000000"):
        calibrate.run(1, [replace(ROW, points=1_000_000)])


def test_the_board_has_the_points_of_the_articles_largest_picture() -> None:
    problem = calibrate._Problem.of(
        calibrate.board(*calibrate.SEARCH_BOARD), calibrate.CalibrationSpec()
    )
    assert len(problem.some(15299).points) == 15299
