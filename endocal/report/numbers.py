"""Numbers as people write them."""

from __future__ import annotations

import math

_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def scientific(value: float, sigma: float | None = None) -> tuple[str, str]:
    """Return a number and its standard deviation, one power of ten for both: −4.680·10⁻⁶, ± 0.001·10⁻⁶."""
    if value == 0:
        return "0", "" if sigma is None else f"± {sigma:.2g}"
    power = math.floor(math.log10(abs(value)))
    decimals = 4
    if sigma:
        # Two digits of the standard deviation tell all that is known.
        decimals = min(max(power - math.floor(math.log10(sigma)) + 1, 1), 6)
    if -3 < power < 3:
        power, decimals = 0, max(decimals - power, 0)
    ten = f"·10{str(power).translate(_RAISED)}" if power else ""
    number = f"{value / 10**power:.{decimals}f}".replace("-", "−")
    return number + ten, "" if sigma is None else f"± {sigma / 10**power:.{decimals}f}{ten}"


def percent(share: float) -> str:
    """Return a share as a signed percentage, a minus sign for a minus: −0.12 %."""
    digits = 2 if abs(share) < 0.1 else 1
    return f"{100 * share:+.{digits}f}\u202f%".replace("-", "−")


def duration(seconds: float) -> str:
    """Return a time as people read it: 0.04 s, 4.2 s, 3 min 05 s, 1 h 02 min."""
    if seconds < 1:
        return f"{seconds:.2f} s"
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest:02d} s"
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes:02d} min"
