"""What a remapped plane must be, worked out in the plainest way in float64.

Independent of the package: the model is inverted by bisection of r_u = r_d / (1 + lam r_d^2 + lam2 r_d^4),
the interpolation kernels are their textbook formulas.
"""

from __future__ import annotations

import math

import numpy as np

RADIUS = {"bilinear": 1, "bicubic": 2, "lanczos": 3}


def kernel(interpolation: str, distance: np.ndarray) -> np.ndarray:
    d = np.abs(distance)
    if interpolation == "bilinear":
        return np.maximum(1 - d, 0)
    if interpolation == "bicubic":  # Keys 1981 with a = -1/2
        inner = 1.5 * d**3 - 2.5 * d**2 + 1
        outer = -0.5 * d**3 + 2.5 * d**2 - 4 * d + 2
        return np.where(d <= 1, inner, np.where(d < 2, outer, 0))
    return np.where(d < 3, np.sinc(d) * np.sinc(d / 3), 0)


def last_radius(model) -> float:
    """The distorted radius where the map folds or its denominator vanishes, found on the polynomials."""
    roots = [
        *np.roots([model.lam2, 0, model.lam, 0, 1]),
        *np.roots([-3 * model.lam2, 0, -model.lam, 0, 1]),
    ]
    real = [r.real for r in roots if abs(r.imag) < 1e-9 * abs(r) and r.real > 0]
    return min(real, default=math.inf)


def distorted_radius(model, undistorted: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """r_d for each r_u, NaN where there is none, and whether r_u is well inside what the model reaches."""
    last = min(last_radius(model), 1e7)
    low, high = np.zeros_like(undistorted), np.full_like(undistorted, last)

    def forward(r):
        return r / (1 + model.lam * r**2 + model.lam2 * r**4)

    for _ in range(100):
        middle = (low + high) / 2
        # Beyond the pole the forward map is negative: too far.
        value = forward(middle)
        below = (value >= 0) & (value < undistorted)
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    edge = forward(last * (1 - 1e-9))
    reach = edge if 0 < edge < 1e6 * last else math.inf
    return np.where(undistorted <= reach, low, np.nan), np.abs(
        undistorted - reach
    ) > 0.01 * undistorted


def remap(source, plane, output, geometry, model, interpolation):
    """Return float values (rows, columns, components) of an output plane, and a mask of the sure ones.

    Not sure are the samples at the fold, where the map has no slope, and with ``nearest`` those about as
    far from two samples.
    """
    i, j = np.meshgrid(np.arange(output.size[0]), np.arange(output.size[1]))
    u = [
        geometry.origin[0] + geometry.step[0] * (output.origin[0] + output.step[0] * i),
        geometry.origin[1] + geometry.step[1] * (output.origin[1] + output.step[1] * j),
    ]
    du = [(u[0] - model.center[0]) * model.pixel_aspect, u[1] - model.center[1]]
    ru = np.hypot(*du)
    rd, sure = distorted_radius(model, ru)
    ratio = np.where(ru > 0, rd / np.where(ru > 0, ru, 1), 1.0)
    luma = [model.center[0] + (u[0] - model.center[0]) * ratio, model.center[1] + du[1] * ratio]
    x = (luma[0] - plane.origin[0]) / plane.step[0]
    y = (luma[1] - plane.origin[1]) / plane.step[1]
    w, h = plane.size
    values = source.reshape(h, w, plane.components).astype(np.float64) / 2**plane.shift
    fill = np.array(plane.fill, np.float64)
    found = ~np.isnan(x)
    x, y = np.where(found, x, -1e6), np.where(found, y, -1e6)

    if interpolation == "nearest":
        near_x, near_y = np.floor(x + 0.5).astype(int), np.floor(y + 0.5).astype(int)
        out = values[np.clip(near_y, 0, h - 1), np.clip(near_x, 0, w - 1)]
        share = np.ones_like(x)
        for position, n in zip((x, y), (w, h), strict=True):
            share *= (position >= -0.5) & (position < n - 0.5)
            sure = sure & (np.abs((position + 0.5) - np.round(position + 0.5)) > 2e-3)
    else:
        reach = RADIUS[interpolation]
        out, total = np.zeros((*x.shape, plane.components)), np.zeros_like(x)
        for b in range(1 - reach, reach + 1):
            for a in range(1 - reach, reach + 1):
                sx, sy = np.floor(x) + a, np.floor(y) + b
                weight = kernel(interpolation, x - sx) * kernel(interpolation, y - sy)
                row = np.clip(sy, 0, h - 1).astype(int)
                column = np.clip(sx, 0, w - 1).astype(int)
                out += weight[..., None] * values[row, column]
                total += weight
        out = np.clip(out / total[..., None], 0, 2**plane.depth - 1)
        share = np.ones_like(x)
        for position, origin, step, n in zip((x, y), plane.origin, plane.step, (w, h), strict=True):
            inside = origin + step * position
            share *= np.clip(inside + 1, 0, 1) * np.clip(step * n - inside, 0, 1)
    return fill + share[..., None] * (out - fill), sure
