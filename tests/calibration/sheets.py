"""The lines of sheets of paper through a lens, as they are measured: points with known truth."""

from __future__ import annotations

import numpy as np

from endocal.calibration.measure.profiles import Measured
from endocal.model import DivisionModel

# A weak one, of which the straightness of lines tells little.
LENS = np.array([-0.8e-6, 325.0, 233.0])
SQUARE, FOCAL = 0.2, 500.0
ROWS, COLUMNS = 8, 10
# Neighbours err alike, as averaged profiles do.
AVERAGED = 6


def sheet(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Where places (n,), (n,) on a tilted sheet, in squares from its middle, are seen, (n, 2) px."""
    at = np.stack([x, y, np.zeros_like(x)], axis=1) * SQUARE
    turn, tilt = np.deg2rad(12), np.deg2rad(25)
    cos, sin = np.cos(turn), np.sin(turn)
    at = at @ np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]]).T
    cos, sin = np.cos(tilt), np.sin(tilt)
    at = at @ np.array([[1, 0, 0], [0, cos, -sin], [0, sin, cos]]).T + (0.05, -0.05, 1.9)
    model = DivisionModel(LENS[0], tuple(LENS[1:]), (640, 480))
    return model.distort(FOCAL * at[:, :2] / at[:, 2:] + LENS[1:])


def left_of(points: np.ndarray) -> np.ndarray:
    """Unit vectors (n, 2) to the left of the way along points (n, 2)."""
    way = np.gradient(points, axis=0)
    way /= np.linalg.norm(way, axis=1)[:, None]
    return np.stack([-way[:, 1], way[:, 0]], axis=1)


def errors(count: int, noise: float, rng: np.random.Generator) -> np.ndarray:
    """Errors (count,) px of neighbours that err alike."""
    alike = np.convolve(rng.normal(0, 1, count + AVERAGED - 1), np.ones(AVERAGED), "valid")
    return alike * noise / np.sqrt(AVERAGED)


def board(
    noise: float = 0.05,
    seed: int = 0,
    astray: float = 0.0,
    wrong: float = 0.0,
) -> Measured:
    """The lines of a board with noise (px); every line moved by a normal deviate of ``astray`` squares.

    One row is moved by ``wrong`` squares.
    """
    rng = np.random.default_rng(seed)
    parts: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
    for family, count, other in ((0, ROWS - 1, COLUMNS), (1, COLUMNS - 1, ROWS)):
        for k in range(count):
            t = np.linspace(-other / 2, other / 2, 16 * other + 1)
            off = k + 1 - (count + 1) / 2 + rng.normal(0, astray)
            if (family, k) == (0, 2):
                off += wrong
            place = (t, np.full(len(t), off))
            points = sheet(*(place if family == 0 else place[::-1]))
            points = points + errors(len(t), noise, rng)[:, None] * left_of(points)
            cell = np.floor(t + other / 2).astype(int)
            clear = np.abs(t - np.rint(t)) > 0.1
            sides = np.where((cell + k + family) % 2, 1.0, -1.0)
            label = np.full(len(t), len(parts))
            parts.append((points[clear], label[clear], sides[clear]))
    return measured(parts, rng)


def measured(
    parts: list[tuple[np.ndarray, np.ndarray, np.ndarray]], rng: np.random.Generator
) -> Measured:
    """The points, labels and sides of lines, as if measured."""
    points, labels, sides = (np.concatenate(p) for p in zip(*parts, strict=True))
    levels = rng.normal((40.0, 200.0, 210.0), 5.0, (len(points), 3))
    return Measured(points, labels, sides, levels, np.ones(len(points)))


def bars(
    noise: float = 0.05,
    seed: int = 0,
    astray: float = 0.0,
    grown: float = 0.0,
    missing: tuple[int, ...] = (),
    rows: tuple[float, ...] = (-ROWS / 2, ROWS / 2),
    seen: float = COLUMNS / 2,
) -> Measured:
    """The long edges of bars, but those ``missing``, then the rows of their ends, measured with noise (px).

    Every edge is moved by a normal deviate of ``astray`` bars' widths. The bright side grows by ``grown`` px,
    and by more to the right. Of the rows so much is ``seen`` to both sides of the middle.
    """
    rng = np.random.default_rng(seed)
    lines = []
    for k in range(COLUMNS + 1):
        y = np.linspace(-ROWS / 2, ROWS / 2, 16 * ROWS + 1)
        x = np.full(len(y), k - COLUMNS / 2 + rng.normal(0, astray))
        if k not in missing:
            lines.append((x, y, 1.0 if k % 2 == 0 else -1.0))
    for end in rows:
        x = np.linspace(-COLUMNS / 2, COLUMNS / 2, 16 * COLUMNS + 1)
        x = x[(np.floor(x + COLUMNS / 2) % 2 == 0) & (np.abs(x) < seen)]
        lines.append((x, np.full(len(x), end), np.sign(end)))
    parts = []
    for number, (x, y, side) in enumerate(lines):
        points = sheet(x, y)
        off = errors(len(x), noise, rng) - side * grown * (1 + (points[:, 0] - 320) / 640)
        sides = np.full(len(x), side)
        parts.append((points + off[:, None] * left_of(points), np.full(len(x), number), sides))
    return measured(parts, rng)
