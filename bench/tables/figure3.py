"""Fig. 3: the maps H1 and H2 of a board, before and after correction."""

from __future__ import annotations

from typing import Any

import numpy as np

from endocal.calibration.calibrate import calibrate
from endocal.calibration.methods.entropy import entropy
from endocal.calibration.methods.grid import voting_edges
from endocal.calibration.methods.vote_maps import vote_maps
from endocal.calibration.scene import look_at
from endocal.calibration.spec import CalibrationSpec
from endocal.remap.remapper import Remapper
from endocal.synth.board import render_board

from .lenses import scene
from .page import figure


def section() -> str:
    picture = render_board(scene("L3", (20.0, 70.0, 10.0), 0))
    model = calibrate(picture, CalibrationSpec(method="heplp", refine=False, samples=7)).model
    view = look_at([picture], CalibrationSpec()).views[0]
    edges = voting_edges(view, 21, 8000)
    size = (float(model.size[0]), float(model.size[1]))
    before, after = (
        vote_maps(edges.points, edges.gradients, np.array([lam, *model.center]), size)
        for lam in (0.0, model.lam)
    )
    corrected = Remapper(model, device="numpy").apply(picture)

    def draw(drawn: Any) -> None:
        axes = drawn.subplots(2, 3)
        for row, image, maps in ((0, picture, before), (1, corrected, after)):
            axes[row, 0].imshow(image // 16, cmap="gray", interpolation="nearest")
            axes[row, 1].imshow(
                _few(maps.first), cmap="magma", aspect="auto", interpolation="nearest"
            )
            axes[row, 2].imshow(
                _few(maps.second), cmap="magma", aspect="auto", interpolation="nearest"
            )
            for column, name in enumerate(
                ("picture", "H1: θ across, r down", "H2: ω across, ρ down")
            ):
                when = "before" if row == 0 else "after"
                axes[row, column].set(title=f"{name}, {when}", xticks=[], yticks=[])

    firsts = [entropy(m.first) for m in (before, after)]
    seconds = [entropy(m.second) for m in (before, after)]
    return f"""## Fig. 3: H1 and H2, before and after

A synthetic board (lens L3, tilted by 20 degrees), corrected by bare HEPLP's model. In H1 each line of the board
is a spot once it is straight; in H2 the two families of parallel lines gather in two vanishing points. The
entropy of H1 as drawn falls from {firsts[0]:.2f} to {firsts[1]:.2f}, that of H2 from {seconds[0]:.2f} to {seconds[1]:.2f}.

{figure("fig3", "A board and its maps H1 and H2, before and after", draw, (7.0, 4.2))}"""


def _few(votes: np.ndarray) -> np.ndarray:
    """Votes in few levels, so that the picture packs well."""
    return np.rint(12 * np.sqrt(votes / votes.max()))
