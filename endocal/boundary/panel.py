"""Panels beside the picture: text, a second picture, whatever a recorder burns in next to the endoscope's."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .coarse import Samples

# A panel is split from the picture by a straight edge along so much of the frame's height or width, ...
_STRAIGHT = 0.9
# ... between two samples next but one to each other, as the samples are smoothed, ...
_APART = 2
# ... beyond which, so many samples on, it is even along half of the edge at least, ...
_BEYOND, _EVEN = 4, 0.5
# ... and lies in either half of the frame, so that the picture has more than this of it.
_LEAST = 0.5


def picture_between_panels(samples: Samples, contrast: float) -> tuple[slice, slice] | None:
    """Return the rows and columns of samples that panels leave of the frame; None where there is none.

    An edge is a step of more than ``contrast``, in levels of 8 bit.
    """
    columns = _between(samples.values, contrast)
    rows = _between(samples.values.T, contrast)
    h, w = samples.values.shape
    return None if (rows, columns) == (slice(0, h), slice(0, w)) else (rows, columns)


def _between(values: NDArray[np.uint8], contrast: float) -> slice:
    """Return the columns of ``values`` (n, m) between the innermost edges that go from top to bottom."""
    width = values.shape[1]
    levels = values.astype(np.int16)
    step = np.abs(levels[:, _APART:] - levels[:, :-_APART]) > contrast
    share = step.mean(axis=0)
    edges = np.flatnonzero(share > _STRAIGHT)
    left, right = edges[edges < width / 2], edges[edges > width / 2]
    left = left[share[np.maximum(left - _BEYOND, 0)] < _EVEN]
    right = right[share[np.minimum(right + _BEYOND, len(share) - 1)] < _EVEN]
    # An edge's own sample is the one between the two whose step it is.
    left, right = left + _APART // 2, right + _APART // 2
    begin = int(left.max()) + _APART if len(left) else 0
    end = int(right.min()) - _APART + 1 if len(right) else width
    return slice(begin, end) if end - begin > _LEAST * width else slice(0, width)
