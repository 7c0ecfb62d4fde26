"""Edge points of the scene: Canny with thresholds that follow noise and light, and big Sobel gradients."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from .picture import Grey, Mask, Picture
from .sampling import sample

Floats = NDArray[np.float64]

# The smoothing before the gradient, in px (sigma): below it noise makes edges, above it squares melt.
SMOOTHING = 1.5
# Smoothed by this instead, px, a soft edge keeps most of its gradient, and white noise loses half of its own.
# Noise that was itself smoothed, by up to 2 px, loses down to this share of what white noise loses.
SMOOTHER, LEAST_LOSS = 2.0, 0.5
# A pattern's strongest gradients are less than so many times what its strong ones would be as noise:
# chessboards whose squares leave little even, in any light and blur, have 2.3 to 2.8. Noise has 3.7, clipped
# or enlarged up to threefold 3.1 or so, and less only where little but black and white is left of it.
STRONGEST = 3.0
# An edge must stand out of the noise by this many standard deviations of the gradient ...
NOISE_FACTOR = 5.0
# ... and reach this share of the strongest gradient around it, so that dark corners keep their edges.
LOCAL_SHARE = 0.3
# The neighbourhood that "around" means, as a share of the frame's short side.
NEIGHBORHOOD = 0.15
# Canny's lower threshold over its upper one.
HYSTERESIS = 0.4
# The Gaussian of the structure tensor, px (sigma), as a share of the size that is looked at.
TENSOR_SPREAD = 0.19
# Connected edges with fewer points than this are specks.
SHORTEST_CHAIN = 15


@dataclass(frozen=True)
class EdgePoints:
    """Points (n, 2) on edges, (x, y) px, to sub-pixel; unit gradients (n, 2) there."""

    points: Floats
    gradients: Floats

    @classmethod
    def none(cls) -> EdgePoints:
        """No point at all."""
        return cls(np.empty((0, 2)), np.empty((0, 2)))

    def __len__(self) -> int:
        return len(self.points)

    def take(self, chosen: NDArray[np.intp] | NDArray[np.bool_] | slice) -> EdgePoints:
        """Return some of the points, by index, mask or slice."""
        return EdgePoints(self.points[chosen], self.gradients[chosen])


def find_edges(picture: Picture) -> EdgePoints:
    """Find the edge points of a picture, ordered by rows; none is an empty set."""
    return find_edges_apart(picture)[0]


def find_edges_apart(picture: Picture) -> tuple[EdgePoints, EdgePoints]:
    """Find the edge points of a picture's content, and those beyond it, by the content's thresholds."""
    smooth = _smoothed(picture.grey, SMOOTHING)
    dx, dy = _derivatives(smooth)
    magnitude = np.hypot(dx, dy)
    threshold = _threshold(magnitude, picture.content, _noise(picture, smooth, magnitude))
    # In units of their threshold, since Canny takes one for all.
    chains = _canny(dx / threshold, dy / threshold)
    found = []
    for mask in (picture.content, picture.beyond):
        if mask is None or not mask.any():
            found.append(EdgePoints.none())
            continue
        edges = np.where(mask, chains, 0).astype(np.uint8)
        y, x = np.nonzero(_without_specks(edges))
        found.append(_sub_pixel(x, y, dx, dy, magnitude))
    return found[0], found[1]


def _canny(dx: Grey, dy: Grey) -> NDArray[np.uint8]:
    """Chains of the steepest points, 255 there: from gradients above 1 on, down to HYSTERESIS."""
    # OpenCV takes gradients of 16 bits.
    x, y = (np.clip(1024 * d, -32000, 32000).astype(np.int16) for d in (dx, dy))
    # With several threads it finds a point more or less where their shares of the picture meet.
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        found = cv2.Canny(x, y, HYSTERESIS * 1024, 1024, L2gradient=True)
    finally:
        cv2.setNumThreads(threads)
    return np.asarray(found, np.uint8)


def sobel_gradients(grey: Grey, points: Floats, size: int) -> Floats:
    """Return gradients (n, 2) by a Sobel mask of ``size`` px at the pixels nearest to ``points``."""
    derivative, smoothing = cv2.getDerivKernels(1, 0, size, normalize=True, ktype=cv2.CV_32F)
    x, y = np.rint(points).astype(np.intp).T
    gx = cv2.sepFilter2D(grey, cv2.CV_32F, derivative, smoothing, borderType=cv2.BORDER_REPLICATE)
    gy = cv2.sepFilter2D(grey, cv2.CV_32F, smoothing, derivative, borderType=cv2.BORDER_REPLICATE)
    return np.stack([gx[y, x], gy[y, x]], axis=1).astype(np.float64)


def edge_directions(grey: Grey, points: Floats, size: int) -> tuple[Floats, Floats]:
    """Return the normals (n, 2) of edges at ``points`` (n, 2) px, and how much of one direction they are.

    The structure tensor: gradients by a Sobel mask of half of ``size`` px, their squares averaged with a
    Gaussian, so that all in all ``size`` px are looked at. The second, (n,), is 1 where all of the gradients
    there share a direction, and 0 where they have none, as at a crossing of lines.
    """
    half = max(3, size // 4 * 2 + 1)
    derivative, smoothing = cv2.getDerivKernels(1, 0, half, normalize=True, ktype=cv2.CV_32F)
    gx = cv2.sepFilter2D(grey, cv2.CV_32F, derivative, smoothing, borderType=cv2.BORDER_REPLICATE)
    gy = cv2.sepFilter2D(grey, cv2.CV_32F, smoothing, derivative, borderType=cv2.BORDER_REPLICATE)
    last = np.array(grey.shape[::-1]) - 1
    x, y = np.clip(np.rint(points), 0, last).astype(np.intp).T
    products = gx * gy
    np.multiply(gx, gx, out=gx)
    np.multiply(gy, gy, out=gy)
    xx, xy, yy = (
        np.asarray(cv2.GaussianBlur(p, (0, 0), TENSOR_SPREAD * size)[y, x], np.float64)
        for p in (gx, products, gy)
    )
    turn = np.arctan2(2 * xy, xx - yy) / 2
    one_direction = np.hypot(xx - yy, 2 * xy) / np.maximum(xx + yy, 1e-9)
    return np.stack([np.cos(turn), np.sin(turn)], axis=1), one_direction


def _smoothed(grey: Grey, sigma: float) -> Grey:
    return np.asarray(cv2.GaussianBlur(grey, (0, 0), sigma, borderType=cv2.BORDER_REPLICATE))


def _derivatives(smooth: Grey) -> tuple[Grey, Grey]:
    """Derivatives in grey levels per px."""
    dx = cv2.Sobel(smooth, cv2.CV_32F, 1, 0, scale=1 / 8, borderType=cv2.BORDER_REPLICATE)
    dy = cv2.Sobel(smooth, cv2.CV_32F, 0, 1, scale=1 / 8, borderType=cv2.BORDER_REPLICATE)
    return np.asarray(dx, np.float32), np.asarray(dy, np.float32)


def _noise(picture: Picture, smooth: Grey, magnitude: Grey) -> float:
    """The standard deviation that noise gives a derivative, grey levels per px; ``smooth`` is by SMOOTHING.

    Gradients are noise where the picture is even, and most of most pictures is. Small squares and soft edges
    leave nothing even; but of them a little more smoothing takes hardly anything, and of noise much. And
    where even the strongest gradients of all are not much stronger than the strong ones, as those of noise
    are, which follow Rayleigh's distribution with its 0.999 quantile at 3.7 sigma, these are a pattern's:
    its edges are alike, however much of it is even.
    """
    inside = _some(magnitude, picture.content)
    if inside.size == 0:
        return 0.0
    most = _of_most(inside)
    lost = smooth - _smoothed(smooth, math.sqrt(SMOOTHER**2 - SMOOTHING**2))
    # Of white noise smoothed by a and b, derivatives have the covariance 4 / (a^2 + b^2)^2, but for a factor.
    a, b = SMOOTHING**2, SMOOTHER**2
    loss = math.sqrt(1 + (a / b) ** 2 - 8 * (a / (a + b)) ** 2)
    by_loss = _of_most(_some(np.hypot(*_derivatives(lost)), picture.content)) / (LEAST_LOSS * loss)
    noise = min(most, by_loss)
    strong, strongest = np.quantile(inside, (0.75, 0.999))
    # The upper quartile of a Rayleigh distribution is 1.665 sigma.
    if strongest < STRONGEST * strong / 1.665:
        noise = min(noise, _white_noise(picture))
    return noise


def _white_noise(picture: Picture) -> float:
    """What ``_noise`` is where all noise is each pixel's own, as seen by what no blurred edge has.

    By the mask of second differences both ways (Immerkaer, CVIU 1996), in the median.
    """
    mask = np.outer((1, -2, 1), (1, -2, 1)).astype(np.float32)
    second = cv2.filter2D(picture.grey, cv2.CV_32F, mask, borderType=cv2.BORDER_REPLICATE)
    # The squares of the mask add up to 36; the median of a normal's size is 0.6745 sigma.
    sigma = float(np.median(np.abs(_some(np.asarray(second), picture.content)))) / (6 * 0.6745)
    # That of a derivative of white noise smoothed by a Gaussian.
    return sigma / (math.sqrt(8 * math.pi) * SMOOTHING**2)


def _of_most(magnitudes: Grey) -> float:
    """The standard deviation of a gradient's parts, where half of ``magnitudes`` (n,) or more are noise."""
    # The lower quartile of a Rayleigh distribution is 0.7585 sigma.
    return float(np.quantile(magnitudes, 0.25)) / 0.7585


def _some(values: Grey, content: Mask) -> Grey:
    """Values (h, w) inside the content, (n,), of so many that quantiles are told, 200 000 at most."""
    inside = values[content]
    return inside[:: max(1, inside.size // 100_000)]


def _threshold(magnitude: Grey, content: Mask, noise: float) -> Grey:
    """The gradient that an edge must reach at each pixel; ``noise`` is that of its parts."""
    floor = max(NOISE_FACTOR * noise, 1.0)
    # The strongest gradient around, on a coarse grid: the maximum of each tile, then of its neighbours.
    tile = 8
    h, w = magnitude.shape
    padded = np.zeros((-(-h // tile) * tile, -(-w // tile) * tile), np.float32)
    padded[:h, :w] = np.where(content, magnitude, 0)
    peaks = padded.reshape(padded.shape[0] // tile, tile, -1, tile).max(axis=(1, 3))
    reach = max(1, round(NEIGHBORHOOD * min(h, w) / tile / 2))
    around = cv2.dilate(peaks, np.ones((2 * reach + 1, 2 * reach + 1), np.uint8))
    around = cv2.blur(around, (2 * reach + 1, 2 * reach + 1))
    local = cv2.resize(around, (padded.shape[1], padded.shape[0]), interpolation=cv2.INTER_LINEAR)
    return np.maximum(floor, LOCAL_SHARE * local[:h, :w]).astype(np.float32)


def _without_specks(edges: NDArray[np.uint8]) -> Mask:
    _, labels, stats, _ = cv2.connectedComponentsWithStats(edges, connectivity=8)
    keep = stats[:, cv2.CC_STAT_AREA] >= SHORTEST_CHAIN
    keep[0] = False
    return np.asarray(keep[labels], bool)


def _sub_pixel(
    x: NDArray[np.intp], y: NDArray[np.intp], dx: Grey, dy: Grey, magnitude: Grey
) -> EdgePoints:
    """Move each point along its gradient to the top of a parabola through three magnitudes."""
    gradient = np.stack([dx[y, x], dy[y, x]], axis=1).astype(np.float64)
    here = np.linalg.norm(gradient, axis=1)
    unit = gradient / here[:, None]
    points = np.stack([x, y], axis=1).astype(np.float64)
    if len(points) == 0:
        return EdgePoints(points, unit)

    before, after = (sample(magnitude, points + step * unit) for step in (-1, 1))
    offset = (before - after) / 2 / np.minimum(before + after - 2 * here, -1e-6)
    return EdgePoints(points + np.clip(offset, -1, 1)[:, None] * unit, unit)
