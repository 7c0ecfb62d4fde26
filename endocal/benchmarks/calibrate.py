"""Algorithm 1 with HEwG beside the article's times and a plain loop, and the time of the whole command."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..boundary.detect import find_boundary
from ..calibration.hough.hewg import hewg
from ..calibration.hough.votes import Voters
from ..calibration.image.content import content_mask
from ..calibration.image.edges import find_edges, sobel_gradients
from ..calibration.image.picture import Picture, to_grey
from ..calibration.methods.grid import SCOUTS, margin
from ..calibration.search import Found, Measure, Region, Scout, search
from ..calibration.spec import CalibrationSpec
from ..errors import EndocalError
from ..files import write_image
from ..synth.board import BoardScene, render_board
from ..synth.camera import Camera, ContentCircle
from ..synth.framing import covering
from ..synth.lens import typical_lens
from ..synth.pattern import Pattern, Pose
from . import plain_hewg

Floats = NDArray[np.float64]
Result = TypeVar("Result")

REPEATS = 5


@dataclass(frozen=True)
class ArticleTime:
    """A row of the article's Table IV: edge points, seconds on one core of an i7-860 and on its four."""

    points: int
    one_core: float
    four_cores: float


ARTICLE = (
    ArticleTime(15299, 6.302, 1.997),
    ArticleTime(7758, 3.182, 0.89),
    ArticleTime(7029, 2.387, 0.671),
    ArticleTime(6100, 1.653, 0.531),
)
# Squares of the boards: many, so that one picture has the edge points of the largest row.
SEARCH_BOARD = ((1440, 1080), (20, 15))
COMMAND_BOARD = ((768, 576), (14, 11))
# Two searches agree when their lambdas lie within the search's epsilon, and the entropies within this:
# a vote that rounding moves over a cell's border may break a tie in the last rounds either way.
SAME_ENTROPY = 1e-3


@dataclass(frozen=True)
class Minimum:
    """Where a search ended: lambda px^-2, centre px, and the entropy there by the plain reckoning."""

    lam: float
    center: tuple[float, float]
    entropy: float


@dataclass(frozen=True)
class Seconds:
    """Time on the clock, median and least, and of the processor, median."""

    median: float
    least: float
    processor: float


@dataclass(frozen=True)
class Row:
    """Algorithm 1 on one number of edge points: by endocal, by the plain loop, by the article."""

    article: ArticleTime
    endocal: Seconds
    plain: Seconds
    found: Minimum
    plain_found: Minimum

    @property
    def same_minimum(self) -> bool:
        """Whether both searches ended in one place, as nearly as the search itself resolves it."""
        a, b = self.found, self.plain_found
        near = abs(a.lam - b.lam) < CalibrationSpec().epsilon
        return near and abs(a.entropy - b.entropy) < SAME_ENTROPY

    @property
    def times_plain(self) -> float:
        """The plain loop's processor time over endocal's: other work on the machine moves it less."""
        return self.plain.processor / self.endocal.processor

    @property
    def times_article(self) -> float:
        """The article's time on one core over endocal's processor time; endocal uses one core."""
        return self.article.one_core / self.endocal.processor


@dataclass(frozen=True)
class Command:
    """The whole ``endocal calibrate`` on a board of ``size`` px, a process from start to end."""

    size: tuple[int, int]
    time: Seconds


@dataclass(frozen=True)
class CalibrateReport:
    """The rows, samples per axis, epsilon in px^-2, how often each was timed, and the whole command."""

    samples: int
    epsilon: float
    repeats: int
    rows: tuple[Row, ...]
    command: Command

    def data(self) -> dict[str, Any]:
        """Return the report as plain data."""
        derived = ("same_minimum", "times_plain", "times_article")
        rows = [{**asdict(r), **{name: getattr(r, name) for name in derived}} for r in self.rows]
        return {**asdict(self), "rows": rows}


def run(
    repeats: int = REPEATS,
    article: Sequence[ArticleTime] = ARTICLE,
    progress: Callable[[str], None] = lambda work: None,
) -> CalibrateReport:
    """Time the search on a synthetic board's edge points, ``repeats`` times, and the plain loop once.

    ``progress`` is called with the name of each piece of work before it starts.
    """
    spec = CalibrationSpec()
    problem = _Problem.of(board(*SEARCH_BOARD), spec)
    rows = []
    for times in article:
        progress(f"{times.points} edge points")
        rows.append(_row(problem.some(times.points), times, spec, repeats))
    progress("the whole command")
    command = Command(COMMAND_BOARD[0], _time_command(board(*COMMAND_BOARD), repeats))
    return CalibrateReport(spec.samples, spec.epsilon, repeats, tuple(rows), command)


def board(size: tuple[int, int], squares: tuple[int, int]) -> BoardScene:
    """Return a chessboard through an endoscope like the article's, sharp and with a little noise."""
    lens = typical_lens(size, fill=0.95)
    circle: ContentCircle = lens.circle_at(1)
    scene = BoardScene(
        lens.model,
        Pattern("chessboard", *squares),
        Pose(circle.center, 1.0, 15.0, 40.0, 10.0, lens.focal),
        circle,
        Camera(blur=0.8, vignetting=0.4, gamma=1.8, black=4.0, noise=2.0),
    )
    placed = covering(scene, 0.6)
    assert placed is not None, "a board tilted by 15 degrees covers 60 % of any view"
    return placed


@dataclass(frozen=True)
class _Problem:
    """Edge points (n, 2) px, their gradients, the region to search, and the frame's height, px."""

    points: Floats
    gradients: Floats
    region: Region
    height: float

    @classmethod
    def of(cls, scene: BoardScene, spec: CalibrationSpec) -> _Problem:
        grey = to_grey(render_board(scene))
        boundary = find_boundary(grey.astype(np.uint8))
        edges = find_edges(Picture(grey, content_mask(grey, boundary)))
        w, h = scene.model.size
        x, y = (w - 1) / 2, (h - 1) / 2
        dx, dy = w * spec.center_region / 2, h * spec.center_region / 2
        reach = float(np.quantile(np.linalg.norm(edges.points - (x, y), axis=1), 0.98))
        region = Region((-1 / reach**2, -1e-7), (x - dx, x + dx), (y - dy, y + dy))
        return cls(edges.points, sobel_gradients(grey, edges.points, spec.sobel), region, h)

    def some(self, count: int) -> _Problem:
        """The problem with ``count`` of its points, drawn evenly."""
        if count > len(self.points):
            raise EndocalError(f"the board has {len(self.points)} edge points, not {count}")
        drawn = np.random.default_rng(0).permutation(len(self.points))[:count]
        return _Problem(self.points[drawn], self.gradients[drawn], self.region, self.height)


def _row(problem: _Problem, article: ArticleTime, spec: CalibrationSpec, repeats: int) -> Row:
    voters = Voters.of(problem.points, problem.gradients, problem.height)
    votes = plain_hewg.Votes.of(voters)

    def minimum(found: Found) -> Minimum:
        lam, x, y = (float(v) for v in found.params)
        return Minimum(lam, (x, y), plain_hewg.entropy(votes, lam, x, y))

    def searched(measure: Measure, scout: Scout | None = None) -> Found:
        limits = spec.samples, spec.epsilon, spec.max_rounds
        return search(measure, problem.region, *limits, scout=scout)

    def ours() -> Found:
        few = voters.only(slice(None, None, SCOUTS))
        return searched(partial(hewg, voters), Scout(partial(hewg, few), margin([len(few)])))

    times, found = _timed(ours, repeats)
    peers, plain_found = _timed(lambda: searched(partial(plain_hewg.grid, votes)), 1)
    return Row(article, times, peers, minimum(found), minimum(plain_found))


def _time_command(scene: BoardScene, repeats: int) -> Seconds:
    with tempfile.TemporaryDirectory() as folder:
        picture, output = Path(folder) / "board.png", Path(folder) / "cal.toml"
        write_image(picture, render_board(scene))
        words = ["calibrate", str(picture), "-o", str(output), "--overwrite"]

        def command() -> None:
            done = subprocess.run(
                [sys.executable, "-m", "endocal", *words],
                capture_output=True,
                text=True,
                check=False,
            )
            if done.returncode:
                raise EndocalError(f"endocal calibrate failed: {done.stderr.strip()}")

        return _timed(command, repeats)[0]


def _timed(call: Callable[[], Result], repeats: int) -> tuple[Seconds, Result]:
    clock, processor = [], []
    for _ in range(repeats):
        start, used = time.perf_counter(), _processor_time()
        result = call()
        clock.append(time.perf_counter() - start)
        processor.append(_processor_time() - used)
    return Seconds(median(clock), min(clock), median(processor)), result


def _processor_time() -> float:
    """Seconds that this process and the ones it waited for have kept a processor busy."""
    # The system counts in hundredths of a second, which is too coarse for the work of this process.
    times = os.times()
    return time.process_time() + times.children_user + times.children_system
