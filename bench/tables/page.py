"""Markdown and pictures of the page."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "results.md"
PICTURES = ROOT / "docs" / "results"
# Pixels per inch of the pictures: a page, not a poster.
DPI = 80


def table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table."""
    lines = [heads, ["---"] * len(heads), *rows]
    return "".join(f"| {' | '.join(cells)} |\n" for cells in lines)


def number(value: float | None, digits: int = 2) -> str:
    """Return a number, or a dash for none."""
    return "–" if value is None else f"{value:.{digits}f}"


def scientific(value: float, digits: int = 4) -> str:
    """Return a number as the article prints it: −2.9644e−5."""
    mantissa, _, exponent = f"{value:.{digits}e}".partition("e")
    return f"{mantissa}e{int(exponent)}".replace("-", "−")


def figure(name: str, alt: str, draw: Callable[[Any], None], size: tuple[float, float]) -> str:
    """Draw with Matplotlib, write ``name``.png, and return the Markdown that shows it.

    ``draw`` gets a figure of ``size`` (width, height) in inches.
    """
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot

    PICTURES.mkdir(exist_ok=True)
    mpl.rcParams.update({"font.size": 9, "axes.grid": True, "grid.alpha": 0.3})
    drawn = pyplot.figure(figsize=size, dpi=DPI, layout="constrained")
    draw(drawn)
    # Nothing that differs from run to run, or with the version.
    drawn.savefig(PICTURES / f"{name}.png", metadata={"Software": None})
    pyplot.close(drawn)
    return f"![{alt}](results/{name}.png)\n"
