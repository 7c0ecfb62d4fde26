"""What a calibration's verdict weighs, one by one, in plain words."""

from __future__ import annotations

from dataclasses import dataclass

from ..calibration import quality as q
from ..calibration.quality import Evidence


@dataclass(frozen=True)
class Check:
    """One thing that was looked at: what was found, what is wanted, and whether it was met."""

    what: str
    found: str
    wanted: str
    met: bool


def checks(e: Evidence) -> list[Check]:
    """Return what was looked at; where the verdict is good, all of it was met."""
    unit = max(1.0, e.short_side / 540)
    # As in ``judge``: without a chessboard, straightness alone says that the lines are lines.
    rough = q.ROUGH if e.board else min(q.ROUGH, q.ROUGH_WITHOUT_BOARD)
    explained = q.LITTLE_EXPLAINED if e.board else q.LITTLE_WITHOUT_BOARD
    rows = [
        Check(
            "Straight lines found",
            f"{e.lines}, with {e.points} points",
            f"{q.FEW_LINES} or more",
            e.lines >= q.FEW_LINES,
        ),
        Check(
            "How far out the lines reach",
            f"{e.reach / e.content_radius:.0%} of the way to the farthest content",
            f"{q.POOR_COVERAGE:.0%} or more",
            e.reach >= q.POOR_COVERAGE * e.content_radius,
        ),
        Check(
            "How straight the lines are now",
            f"{e.rms:.3f} px (before: {e.rms_before:.2f} px)",
            f"{rough * unit:.2g} px or less",
            e.rms <= rough * unit,
        ),
        Check(
            "Points that do not follow their lines",
            f"{e.outlying:.0%}, left out above",
            f"{q.MANY_OUTLYING:.0%} or less",
            e.outlying <= q.MANY_OUTLYING,
        ),
        Check(
            "How bent they stay, beyond noise",
            f"{e.bend:.2f} px" if e.bend else "not measurably",
            f"{q.BENT * unit:.2g} px or less",
            e.bend <= q.BENT * unit,
        ),
        Check(
            "Edges that lie on these lines",
            f"{min(e.explained, 1):.0%}"
            + (", on a chessboard" if e.board else ", no chessboard seen"),
            f"{explained:.0%} or more",
            e.explained >= explained,
        ),
    ]
    if e.lam_sigma is not None and e.lam:
        relative = e.lam_sigma / abs(e.lam)
        rows.append(
            Check(
                "How surely the distortion is known",
                f"± {relative:.2g} of itself" if relative >= 1 else f"± {relative:.2%}",
                f"± {q.WEAK_LAMBDA:.0%} or less",
                relative <= q.WEAK_LAMBDA,
            )
        )
    if e.center_sigma is not None:
        rows += [
            Check(
                "How surely the centre is known",
                f"± {e.center_sigma:.2g} px",
                f"± {q.WEAK_CENTER * e.short_side:.2g} px or less",
                e.center_sigma <= q.WEAK_CENTER * e.short_side,
            ),
            Check(
                "Where the centre lies",
                f"{e.astray:.1f} standard deviations from the middle of the picture",
                f"{q.ASTRAY:.0f} or less",
                e.astray <= q.ASTRAY,
            ),
        ]
    fold = "nowhere" if e.fold_radius == float("inf") else f"{e.fold_radius:.0f} px from the centre"
    rows.append(
        Check(
            "Where the correction would fold",
            fold,
            "beyond all that is seen",
            e.fold_radius > e.content_radius,
        )
    )
    return rows
