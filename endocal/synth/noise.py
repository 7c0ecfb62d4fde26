"""Smooth random fields."""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np
from numpy.typing import NDArray


def fractal_noise(
    rng: np.random.Generator, size: tuple[int, int], octaves: Mapping[int, float]
) -> NDArray[np.float32]:
    """Return a smooth random field, float32 (h, w), mean about 0.

    ``octaves`` maps a number of cells across the field to the half-range of the values in those cells.
    """
    total = np.zeros((size[1], size[0]), np.float32)
    for cells, weight in octaves.items():
        coarse = rng.uniform(-weight, weight, (cells, cells)).astype(np.float32)
        total += cv2.resize(coarse, size, interpolation=cv2.INTER_CUBIC)
    return total
