"""Image correction at the frame sizes of the article's Table IV, beside its rates.

Lee et al. 2013, doi:10.1109/TBME.2013.2261816: an i7-860 with one core and with four, and a Tesla C2050.
"""

from __future__ import annotations

import time
from dataclasses import asdict, dataclass
from statistics import median
from typing import Any

import numpy as np

from ..model import DivisionModel
from ..remap.engine import FrameRemapper
from ..remap.geometry import OutputGeometry
from ..remap.layout import frame_layout

REPEATS = 20
# Size in px -> frames per second with one core, with four, with the GPU.
ARTICLE = {
    (1637, 1091): (5.097, 16.006, 64.103),
    (2847, 1900): (2.218, 8.217, 32.083),
    (6000, 6000): (0.389, 1.714, 10.581),
}
# The article does not say in what form its frames were: colour, all channels in each pixel.
PIX_FMT = "bgr24"
_BEND = -0.5  # lam R^2, R being half the frame's diagonal


@dataclass(frozen=True)
class SizeRow:
    """One frame size in px: frames per second.

    ``frames_per_second`` with all transfers, from host arrays to host arrays; ``kernel_per_second`` of the
    kernel alone, and ``copy_share``, its bytes per second over those of a copy on the device (both None
    for NumPy). ``article``: one core, four cores, GPU.
    """

    size: tuple[int, int]
    frames_per_second: float
    kernel_per_second: float | None
    copy_share: float | None
    article: tuple[float, float, float]


@dataclass(frozen=True)
class Table4Report:
    """The rows, the device's name, and how often each was timed."""

    device: str
    repeats: int
    rows: tuple[SizeRow, ...]

    def data(self) -> dict[str, Any]:
        """Return the report as plain data."""
        return asdict(self)


def run(device: str = "auto", repeats: int = REPEATS) -> Table4Report:
    """Time bilinear correction of colour frames; raises UsageError where the device does not exist."""
    rows, name = [], ""
    for size, article in ARTICLE.items():
        layout = frame_layout(PIX_FMT, size, full_range=True)
        model = DivisionModel(
            _BEND / ((size[0] / 2) ** 2 + (size[1] / 2) ** 2), (size[0] / 2, size[1] / 2), size
        )
        remapper = FrameRemapper(layout, OutputGeometry(size, size), device=device)
        name = remapper.device_name
        planes, out = [np.full(p.shape, 90, p.dtype) for p in layout.planes], layout.empty()
        seconds = []
        for turn in range(1 + repeats):
            start = time.perf_counter()
            remapper.apply(model, planes, out)
            if turn:
                seconds.append(time.perf_counter() - start)
        alone = share = None
        if device != "numpy":
            from ..remap.opencl_measure import kernel_speed

            speed = kernel_speed(device, layout, model, "bilinear", repeats)
            alone, share = 1 / speed.kernel, speed.share
        rows.append(SizeRow(size, 1 / median(seconds), alone, share, article))
    return Table4Report(name, repeats, tuple(rows))
