"""The page of the article's tables: what can be checked without making it."""

from __future__ import annotations

import re
from math import erf, pi, sqrt

import numpy as np
import pytest

from bench.tables import lenses, table1
from bench.tables.methods import Result, mean
from bench.tables.page import PAGE, scientific, table
from bench.tables.sharpness import mtf50
from endocal.synth.board import true_corners


def test_table_1_is_the_articles_to_every_printed_digit() -> None:
    text = table1.section()
    rows = [line for line in text.splitlines() if re.match(r"\| F\d", line)]
    assert len(rows) == 4
    assert all(row.endswith("| yes |") for row in rows)
    # And the columns do come from eq. 15, not from the print.
    assert scientific(-1.2742e-5 * (312 / 210) ** 2) == "−2.8126e−5"


def test_the_page_has_every_section() -> None:
    text = PAGE.read_text(encoding="utf-8")
    heads = re.findall(r"^##+ (.*)$", text, re.MULTILINE)
    for name in (
        "Table I:",
        "Tables II and III",
        "Fig. 1:",
        "Fig. 3:",
        "Fig. 11:",
        "Table V:",
        "Table IV:",
    ):
        assert any(head.startswith(name) for head in heads), name
    assert "pictures are not public" in text
    pictures = re.findall(r"\]\((results/[^)]+)\)", text)
    assert len(pictures) >= 4
    assert all((PAGE.parent / picture).exists() for picture in pictures)
    assert sum((PAGE.parent / picture).stat().st_size for picture in pictures) < 600_000


@pytest.mark.parametrize("sigma", [0.7, 1.0, 2.0])
def test_mtf50_of_a_blurred_edge(sigma: float) -> None:
    rng = np.random.default_rng(0)
    distances = rng.uniform(-12, 12, 4000)
    levels = np.array([128 + 100 * erf(d / sigma / sqrt(2)) for d in distances])
    # A Gaussian's transform falls to half at sqrt(ln 2 / 2) / (pi sigma).
    expected = sqrt(np.log(2) / 2) / (pi * sigma)
    assert mtf50(levels, distances) == pytest.approx(expected, rel=0.05)
    assert np.isnan(mtf50(levels[:20], distances[:20]))


def test_the_synthetic_lenses_are_as_said() -> None:
    for name, (strength, *_) in lenses.LENSES.items():
        scene = lenses.scene(name, lenses.POSES[0], 0)
        w, h = scene.model.size
        corner = np.hypot(
            max(scene.model.center[0], w - 1 - scene.model.center[0]),
            max(scene.model.center[1], h - 1 - scene.model.center[1]),
        )
        reach = scene.circle.diameter / 2 if scene.circle else corner
        assert scene.model.lam * reach**2 == pytest.approx(strength, rel=0.02)
        assert true_corners(scene)[1].sum() > 40


def test_means_say_what_they_leave_out() -> None:
    results = [
        Result("L1", "hewg", rmse=1.0),
        Result("L1", "hewg", rmse=np.inf),
        Result("L1", "hewg"),
    ]
    assert mean(results, "rmse") == (1.0, 2)
    assert mean([Result("L1", "corners", refused="no board")], "rmse") == (None, 1)


def test_a_markdown_table() -> None:
    assert table(["a", "b"], [["1", "2"]]) == "| a | b |\n| --- | --- |\n| 1 | 2 |\n"
