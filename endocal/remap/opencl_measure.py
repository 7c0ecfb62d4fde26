"""Measure a device: how fast its strategies are, and whether it computes what it should."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median

import numpy as np
import pyopencl as cl

from ..model import DivisionModel
from .geometry import OutputGeometry
from .grid import plane_grids
from .interpolation import TAPS
from .layout import FrameLayout, frame_layout
from .numpy_engine import NumpyEngine
from .opencl_choice import STRATEGIES, choose_strategy
from .opencl_device import choose_device, session
from .opencl_engine import OpenCLEngine
from .opencl_memory import StagedPlanes
from .opencl_plane import OpenCLPlane

# What is checked: every kernel on small frames of noise, with borders, a fold and an odd size.
_CHECK_SIZE = (150, 37)
_CHECK_FORMATS = ("yuv420p", "yuv420p10le", "nv12", "bgr24")
_CHECK_MODELS = (
    DivisionModel(-8e-5, (70.3, 19.6), _CHECK_SIZE),
    DivisionModel(4e-5, (74.8, 17.1), _CHECK_SIZE, lam2=-4e-9),
    # Far from the one-parameter root that its inverse starts at.
    DivisionModel(1.3e-5, (3.0, 17.1), _CHECK_SIZE, lam2=-1.4e-8),
)
# What is timed: frames of a usual kind, often enough for a median.
PIX_FMT, SIZE, INTERPOLATION = "yuv420p", (1920, 1080), "bilinear"
_FRAMES = 15


@dataclass(frozen=True)
class Measurement:
    """How a device did on 1920x1080 yuv420p frames, bilinear.

    ``milliseconds`` per frame for each strategy, a median; ``first_seconds``: what its first two frames
    took, with the building of the kernels unless the driver had them in its cache.
    """

    milliseconds: dict[str, float]
    first_seconds: dict[str, float]

    @property
    def best(self) -> str:
        """The faster strategy."""
        return min(self.milliseconds, key=lambda strategy: self.milliseconds[strategy])


def measure(address: str) -> Measurement:
    """Time the strategies on the device of that number or name."""
    model = DivisionModel(-4e-7, (950.0, 545.0), SIZE)
    layout = frame_layout(PIX_FMT, SIZE, full_range=False)
    grids = plane_grids(layout, OutputGeometry(SIZE, SIZE))
    rng = np.random.default_rng(0)
    planes = [rng.integers(0, 256, p.shape, np.uint8) for p in layout.planes]
    out = layout.empty()
    engines = {s: OpenCLEngine(grids, INTERPOLATION, address, s) for s in STRATEGIES}
    seconds: dict[str, list[float]] = {s: [] for s in STRATEGIES}
    for _ in range(2 + _FRAMES):
        for strategy, engine in engines.items():
            start = time.perf_counter()
            engine.submit(model, planes, out).wait()
            seconds[strategy].append(time.perf_counter() - start)
    return Measurement(
        {s: median(times[2:]) * 1e3 for s, times in seconds.items()},
        {s: sum(times[:2]) for s, times in seconds.items()},
    )


def deviation(address: str, strategy: str) -> float:
    """Return how far a device is off the NumPy engine at most, in levels of 8 bits.

    1 is what the kernels promise. More tells of a driver that miscompiles them. Nearest is left out: where
    two samples are about as near, either is right.
    """
    worst = 0.0
    geometry = OutputGeometry(_CHECK_SIZE, _CHECK_SIZE)
    rng = np.random.default_rng(0)
    for pix_fmt in _CHECK_FORMATS:
        layout = frame_layout(pix_fmt, _CHECK_SIZE, full_range=False)
        grids = plane_grids(layout, geometry)
        planes = [rng.integers(0, p.maximum + 1, p.shape).astype(p.dtype) for p in layout.planes]
        for interpolation in list(TAPS)[1:]:
            exact = NumpyEngine(grids, interpolation)
            engine = OpenCLEngine(grids, interpolation, address, strategy)
            for model in _CHECK_MODELS:
                want, got = layout.empty(), layout.empty()
                exact.submit(model, planes, want)
                engine.submit(model, planes, got).wait()
                for plane, a, b in zip(layout.planes, want, got, strict=True):
                    off = np.abs(a.astype(np.int32) - b).max() / 2.0 ** (plane.depth - 8)
                    worst = max(worst, float(off))
    return worst


@dataclass(frozen=True)
class KernelSpeed:
    """The resampling of one frame whose planes lie on the device, beside a copy of as many bytes there.

    Seconds, medians; ``moved`` is in bytes: each plane read once and written once.
    """

    kernel: float
    copy: float
    moved: int

    @property
    def share(self) -> float:
        """The kernel's bytes per second over those of the copy."""
        return self.copy / self.kernel


def kernel_speed(
    device: str, layout: FrameLayout, model: DivisionModel, interpolation: str, repeats: int
) -> KernelSpeed:
    """Time the kernels alone, without the planes' way to the device and back.

    The view is the frame's own. Raises UsageError where the device does not exist.
    """
    listed, _ = choose_device(device)
    opened = session(listed)
    queue = cl.CommandQueue(opened.context)
    grids = plane_grids(layout, OutputGeometry(layout.size, layout.size))
    planes = [OpenCLPlane(opened, g, interpolation, choose_strategy(opened)) for g in grids]
    memory = StagedPlanes(opened, queue, layout.planes, layout.planes)
    memory.upload(layout.empty(), layout.empty())
    for plane in planes:
        plane.set_model(queue, model)

    def resample() -> None:
        for plane, source, output in zip(planes, memory.sources, memory.outputs, strict=True):
            plane.enqueue(queue, *source, *output)

    def copy() -> None:
        for (source, _), (output, _) in zip(memory.sources, memory.outputs, strict=True):
            cl.enqueue_copy(queue, output, source)

    seconds: dict[Callable[[], None], list[float]] = {resample: [], copy: []}
    for turn in range(2 + repeats):
        for work, times in seconds.items():
            queue.finish()
            start = time.perf_counter()
            work()
            queue.finish()
            if turn >= 2:
                times.append(time.perf_counter() - start)
    moved = 2 * sum(p.shape[0] * p.shape[1] * p.dtype.itemsize for p in layout.planes)
    return KernelSpeed(median(seconds[resample]), median(seconds[copy]), moved)
