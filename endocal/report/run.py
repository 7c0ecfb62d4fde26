"""The page of a corrected video: its zoom over time, and what was noted on the way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import page as p
from .figures import BLUE, GREEN, ORANGE, RED, TINT, VIOLET, plot
from .numbers import duration

Floats = NDArray[np.float64]

# Where the diameter came from, from the surest to the least sure, with the colour that stands for it.
SOURCES = {"rim": GREEN, "given": VIOLET, "tracked": BLUE, "held": ORANGE}
_MEANINGS = {
    "rim": "the rim was seen in the frame",
    "given": "given, by a record or an option",
    "tracked": "the rim was out of the frame; the picture itself was followed",
    "held": "not seen in this frame; held from before",
}
# A diameter less sure than this, relative, leaves lambda unsure by twice as much.
UNSURE = 0.03
# Plots are drawn from so many stretches of time at most.
MOST_STRETCHES = 1200


@dataclass(frozen=True)
class ZoomHistory:
    """The zoom of the frames (n,) in order.

    ``place`` is in s, or in frames where ``in_seconds`` is false; ``diameter`` px; ``lam`` px^-2 and the
    relative ``uncertainty`` are NaN where not known; ``source`` is one of SOURCES, or "".
    """

    place: Floats
    in_seconds: bool
    diameter: Floats
    lam: Floats
    uncertainty: Floats
    source: NDArray[np.str_]

    def __len__(self) -> int:
        return len(self.place)


@dataclass(frozen=True)
class Run:
    """What there is to say of a correction: (label, words) facts, notes, and warnings about the input.

    ``calibrated``: the smallest and the largest diameter of the zoom table's settings, px of these frames.
    """

    facts: Sequence[tuple[str, str]] = ()
    notes: Sequence[str] = ()
    warnings: Sequence[str] = ()
    calibrated: tuple[float, float] | None = None


def run_page(name: str, zoom: ZoomHistory | None, run: Run = Run()) -> p.Html:
    """Return the page of a correction, or of a zoom log, that goes by ``name``."""
    parts = [_verdict(zoom, run)]
    if zoom is not None:
        parts += [p.tiles(_tiles(zoom)), _over_time(zoom, run.calibrated), _shares(zoom)]
    if run.facts:
        parts.append(p.section("The run", p.facts(run.facts)))
    if run.notes:
        parts.append(p.section("Notes", p.bullets(run.notes)))
    return p.page(name, *parts)


def _verdict(zoom: ZoomHistory | None, run: Run) -> p.Html:
    reasons = list(run.warnings)
    if zoom is not None:
        unsure = zoom.uncertainty > UNSURE
        if unsure.any():
            reasons.append(
                f"In {np.count_nonzero(unsure)} of {len(zoom)} frames the diameter is less sure than"
                f" ± {UNSURE:.0%}, first at {_place(zoom, int(np.argmax(unsure)))}."
            )
    if reasons:
        return p.verdict("doubtful", "Done, with points to look at", reasons)
    words = (
        "Good: the zoom is known in every frame" if zoom is not None else "Done, nothing to report"
    )
    return p.verdict("good", words)


def _tiles(zoom: ZoomHistory) -> list[tuple[str, str, str]]:
    low, high = float(zoom.diameter.min()), float(zoom.diameter.max())
    tiles = [("Frames", str(len(zoom)), duration(_length(zoom)) if zoom.in_seconds else "")]
    tiles.append(("Zoom range", f"{high / low:.2f} ×", f"circle {low:.0f} to {high:.0f} px wide"))
    if np.isfinite(zoom.lam).any():
        ends = 1e6 * np.nanmin(zoom.lam), 1e6 * np.nanmax(zoom.lam)
        words = f"{ends[0]:.3g} to {ends[1]:.3g}".replace("-", "−")
        tiles.append(("λ, 10⁻⁶ px⁻²", words, ""))
    if (zoom.source != "").any():
        seen = float(np.mean(zoom.source == "rim"))
        tiles.append(("Rim seen", f"{seen:.0%}", "of the frames"))
    if np.isfinite(zoom.uncertainty).any():
        worst = float(np.nanmax(zoom.uncertainty))
        tiles.append(("Least sure diameter", f"± {worst:.2%}", "one standard deviation"))
    return tiles


def _over_time(zoom: ZoomHistory, calibrated: tuple[float, float] | None) -> p.Html:
    short = _shortened(zoom)
    words = "Diameter of the visible circle."
    if calibrated is not None:
        words += " The shaded band is the zoom that was calibrated; outside it the law is followed."
    shown = [p.figure(_diameter_plot(short, calibrated), words)]
    if np.isfinite(zoom.lam).any():
        shown.append(
            p.figure(_line_plot(short, 1e6 * short.lam, "λ, 10⁻⁶ px⁻²"), "λ that was used.")
        )
    if np.isfinite(zoom.uncertainty).any():
        sure = _line_plot(short, 100 * short.uncertainty, "uncertainty of the diameter, %", True)
        shown.append(
            p.figure(sure, "One standard deviation of the diameter. λ is unsure by twice as much.")
        )
    used = [s for s in SOURCES if (zoom.source == s).any()]
    colours = p.key((f"var(--{_css_name(s)})", f"{s}: {_MEANINGS[s]}") for s in used)
    return p.section("Zoom over time", colours, p.figures(*shown))


def _shares(zoom: ZoomHistory) -> p.Html:
    rows = []
    for source in SOURCES:
        own = zoom.source == source
        if own.any():
            longest = _longest(zoom, own)
            rows.append(
                (
                    source,
                    _MEANINGS[source],
                    str(np.count_nonzero(own)),
                    f"{np.mean(own):.1%}",
                    longest,
                )
            )
    if not rows:
        return p.Html("")
    heads = ("source", "meaning", "frames", "share", "longest stretch")
    return p.section("Where the zoom came from", p.table(heads, rows))


def _diameter_plot(zoom: ZoomHistory, calibrated: tuple[float, float] | None) -> p.Html:
    def draw(axes: Any) -> None:
        if calibrated is not None:
            axes.axhspan(*calibrated, color=TINT, alpha=0.5, lw=0)
        if np.isfinite(zoom.uncertainty).any():
            spread = np.nan_to_num(zoom.uncertainty) * zoom.diameter
            axes.fill_between(
                zoom.place,
                zoom.diameter - spread,
                zoom.diameter + spread,
                color=BLUE,
                alpha=0.2,
                lw=0,
            )
        _by_source(axes, zoom, zoom.diameter)
        axes.set_ylabel("diameter, px")
        _time_axis(axes, zoom)

    low, high = zoom.diameter.min(), zoom.diameter.max()
    return plot(draw, f"Diameter of the visible circle over time: from {low:.0f} to {high:.0f} px.")


def _line_plot(zoom: ZoomHistory, values: Floats, label: str, from_zero: bool = False) -> p.Html:
    def draw(axes: Any) -> None:
        _by_source(axes, zoom, values)
        if from_zero:
            axes.set_ylim(0, max(1.1 * float(np.nanmax(values)), 0.01))
        axes.set_ylabel(label)
        _time_axis(axes, zoom)

    return plot(draw, f"{label} over time: {np.nanmin(values):.3g} to {np.nanmax(values):.3g}.")


def _by_source(axes: Any, zoom: ZoomHistory, values: Floats) -> None:
    """Draw a line that has the colour of each stretch's source."""
    axes.plot(zoom.place, values, color=BLUE, lw=0.8)
    for source, colour in SOURCES.items():
        own = zoom.source == source
        if own.any():
            # A stretch reaches to the next point, so that one frame alone shows too.
            own[1:] |= own[:-1].copy()
            axes.plot(zoom.place, np.where(own, values, np.nan), color=colour, lw=2)


def _time_axis(axes: Any, zoom: ZoomHistory) -> None:
    axes.set_xlabel("time, s" if zoom.in_seconds else "frame")
    axes.margins(x=0.01)


def _shortened(zoom: ZoomHistory) -> ZoomHistory:
    """Take at most MOST_STRETCHES frames, of each stretch the least sure one, so that none is hidden."""
    if len(zoom) <= MOST_STRETCHES:
        return zoom
    unsure = np.nan_to_num(zoom.uncertainty)
    rank = {source: i for i, source in enumerate(SOURCES)}
    worst = unsure + np.array([rank.get(s, 0) for s in zoom.source]) * (unsure.max() + 1)
    ends = np.linspace(0, len(zoom), MOST_STRETCHES + 1).astype(np.intp)
    chosen = [int(a + np.argmax(worst[a:b])) for a, b in pairwise(ends)]
    return ZoomHistory(
        zoom.place[chosen],
        zoom.in_seconds,
        zoom.diameter[chosen],
        zoom.lam[chosen],
        zoom.uncertainty[chosen],
        zoom.source[chosen],
    )


def _longest(zoom: ZoomHistory, own: NDArray[np.bool_]) -> str:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], own, [False]]).astype(np.int8)))
    starts, stops = edges[::2], edges[1::2]
    lengths = stops - starts
    i = int(np.argmax(lengths))
    at = _place(zoom, int(starts[i]))
    if not zoom.in_seconds:
        return f"{lengths[i]} frames from {at}"
    step = _length(zoom) / max(len(zoom) - 1, 1)
    return f"{duration(zoom.place[stops[i] - 1] - zoom.place[starts[i]] + step)} from {at}"


def _length(zoom: ZoomHistory) -> float:
    return float(zoom.place[-1] - zoom.place[0])


def _place(zoom: ZoomHistory, index: int) -> str:
    at = float(zoom.place[index])
    return f"{at:.2f} s" if zoom.in_seconds else f"frame {at:.0f}"


def _css_name(source: str) -> str:
    return {GREEN: "green", VIOLET: "violet", BLUE: "blue", ORANGE: "orange", RED: "red"}[
        SOURCES[source]
    ]
