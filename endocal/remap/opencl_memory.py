"""Planes of a frame on their way to a device and back: shared with it, or staged in pinned memory."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
import pyopencl as cl

from .layout import PlaneLayout
from .opencl_device import DeviceSession


class Planes(Protocol):
    """Buffers of one frame's planes, with their pitches in words."""

    sources: list[tuple[cl.Buffer, int]]
    outputs: list[tuple[cl.Buffer, int]]

    def finish(self) -> None:
        """Wait until the output planes are written where the caller wants them."""
        ...


class SharedPlanes:
    """The caller's own memory as the device's buffers: nothing is copied where they share memory."""

    def __init__(
        self,
        session: DeviceSession,
        queue: cl.CommandQueue,
        planes: Sequence[np.ndarray],
        out: Sequence[np.ndarray],
    ) -> None:
        self._queue = queue
        self._flat = [_flat(array) for array in out]
        self._hold = [_flat(array) for array in planes]
        flags = cl.mem_flags
        self.sources = [
            (cl.Buffer(session.context, flags.READ_ONLY | flags.USE_HOST_PTR, hostbuf=f), _pitch(a))
            for f, a in zip(self._hold, planes, strict=True)
        ]
        # Read and written: the words between the rows must come back as they are.
        self.outputs = [
            (
                cl.Buffer(session.context, flags.READ_WRITE | flags.USE_HOST_PTR, hostbuf=f),
                _pitch(a),
            )
            for f, a in zip(self._flat, out, strict=True)
        ]

    def finish(self) -> None:
        """Wait, and give the output's memory back to the host: by the standard, mapping does that."""
        for (buffer, _), flat in zip(self.outputs, self._flat, strict=True):
            array, _ = cl.enqueue_map_buffer(
                self._queue, buffer, cl.map_flags.READ, 0, flat.shape, flat.dtype, is_blocking=False
            )
            array.base.release(self._queue)
        self._queue.finish()


class StagedPlanes:
    """Device buffers and pinned host memory for one frame in flight, used again and again."""

    def __init__(
        self,
        session: DeviceSession,
        queue: cl.CommandQueue,
        sources: Sequence[PlaneLayout],
        outputs: Sequence[PlaneLayout],
    ) -> None:
        self._queue = queue
        self._up = [_Pinned(session, queue, layout, cl.map_flags.WRITE) for layout in sources]
        self._down = [_Pinned(session, queue, layout, cl.map_flags.READ) for layout in outputs]
        self.sources = [(plane.device, plane.array.shape[1]) for plane in self._up]
        self.outputs = [(plane.device, plane.array.shape[1]) for plane in self._down]
        self._out: Sequence[np.ndarray] = ()

    def upload(self, planes: Sequence[np.ndarray], out: Sequence[np.ndarray]) -> None:
        """Copy the planes to pinned memory and enqueue their way to the device."""
        self._out = out
        for pinned, plane in zip(self._up, planes, strict=True):
            np.copyto(pinned.array, plane)
            cl.enqueue_copy(self._queue, pinned.device, pinned.array, is_blocking=False)

    def download(self) -> None:
        """Enqueue the output planes' way back."""
        for pinned in self._down:
            cl.enqueue_copy(self._queue, pinned.array, pinned.device, is_blocking=False)
        self._queue.flush()

    def finish(self) -> None:
        """Wait, and copy the output planes to where the caller wants them."""
        self._queue.finish()
        for pinned, plane in zip(self._down, self._out, strict=True):
            np.copyto(plane, pinned.array)
        self._out = ()


class _Pinned:
    """A device buffer and the pinned host array of its shape."""

    def __init__(
        self,
        session: DeviceSession,
        queue: cl.CommandQueue,
        layout: PlaneLayout,
        access: cl.map_flags,
    ) -> None:
        flags = cl.mem_flags
        size = layout.shape[0] * layout.shape[1] * layout.dtype.itemsize
        self.device = cl.Buffer(session.context, flags.READ_WRITE, size)
        self._host = cl.Buffer(session.context, flags.READ_WRITE | flags.ALLOC_HOST_PTR, size)
        self.array, _ = cl.enqueue_map_buffer(
            queue, self._host, access, 0, layout.shape, layout.dtype
        )


def _flat(plane: np.ndarray) -> np.ndarray:
    """View a plane, with what lies between its rows, as one run of words."""
    rows, columns = plane.shape
    if plane.flags.c_contiguous:
        return plane.reshape(-1)
    return np.lib.stride_tricks.as_strided(
        plane, ((rows - 1) * _pitch(plane) + columns,), (plane.itemsize,)
    )


def _pitch(plane: np.ndarray) -> int:
    """Words from row to row."""
    return plane.strides[0] // plane.itemsize
