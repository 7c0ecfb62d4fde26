"""A chessboard's corners in a picture, and which is which, with no word about how many there are.

OpenCV's sector-based detector (cv2.findChessboardCornersSBWithMeta) is asked for a small board or any larger
one; where squares get small or lines bend, it ends. What it found is grown from there: the model of the
corners so far (``lifted.py``) says where the next ones are, there they are measured, and they count if the
four squares around show the board's two colours.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from ..image.picture import Grey
from ..image.sampling import sample
from ..straightness import Floats, Labels
from .lifted import BoardFit, Corners, fit, linear_solution, see

# Boards of at least so many inner corners are looked for, in the whole picture and in one half as wide, where
# noise and blur are less; the first that is found is grown.
SMALLEST = ((9, 7), (7, 6), (5, 4), (4, 3))
REDUCTIONS = (1, 2)
# A larger picture is reduced to about so many px for that.
MOST_PIXELS = 4_000_000
# A new corner lies within this share of a square's side of where it was expected; so wide is its window, too.
NEAR = 0.25
# The squares around a corner differ by this share of what the board's usually do, at least.
LEAST_CONTRAST = 0.3
# Squares with shorter sides, px, have no corners that could be measured.
SHORTEST_SIDE = 4.0
WIDEST_WINDOW = 10
# A corner farther from where the fitted model sees it than this, in robust deviations and px, is none.
OUTLYING, LEAST_OUTLYING = 5.0, 0.5
MOST_ROUNDS = 30
# Two points lie on a line whatever they are; the third proves it: so many neighbouring corners make a row.
FEWEST_IN_ROW = 3
# A mesh of the seed is a square where its grey levels spread less than this share of their step to others.
MOST_SPREAD = 0.3
FEWEST_SEEDS = 9
CROSS = np.array([[0, 1, 0], [1, 0, 1], [0, 1, 0]], np.float32)
# From a corner to the middles of the four squares around it, and the colours there: 1 and -1 by turns.
AROUND = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])


@dataclass(frozen=True)
class Board:
    """The chessboard in a picture: its corners, and the lens that they tell.

    ``corners`` has the points (n, 2) px and each one's place (n, 2) on the board: whole numbers, (column,
    row), from an arbitrary first one and possibly negative; not every place of the rectangle they span need
    be there. Corners with equal column, or equal row, lie on one line of the board. ``fit`` holds (lam px^-2,
    cx, cy px), the homography from places to undistorted offsets, and what the corners are off by, px.
    """

    corners: Corners
    fit: BoardFit

    def seen_at(self, places: Floats | Labels) -> Floats:
        """Return where places (m, 2) on the board are seen, (m, 2) px; NaN where it has no such place."""
        return see(self.fit.params, self.fit.homographies[0], places)

    def lines(self) -> list[Floats]:
        """Return the corners on each row and column in order, (k, 2) px, where there are three or more."""
        found = []
        for axis in (0, 1):
            across = self.corners.places[:, axis]
            for value in np.unique(across):
                own = np.flatnonzero(across == value)
                if len(own) >= 3:
                    order = np.argsort(self.corners.places[own, 1 - axis])
                    found.append(self.corners.points[own[order]])
        return found


def find_board(grey: Grey) -> Board | None:
    """Find the chessboard in a picture (h, w) of grey levels 0 to 255; None where there is none.

    The picture's pixels are to be square. One with 4 x 3 inner corners or more is found; of several, one.
    """
    corners = _seed(grey)
    if corners is None:
        return None
    model = fit([corners], _start(corners))
    for _ in range(MOST_ROUNDS):
        grown = _grown(grey, corners, model)
        model = fit([grown], model.params, rounds=15)
        before = {*map(tuple, corners.places)}
        # What is dropped here is measured anew in the next round, if the model expects it.
        corners = _without_outliers(grown, model)
        if before == {*map(tuple, corners.places)}:
            break
    corners = _without_stray_rows(corners)
    return Board(corners, fit([corners], model.params))


def _seed(grey: Grey) -> Corners | None:
    """A part of the board that OpenCV's detector sees rightly: it may also skip rows, or run askew."""
    least_reduction = int(np.ceil(np.sqrt(grey.size / MOST_PIXELS)))
    for reduction in (least_reduction * r for r in REDUCTIONS):
        small = cv2.resize(
            grey, None, fx=1 / reduction, fy=1 / reduction, interpolation=cv2.INTER_AREA
        )
        for least in SMALLEST:
            grid = _grid(np.asarray(small), least)
            if grid is None:
                continue
            grid = (grid + 0.5) * reduction - 0.5
            chosen = _on_squares(grey, grid)
            if np.count_nonzero(chosen) >= FEWEST_SEEDS:
                y, x = np.nonzero(chosen)
                return Corners(grid[chosen], np.stack([x, y], axis=1).astype(np.intp))
    return None


def _grid(grey: Grey, least: tuple[int, int]) -> Floats | None:
    """The corners (rows, cols, 2) px that OpenCV's detector finds, at least so many each way, or None."""
    flags = cv2.CALIB_CB_LARGER | cv2.CALIB_CB_EXHAUSTIVE | cv2.CALIB_CB_ACCURACY
    flags |= cv2.CALIB_CB_NORMALIZE_IMAGE
    picture = np.clip(np.rint(grey), 0, 255).astype(np.uint8)
    found, corners, squares = cv2.findChessboardCornersSBWithMeta(picture, least, flags)
    if not found:
        return None
    return np.asarray(corners, np.float64).reshape(*squares.shape[:2], 2)


def _on_squares(grey: Grey, grid: Floats) -> NDArray[np.bool_]:
    """Which corners of a grid (rows, cols, 2) px belong to the largest patch of light and dark squares.

    A mesh of the grid is a square where it is of one colour inside, and its neighbours are of the other.
    """
    along = np.linspace(0.2, 0.8, 5)
    v, u = (f.ravel()[:, None] for f in np.meshgrid(along, along, indexing="ij"))
    corner = [grid[:-1, :-1], grid[:-1, 1:], grid[1:, :-1], grid[1:, 1:]]
    a, b, c, d = (part[:, :, None] for part in corner)
    levels = sample(grey, (1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * c + u * d))
    level, spread = levels.mean(axis=2), levels.std(axis=2)
    parity = np.where(np.indices(level.shape).sum(axis=0) % 2, -1.0, 1.0)
    # The mean of the neighbours, at the grid's edge of those there are.
    around = cv2.filter2D(level, -1, CROSS, borderType=cv2.BORDER_CONSTANT)
    number = cv2.filter2D(np.ones_like(level), -1, CROSS, borderType=cv2.BORDER_CONSTANT)
    step = (level - around / number) * parity
    step *= np.sign(np.median(step)) or 1.0
    square = (step > 0) & (spread < MOST_SPREAD * step)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(
        square.astype(np.uint8), connectivity=4
    )
    chosen = np.zeros(grid.shape[:2], bool)
    if count > 1:
        largest = labels == 1 + int(stats[1:, cv2.CC_STAT_AREA].argmax())
        for i in (0, 1):
            for j in (0, 1):
                chosen[i : i + len(largest), j : j + largest.shape[1]] |= largest
    return chosen


def _start(board: Corners) -> Floats:
    """The linear solution where it makes sense, else no distortion around the corners' middle."""
    found = linear_solution(board)
    middle = board.points.mean(axis=0)
    reach = float(np.linalg.norm(board.points - middle, axis=1).max())
    sensible = np.all(np.isfinite(found)) and abs(found[0]) * reach**2 < 1
    if sensible and np.linalg.norm(found[1:3] - middle) < 2 * reach:
        return found
    return np.array([0.0, *middle])


def _grown(grey: Grey, board: Corners, model: BoardFit) -> Corners:
    """Add the corners next to those known, where the picture shows them."""
    places = _neighbors(board.places)
    at, around, side = _expected(model, places)
    h, w = grey.shape
    with np.errstate(invalid="ignore"):
        seen = ((around >= 1) & (around <= (w - 2, h - 2))).all(axis=(1, 2))
        seen &= (side > SHORTEST_SIDE) & np.isfinite(at).all(axis=1)
    places, at, around, side = places[seen], at[seen], around[seen], side[seen]
    if len(places) == 0:
        return board
    usual = np.nanmedian(_contrast(grey, board.places, _expected(model, board.places)[1]))
    good = _contrast(grey, places, around) * np.sign(usual) > LEAST_CONTRAST * abs(usual)
    found = _measured(grey, at[good], side[good])
    near = np.linalg.norm(found - at[good], axis=1) < np.maximum(NEAR * side[good], 1.0)
    return Corners(
        np.concatenate([board.points, found[near]]),
        np.concatenate([board.places, places[good][near]]),
    )


def _neighbors(places: Labels) -> Labels:
    """Places (n, 2) next to those given, along rows and columns, that are not among them."""
    known = {(int(x), int(y)) for x, y in places}
    steps = ((1, 0), (-1, 0), (0, 1), (0, -1))
    new = {(x + i, y + j) for x, y in known for i, j in steps} - known
    return np.array(sorted(new), np.intp).reshape(-1, 2)


def _expected(model: BoardFit, places: Labels) -> tuple[Floats, Floats, Floats]:
    """Where corners (n, 2), and the middles of the four squares around each, (n, 4, 2), are seen, px.

    And the shorter of the two ways across those squares, (n,) px: about a square's side.
    """
    params, homography = model.params, model.homographies[0]
    at = see(params, homography, places)
    around = see(params, homography, (places[:, None] + AROUND).reshape(-1, 2)).reshape(-1, 4, 2)
    side = np.linalg.norm(around[:, 2:] - around[:, :2], axis=-1).min(axis=1) / np.sqrt(2)
    return at, around, side


def _contrast(grey: Grey, places: Labels, around: Floats) -> Floats:
    """The least difference in grey levels, (n,), between squares around a corner that differ in colour.

    ``around`` (n, 4, 2) px are the squares' middles. Its sign is the same all over a board, by which squares
    are the light ones; 0 where the squares are not light and dark by turns.
    """
    levels = np.nan_to_num(sample(grey, np.nan_to_num(around)))
    odd = (places.sum(axis=1) % 2 == 1)[:, None]
    ones = np.where(odd, levels[:, 1::2], levels[:, ::2])
    others = np.where(odd, levels[:, ::2], levels[:, 1::2])
    lighter = ones.min(axis=1) - others.max(axis=1)
    darker = others.min(axis=1) - ones.max(axis=1)
    return np.asarray(np.where(lighter > 0, lighter, np.where(darker > 0, -darker, 0.0)))


def _measured(grey: Grey, at: Floats, side: Floats) -> Floats:
    """The saddle of grey levels near each expected corner, (n, 2) px."""
    end = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 30, 0.005)
    found = np.empty_like(at)
    windows = np.clip(np.rint(NEAR * side), 2, WIDEST_WINDOW).astype(int)
    for window in np.unique(windows):
        own = windows == window
        points = at[own, None].astype(np.float32)
        size = (int(window), int(window))
        found[own] = cv2.cornerSubPix(grey, points, size, (-1, -1), end)[:, 0]
    return found


def _without_outliers(board: Corners, model: BoardFit) -> Corners:
    """Drop corners that lie elsewhere than the model says, by far more than others do."""
    off = np.linalg.norm(
        see(model.params, model.homographies[0], board.places) - board.points, axis=1
    )
    limit = max(LEAST_OUTLYING, OUTLYING * float(np.median(off)) / 1.1774)
    with np.errstate(invalid="ignore"):
        kept = off < limit
    return Corners(board.points[kept], board.places[kept])


def _without_stray_rows(board: Corners) -> Corners:
    """Drop outermost rows and columns that no FEWEST_IN_ROW neighbours in line speak for.

    Beside a board, its margin, the table and the rim of the view may look like the four squares of a corner,
    once; a row of the board shows several. A board too small to have such rows comes back as it is.
    """
    kept = np.ones(len(board.points), bool)
    while kept.any():
        outermost = np.zeros_like(kept)
        for axis in (0, 1):
            across, along = board.places[:, axis], board.places[:, 1 - axis]
            for value in (across[kept].min(), across[kept].max()):
                own = kept & (across == value)
                if _longest_run(along[own]) < FEWEST_IN_ROW:
                    outermost |= own
        if not outermost.any():
            return Corners(board.points[kept], board.places[kept])
        kept &= ~outermost
    return board


def _longest_run(places: Labels) -> int:
    """How many of the places (n,), whole numbers, follow each other without a gap, at most."""
    breaks = np.flatnonzero(np.diff(np.sort(places)) > 1) + 1
    return max(len(run) for run in np.split(places, breaks))
