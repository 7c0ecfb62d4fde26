"""One plane's kernels and maps on an OpenCL device."""

from __future__ import annotations

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
# From the root of the one-parameter model, this many Newton steps reach single precision.
_NEWTON_STEPS = 6
# Work-groups of the GPU kernel, samples: a row's neighbours together, so that their loads share lines.
_GROUP = (32, 8)

_COMMON = ("lanes.cl", "division.cl", "interpolate.cl", "mapping.cl", "anywhere.cl")
_DIRECT = (*_COMMON, "remap_direct.cl")
_PLACES = (
    *_COMMON,
    "strips.cl",
    "places.cl",
    "bake_places.cl",
    "remap_baked.cl",
    "remap_strips.cl",
)
_TAPS = (*_COMMON, "strips.cl", "taps.cl", "remap_taps.cl")


class OpenCLPlane:
    """The mapping of one plane grid on a device, and the kernels that resample planes through it.

    With strategy ``direct`` each work-item resamples one sample at coordinates worked out on the fly. With
    ``baked`` each takes a row, in strips, and the places of nearest and bilinear samples are baked into a
    map as soon as a model comes a second time: a zoom that changes with every frame never pays for a map
    that it would use once. One instance serves one in-order queue.
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
        self._kernels: dict[str, cl.Kernel] = {}
        self._places: cl.Buffer | None = None
        self._strips: cl.Buffer | None = None
        self._frames = 0  # that the present model has served
        self._baked = False

    def set_model(self, model: DivisionModel) -> None:
        """Take a model for the frames that follow."""
        if model == self._model:
            return
        flags = cl.mem_flags.READ_ONLY | cl.mem_flags.COPY_HOST_PTR
        # A new buffer, not a write to the old one: kernels on their way may still read that.
        self._mapping = cl.Buffer(
            self._session.context, flags, hostbuf=pack_mapping(self._grid, model)
        )
        self._model = model
        self._frames, self._baked = 0, False

    def prepare(self, queue: cl.CommandQueue) -> None:
        """Enqueue what the next frame needs before its planes: the map, when it is worth baking."""
        bakes = not self._direct and self._interpolation in ("nearest", "bilinear")
        if bakes and not self._baked and self._frames > 0:
            columns, rows = self._grid.output.size
            count = -(-columns // STRIP) * rows
            if self._places is None:
                flags = cl.mem_flags.READ_WRITE
                self._places = cl.Buffer(self._session.context, flags, count * STRIP * 4)
                self._strips = cl.Buffer(self._session.context, flags, count * 16)
            kernel = self._kernel("bake_places")
            kernel(queue, (rows,), (1,), self._mapping, self._places, self._strips)
            self._baked = True
        self._frames += 1

    def enqueue(
        self,
        queue: cl.CommandQueue,
        source: cl.Buffer,
        source_pitch: int,
        output: cl.Buffer,
        output_pitch: int,
    ) -> None:
        """Enqueue the resampling of one plane; pitches are in words from row to row."""
        planes = (source, np.int32(source_pitch), output, np.int32(output_pitch), self._mapping)
        columns, rows = self._grid.output.size
        if self._direct:
            whole_groups = (-(-columns // _GROUP[0]) * _GROUP[0], -(-rows // _GROUP[1]) * _GROUP[1])
            self._kernel("remap_direct")(queue, whole_groups, _GROUP, *planes)
        elif self._interpolation in ("bicubic", "lanczos"):
            self._kernel("remap_with_taps")(queue, (rows,), (1,), *planes)
        elif self._baked:
            maps = (self._places, self._strips)
            self._kernel("remap_baked")(queue, (rows,), (1,), *planes, *maps)
        else:
            self._kernel("remap_strips")(queue, (rows,), (1,), *planes)

    def _kernel(self, name: str) -> cl.Kernel:
        if name not in self._kernels:
            files = {"remap_direct": _DIRECT, "remap_with_taps": _TAPS}.get(name, _PLACES)
            program = self._session.program(files, self._options())
            self._kernels[name] = cl.Kernel(program, name)
        return self._kernels[name]

    def _options(self) -> tuple[str, ...]:
        """The build options; each kernel file says what they mean."""
        plane = self._grid.source
        taps = TAPS[self._interpolation]
        run = taps * plane.components * plane.dtype.itemsize
        values = {
            "WORD": "uchar" if plane.dtype == np.uint8 else "ushort",
            "BLEND": "ushort" if plane.dtype == np.uint8 else "uint",
            "RUN": {1: "uchar", 2: "ushort", 3: "uint", 4: "uint"}.get(run, "ulong"),
            "COMPONENTS": plane.components,
            "DEPTH_SHIFT": plane.shift,
            "INTERPOLATION": list(TAPS).index(self._interpolation),
            "NEWTON_STEPS": _NEWTON_STEPS,
            "LANES": 1 if self._direct else self._session.lanes,
            "STRIP": STRIP,
        }
        return tuple(f"-D{name}={value}" for name, value in values.items())
