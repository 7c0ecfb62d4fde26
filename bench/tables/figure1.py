"""Fig. 1: the degenerate problem of the entropy without gradients."""

from __future__ import annotations

from typing import Any

import numpy as np

from endocal.calibration.hough.hewg import Voters, hewg
from endocal.calibration.methods.entropy import entropy
from endocal.calibration.methods.grid import voting_edges
from endocal.calibration.methods.hewog import undistorted, vote_map
from endocal.calibration.scene import look_at
from endocal.calibration.spec import CalibrationSpec
from endocal.model import DivisionModel
from endocal.synth.board import BoardScene, render_board
from endocal.synth.camera import Camera, ContentCircle
from endocal.synth.framing import covering
from endocal.synth.pattern import Pattern, Pose

from .page import figure, scientific, table

TRUE = -2e-5
LAMBDAS = (-3e-5, -2.5e-5, -2e-5, -1.5e-5, -1e-5)
# The article's lambdas fold at 183 px: a small endoscope picture.
SIZE, DIAMETER = (360, 300), 290.0
ANGLES, STEP, HALF = 180, 2.0, 200


def section() -> str:
    center = ((SIZE[0] - 1) / 2, (SIZE[1] - 1) / 2)
    scene = BoardScene(
        DivisionModel(TRUE, center, SIZE),
        Pattern("chessboard", 10, 8),
        Pose(center, 1.0, 15.0, 40.0, 10.0, focal=160.0),
        ContentCircle(center, DIAMETER, 2.0),
        Camera(blur=0.7, noise=2.0),
    )
    placed = covering(scene, 0.7)
    assert placed is not None, "a board tilted by 15 degrees covers 70 % of any view"
    view = look_at([render_board(placed)], CalibrationSpec()).views[0]
    edges = voting_edges(view, 21, 4000)
    at = (np.array([center[0]]), np.array([center[1]]))

    def without(lam: float) -> Any:
        return vote_map(undistorted(edges.points, lam, *center), ANGLES, STEP, HALF)

    lams = np.linspace(-3.2e-5, -2e-6, 60)
    plain = np.array([entropy(without(lam)) for lam in lams])
    voters = Voters.of(edges.points, edges.gradients, SIZE[1])
    gradient = hewg(voters, lams, *at)[:, 0, 0]
    maps = [without(lam) for lam in LAMBDAS]
    central = slice(HALF - HALF // 4, HALF + HALF // 4)
    rows = []
    for lam, votes in zip(LAMBDAS, maps, strict=True):
        own = hewg(voters, np.array([lam]), *at).item()
        rows.append(
            [
                scientific(lam, 1),
                str(int((votes == 0).sum())),
                str(int((votes[:, central] == 0).sum())),
                f"{entropy(votes):.3f}",
                f"{own:.3f}",
            ]
        )

    def draw(drawn: Any) -> None:
        left, right = drawn.subplots(1, 2)
        for axes, values, name in (
            (left, plain, "every direction (HEwoG)"),
            (right, gradient, "with gradient (HEwG)"),
        ):
            axes.plot(lams * 1e5, values)
            axes.axvline(TRUE * 1e5, color="tab:green", label="true λ")
            axes.plot(
                lams[values.argmin()] * 1e5, values.min(), "o", color="tab:red", label="least"
            )
            axes.set(title=name, xlabel="λ, 10⁻⁵ px⁻²", ylabel="entropy")
            axes.legend()

    def draw_maps(drawn: Any) -> None:
        for axes, lam, votes in zip(drawn.subplots(1, 5), LAMBDAS, maps, strict=True):
            axes.imshow(np.sqrt(votes.T), cmap="gray", aspect="auto", interpolation="nearest")
            axes.set(title=f"{lam * 1e5:g}·10⁻⁵", xticks=[], yticks=[])

    least = [scientific(lams[v.argmin()], 2) for v in (plain, gradient)]
    return f"""## Fig. 1: the degenerate problem

A board through an endoscope of λ = {scientific(TRUE, 1)}, the centre given, and the five λ of the article. A vote map
of {ANGLES} directions by {2 * HALF} offsets of {STEP:g} px; the central region is the middle half of the offsets. Each
edge point votes for every direction; the last column is the entropy with one vote a point, by the gradient.

{table(["λ, px⁻²", "empty cells", "of the central region", "entropy (HEwoG)", "entropy (HEwG)"], rows)}
{figure("fig1-entropy", "Entropy over lambda, without and with gradient", draw, (7.5, 2.8))}
{figure("fig1-maps", "Five vote maps without gradient", draw_maps, (7.5, 2.0))}
As in the article: a weaker λ makes the picture small and leaves more of the map empty, so that the entropy
without gradients falls towards it (least at {least[0]}, the end of what was tried), whatever the lens is. With the
gradient it is least at {least[1]}.
"""
