"""The synthetic lenses of Tables II and III, in the place of the article's five, and the real ones."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from endocal.benchmarks.corner_score import as_grid
from endocal.calibration.calibrate import calibrate
from endocal.calibration.evaluate import LinePoints
from endocal.calibration.scene import Image
from endocal.files import read_image
from endocal.model import DivisionModel
from endocal.synth.board import BoardScene, render_board, true_lines
from endocal.synth.camera import Camera, ContentCircle
from endocal.synth.framing import covering
from endocal.synth.pattern import Pattern, Pose

from .page import ROOT

SIZE = (720, 540)
# Name -> lam R^2 at the farthest visible pixel, centre off the frame's middle px, diameter of the circle or
# None, noise in grey levels, blur px.
LENSES = {
    "L1": (-0.30, (9.0, -6.0), None, 2.0, 0.7),
    "L2": (-0.45, (-12.0, 8.0), None, 4.0, 1.0),
    "L3": (-0.60, (6.0, 10.0), 500.0, 3.0, 0.8),
    "L4": (-0.75, (-8.0, -9.0), 520.0, 5.0, 1.2),
    "L5": (-0.85, (14.0, 5.0), None, 3.0, 0.8),
}
# The poses of each lens's pictures: tilt, its axis, rotation, degrees.
POSES = ((10.0, 20.0, 4.0), (30.0, 110.0, 25.0))
# The real lenses whose corners are listed, and what their centres are believed to be: endocal's refined.
REAL = ("gopro3", "endoscope_6080hd", "fisheye2")
EACH = 2  # pictures of each


@dataclass(frozen=True)
class Case:
    """A picture of a lens, the lines that methods are measured on, and the true model where it is known."""

    lens: str
    name: str
    image: Image
    lines: LinePoints
    truth: DivisionModel | None
    center: tuple[float, float]


def scene(lens: str, pose: tuple[float, float, float], seed: int) -> BoardScene:
    """Return a board of 12 x 9 squares before one of LENSES, covering 60 % of what is seen."""
    strength, (dx, dy), diameter, noise, blur = LENSES[lens]
    center = ((SIZE[0] - 1) / 2 + dx, (SIZE[1] - 1) / 2 + dy)
    corner = np.hypot(SIZE[0] / 2 + abs(dx), SIZE[1] / 2 + abs(dy))
    reach = corner if diameter is None else diameter / 2
    model = DivisionModel(strength / reach**2, center, SIZE)
    tilt, axis, rotation = pose
    placed = covering(
        BoardScene(
            model,
            Pattern("chessboard", 12, 9),
            Pose(center, 1.0, tilt, axis, rotation, focal=450.0),
            None if diameter is None else ContentCircle(center, diameter, 2.0),
            Camera(blur=blur, noise=noise),
            seed=seed,
        ),
        0.6,
    )
    assert placed is not None, "a board tilted by 35 degrees covers 60 % of any view"
    return placed


def synthetic() -> Iterator[Case]:
    """Yield the pictures of all synthetic lenses."""
    for lens in LENSES:
        for i, pose in enumerate(POSES):
            board = scene(lens, pose, i)
            lines = LinePoints.of(true_lines(board, 60))
            model = board.model
            yield Case(lens, f"{lens}.{i + 1}", render_board(board), lines, model, model.center)


def real_folder() -> Path | None:
    """The folder of real pictures, or None where it is not at hand."""
    default = ROOT.parent / "shared" / "data"
    folder = Path(os.environ.get("ENDOCAL_REAL_DATA", default)) / "boards"
    return folder if (folder / "corners.json").exists() else None


def real(folder: Path) -> Iterator[Case]:
    """Yield the real pictures whose corners are known."""
    known = json.loads((folder / "corners.json").read_text(encoding="utf-8"))
    names = [
        n for lens in REAL for n in sorted(k for k in known if k.startswith(f"{lens}/"))[:EACH]
    ]
    for name in names:
        lens = name.split("/")[0]
        image = read_image(folder / name)
        corners = as_grid(
            np.array(known[name]["corners"], float).reshape(-1, 2), tuple(known[name]["grid"])
        )
        lines = LinePoints.of([*corners, *corners.swapaxes(0, 1)])
        yield Case(lens, name, image, lines, None, calibrate(image).model.center)
