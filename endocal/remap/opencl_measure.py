"""Measure a device: frame by frame, one strategy and the other in turn."""

from __future__ import annotations

import time
from dataclasses import dataclass
from statistics import median

import numpy as np

from ..model import DivisionModel
from .geometry import OutputGeometry
from .grid import plane_grids
from .layout import frame_layout
from .opencl_choice import STRATEGIES
from .opencl_engine import OpenCLEngine

# What is measured: frames of a usual kind, often enough for a median.
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
