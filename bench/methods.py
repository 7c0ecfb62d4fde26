"""Print how near bare methods come on random boards: ``make bench-methods``.

Boards of ``endocal.synth.random`` whose lam R^2 is -0.3 or less, R being the farthest visible pixel's radius.
A method is near where lambda is within 8 % and the centre within 10 px, in a picture of 720x540. So the same
scenes are drawn twice: in frames of 720x540, and of all sizes; in these the 10 px are in proportion to the
frame's height.
"""

from __future__ import annotations

import argparse
import math
import os
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context

# Before NumPy is loaded, here and in the processes that inherit it: they fill the processors already.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import cv2
import numpy as np

from endocal.benchmarks.synthetic_boards import strength_of
from endocal.calibration.calibrate import calibrate
from endocal.calibration.evaluate import LinePoints, evaluate
from endocal.calibration.methods.registry import METHODS
from endocal.calibration.spec import CalibrationSpec
from endocal.errors import CalibrationError
from endocal.synth.board import render_board, true_lines
from endocal.synth.random import random_board

WEAKEST = -0.3
NEAR_LAMBDA, NEAR_CENTER, LINES = 0.08, 10.0, 540
SIZE = (720, 540)

Size = tuple[int, int] | None


@dataclass(frozen=True)
class Outcome:
    """A method on a board: errors relative, and px of 540 lines; RMSE px; infinite where it refused."""

    seed: int
    pattern: str
    method: str
    lam: float = math.inf
    center: float = math.inf
    rmse: float = math.inf

    @property
    def near(self) -> bool:
        """Whether both lambda and centre are near."""
        return abs(self.lam) < NEAR_LAMBDA and self.center < NEAR_CENTER


def main() -> None:
    """Run what the command line asks for, and print it."""
    args = parse()
    with ProcessPoolExecutor(args.processes, get_context("spawn"), _one_thread_each) as pool:
        for size in (SIZE, None):
            seeds = list(seeds_from(args.first, args.boards, size))
            work = [(seed, method, size) for seed in seeds for method in args.method.split(",")]
            outcomes = []
            for outcome in pool.map(run, work):
                print(f"\r{outcome.seed}", end="", file=sys.stderr, flush=True)
                outcomes.append(outcome)
            frames = "frames of all sizes" if size is None else f"{size[0]}x{size[1]}"
            print(
                f"\n{len(seeds)} random boards of λR² ≤ {WEAKEST}, {frames},"
                f" seeds {seeds[0]} to {seeds[-1]}\n"
            )
            tell(outcomes, args.method.split(","))


def tell(outcomes: list[Outcome], methods: list[str]) -> None:
    """Print the table of some boards, and those that are not near."""
    print(
        "| method | boards | near | λ off by: median | centre, px: median | RMSE, px: mean | median |"
    )
    print("|---|---|---|---|---|---|---|")
    for method in methods:
        own = [o for o in outcomes if o.method == method]
        for title, pattern in (("all", None), ("chessboards", "chessboard"), ("bars", "lines")):
            group = [o for o in own if pattern in (None, o.pattern)]
            if group:
                print(row(f"{method}, {title}", group))
    far = [
        f"{o.seed} ({o.method}, {o.pattern}, {o.lam:+.1%}, {o.center:.1f} px)"
        for o in outcomes
        if not o.near
    ]
    print(f"\nNot near: {', '.join(far) or 'none'}", flush=True)


def row(title: str, group: list[Outcome]) -> str:
    """Return a row of the table."""
    near = np.mean([o.near for o in group])
    finite = [o.rmse for o in group if math.isfinite(o.rmse)]
    cells = [title, str(len(group)), f"{near:.0%}", f"{np.median([abs(o.lam) for o in group]):.1%}"]
    cells += [f"{np.median([o.center for o in group]):.1f}", f"{np.mean(finite):.2f}"]
    return f"| {' | '.join([*cells, f'{np.median(finite):.2f}'])} |"


def parse() -> argparse.Namespace:
    """Return the options of the command line."""
    parser = argparse.ArgumentParser(description=__doc__, allow_abbrev=False)
    parser.add_argument("--boards", type=int, default=100)
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument(
        "--method", default="hewg,heplp", help=f"of {','.join(METHODS)} (default hewg,heplp)"
    )
    parser.add_argument("--processes", type=int, default=min(2, os.cpu_count() or 1))
    return parser.parse_args()


def seeds_from(first: int, count: int, size: Size) -> Iterator[int]:
    """Yield the seeds of boards that are bent enough."""
    seed = first
    while count > 0:
        if strength_of(random_board(seed, size)) <= WEAKEST:
            yield seed
            count -= 1
        seed += 1


def run(work: tuple[int, str, Size]) -> Outcome:
    """Run a method on the board of a seed."""
    seed, method, size = work
    scene = random_board(seed, size)
    truth = scene.model
    try:
        spec = CalibrationSpec(method=method, refine=False)
        model = calibrate(render_board(scene), spec).model
    except CalibrationError:
        return Outcome(seed, scene.pattern.kind, method)
    away = math.hypot(*np.subtract(model.center, truth.center)) * LINES / truth.size[1]
    rmse = evaluate(LinePoints.of(true_lines(scene, 60)), model).rmse
    return Outcome(seed, scene.pattern.kind, method, model.lam / truth.lam - 1, away, rmse)


def _one_thread_each() -> None:
    cv2.setNumThreads(1)


if __name__ == "__main__":
    main()
