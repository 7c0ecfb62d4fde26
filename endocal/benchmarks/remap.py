"""How fast planes are resampled, beside cv2.remap in the same run."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from statistics import median
from typing import Any

import cv2
import numpy as np

from ..model import DivisionModel
from ..remap.engine import FrameRemapper
from ..remap.geometry import output_geometry
from ..remap.grid import plane_grids
from ..remap.layout import frame_layout

SIZE = (1920, 1080)
REPEATS = 60
_BLOCK = 10  # calls at a time
# lam R^2 of about -0.5, R being half the frame's diagonal: a wide-angle endoscope.
_BEND = -0.5
_CV2 = {
    "nearest": cv2.INTER_NEAREST,
    "bilinear": cv2.INTER_LINEAR,
    "bicubic": cv2.INTER_CUBIC,
    "lanczos": cv2.INTER_LANCZOS4,
}


@dataclass(frozen=True)
class Time:
    """Milliseconds of one kind of work: on the clock, median and least, and of all processors together."""

    median: float
    least: float
    processor: float


@dataclass(frozen=True)
class Row:
    """One kind of work by endocal and by a peer.

    ``ratio`` is the peer's median time over endocal's: how many times the peer's rate endocal's is;
    ``processor_ratio`` is the same of the processors' time, which other work on the machine moves less.
    """

    work: str
    endocal: Time
    peer: str
    peers: Time

    @property
    def ratio(self) -> float:
        """The peer's time over endocal's."""
        return self.peers.median / self.endocal.median

    @property
    def processor_ratio(self) -> float:
        """The peer's processor time over endocal's."""
        return self.peers.processor / self.endocal.processor


@dataclass(frozen=True)
class RemapReport:
    """The rows, the frame size in px, the device's name, and how often each work was done."""

    size: tuple[int, int]
    device: str
    repeats: int
    rows: tuple[Row, ...]

    def data(self) -> dict[str, Any]:
        """Return the report as plain data."""
        rows = [
            {**asdict(r), "ratio": r.ratio, "processor_ratio": r.processor_ratio} for r in self.rows
        ]
        return {**asdict(self), "rows": rows}


def run(size: tuple[int, int] = SIZE, device: str = "auto", repeats: int = REPEATS) -> RemapReport:
    """Time endocal and its peers in turn, ``repeats`` times (by tens), on frames of white noise.

    Raises UsageError where the device does not exist.
    """
    bench = _Bench(size, device)
    pairs = [
        bench.plane("gray", "bilinear", "cv2.remap, float maps"),
        bench.plane("gray", "bilinear", "cv2.remap, fixed maps"),
        bench.plane("gray10le", "bilinear", "cv2.remap, float maps"),
        bench.plane("gray", "nearest", "cv2.remap, float maps"),
        bench.plane("gray", "bicubic", "cv2.remap, float maps"),
        bench.plane("gray", "lanczos", "cv2.remap, float maps (8 x 8 taps)"),
        bench.plane("bgr24", "bilinear", "cv2.remap, float maps"),
        bench.zoom("gray"),
        bench.zoom("yuv420p"),
    ]
    return bench.report(pairs, repeats)


def run_zoom(
    size: tuple[int, int] = SIZE, device: str = "auto", repeats: int = REPEATS
) -> RemapReport:
    """Time a zoom that changes with every frame beside one that stays, as ``run`` does."""
    bench = _Bench(size, device)
    return bench.report([bench.zoom("gray"), bench.zoom("yuv420p")], repeats)


def _clock(pairs: Sequence[_Pair], repeats: int) -> tuple[Row, ...]:
    clocks: list[tuple[list[_Sample], list[_Sample]]] = [([], []) for _ in pairs]
    for pair, (ours, peers) in zip(pairs, clocks, strict=True):
        for turn in range(1 + -(-repeats // _BLOCK)):
            # In turn, so that what else the machine does falls on both alike; by blocks, so that neither
            # always finds the caches full of the other's maps. The first turn builds, bakes and warms up.
            for call, samples in ((pair.ours, ours), (pair.peers, peers)):
                block = [_time(call) for _ in range(_BLOCK)]
                samples += block if turn else []
    return tuple(
        Row(p.work, _summary(ours), p.peer, _summary(peers))
        for p, (ours, peers) in zip(pairs, clocks, strict=True)
    )


@dataclass(frozen=True)
class _Pair:
    work: str
    ours: Callable[[], None]
    peer: str
    peers: Callable[[], None]


class _Bench:
    """The frames and models of a run."""

    def __init__(self, size: tuple[int, int], device: str) -> None:
        w, h = size
        self._size, self._device = size, device
        lam = _BEND / ((w / 2) ** 2 + (h / 2) ** 2)
        self._model = DivisionModel(lam, (0.49 * w, 0.51 * h), size)
        self._geometry = output_geometry([self._model])
        self.device_name = self._remapper("gray", "nearest").device_name

    def report(self, pairs: Sequence[_Pair], repeats: int) -> RemapReport:
        """Time the pairs."""
        return RemapReport(self._size, self.device_name, repeats, _clock(pairs, repeats))

    def plane(self, pix_fmt: str, interpolation: str, peer: str) -> _Pair:
        """One plane through one model, beside cv2.remap with the same map."""
        remapper = self._remapper(pix_fmt, interpolation)
        planes, out = self._frame(pix_fmt), remapper.output_layout.empty()
        layout = remapper.output_layout.planes[0]
        image: Any = planes[0]
        if layout.components > 1:
            image = image.reshape(*layout.size[::-1], layout.components)
        maps: Any = self._maps(pix_fmt)
        if "fixed" in peer:
            maps = cv2.convertMaps(maps[0], maps[1], cv2.CV_16SC2)
        flag, target = _CV2[interpolation], np.empty_like(image)

        def peers() -> None:
            cv2.remap(image, maps[0], maps[1], flag, target, cv2.BORDER_CONSTANT)

        work = f"{pix_fmt}, {interpolation}"
        return _Pair(work, lambda: remapper.apply(self._model, planes, out), peer, peers)

    def zoom(self, pix_fmt: str) -> _Pair:
        """A model that changes with every frame, beside one that stays."""
        moving, still = (self._remapper(pix_fmt, "bilinear") for _ in range(2))
        planes, out = self._frame(pix_fmt), moving.output_layout.empty()
        lam, center = self._model.lam, self._model.center
        models = [DivisionModel(lam * f, center, self._size) for f in (0.9, 1.0)]

        def zooming() -> None:
            models.reverse()
            moving.apply(models[0], planes, out)

        return _Pair(
            f"{pix_fmt}, bilinear, zoom changing with every frame",
            zooming,
            "endocal, zoom fixed",
            lambda: still.apply(self._model, planes, out),
        )

    def _remapper(self, pix_fmt: str, interpolation: str) -> FrameRemapper:
        layout = frame_layout(pix_fmt, self._size, full_range=False)
        return FrameRemapper(layout, self._geometry, interpolation, self._device)

    def _frame(self, pix_fmt: str) -> list[np.ndarray]:
        rng = np.random.default_rng(0)
        layout = frame_layout(pix_fmt, self._size, full_range=False)
        return [rng.integers(0, p.maximum + 1, p.shape).astype(p.dtype) for p in layout.planes]

    def _maps(self, pix_fmt: str) -> tuple[np.ndarray, np.ndarray]:
        layout = frame_layout(pix_fmt, self._size, full_range=False)
        dx, dy = plane_grids(layout, self._geometry)[0].displacement(self._model)
        x = dx + np.arange(dx.shape[1])[None, :]
        y = dy + np.arange(dy.shape[0])[:, None]
        return x.astype(np.float32), y.astype(np.float32)


# Seconds on the clock and of all processors.
_Sample = tuple[float, float]


def _time(call: Callable[[], None]) -> _Sample:
    start, used = time.perf_counter(), time.process_time()
    call()
    return time.perf_counter() - start, time.process_time() - used


def _summary(samples: Sequence[_Sample]) -> Time:
    clock, used = zip(*samples, strict=True)
    return Time(median(clock) * 1e3, min(clock) * 1e3, median(used) * 1e3)
