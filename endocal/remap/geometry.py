"""The view of the output: which undistorted place each output pixel shows."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..boundary.circle import Boundary
from ..errors import InputError, UsageError
from ..model import DivisionModel, Points

VIEWS = ("same", "crop", "full")

# Output frames beyond this side, px, are refused before anything is allocated.
MAX_SIDE = 16384
# Search for the crop: the first grid of rectangle centres, then so many rounds around the best, each on a
# grid half as wide: 16 rounds end at 2^-16 of the frame.
_FIRST_GRID, _NEXT_GRID, _ROUNDS = 9, 5, 16
_PERIMETER = 32  # points on each side of a rectangle while searching
# Half the height that a crop can have, in frame sides, and how finely it is bisected.
_LARGEST, _BISECTIONS = 64.0, 44
_RADII = 4096  # nodes of a model's table of radii while searching
_SHRINK = 1e-6  # of a crop that turns out to show a blank pixel after all
_CIRCLE_POINTS = 1440  # points on the content circle: a quarter of a degree


@dataclass(frozen=True)
class OutputGeometry:
    """An output frame laid over undistorted coordinates.

    Output pixel (i, j) shows the undistorted point ``origin + step * (i, j)``, in px of the source frame.
    ``size`` is the output's and ``source_size`` the input's (width, height) in px; ``pixel_aspect`` is the
    output's pixel width over its height.
    """

    source_size: tuple[int, int]
    size: tuple[int, int]
    origin: tuple[float, float] = (0.0, 0.0)
    step: tuple[float, float] = (1.0, 1.0)
    pixel_aspect: float = 1.0


def output_geometry(
    models: Sequence[DivisionModel],
    boundaries: Sequence[Boundary | None] | None = None,
    view: str = "same",
    size: tuple[int, int] | None = None,
    scale: float | None = None,
    square_pixels: bool = False,
) -> OutputGeometry:
    """Lay out the output for a stream on which every one of ``models`` may come to hold.

    - ``same`` shows the frame's own place and size: magnification 1 at the distortion centre.
    - ``crop`` shows the largest rectangle, of the output's shape, that holds no blank pixel.
    - ``full`` shows all content, as large as it fits.

    The content is the frame or, where ``boundaries`` gives a circle for a model, what of the frame lies in
    it. The output has the frame's size, or ``scale`` times that, or ``size`` (width, height): the view is
    resized to it, never stretched; a shape other than the view's shows more of the surroundings.
    ``square_pixels`` makes the output's pixels square by resizing the width.

    Raises UsageError for options that make no sense and InputError for models that do not share a frame
    or leave nothing to show.
    """
    if view not in VIEWS:
        raise UsageError(f"view {view!r} is unknown; it is one of {', '.join(VIEWS)}")
    if not models:
        raise UsageError("an output needs at least one model")
    first = models[0]
    if any(m.size != first.size or m.pixel_aspect != first.pixel_aspect for m in models):
        raise InputError("the models are for frames of different sizes or pixel aspects")
    circles = list(boundaries) if boundaries is not None else [None] * len(models)
    if len(circles) != len(models):
        raise UsageError(f"{len(circles)} boundaries were given for {len(models)} models")

    aspect_out = 1.0 if square_pixels else first.pixel_aspect
    out = _output_size(first, aspect_out, size, scale)
    # Undistorted px of the frame that one output pixel's width spans when its height spans 1.
    ratio = aspect_out / first.pixel_aspect
    if view == "same":
        (w, h), (columns, rows) = first.size, out
        middle, vertical = ((w - 1) / 2, (h - 1) / 2), max(h / rows, w / ratio / columns)
    elif view == "full":
        middle, vertical = _full(models, circles, out, ratio)
    else:
        middle, vertical = _crop(models, circles, out, ratio)
    steps = (vertical * ratio, vertical)
    origin = tuple(
        round(m - s * (n - 1) / 2, 6) + 0.0 for m, s, n in zip(middle, steps, out, strict=True)
    )
    # Rounded far below a visible difference, so that an undistorted frame is met exactly.
    return OutputGeometry(
        first.size,
        out,
        (origin[0], origin[1]),
        (round(steps[0], 9), round(steps[1], 9)),
        aspect_out,
    )


def _output_size(
    model: DivisionModel, aspect: float, size: tuple[int, int] | None, scale: float | None
) -> tuple[int, int]:
    if size is not None and scale is not None:
        raise UsageError("--size and --scale exclude each other")
    if size is None:
        factor = 1.0 if scale is None else scale
        if not 0 < factor < math.inf:
            raise UsageError(f"the scale {factor:g} is no positive number")
        sides = (factor * model.size[0] * model.pixel_aspect / aspect, factor * model.size[1])
        if max(sides) < MAX_SIDE + 0.5:
            sides = (max(1, round(sides[0])), max(1, round(sides[1])))
    else:
        sides = size
    w, h = sides
    if w != int(w) or h != int(h) or not (1 <= w <= MAX_SIDE and 1 <= h <= MAX_SIDE):
        raise UsageError(f"an output of {w:g}x{h:g} is not between 1 and {MAX_SIDE} px a side")
    return int(w), int(h)


def _full(
    models: Sequence[DivisionModel],
    circles: Sequence[Boundary | None],
    out: tuple[int, int],
    ratio: float,
) -> tuple[tuple[float, float], float]:
    """The middle and the vertical step of the smallest view that holds all content."""
    rims = [m.undistort(_content_rim(m, b)) for m, b in zip(models, circles, strict=True)]
    rim = np.concatenate(rims)
    if not np.isfinite(rim).all():
        fold = min(m.valid_radius for m in models)
        raise InputError(
            f"the model folds {fold:.0f} px from the centre, within the content, so that a view of all of it"
            " has no bounds: use --view same or crop, or calibrate with --model division2"
        )
    low, high = rim.min(axis=0), rim.max(axis=0)
    columns, rows = (max(n - 1, 1) for n in out)
    step = max((high[1] - low[1]) / rows, (high[0] - low[0]) / ratio / columns)
    middle = (low + high) / 2
    return (float(middle[0]), float(middle[1])), float(step) or 1.0


def _crop(
    models: Sequence[DivisionModel],
    circles: Sequence[Boundary | None],
    out: tuple[int, int],
    ratio: float,
) -> tuple[tuple[float, float], float]:
    """The middle and the vertical step of the largest view without a blank pixel.

    The content is simply connected and undistorting does not tear it: a rectangle holds no blank pixel when
    its rim holds none, and rectangles around one middle are nested.
    """
    w, h = models[0].size
    half = np.array([max(out[0] - 1, 1) * ratio, max(out[1] - 1, 1)]) / 2
    contents = [_Content(m, b) for m, b in zip(models, circles, strict=True)]

    def fits(middles: Points, step: NDArray[np.float64], rim: Points) -> NDArray[np.bool_]:
        points = middles[:, None] + step[:, None, None] * rim
        return np.all([c.shown(points).all(axis=1) for c in contents], axis=0)

    def largest(middles: Points, rim: Points, least: float) -> NDArray[np.float64]:
        """The largest step around each middle, or ``least`` where a larger one does not fit."""
        low = np.full(len(middles), least)
        promising = np.flatnonzero(fits(middles, low * (1 + 1e-6), rim))
        a, b = low[promising], np.full(len(promising), _LARGEST * max(w, h) / half.max())
        for _ in range(_BISECTIONS):
            step = (a + b) / 2
            good = fits(middles[promising], step, rim)
            a, b = np.where(good, step, a), np.where(good, b, step)
        low[promising] = a
        return low

    coarse = _rectangle(np.linspace(-1, 1, _PERIMETER), np.linspace(-1, 1, _PERIMETER)) * half
    best = np.array([(w - 1) / 2, (h - 1) / 2])
    if circles[0] is not None:
        best = np.array(circles[0].center)
    reach, grid, step = np.array([w, h]) / 2, _FIRST_GRID, 0.0
    for _ in range(_ROUNDS):
        ticks = np.linspace(-1, 1, grid)
        offsets = np.stack(np.meshgrid(ticks, ticks), axis=-1).reshape(-1, 2)
        # The present best first: of equals, the first wins, so that a tie moves nothing.
        offsets = offsets[np.argsort((offsets**2).sum(axis=1), kind="stable")]
        middles = best + offsets * reach
        steps = largest(middles, coarse, step)
        best, step = middles[np.argmax(steps)], float(steps.max())
        reach, grid = reach / 2, _NEXT_GRID
    pixels = [np.linspace(-1, 1, n) if n > 1 else np.zeros(1) for n in out]
    rim = _rectangle(pixels[0], pixels[1]) * half
    step = float(largest(best[None], rim, 0.0)[0])
    while step > 0 and not all(c.surely_shown(best + step * rim) for c in contents):
        step *= 1 - _SHRINK
    if step <= 0:
        raise InputError("the view has no rectangle without a blank pixel; use --view same or full")
    return (float(best[0]), float(best[1])), step


class _Content:
    """What an undistorted point shows under one model: content, or nothing."""

    def __init__(self, model: DivisionModel, circle: Boundary | None) -> None:
        self._model, self._circle = model, circle
        (cx, cy), (w, h) = model.center, model.size
        farthest = np.hypot(
            max(abs(cx), abs(w - 1 - cx)) * model.pixel_aspect, max(abs(cy), abs(h - 1 - cy))
        )
        # Radii by the forward map, which needs no inversion: quick, and right to a small part of a pixel.
        self._distorted = np.linspace(
            0, min(farthest, model.valid_radius * (1 - 1e-9)) or 1.0, _RADII
        )
        q = self._distorted**2
        self._undistorted = self._distorted / (1 + q * (model.lam + q * model.lam2))

    def shown(self, points: Points) -> NDArray[np.bool_]:
        """Whether undistorted points (..., 2) show content."""
        d = points - self._model.center
        ru = np.hypot(d[..., 0] * self._model.pixel_aspect, d[..., 1])
        rd = np.interp(ru, self._undistorted, self._distorted, right=np.inf)
        with np.errstate(invalid="ignore"):
            ratio = np.where(ru > 0, rd / np.where(ru > 0, ru, 1), 1.0)
            return self._in_content(d * ratio[..., None] + self._model.center)

    def surely_shown(self, points: Points) -> bool:
        """Whether all undistorted points (n, 2) show content, by the model itself."""
        return bool(self._in_content(self._model.distort(points)).all())

    def _in_content(self, distorted: Points) -> NDArray[np.bool_]:
        x, y = distorted[..., 0], distorted[..., 1]
        w, h = self._model.size
        slack = 1e-9  # px: rounding of a point on the very edge
        # Comparisons with NaN are false: no preimage, no content.
        inside = (x >= -slack) & (x <= w - 1 + slack) & (y >= -slack) & (y <= h - 1 + slack)
        if self._circle is not None:
            cx, cy = self._circle.center
            away = np.hypot((x - cx) * self._model.pixel_aspect, y - cy)
            inside &= away <= self._circle.diameter / 2
        return np.asarray(inside)


def _content_rim(model: DivisionModel, circle: Boundary | None) -> Points:
    """Distorted points (n, 2) around the content: the frame's border, the circle, or what bounds both."""
    w, h = model.size
    frame = _rectangle(np.linspace(-1, 1, 2 * w + 1), np.linspace(-1, 1, 2 * h + 1))
    frame = (frame + 1) / 2 * [w - 1, h - 1]
    if circle is None:
        return frame
    (cx, cy), radius = circle.center, circle.diameter / 2
    angle = np.linspace(0, 2 * np.pi, _CIRCLE_POINTS, endpoint=False)
    rim = np.stack(
        [cx + radius / model.pixel_aspect * np.cos(angle), cy + radius * np.sin(angle)], axis=-1
    )
    seen = ((rim >= 0) & (rim <= [w - 1, h - 1])).all(axis=1)
    covered = np.hypot((frame[:, 0] - cx) * model.pixel_aspect, frame[:, 1] - cy) <= radius
    points = np.concatenate([rim[seen], frame[covered]])
    if not len(points):
        raise InputError("the content circle lies outside the frame")
    return points


def _rectangle(x: NDArray[np.float64], y: NDArray[np.float64]) -> Points:
    """The four sides (n, 2) of the rectangle whose horizontal and vertical ticks are given."""
    horizontal = [np.stack([x, np.full_like(x, side)], axis=-1) for side in (y[0], y[-1])]
    vertical = [np.stack([np.full_like(y, side), y], axis=-1) for side in (x[0], x[-1])]
    return np.concatenate(horizontal + vertical)
