"""Table I: the zoom law between two settings of each of the article's endoscopes."""

from __future__ import annotations

from .page import scientific, table

# Name, lambda px^-2, diameter px, and the article's linear and quadratic prediction from its partner.
F1 = ("F1", -2.9644e-5, 210.0, -1.8931e-5, -2.8126e-5)
F2 = ("F2", -1.2742e-5, 312.0, -1.9953e-5, -1.3430e-5)
F3 = ("F3", -7.5446e-6, 432.0, -3.0577e-6, -5.6195e-6)
F4 = ("F4", -1.6638e-6, 712.0, -4.1052e-6, -2.2338e-6)
# What F3's and F4's printed predictions follow from: 432 px against 794, not against ~712.
RATIO = 1.8378


def section() -> str:
    rows = []
    for one, other, ratio in (
        (F1, F2, 312 / 210),
        (F2, F1, 210 / 312),
        (F3, F4, RATIO),
        (F4, F3, 1 / RATIO),
    ):
        name, lam, diameter, *printed = one
        ours = [other[1] * ratio, other[1] * ratio**2]
        cells = [f"{scientific(a)} / {scientific(p)}" for a, p in zip(ours, printed, strict=True)]
        same = all(scientific(a) == scientific(p) for a, p in zip(ours, printed, strict=True))
        size = f"{'~' if one is F4 else ''}{diameter:.0f}"
        rows.append([name, scientific(lam), size, *cells, "yes" if same else "no"])
    heads = [
        "setting",
        "λ, px⁻²",
        "diameter, px",
        "linear: ours / printed",
        "quadratic: ours / printed",
    ]
    literal = [scientific(F4[1] * (712 / 432) ** 2), scientific(F3[1] * (432 / 712) ** 2)]
    return f"""## Table I: the zoom law

Each λ predicted from the other setting of the same endoscope, from the ratio of the diameters of the visible
circle: λ′ = λ · r (linear), λ′ = λ · r² (quadratic, eq. 15).

{table([*heads, "every digit"], rows)}
F1 and F2 follow from 312/210. F3 and F4 follow from a ratio of {RATIO}, that is from 432 px against
{432 * RATIO:.0f} px; from the printed ~712 px the quadratic predictions would be {literal[0]} and {literal[1]}. The
~712 px circle is cut by the frame; its predictions are those of a circle of 794 px.

Quadratic beats linear at all four settings, here as there.
"""
