"""One plane's kernels and maps on an OpenCL device."""

from __future__ import annotations

import math

import numpy as np
import pyopencl as cl

from ..model import DivisionModel
from .grid import PlaneGrid
from .interpolation import TAPS
from .opencl_device import DeviceSession
from .opencl_mapping import pack_mapping

# The kernels for a CPU work on so many samples of a row at a time: long enough to hide the loads from the
# source, short enough to stay in the first-level cache.
STRIP = 64
# The most that a curve may be off, source samples: it moves a value of white noise by less than half a
# level of 8 bits, and where a curve is off by more the kernel works without it.
_CURVE_ERROR = 1 / 2048
_CURVE_BYTES = 52  # of struct curve in kernels/curves.cl
# The most Newton steps of the inverse: 4 are usual, and beyond these single precision holds no more.
_NEWTON_STEPS = 24
# Work-groups of the GPU kernel, samples: a row's neighbours together, so that their loads share lines.
_GROUP = (32, 8)

# The kernels' arguments: source, its pitch, output, its pitch, the mapping; baked ones have three for curves.
_MAPPING, _CURVES_FROM = 4, 5

_COMMON = ("lanes.cl", "division.cl", "interpolate.cl", "mapping.cl", "anywhere.cl")
_DIRECT = (*_COMMON, "remap_direct.cl")
_CURVES = (
    *_COMMON,
    "strips.cl",
    "curves.cl",
    "bake_curves.cl",
    "blend.cl",
    "look_up.cl",
    "remap_curves.cl",
)


class OpenCLPlane:
    """The mapping of one plane grid on a device, and the kernels that resample planes through it.

    With strategy ``direct`` each work-item resamples one sample, at coordinates worked out on the fly. With
    ``baked`` each takes a row, along curves that were fitted to the mapping when the model came: that costs
    less than a frame, so that a zoom may change with every one. An instance serves one in-order queue.
    """

    def __init__(
        self, session: DeviceSession, grid: PlaneGrid, interpolation: str, strategy: str
    ) -> None:
        self._session = session
        self._grid = grid
        self._interpolation = interpolation
        self._direct = strategy == "direct"
        self._model: DivisionModel | None = None
        self._mapping: cl.Buffer | None = None
        self._curves: cl.Buffer | None = None
        self._length_log2 = 0
        self._pitches = (0, 0)
        program = session.program(_DIRECT if self._direct else _CURVES, self._options())
        self._remap = cl.Kernel(program, "remap_direct" if self._direct else "remap_curves")
        self._bake = None if self._direct else cl.Kernel(program, "bake_curves")

    def set_model(self, queue: cl.CommandQueue, model: DivisionModel) -> None:
        """Take a model for the frames that follow: enqueue the baking, unless it is the present one."""
        if model == self._model:
            return
        context, flags = self._session.context, cl.mem_flags
        # A new buffer, not a write to the old one: kernels on their way may still read that.
        packed = pack_mapping(self._grid, model)
        self._mapping = cl.Buffer(context, flags.READ_ONLY | flags.COPY_HOST_PTR, hostbuf=packed)
        self._model = model
        self._remap.set_arg(_MAPPING, self._mapping)
        if self._bake is None:
            return
        rows = self._grid.output.size[1]
        if self._curves is None:
            # As many as the shortest curves need, so that any model's fit.
            count = rows * self._strips * (STRIP // self._session.lanes)
            self._curves = cl.Buffer(context, flags.READ_WRITE, count * _CURVE_BYTES)
        self._length_log2 = curve_length_log2(self._grid, model, self._session.lanes)
        curves = self._curve_arguments()
        self._bake(queue, (rows,), (1,), self._mapping, *curves)
        for index, value in enumerate(curves, _CURVES_FROM):
            self._remap.set_arg(index, value)

    def enqueue(
        self,
        queue: cl.CommandQueue,
        source: cl.Buffer,
        source_pitch: int,
        output: cl.Buffer,
        output_pitch: int,
    ) -> None:
        """Enqueue the resampling of one plane; pitches are in words from row to row."""
        # Arguments keep their values from launch to launch, and setting one costs: those of the model were
        # set when it came.
        kernel = self._remap
        kernel.set_arg(0, source)
        kernel.set_arg(2, output)
        if (source_pitch, output_pitch) != self._pitches:
            kernel.set_arg(1, np.int32(source_pitch))
            kernel.set_arg(3, np.int32(output_pitch))
            self._pitches = source_pitch, output_pitch
        columns, rows = self._grid.output.size
        if self._direct:
            across, down = _GROUP if self._session.device.max_work_group_size >= 256 else (8, 4)
            whole_groups = (-(-columns // across) * across, -(-rows // down) * down)
            cl.enqueue_nd_range_kernel(queue, kernel, whole_groups, (across, down))
        else:
            cl.enqueue_nd_range_kernel(queue, kernel, (rows,), (1,))

    @property
    def _strips(self) -> int:
        """Strips in a row."""
        return -(-self._grid.output.size[0] // STRIP)

    def _curve_arguments(self) -> tuple[cl.Buffer | None, np.int32, np.int32]:
        """The kernels' arguments that tell of the curves."""
        in_row = self._strips * (STRIP >> self._length_log2)
        return self._curves, np.int32(in_row), np.int32(self._length_log2)

    def _options(self) -> tuple[str, ...]:
        """The build options; each kernel file says what they mean."""
        plane = self._grid.source
        run = TAPS[self._interpolation] * plane.components * plane.dtype.itemsize
        values = {
            "WORD": "uchar" if plane.dtype == np.uint8 else "ushort",
            "WORD_BYTES": plane.dtype.itemsize,
            "RUN": {1: "uchar", 2: "ushort", 3: "uint", 4: "uint"}.get(run, "ulong"),
            "COMPONENTS": plane.components,
            "DEPTH_SHIFT": plane.shift,
            "INTERPOLATION": list(TAPS).index(self._interpolation),
            "NEWTON_STEPS": _NEWTON_STEPS,
            "LANES": 1 if self._direct else self._session.lanes,
            "STRIP": STRIP,
            "LOOK_UP": int(self._session.looks_up),
            "CURVE_ERROR": f"{_CURVE_ERROR}f",
        }
        return tuple(f"-D{name}={value}" for name, value in values.items())


def curve_length_log2(grid: PlaneGrid, model: DivisionModel, shortest: int) -> int:
    """Return log2 of the samples in a curve: as long as its error is likely to stay small.

    A cubic over n samples is off by about n^4 f'''' / 3072 of the fourth derivative, and that of a division
    model is 40 / L^3 at most, L being the radius at which distortion is of the order of 1.
    """
    bend = max(math.sqrt(abs(model.lam)), abs(model.lam2) ** 0.25)
    bend *= max(grid.metric(model))
    for log2 in range(STRIP.bit_length() - 1, shortest.bit_length() - 1, -1):
        length = (1 << log2) * (1 + max(abs(s) for s in grid.stretch))
        if length**4 * 40 * bend**3 / 3072 < _CURVE_ERROR / 2:
            return log2
    return shortest.bit_length() - 1
