"""How near to the best model of its kind calibration comes on lenses that follow none: circular fisheyes.

Scored as real pictures are: on corners, here the true ones moved by as much as found ones are wrong.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ..calibration.spec import MODELS, CalibrationSpec
from ..model import DivisionModel
from ..synth.board import BoardScene, render_board, true_corners
from ..synth.fisheye import Fisheye
from ..synth.fisheye_boards import fisheye_board
from .corner_floor import least_straightness
from .corner_score import Corners, straightness
from .synthetic_boards import attempt, each

# Corners that are found in pictures are wrong by about this, px.
CORNER_NOISE = 0.05
# A floor is no lens where it sends a corner this many times as far out as it is seen, or farther.
FAR_OUT = 25.0
# Twice the floor, or so many px above it, counts as near it.
NEAR, NEAR_PX = 2.0, 0.2


@dataclass(frozen=True)
class Outcome:
    """One model on one board.

    ``angle``: how far from the axis the farthest corner is, degrees; ``s`` and ``floor`` px: the straightness
    of the corners under the model found, and the least of any; ``far_out``: how many times as far as it is
    seen that least model sends a corner. ``s`` is infinite where nothing was found.
    """

    seed: int
    lens: str
    angle: float
    model: str
    verdict: str
    s: float
    floor: float
    far_out: float

    @property
    def ratio(self) -> float:
        """The straightness over the least one."""
        return self.s / self.floor

    @property
    def degenerate(self) -> bool:
        """Whether the least one is no lens."""
        return self.far_out > FAR_OUT

    @property
    def near(self) -> bool:
        """Whether it is near the least one."""
        return self.s <= max(NEAR * self.floor, self.floor + NEAR_PX)

    def data(self) -> dict[str, Any]:
        """Return the outcome as plain data; what is infinite as None."""
        values = {**asdict(self), "ratio": self.ratio}
        return {k: None if v == math.inf else v for k, v in values.items()}


@dataclass(frozen=True)
class Summary:
    """A row of the table: quantiles of s / floor, and the seeds of the boards that are not near the floor."""

    boards: int
    median: float
    p90: float
    worst: float
    far: tuple[int, ...]


def run(
    seeds: Sequence[int], processes: int = 1, progress: Callable[[Outcome], None] = lambda o: None
) -> tuple[Outcome, ...]:
    """Render and calibrate the boards of these seeds with each model; ``progress`` gets one a board."""
    outcomes = []
    for own in each(run_board, seeds, processes):
        progress(own[0])
        outcomes.extend(own)
    return tuple(outcomes)


def run_board(seed: int) -> list[Outcome]:
    """Render board number ``seed``, calibrate from the picture alone, and score its corners."""
    scene = fisheye_board(seed)
    picture = render_board(scene)
    true = true_corners(scene)[0]
    corners = true + np.random.default_rng(seed).normal(0, CORNER_NOISE, true.shape)
    outcomes = []
    for name in MODELS:
        floor, best = least_straightness(corners, scene.model.size, name)
        found, verdict, _ = attempt(picture, CalibrationSpec(model=name))
        outcomes.append(
            Outcome(
                seed=seed,
                lens=lens_name(scene.model),
                angle=_angle(scene, true),
                model=name,
                verdict=verdict,
                s=math.inf if found is None else straightness(corners, found.model),
                floor=floor,
                far_out=_far_out(best, corners),
            )
        )
    return outcomes


def summarise(outcomes: Sequence[Outcome]) -> Summary:
    """Return the row of a set of one outcome or more."""
    ratios = np.array([o.ratio for o in outcomes])
    median, p90 = (float(np.quantile(ratios, q, method="higher")) for q in (0.5, 0.9))
    far = tuple(o.seed for o in outcomes if not o.near)
    return Summary(len(outcomes), median, p90, float(ratios.max()), far)


def lens_name(model: DivisionModel | Fisheye) -> str:
    """Return what kind of lens it is."""
    if isinstance(model, DivisionModel):
        return "division"
    return "series" if model.k else model.projection


def _angle(scene: BoardScene, corners: Corners) -> float:
    offsets = scene.model.undistort(corners) - scene.model.center
    return math.degrees(math.atan(np.linalg.norm(offsets, axis=-1).max() / scene.pose.focal))


def _far_out(model: DivisionModel, corners: Corners) -> float:
    q = ((corners - model.center) ** 2).sum(axis=-1)
    return float(1 / model.denominator(q).min())
