"""Where the scene is: inside the visible circle, off the frame's border and the dark surround."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from ...boundary.circle import Boundary
from .picture import Grey, Mask

# The rim is a wide, soft edge: what lies within this share of the short side, in px, is left out.
RIM_MARGIN = 0.015
# Sensors and recorders spoil the last pixels of a frame.
FRAME_MARGIN = 6
# Darker than this share of the way from black to bright, and joined to a corner of the frame: surround. A
# circle leaves the corners dark; the dark parts of a pattern end at the frame's sides, hardly ever there.
SURROUND_LEVEL = 0.05
# It is told on a picture of at most so many pixels.
SAMPLED_PIXELS = 2_500_000
# What counts as a corner, as a share of the sides.
CORNER = 0.02


def content_mask(
    grey: Grey,
    boundary: Boundary | None,
    pixel_aspect: float = 1.0,
    roi: tuple[int, int, int, int] | None = None,
) -> Mask:
    """Return the (h, w) mask of pixels where an edge belongs to the scene.

    ``roi`` is (x, y, width, height) in px; ``pixel_aspect`` a pixel's width over its height.
    """
    return content_masks(grey, boundary, pixel_aspect, roi)[0]


def content_masks(
    grey: Grey,
    boundary: Boundary | None,
    pixel_aspect: float = 1.0,
    roi: tuple[int, int, int, int] | None = None,
) -> tuple[Mask, Mask]:
    """Return the mask of ``content_mask``, and that of pixels in the dark surround or close to it.

    In the second an edge is the rim's, or that of something bright before a background as black as the
    surround. It has no pixel of the first, and none off the circle, the frame or the ``roi``.
    """
    margin = max(4, round(RIM_MARGIN * min(grey.shape)))
    inside = _inside(grey, boundary, margin, pixel_aspect, roi)
    off = _off_surround(grey, margin)
    return inside & off, inside & ~off


def _inside(
    grey: Grey,
    boundary: Boundary | None,
    margin: int,
    pixel_aspect: float,
    roi: tuple[int, int, int, int] | None,
) -> Mask:
    """Everything in the circle, ``margin`` px off its rim, in the ``roi`` and off the frame's border."""
    h, w = grey.shape
    mask = np.zeros((h, w), bool)
    mask[FRAME_MARGIN:-FRAME_MARGIN, FRAME_MARGIN:-FRAME_MARGIN] = True
    if boundary is not None:
        y, x = np.ogrid[:h, :w]
        dx = (x - boundary.center[0]) * pixel_aspect
        reach = max(0.0, boundary.diameter / 2 - margin)
        # Compared row by column: squared distances of all pixels would fill the memory of a large picture.
        mask &= dx**2 < reach**2 - (y - boundary.center[1]) ** 2
    if roi is not None:
        x0, y0, width, height = roi
        inside = np.zeros_like(mask)
        inside[y0 : y0 + height, x0 : x0 + width] = True
        mask &= inside
    return mask


def _off_surround(grey: Grey, margin: int) -> Mask:
    """Everything at least ``margin`` px away from the dark that touches a corner of the frame."""
    step = int(np.ceil(np.sqrt(grey.size / SAMPLED_PIXELS)))
    smooth = cv2.GaussianBlur(grey, (0, 0), 2.0)[::step, ::step]
    black, bright = np.quantile(smooth[::4, ::4], [0.005, 0.95])
    dark = (smooth < black + max(4.0, SURROUND_LEVEL * (bright - black))).astype(np.uint8)
    _, labels = cv2.connectedComponents(dark, connectivity=4)
    high, wide = (max(2, round(CORNER * side)) for side in smooth.shape)
    ends = np.concatenate([labels[:high], labels[-high:]])
    touching = np.zeros(int(labels.max()) + 1, bool)
    touching[np.unique(np.concatenate([ends[:, :wide], ends[:, -wide:]]))] = True
    touching[0] = False
    surround: NDArray[np.uint8] = touching[labels].astype(np.uint8)
    distance = cv2.distanceTransform(1 - surround, cv2.DIST_L2, 3)
    off = (distance > margin / step).astype(np.uint8)
    h, w = grey.shape
    return off.repeat(step, axis=0).repeat(step, axis=1)[:h, :w].astype(bool)
