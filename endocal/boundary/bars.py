"""Bars of digital black about the picture: some recorders add them, and no camera's black is so even."""

from __future__ import annotations

import numpy as np

from .frame import Frame, Luma

# Every so manieth line tells where bars may end, so many to a frame; a corner has so many samples a side.
_LINES, _CORNER = 120, 5
# So many pixels of a side nearly always tell that it is not even.
_FEW = 8
# The picture has more than this of the frame's width and height.
_LEAST = 0.5


def picture_between_bars(frame: Frame) -> tuple[slice, slice] | None:
    """Return the rows and columns, px, that bars leave of the frame; None where there is none.

    A bar is exactly of one level over the whole of a side. It only tells from a black outside where the
    picture's own black is brighter in all corners: otherwise the two are one.
    """
    luma = frame.luma
    # Nearly all frames end here, before anything is looked at in full.
    levels = [side[0] for side in (luma[0], luma[-1], luma[:, 0], luma[:, -1]) if _is_even(side)]
    if not levels:
        return None
    level = min(levels)
    step = -(-min(frame.size) // _LINES)
    thinned = luma[::step, ::step]
    rough = _extent(thinned, level)
    if rough is None or not _is_brighter_in_corners(thinned[rough], level):
        return None
    rows, columns = (slice(max((s.start - 1) * step, 0), s.stop * step) for s in rough)
    exact = _extent(luma[rows, columns], level)
    assert exact is not None
    left = slice(rows.start + exact[0].start, rows.start + exact[0].stop)
    across = slice(columns.start + exact[1].start, columns.start + exact[1].stop)
    height, width = luma.shape
    is_enough = (
        left.stop - left.start > _LEAST * height and across.stop - across.start > _LEAST * width
    )
    return (left, across) if is_enough else None


def _is_even(side: Luma) -> bool:
    if side[0] != side[-1]:
        return False
    few = side[:: max(len(side) // _FEW, 1)].tolist()
    return few.count(few[0]) == len(few) and bool((side == side[0]).all())


def _extent(luma: Luma, level: np.integer) -> tuple[slice, slice] | None:
    """Return the rows and columns between the outermost that are not all at the level; None without any."""
    other = luma != level
    rows, columns = (np.flatnonzero(other.any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        return None
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)


def _is_brighter_in_corners(luma: Luma, level: np.integer) -> bool:
    ends = (slice(None, _CORNER), slice(-_CORNER, None))
    return all(float(np.median(luma[a, b])) > level for a in ends for b in ends)
