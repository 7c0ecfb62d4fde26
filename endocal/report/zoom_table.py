"""The page of a zoom table: the lens over its zoom, and how well its settings agree."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..zoom.table import ZoomTable
from . import page as p
from .figures import BLUE, INK, ORANGE, SOFT, plot
from .numbers import percent, scientific

# A law that spreads by more than this deserves a look; see also the table's own outlier.
WIDE_SPREAD = 0.05
# Curves are drawn so far beyond the outermost settings, as a share.
_BEYOND = 0.08
_SAMPLES = 160


def zoom_table_page(name: str, table: ZoomTable) -> p.Html:
    """Return the page of a zoom table that goes by ``name``."""
    law, settings = table.law, table.settings
    w, h = table.size
    low, high = settings[0].diameter, settings[-1].diameter
    worst = max(law.departures, key=abs)
    constant, _ = scientific(law.lambda_diameter2)
    return p.page(
        f"Zoom table: {name}",
        _verdict(table),
        p.tiles(
            [
                ("Settings", str(len(settings)), ""),
                (
                    "Zoom that they span",
                    f"{high / low:.2f} ×",
                    f"circle {low:.0f} to {high:.0f} px wide",
                ),
                ("λ · diameter²", constant, "the law: one constant of the lens"),
                ("Spread about the law", f"{law.spread:.2%}", f"the farthest {percent(worst)}"),
            ]
        ),
        p.section(
            "The lens over its zoom",
            p.paragraph(
                "A zoom that magnifies the picture by r divides λ by r². The diameter of the visible circle"
                " tells r, so λ · diameter² is one number for all settings: the law."
            ),
            p.figures(
                p.figure(_lambda_plot(table), "λ at the settings, and what is used between them."),
                p.figure(_departure_plot(table), "How far each setting is from the law."),
                p.figure(
                    _center_plot(table),
                    "The distortion centre, from the middle of the picture. It moves with the zoom.",
                ),
            ),
        ),
        p.section("The settings", _settings(table)),
        subtitle=f"One zoom lens, {w}x{h} px",
    )


def _verdict(table: ZoomTable) -> p.Html:
    law = table.law
    if law.outlier is not None:
        setting = table.settings[law.outlier]
        off = percent(law.departures[law.outlier])
        return p.verdict(
            "doubtful",
            "Doubtful: one setting stands out from the others",
            [
                f"At diameter {setting.diameter:.1f} px λ is {off} off the law:"
                " calibrate that setting again, or leave it out."
            ],
        )
    if law.spread > WIDE_SPREAD:
        return p.verdict(
            "doubtful",
            "Doubtful: the settings do not agree well",
            [f"They spread by {law.spread:.1%} about the law. Are all of them of this lens?"],
        )
    return p.verdict("good", "Good: the settings agree, as those of one lens do")


def _diameters(table: ZoomTable) -> Any:
    low, high = table.settings[0].diameter, table.settings[-1].diameter
    return np.geomspace(low * (1 - _BEYOND), high * (1 + _BEYOND), _SAMPLES)


def _lambda_plot(table: ZoomTable) -> p.Html:
    diameters = _diameters(table)
    # With a second parameter: of the one-parameter model that is equal at the rim, as the law counts.
    used = []
    for d in diameters:
        model = table.at_diameter(float(d))
        used.append(model.lam + model.lam2 * d**2 / 4)

    def draw(axes: Any) -> None:
        axes.plot(diameters, 1e6 * np.array(used), color=BLUE, label="used in between")
        law = 1e6 * table.law.lambda_diameter2 / diameters**2
        axes.plot(diameters, law, color=ORANGE, ls=(0, (4, 3)), label="the law")
        points = [(s.diameter, 1e6 * s.strength / s.diameter**2) for s in table.settings]
        axes.plot(*zip(*points, strict=True), "o", color=INK, ms=5, label="settings")
        axes.set_xlabel("diameter of the visible circle, px")
        axes.set_ylabel("λ, 10⁻⁶ px⁻²")
        axes.legend(loc="best")

    return plot(draw, f"λ over the diameter of the circle at {len(table.settings)} settings.")


def _departure_plot(table: ZoomTable) -> p.Html:
    diameters = [s.diameter for s in table.settings]
    departures = 100 * np.array(table.law.departures)

    def draw(axes: Any) -> None:
        axes.axhline(0, color=ORANGE, ls=(0, (4, 3)))
        axes.vlines(diameters, 0, departures, color=BLUE, lw=2)
        axes.plot(diameters, departures, "o", color=BLUE, ms=6)
        edge = max(1.3 * float(np.abs(departures).max()), 0.05)
        axes.set_ylim(-edge, edge)
        axes.set_xlim(*_diameters(table)[[0, -1]])
        axes.set_xlabel("diameter of the visible circle, px")
        axes.set_ylabel("departure from the law, %")

    words = ", ".join(percent(d) for d in table.law.departures)
    return plot(draw, f"Departures of the settings from the law: {words}.")


def _center_plot(table: ZoomTable) -> p.Html:
    diameters = _diameters(table)
    middle = np.array([(table.size[0] - 1) / 2, (table.size[1] - 1) / 2])
    line = np.array([table.at_diameter(float(d)).center for d in diameters]) - middle
    points = np.array([s.center for s in table.settings]) - middle

    def draw(axes: Any) -> None:
        axes.axhline(0, color=SOFT, lw=0.8)
        for i, (axis, colour, mark) in enumerate((("x", BLUE, "o"), ("y", ORANGE, "s"))):
            axes.plot(diameters, line[:, i], color=colour, label=axis)
            axes.plot([s.diameter for s in table.settings], points[:, i], mark, color=colour, ms=5)
        axes.set_xlabel("diameter of the visible circle, px")
        axes.set_ylabel("centre from the middle, px")
        axes.legend(loc="best")

    return plot(draw, "The distortion centre over the diameter of the circle, x and y.")


def _settings(table: ZoomTable) -> p.Html:
    second = any(s.lam2 for s in table.settings)
    heads = [
        "diameter, px",
        "λ, px⁻²",
        *(["λ₂, px⁻⁴"] if second else []),
        "centre, px",
        "off the law",
        "from",
    ]
    rows = []
    for s, departure in zip(table.settings, table.law.departures, strict=True):
        rows.append(
            [
                f"{s.diameter:.2f}",
                scientific(s.lam)[0],
                *([scientific(s.lam2)[0]] if second else []),
                f"{s.center[0]:.2f}, {s.center[1]:.2f}",
                percent(departure),
                "" if s.source is None else s.source.file,
            ]
        )
    return p.table(heads, rows)
