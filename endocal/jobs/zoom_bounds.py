"""Which zooms a lens can have: what is assumed or recorded beyond them is a slip, and refused at once.

Beyond those that its table covers, less is known.
"""

from __future__ import annotations

import math

from ..errors import InputError, UsageError
from ..zoom.shift import shifted
from ..zoom.table import ZoomTable
from .zoom_log import RecordedZoom

# No lens zooms so far beyond both its settings and the frame, as a ratio.
_FURTHEST_ZOOM = 4.0
# No coupler has so much play, in parts of the frame's width and height.
_FURTHEST_SHIFT = 0.5


def check_named(option: str, diameter: float, table: ZoomTable, lookup: str) -> None:
    """Raise UsageError where an ``option`` names a diameter, px, that no circle before this lens can have."""
    least, most = _possible(table)
    if not least <= diameter <= most:
        raise UsageError(
            f"{option} {diameter:g}: {_known(table)}, and {least:.0f} to {most:.0f} px can be"
        )
    try:
        table.at_diameter(diameter, lookup)
    except InputError as error:
        raise UsageError(f"{option} {diameter:g}: {error}; {_known(table)}") from None


def check_recorded(
    recorded: RecordedZoom, table: ZoomTable, lookup: str, follows_shift: bool
) -> None:
    """Raise InputError, with the log's name and line, for a zoom that no circle before this lens can have.

    A shift is only looked at where the centre ``follows_shift``.
    """
    least, most = _possible(table)
    width, height = table.size
    seen: tuple[float, tuple[float, float]] | None = None
    for row in recorded.rows:
        shift = row.shift if follows_shift else (0.0, 0.0)
        if (row.diameter, shift) == seen:
            continue
        seen = row.diameter, shift
        where = f"{recorded.name}, line {row.line}"
        if not least <= row.diameter <= most:
            raise InputError(
                f"{where}: the diameter {row.diameter:g} px is that of no circle before this lens:"
                f" {_known(table)}, and {least:.0f} to {most:.0f} px can be; is it the log of this video?"
            )
        x, y = shift
        if abs(x) > _FURTHEST_SHIFT * width or abs(y) > _FURTHEST_SHIFT * height:
            raise InputError(
                f"{where}: the shift ({x:g}, {y:g}) px is more than half the {width}x{height} frame: correct"
                " the row, or give --center fixed"
            )
        try:
            shifted(table.at_diameter(row.diameter, lookup), shift)
        except InputError as error:
            raise InputError(
                f"{where}: {error}; {_known(table)}: correct the row, or calibrate at a zoom near it"
            ) from None


def _possible(table: ZoomTable) -> tuple[float, float]:
    """Return the least and the greatest diameter, px, that a circle before this lens can have."""
    low, high = (table.settings[i].diameter for i in (0, -1))
    width, height = table.size
    least = min(low, height) / _FURTHEST_ZOOM
    return least, max(high, math.hypot(width * table.pixel_aspect, height)) * _FURTHEST_ZOOM


def _known(table: ZoomTable) -> str:
    low, high = (table.settings[i].diameter for i in (0, -1))
    width, height = table.size
    return f"in frames of {width}x{height} the zoom table goes from {low:.0f} to {high:.0f} px"


def beyond_table(diameter: float, table: ZoomTable, when: str = "") -> str:
    """Say in words that the circle, ``diameter`` px wide ``when`` it is, lies outside the table's range."""
    low, high = table.settings[0].diameter, table.settings[-1].diameter
    return (
        f"the circle is {diameter:.0f} px wide{when}, outside the table's {low:.0f} to {high:.0f} px: there"
        " the law lambda * diameter^2 = constant holds"
    )
