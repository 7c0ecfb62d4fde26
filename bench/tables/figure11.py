"""Fig. 11: RMSE against a shifted centre, on syn1c and syn2c, for HEwG by Sobel size and for HTRDC."""

from __future__ import annotations

import math
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from typing import Any

import cv2
import numpy as np

from endocal.calibration.calibrate import calibrate
from endocal.calibration.evaluate import LinePoints, evaluate
from endocal.calibration.spec import CalibrationSpec
from endocal.model import DivisionModel
from endocal.synth.board import BoardScene, render_board, true_lines
from endocal.synth.camera import Camera
from endocal.synth.framing import covering
from endocal.synth.pattern import Pattern, Pose

from .page import figure, number, table

LENSES = {"syn1c": -5.25e-6, "syn2c": -8.85e-6}
# The article's lambdas fold at 436 and 336 px, so that its frames were smaller; 320 px is the corner here.
SIZE = (512, 384)
SHIFTS = (-20, -10, -5, 0, 5, 10, 20)
SOBELS = (3, 7, 11, 15, 21, 27, 31)


@dataclass(frozen=True)
class Figure:
    """RMSE px: ``curves`` by (lens, "htrdc" or Sobel size), one value a shift."""

    curves: dict[tuple[str, str | int], list[float]]

    def average(self, sobel: int) -> float:
        """The mean over lenses and shifts."""
        return float(np.mean([self.curves[lens, sobel] for lens in LENSES]))

    def centered(self, sobel: int) -> float:
        """The mean over lenses where the centre given is the right one."""
        return float(np.mean([self.curves[lens, sobel][SHIFTS.index(0)] for lens in LENSES]))

    @property
    def verdict(self) -> str:
        """Which size is best, in words, beside the article's 21x21."""
        best, at_center = min(SOBELS, key=self.average), min(SOBELS, key=self.centered)
        return (
            f"With the right centre {at_center}x{at_center} is best ({self.centered(at_center):.2f} px, mean of"
            f" both lenses; 21x21: {self.centered(21):.2f} px); over all shifts {best}x{best}"
            f" ({self.average(best):.2f} px; 21x21: {self.average(21):.2f} px)."
        )


def run(processes: int) -> Figure:
    kinds: tuple[str | int, ...] = (*SOBELS, "htrdc")
    work = [(lens, kind, shift) for lens in LENSES for kind in kinds for shift in SHIFTS]
    with ProcessPoolExecutor(processes, get_context("spawn"), _one_thread_each) as pool:
        values = list(pool.map(_one, work, chunksize=len(SHIFTS)))
    curves: dict[tuple[str, str | int], list[float]] = {}
    for (lens, kind, _), value in zip(work, values, strict=True):
        curves.setdefault((lens, kind), []).append(value)
    return Figure(curves)


def _one_thread_each() -> None:
    cv2.setNumThreads(1)


def board(lens: str) -> BoardScene:
    """Return a board before one of LENSES, its centre 4 px off the frame's."""
    center = ((SIZE[0] - 1) / 2 + 4.0, (SIZE[1] - 1) / 2 - 3.0)
    model = DivisionModel(LENSES[lens], center, SIZE)
    pose = Pose(center, 1.0, 10.0, 60.0, 8.0, focal=300.0)
    placed = covering(
        BoardScene(model, Pattern("chessboard", 12, 9), pose, None, Camera(blur=0.8, noise=4.0)),
        0.7,
    )
    assert placed is not None, "a board tilted by 10 degrees covers 70 % of any view"
    return placed


def _one(work: tuple[str, str | int, int]) -> float:
    lens, kind, shift = work
    scene = board(lens)
    x, y = scene.model.center
    spec = CalibrationSpec(
        method="htrdc" if kind == "htrdc" else "hewg",
        sobel=21 if kind == "htrdc" else int(kind),
        refine=False,
        center=(x + shift, y + shift),
    )
    model = calibrate(render_board(scene), spec).model
    # A little short of the corners, which a shifted centre takes past the fold.
    lines = [line[np.hypot(*(line - (x, y)).T) < 280] for line in true_lines(scene, 60)]
    return evaluate(LinePoints.of([line for line in lines if len(line) > 5]), model).rmse


def section(found: Figure) -> str:
    def draw(drawn: Any) -> None:
        for axes, lens in zip(drawn.subplots(1, 2), LENSES, strict=True):
            for sobel in SOBELS:
                axes.plot(SHIFTS, found.curves[lens, sobel], label=f"HEwG S{sobel}", lw=1.2)
            axes.plot(SHIFTS, found.curves[lens, "htrdc"], "k--", label="HTRDC")
            axes.set(title=lens, xlabel="centre shifted by (Δ, Δ), Δ in px", ylabel="RMSE, px")
        axes.legend(fontsize=7)

    rows = []
    for kind in (*SOBELS, "htrdc"):
        name = "HTRDC" if kind == "htrdc" else f"HEwG, {kind}x{kind}"
        cells = []
        for lens in LENSES:
            values = found.curves[lens, kind]
            held = [v for v in values if math.isfinite(v)]
            cells += [number(values[SHIFTS.index(0)]), number(float(np.mean(held)))]
        rows.append([name, *cells])
    heads = [
        "",
        *(f"{lens}: {what}" for lens in LENSES for what in ("right centre", "mean over Δ")),
    ]
    return f"""## Fig. 11: a shifted centre, and the size of the Sobel mask

syn1c (λ = −5.25e−6) and syn2c (λ = −8.85e−6), boards of ours at {SIZE[0]}x{SIZE[1]} with those λ; the centre is given,
off by (Δ, Δ). RMSE in px of the corrected picture, over points of the true lines.

{figure("fig11", "RMSE over the shift of the centre, by Sobel size, and of HTRDC", draw, (8.0, 3.2))}
{table(heads, rows)}
The article found 21x21 best. {found.verdict}
A size says how far along an edge its points tell the direction, 0.7 of it to both sides
(`endocal.calibration.image.directions.directions_along`); which points see one direction only, half of it tells.
"""
