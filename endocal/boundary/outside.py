"""The black outside of a circle: how dark a frame's is, and whether the picture ends there."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .fit import Circle
from .frame import Frame

Array = NDArray[np.float32]

# Lines of samples at most along a frame's shorter side.
LINES = 120
# Side of a corner's patch, in lines of samples; along its lines every quarter of their distance counts.
CORNER = 5
_DENSER = 4
# Which share of a corner's pixels is below one standard deviation above the middle.
_SIGMA_ABOVE = 0.84
# Blocks are so many samples of a row side by side, of so many along the shorter side; the rows are about as
# far apart as the blocks are wide, the outermost this far from the frame's edge, px. A row's pixels share
# cache lines, and to fetch these takes longer than all else.
_SIDE_BY_SIDE, _ALONG, _INSET = 8, 240, 3
# Within so much of its radius a circle holds the picture, of which this share at least is not black. Dark
# rooms leave 0.6 of it; a gauge, a logo's outline or another ring on black has little but its line.
_WITHIN, _LEAST_LIT = 0.9, 0.4
# Near the circle that is further out than this, in radii.
_NEAR = 1.02
# Glare has died away this far out, in radii of the circle; from there on the outside is within this many
# levels of its darkest corner, and half a standard deviation of the noise. To judge that takes this many
# blocks.
_FAR, _FLAT, _ENOUGH = 1.12, 2.5, 4


class Dark(NamedTuple):
    """The outside: its level, its noise (one standard deviation), and the level that content exceeds."""

    level: float
    noise: float
    threshold: float

    @property
    def contrast(self) -> float:
        """The least rise above the outside that is no noise."""
        return _least_contrast(self.noise)

    @property
    def has_glare(self) -> bool:
        """Say whether the outside is taken to be brighter than its darkest corner."""
        return self.threshold > self.level + self.contrast

    def raised(self, threshold: float) -> Dark:
        """Return the same outside with glare in it: content only counts above ``threshold``."""
        return self._replace(threshold=max(threshold, self.level + self.contrast))


def _least_contrast(noise: float) -> float:
    """Return the least rise above a level with this noise that is none itself."""
    return 3 + 1.5 * noise


def line_step(frame: Frame) -> int:
    """Return how far apart lines of samples are, px."""
    return -(-min(frame.luma.shape) // LINES)


def darkest_corner(frame: Frame) -> Dark:
    """Take the outside from the darkest and evenest corner: a logo may lie over one of them.

    A circle that leaves anything outside it in the frame leaves a corner outside, since the corners' convex
    hull is the frame.
    """
    step = line_step(frame)
    side, fine = CORNER * step, max(step // _DENSER, 1)
    rows = (slice(0, side, step), slice(-side, None, step))
    columns = (slice(0, side, fine), slice(-side, None, fine))
    patches = np.array([frame.luma[a, b] for a in rows for b in columns]).reshape(4, -1)
    patches.sort(axis=1)
    count = patches.shape[1]
    middle, upper = count // 2, int(count * _SIGMA_ABOVE)
    levels = patches[:, middle :: upper - middle].tolist()
    sums = [sum(pair) for pair in levels]
    corner = sums.index(min(sums))
    patch, unit = patches[corner], frame.unit
    # The upper side only: black is often clipped at zero, and then the lower side shows no noise. The level
    # is the mean, as that of blocks, which clipped noise lifts; without marks in the corner.
    median, above = levels[corner]
    noise = max((above - median) / unit, 0.5)
    marked = median + 4 * noise * unit
    if patch[-1] >= marked:
        count = int(patch.searchsorted(marked))
    level = float(np.add.reduce(patch[:count], dtype=np.intp)) / (count * unit)
    return Dark(level, noise, level + _least_contrast(noise))


class Blocks(NamedTuple):
    """Mean levels, (n,) of 8 bit, of small pieces of rows all over a frame.

    ``places`` (3, n) are x^2 + y^2, x and y of their middles, square pixels; ``half`` is half their width
    in px.
    """

    levels: Array
    places: Array
    half: float


def blocks_of(frame: Frame) -> Blocks:
    """Take the blocks of a frame."""
    h, w = frame.luma.shape
    fine = -(-min(h, w) // _ALONG)
    rows, across, places = _grid(h, w, fine, frame.pixel_aspect)
    pieces = frame.luma[rows][:, across].reshape(-1, _SIDE_BY_SIDE)
    levels = pieces.astype(np.float32) @ _share(frame.unit)
    return Blocks(levels, places, fine * _SIDE_BY_SIDE / 2)


@lru_cache(maxsize=4)
def _share(unit: int) -> Array:
    return np.full(_SIDE_BY_SIDE, 1 / (_SIDE_BY_SIDE * unit), np.float32)


@lru_cache(maxsize=4)
def _grid(
    height: int, width: int, fine: int, pixel_aspect: float
) -> tuple[NDArray[np.intp], slice, Array]:
    """Return the blocks' rows, the columns of their samples, and the ``places`` of their middles."""
    side = _SIDE_BY_SIDE * fine
    count = width // side
    rows = np.rint(np.linspace(_INSET, height - 1 - _INSET, max(height // side, 2))).astype(np.intp)
    begin = (width - count * side + fine) // 2
    x = (begin + np.arange(count) * side + (side - fine) / 2) * pixel_aspect
    y = rows[:, None].astype(np.float64)
    places = np.stack(np.broadcast_arrays(x * x + y * y, x, y)).reshape(3, -1)
    return rows, slice(begin, begin + count * side, fine), places.astype(np.float32)


def ends_at(circle: Circle, blocks: Blocks, dark: Dark, share: float, marks: float) -> bool:
    """Say whether the picture ends at a circle: not black within, and dark outside but for a ``share``.

    For ``marks``, a share of the whole frame, more may be bright. Glare is borne near the circle, but must
    have died away further out: else it is a dark scene about something round.
    """
    levels, places, half = blocks
    x, y, radius = circle
    # The squared distance, but for a term that is the same for all blocks.
    distance2 = np.array((1, -2 * x, -2 * y), np.float32) @ places
    own = x * x + y * y
    spared = 0.0 if dark.has_glare else marks * len(levels)

    def are_few(where: NDArray[np.bool_], exceptions: NDArray[np.bool_], spared: float) -> bool:
        found = int(np.count_nonzero(where & exceptions))
        return found <= spared or found <= spared + share * int(np.count_nonzero(where))

    bright = levels > dark.threshold
    if not are_few(distance2 > (_NEAR * radius + half) ** 2 - own, bright, spared):
        return False
    within = distance2 < max(_WITHIN * radius - half, 0.0) ** 2 - own
    lit = levels > dark.level + dark.contrast if dark.has_glare else bright
    if np.count_nonzero(within & lit) < _LEAST_LIT * np.count_nonzero(within):
        return False
    far = distance2 > (_FAR * radius) ** 2 - own
    if int(np.count_nonzero(far)) < _ENOUGH:
        return not dark.has_glare
    # Flat, too: darker places than a corner that seemed black tell of a scene as brighter ones do.
    slack = _FLAT + dark.noise / 2
    if not are_few(far, levels > dark.level + slack, spared):
        return False
    return dark.level <= slack or are_few(far, levels < dark.level - slack, 0.0)
