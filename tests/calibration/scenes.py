"""Boards and plain points with known truth, for the tests of calibration."""

from __future__ import annotations

import numpy as np

from endocal.calibration.measure.profiles import Measured
from endocal.model import DivisionModel
from endocal.synth.board import BoardScene
from endocal.synth.camera import Camera, ContentCircle
from endocal.synth.pattern import Pattern, Pose

TRUTH = np.array([-2.4e-6, 325.0, 233.0])


def board(
    lam: float = -2.4e-6,
    center: tuple[float, float] = (325.0, 233.0),
    size: tuple[int, int] = (640, 480),
    lam2: float = 0.0,
    pixel_aspect: float = 1.0,
    square: float = 42.0,
    tilt: float = 20.0,
    axis: float = 30.0,
    rotation: float = 12.0,
    kind: str = "chessboard",
    circle: ContentCircle | None = None,
    comb: tuple[float, float] = (0.0, 0.0),
    seed: int = 1,
    **camera: float,
) -> BoardScene:
    """A board that fills the view, tilted, with some noise and blur unless told otherwise."""
    return BoardScene(
        model=DivisionModel(lam, center, size, pixel_aspect, lam2),
        pattern=Pattern(kind=kind, cols=12, rows=9),
        pose=Pose(center, square, tilt=tilt, tilt_axis=axis, rotation=rotation),
        circle=circle,
        camera=Camera(**{"noise": 2.0, "blur": 0.8, **camera}),
        comb=comb,
        seed=seed,
    )


def line_points(
    params: np.ndarray, count: int = 14, each: int = 120, radius: float = 300.0, seed: int = 0
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Distorted points (n, 2) of straight lines in all directions, labels (n,), and unit normals (n, 2)."""
    rng = np.random.default_rng(seed)
    lam2 = params[3] if len(params) > 3 else 0.0
    model = DivisionModel(params[0], tuple(params[1:3]), (2000, 2000), lam2=lam2)
    points, labels, normals = [], [], []
    label = 0
    while label < count:
        angle, offset = rng.uniform(0, np.pi), rng.uniform(-0.8, 0.8) * radius
        normal = np.array([np.cos(angle), np.sin(angle)])
        along = np.linspace(-3 * radius, 3 * radius, 4 * each)[:, None] * [-normal[1], normal[0]]
        seen = model.distort(params[1:3] + offset * normal + along)
        seen = seen[np.linalg.norm(seen - params[1:3], axis=1) < radius]
        if len(seen) < each:
            continue
        chosen = seen[np.linspace(0, len(seen) - 1, each).astype(int)]
        points.append(chosen)
        labels.append(np.full(each, label))
        # The image gradient of a line: the transposed Jacobian carries the undistorted normal back.
        gradient = np.einsum("nij,i->nj", model.jacobian(chosen), normal)
        normals.append(gradient / np.linalg.norm(gradient, axis=1)[:, None])
        label += 1
    return np.concatenate(points), np.concatenate(labels), np.concatenate(normals)


def grid(n: int, step: int = 20) -> Measured:
    """The lines of a flat n x n chessboard, one point a px, and one stray line that never changes sides."""
    t = np.arange(0.5, n * step)
    near = np.abs((t + step / 2) % step - step / 2) < 2  # too weak to be measured at crossings
    points, labels, sides = [], [], []
    for i in range(1, n):
        for flip in (0, 1):
            p = np.stack([t, np.full_like(t, i * step)], axis=1)[~near]
            points.append(p[:, ::-1] if flip else p)
            labels.append(np.full(len(p), len(labels)))
            sides.append(np.where((t[~near] // step + i) % 2 == 0, 1.0, -1.0))
    stray = np.stack([t, np.full_like(t, -50.0)], axis=1)
    points.append(stray)
    labels.append(np.full(len(stray), len(labels)))
    sides.append(np.ones(len(stray)))
    levels = np.tile([20.0, 200.0, 200.0], (sum(map(len, points)), 1))
    return Measured(
        np.concatenate(points),
        np.concatenate(labels),
        np.concatenate(sides),
        levels,
        np.ones(len(levels)),
    )
