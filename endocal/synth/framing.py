"""Placing a board so that it fills the view."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ..model import Points
from .board import BoardScene, plane_coordinates, visible

_GRID = (48, 36)
_HALVINGS = 20


def covering(scene: BoardScene, share: float) -> BoardScene | None:
    """Return the scene with squares of such a size that the pattern covers ``share`` of the content.

    Instruments do not count. None where the pattern, seen from however near, covers less: a tilted plane
    ends at its horizon.
    """
    points = _content_points(replace(scene, instruments=()))
    half = np.array([scene.pattern.cols, scene.pattern.rows]) / 2

    def covered(square: float) -> float:
        plane = plane_coordinates(replace(scene, pose=replace(scene.pose, square=square)), points)
        return float(np.mean(np.all(np.abs(plane) < half, axis=-1)))

    low, high = 1.0, 2.0 * max(scene.model.size)
    if covered(high) < share:
        return None
    for _ in range(_HALVINGS):
        square = math.sqrt(low * high)
        low, high = (low, square) if covered(square) >= share else (square, high)
    return replace(scene, pose=replace(scene.pose, square=high))


def _content_points(scene: BoardScene) -> Points:
    """A grid of visible points, (n, 2) px."""
    w, h = scene.model.size
    x, y = np.meshgrid(np.linspace(0, w - 1, _GRID[0]), np.linspace(0, h - 1, _GRID[1]))
    points = np.stack([x, y], axis=-1)
    return points[visible(scene, points)]
