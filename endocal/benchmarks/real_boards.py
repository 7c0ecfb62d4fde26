"""What calibration makes of real pictures of boards, scored on corners that were found without it.

The folder holds a folder of pictures for each lens, and ``corners.json``: for some pictures the corners
and the least straightness that any one- or two-parameter division model reaches on them.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..calibration.image.picture import to_grey
from ..calibration.scene import Image
from ..calibration.spec import MODELS, CalibrationSpec
from ..errors import InputError
from ..files import read_image
from ..files.images import PICTURE_SUFFIXES
from .corner_score import Corners, as_grid, find_corners, straightness
from .synthetic_boards import attempt

# Grids of dots hold no straight edge and no corner to be scored on.
UNSCORED = ("dots",)


@dataclass(frozen=True)
class Score:
    """One model on one picture.

    ``lam`` px^-2 (None: nothing found); ``s`` px, the straightness of the corners under the model, and
    ``floor`` px, the least that a model of its kind reaches (None: not known).
    """

    verdict: str
    reasons: tuple[str, ...]
    lam: float | None
    lam2: float | None
    center: tuple[float, float] | None
    s: float | None
    floor: float | None

    @property
    def ratio(self) -> float | None:
        """The straightness over the least one."""
        return None if self.s is None or self.floor is None else self.s / self.floor


@dataclass(frozen=True)
class Picture:
    """A picture, the straightness of its corners as they are, px (None: no corners), the scores by model."""

    lens: str
    file: str
    size: tuple[int, int]
    uncorrected: float | None
    scores: dict[str, Score]

    def data(self) -> dict[str, Any]:
        """Return the picture's scores as plain data; an infinite s as None."""
        scores = {k: {**asdict(v), "ratio": v.ratio} for k, v in self.scores.items()}
        for score in scores.values():
            for key in ("s", "ratio"):
                if score[key] is not None and not math.isfinite(score[key]):
                    score[key] = None
        return {**asdict(self), "scores": scores}


def run(folder: Path, progress: Callable[[Picture], None] = lambda p: None) -> tuple[Picture, ...]:
    """Calibrate from each picture below ``folder``, one by one, with each model.

    Raises InputError where there is no picture.
    """
    known = json.loads((folder / "corners.json").read_text(encoding="utf-8"))
    files = [p for p in sorted(folder.glob("*/*")) if p.suffix.lower() in PICTURE_SUFFIXES]
    if not files:
        raise InputError(f"{folder}: no pictures in the folders there")
    pictures = []
    for path in files:
        pictures.append(run_picture(path, known.get(f"{path.parent.name}/{path.name}", {})))
        progress(pictures[-1])
    return tuple(pictures)


def run_picture(path: Path, known: dict[str, Any]) -> Picture:
    """Calibrate from one picture with each model; ``known`` is its entry of corners.json, or empty."""
    image = read_image(path)
    corners = _corners(image, known, path.parent.name)
    scores = {}
    for model in MODELS:
        floor = known.get("floor_division2" if model == "division2" else "floor_division")
        scores[model] = _score(image, model, corners, floor)
    return Picture(
        lens=path.parent.name,
        file=path.name,
        size=(image.shape[1], image.shape[0]),
        uncorrected=None if corners is None else straightness(corners),
        scores=scores,
    )


def median_ratio(pictures: tuple[Picture, ...], lens: str, model: str) -> float | None:
    """Return the median s / floor over a lens's pictures; None where no floor is known."""
    ratios = [p.scores[model].ratio for p in pictures if p.lens == lens]
    finite = [math.inf if r is None else r for r in ratios]
    return float(np.median(finite)) if any(r is not None for r in ratios) else None


def _corners(image: Image, known: dict[str, Any], lens: str) -> Corners | None:
    if known:
        corners = np.asarray(known["corners"], np.float64).reshape(-1, 2)
        return as_grid(corners, (known["grid"][0], known["grid"][1]))
    if lens.startswith(UNSCORED):
        return None
    return find_corners(np.rint(to_grey(image)).astype(np.uint8))


def _score(image: Image, model: str, corners: Corners | None, floor: float | None) -> Score:
    found, verdict, reasons = attempt(image, CalibrationSpec(model=model))
    if found is None:
        return Score(verdict, reasons, None, None, None, None, floor)
    return Score(
        verdict,
        reasons,
        lam=found.model.lam,
        lam2=found.model.lam2 if model == "division2" else None,
        center=found.model.center,
        s=None if corners is None else straightness(corners, found.model),
        floor=floor,
    )
