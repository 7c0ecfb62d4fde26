"""The interpolation kernels, as weights of neighbouring samples.

- ``nearest``: the sample whose centre is nearest.
- ``bilinear``: 2 x 2 samples.
- ``bicubic``: 4 x 4 samples, cubic convolution with a = -1/2, which is Catmull-Rom's spline
  (Keys 1981, doi:10.1109/TASSP.1981.1163711).
- ``lanczos``: 6 x 6 samples, sinc windowed by a sinc of three lobes (Duchon 1979,
  doi:10.1175/1520-0450(1979)018<1016:LFIOAT>2.0.CO;2), weights divided by their sum so that a flat
  picture stays flat.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

# Name -> how many samples along each axis a value is made of.
TAPS = {"nearest": 1, "bilinear": 2, "bicubic": 4, "lanczos": 6}


def first_tap(interpolation: str) -> int:
    """Return the index of the first sample, relative to the sample at or before the position."""
    return 1 - (TAPS[interpolation] + 1) // 2


def weights(interpolation: str, fraction: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the weights (taps, ...) of the samples around positions with this fraction in [0, 1)."""
    f = np.asarray(fraction, np.float64)
    if interpolation == "nearest":
        return np.ones((1, *f.shape))
    if interpolation == "bilinear":
        return np.stack([1 - f, f])
    distance = np.abs(
        f - (np.arange(TAPS[interpolation]) + first_tap(interpolation)).reshape(-1, *[1] * f.ndim)
    )
    if interpolation == "bicubic":
        near = (1.5 * distance - 2.5) * distance**2 + 1
        far = ((-0.5 * distance + 2.5) * distance - 4) * distance + 2
        return np.where(distance <= 1, near, far)
    w = np.where(distance < 3, np.sinc(distance) * np.sinc(distance / 3), 0.0)
    # A sinc at a whole number is zero, not the 4e-17 that rounding leaves.
    w = np.where((distance >= 1) & (distance == np.round(distance)), 0.0, w)
    return w / w.sum(axis=0)
