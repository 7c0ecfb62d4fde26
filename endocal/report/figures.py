"""Plots by matplotlib (extra ``report``) as SVG whose colours follow the page: light, dark, paper."""

from __future__ import annotations

import html
import io
import logging
import re
from collections.abc import Callable
from typing import Any

from ..errors import EndocalError
from .page import Html

# Stand-ins: each is drawn as it is here and becomes the page's own colour of that name (style.css).
INK, SOFT, LINE, SURFACE, TINT = "#000001", "#000002", "#000003", "#000004", "#000005"
BLUE, ORANGE, GREEN = "#000006", "#000007", "#000008"
RED, YELLOW, VIOLET = "#000009", "#00000a", "#00000b"
_NAMES = {
    INK: "ink",
    SOFT: "soft",
    LINE: "line",
    SURFACE: "surface",
    TINT: "tint",
    BLUE: "blue",
    ORANGE: "orange",
    GREEN: "green",
    RED: "red",
    YELLOW: "yellow",
    VIOLET: "violet",
}
# The blue of maps, which are pixels and cannot follow the page.
_HEAT = (0.16, 0.46, 0.86)
# Inches at 72 points: a figure fills a column of the page, so that its 9 point text reads as 12 px or more.
WIDTH, HEIGHT = 5.6, 3.3

_STYLE: dict[Any, Any] = {
    "svg.fonttype": "none",  # text stays text: small, sharp, read aloud
    "font.size": 9.5,
    "axes.titlesize": 10,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelcolor": SOFT,
    "axes.edgecolor": SOFT,
    "axes.linewidth": 0.7,
    "axes.facecolor": "none",
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.formatter.useoffset": False,
    "grid.color": LINE,
    "grid.linewidth": 0.7,
    "text.color": INK,
    "xtick.color": SOFT,
    "ytick.color": SOFT,
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.7,
    "lines.linewidth": 1.6,
    "legend.frameon": False,
    "legend.fontsize": 9,
    "figure.facecolor": "none",
    "path.simplify": True,
    "text.parse_math": False,  # a file name may hold a dollar sign
}


def require_figures() -> None:
    """Raise EndocalError, saying what to install, where plots cannot be made: call it before the work."""
    # Where its folders cannot be written, as without a home, it tells of temporary ones that it takes as it
    # is loaded: nobody need do anything about that. A level that somebody has set stays.
    logger = logging.getLogger("matplotlib")
    level = logger.level
    if level == logging.NOTSET:
        logger.setLevel(logging.ERROR)
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        raise EndocalError(
            "reports need matplotlib: pip install 'endocal-toolchain[report]'"
        ) from None
    finally:
        logger.setLevel(level)


def plot(
    draw: Callable[[Any], None], alt: str, size: tuple[float, float] = (WIDTH, HEIGHT)
) -> Html:
    """Return an SVG of one plot; ``draw`` is given matplotlib's Axes, ``size`` is in inches.

    ``alt`` says in words what the plot shows. Colours are this module's. The same plot gives the same text.
    """
    require_figures()
    import matplotlib
    from matplotlib.figure import Figure

    with matplotlib.rc_context({**_STYLE, "svg.hashsalt": alt}):
        drawing = Figure(figsize=size, layout="constrained")
        draw(drawing.add_subplot())
        text = io.StringIO()
        drawing.savefig(text, format="svg", metadata={"Date": None}, transparent=True)
    return _inline(text.getvalue(), alt)


def heat() -> Any:
    """Return the colour map of maps: one blue from nothing to full, which shows on light and on dark."""
    from matplotlib.colors import LinearSegmentedColormap

    r, g, b = _HEAT
    return LinearSegmentedColormap.from_list("heat", [(r, g, b, 0.0), (r, g, b, 1.0)])


def _inline(svg: str, alt: str) -> Html:
    """Make a stand-alone SVG a part of a page: no header, no ids but those it refers to, its colours."""
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    # A style within the picture would hold for all of the page: style.css has it instead.
    svg = re.sub(r"<style.*?</style>", "", svg, flags=re.DOTALL)
    referred = set(re.findall(r"#([\w.-]+)[\")]", svg))
    svg = re.sub(r' id="([^"]+)"', lambda m: m[0] if m[1] in referred else "", svg)
    for colour, name in _NAMES.items():
        svg = svg.replace(colour, f"var(--{name})")
    svg = re.sub(r"font-family: [^;\"]*", "font-family: var(--sans)", svg)
    _, _, rest = svg.partition(">")
    box = re.search(r'viewBox="([^"]+)"', svg)
    assert box is not None
    label = html.escape(alt)
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"'
        f' viewBox="{box[1]}" role="img" aria-label="{label}">'
    )
    return Html(head + re.sub(r"\n\s*", "\n", rest.strip()))
