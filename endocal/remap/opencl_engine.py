"""The OpenCL engine: planes resampled on a device."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pyopencl as cl

from ..model import DivisionModel
from .grid import PlaneGrid
from .interpolation import TAPS
from .opencl_device import choose_device, session

# A square root and a division give the first guess; so many Newton steps reach single precision.
_NEWTON_STEPS = 8


class OpenCLEngine:
    """Resamples planes on one OpenCL device."""

    def __init__(self, grids: Sequence[PlaneGrid], interpolation: str, device: str) -> None:
        chosen, self.reason = choose_device(device)
        self._session = session(chosen)
        self.device_name = chosen.name.strip()
        self._queue = cl.CommandQueue(self._session.context)
        self._grids = tuple(grids)
        self._interpolation = interpolation
        self._kernels: dict[tuple[int, bool], cl.Kernel] = {}

    def apply(
        self, model: DivisionModel, planes: Sequence[np.ndarray], out: Sequence[np.ndarray]
    ) -> None:
        """Resample every plane; see FrameRemapper.apply."""
        for k, (grid, source, target) in enumerate(zip(self._grids, planes, out, strict=True)):
            kernel = self._kernel(k, model.lam2 != 0)
            flags = cl.mem_flags
            flat, flat_out = _flat(source), _flat(target)
            a = cl.Buffer(self._session.context, flags.READ_ONLY | flags.USE_HOST_PTR, hostbuf=flat)
            b = cl.Buffer(
                self._session.context, flags.READ_WRITE | flags.USE_HOST_PTR, hostbuf=flat_out
            )
            kernel(
                self._queue,
                grid.output.size,
                None,
                a,
                _pitch(source),
                _int2(grid.source.size),
                b,
                _pitch(target),
                _int2(grid.output.size),
                _float(grid.source.origin),
                _float(grid.source.step),
                _float(grid.shift),
                _float(grid.stretch),
                _float(grid.center(model)),
                _float(grid.metric(model)),
                np.float32(model.lam),
                np.float32(model.lam2),
                np.float32(squared_reach(model)),
                _float((*grid.source.fill, 0, 0, 0, 0)[:4]),
            )
            mapped, _ = cl.enqueue_map_buffer(
                self._queue, b, cl.map_flags.READ, 0, flat_out.shape, flat_out.dtype
            )
            mapped.base.release(self._queue)
        self._queue.finish()

    def _kernel(self, plane: int, two_parameters: bool) -> cl.Kernel:
        if (plane, two_parameters) not in self._kernels:
            layout = self._grids[plane].source
            program = self._session.program(
                ("division.cl", "interpolate.cl", "remap_direct.cl"),
                (
                    f"-DWORD={'uchar' if layout.dtype == np.uint8 else 'ushort'}",
                    f"-DCOMPONENTS={layout.components}",
                    f"-DDEPTH_SHIFT={layout.shift}",
                    f"-DMAXIMUM={layout.maximum}",
                    f"-DINTERPOLATION={list(TAPS).index(self._interpolation)}",
                    f"-DTWO_PARAMETERS={int(two_parameters)}",
                    f"-DNEWTON_STEPS={_NEWTON_STEPS}",
                ),
            )
            self._kernels[plane, two_parameters] = cl.Kernel(program, "remap_direct")
        return self._kernels[plane, two_parameters]


def squared_reach(model: DivisionModel) -> float:
    """The squared undistorted radius, px^2, beyond which nothing maps; inf where everything does."""
    limit = model.valid_radius
    if not math.isfinite(limit):
        return math.inf
    q = limit * limit
    denominator = 1 + q * (model.lam + q * model.lam2)
    return q / denominator**2 if denominator > 0 else math.inf


def _flat(plane: np.ndarray) -> np.ndarray:
    """View a plane, with the padding between its rows, as one run of words."""
    rows, columns = plane.shape
    pitch = plane.strides[0] // plane.itemsize
    return np.lib.stride_tricks.as_strided(
        plane, ((rows - 1) * pitch + columns,), (plane.itemsize,)
    )


def _pitch(plane: np.ndarray) -> np.int32:
    return np.int32(plane.strides[0] // plane.itemsize)


def _int2(pair: tuple[int, int]) -> np.ndarray:
    return np.array(pair, np.int32)


def _float(values: Sequence[float]) -> np.ndarray:
    return np.array(values, np.float32)
