"""Votes that fall into one cell under all models of a range: they are counted once for all of them.

The rounds of a search soon are so narrow that few votes depend on which of their models is taken.

With z and g as in ``hewg``, and w = 1 + lam z^2 in the middle of the range, a model that is (h_lam, h) away
has w (1 + x) in its place,

    x = (h_lam z^2 + 2 lam z conj(g) h + 2 h_lam z conj(g) h + (lam + h_lam) (conj(g) h)^2) / w

The imaginary part of log(1 + x) is by what phi moves, and its real part together with the logarithm of the
magnification is by what the logarithm of D / r does. It is x but for |x|^2 / (2 (1 - |x|)) at most.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..straightness import Floats
from .votes import ANGLES, FOLDING, STRIDE, Cells, Voters

# What rounding to float32 may add: to lengths, as a share of the points' coordinates, and to log w.
ROUNDING = 1e-5


def settled(
    voters: Voters, lams: Floats, xs: Floats, ys: Floats, magnifications: Floats
) -> tuple[NDArray[np.bool_], Cells]:
    """Return which of n points vote for one cell whatever the model, (n,), and the cells of those, (k,).

    Others may do so, too. The models are those of a grid: ``lams`` px^-2, the centres' ``xs`` and ``ys`` px,
    and what they magnify by, (len(xs), len(ys), len(lams)).
    """
    (lam, h_lam), (x, h_x), (y, h_y) = (_middle(values) for values in (lams, xs, ys))
    rounding = ROUNDING * float(np.hypot(np.abs(voters.x).max(), np.abs(voters.y).max()))
    h = float(np.hypot(h_x, h_y)) + rounding
    most = abs(lam) + h_lam
    dx, dy = voters.x - np.float32(x), voters.y - np.float32(y)
    d = dx * voters.gx + dy * voters.gy
    c = dy * voters.gx - dx * voters.gy
    square = d * d + c * c
    length = np.sqrt(square)
    # z^2, and lam z^2, w and z^2 / w.
    a, b = d * d - c * c, 2 * d * c
    w_real, w_imaginary = 1 + lam * a, lam * b
    w2 = w_real**2 + w_imaginary**2
    w = np.sqrt(w2)
    by_center = (2 * most * h) * length + most * h**2
    size = (h_lam * square + by_center) / w
    rest = by_center / w + size**2 / (2 * np.maximum(1 - size, 0.1)) + ROUNDING

    to_cells = ANGLES / np.pi
    phi = 2 * np.pi * voters.turn + np.arctan(w_imaginary / w_real)
    phi_move = h_lam * np.abs(b / w2) + rest
    phi, first = (np.floor((phi + move) * to_cells) for move in (phi_move, -phi_move))
    sure = (size < 0.9) & (most * (length + h) ** 2 < FOLDING) & (phi == first)

    log, slope, bend = _growth(lams - lam, magnifications)
    r_move = h_lam * np.abs((a + lam * square**2) / w2 + slope) + rest + bend
    factor = np.exp(np.minimum(r_move, 50))
    d_move = h_x * np.abs(voters.gx) + h_y * np.abs(voters.gy) + rounding
    scale = 1 / (voters.step * np.exp(log) * w)
    low, high = ((d + move) * scale for move in (-d_move, d_move))
    r = np.floor(np.maximum(high * factor, high / factor) + voters.aside)
    sure &= r == np.floor(np.minimum(low * factor, low / factor) + voters.aside)
    return sure, (r[sure] * STRIDE + phi[sure]).astype(np.int32)


def _middle(values: Floats) -> tuple[float, float]:
    low, high = float(values.min()), float(values.max())
    return (low + high) / 2, (high - low) / 2


def _growth(lams: Floats, magnifications: Floats) -> tuple[float, float, float]:
    """How the logarithm of the magnification grows with lambda: (log at 0, slope, what it departs by)."""
    logs = np.log(magnifications)
    low, high = np.argmin(lams), np.argmax(lams)
    slope = 0.0
    if lams[high] > lams[low]:
        slope = float((logs[..., high] - logs[..., low]).mean() / (lams[high] - lams[low]))
    rest = logs - slope * lams
    log = (rest.min() + rest.max()) / 2
    return float(log), slope, float(rest.max() - log)
