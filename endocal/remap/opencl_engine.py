"""The OpenCL engine: frames resampled on a device."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager

import numpy as np
import pyopencl as cl

from ..errors import DeviceError
from ..model import DivisionModel
from .grid import PlaneGrid
from .opencl_choice import choose_strategy
from .opencl_device import DeviceSession, choose_device, session
from .opencl_memory import Planes, SharedPlanes, StagedPlanes
from .opencl_plane import OpenCLPlane


class OpenCLEngine:
    """Resamples frames on one OpenCL device.

    ``strategy`` is ``direct`` or ``baked``, see OpenCLPlane, or ``auto``: what was measured on the device,
    else baked on a CPU and direct elsewhere. ``staged`` sends planes through pinned memory, two frames in
    flight; by default that is done where the device has memory of its own.
    """

    def __init__(
        self,
        grids: Sequence[PlaneGrid],
        interpolation: str,
        device: str = "auto",
        strategy: str = "auto",
        staged: bool | None = None,
    ) -> None:
        listed, self.reason = choose_device(device)
        self._session = session(listed)
        self.device_name = self._session.name
        self.strategy = choose_strategy(self._session) if strategy == "auto" else strategy
        self.staged = not self._session.shares_memory if staged is None else staged
        count = 2 if self.staged else 1
        self._slots = [
            _Slot(self._session, tuple(grids), interpolation, self.strategy, self.staged)
            for _ in range(count)
        ]
        self._next = 0

    def submit(
        self, model: DivisionModel, planes: Sequence[np.ndarray], out: Sequence[np.ndarray]
    ) -> Pending:
        """Start on one frame; ``out`` is written when the result's ``wait`` has returned.

        ``planes`` and ``out`` must stay as they are until then.
        """
        slot = self._slots[self._next]
        self._next = (self._next + 1) % len(self._slots)
        if slot.pending is not None and slot.is_staged:
            slot.pending.wait()  # its memory is needed
        with self._errors():
            slot.pending = Pending(slot.start(model, planes, out), self._errors)
        return slot.pending

    @contextmanager
    def _errors(self) -> Iterator[None]:
        try:
            yield
        except cl.Error as error:
            first = str(error).splitlines()[0]
            raise DeviceError(f"{self.device_name} failed: {first}") from error


class Pending:
    """A frame on its way."""

    def __init__(self, planes: Planes, errors: Callable[[], AbstractContextManager[None]]) -> None:
        self._planes: Planes | None = planes
        self._errors = errors
        self._lock = threading.Lock()

    def wait(self) -> None:
        """Return when the output planes are written; raises DeviceError where the device failed."""
        with self._lock, self._errors():
            if self._planes is not None:
                self._planes.finish()
            self._planes = None


class _Slot:
    """What one frame in flight needs of its own: a queue, maps, and staging memory if any."""

    def __init__(
        self,
        session: DeviceSession,
        grids: tuple[PlaneGrid, ...],
        interpolation: str,
        strategy: str,
        staged: bool,
    ) -> None:
        self._session = session
        self._queue = cl.CommandQueue(session.context)
        # Planes on the same grid, such as both chroma planes, share their maps.
        each = {grid: OpenCLPlane(session, grid, interpolation, strategy) for grid in grids}
        self._planes = [each[grid] for grid in grids]
        self._distinct = tuple(each.values())
        self._staged = (
            StagedPlanes(session, self._queue, [g.source for g in grids], [g.output for g in grids])
            if staged
            else None
        )
        self.pending: Pending | None = None

    @property
    def is_staged(self) -> bool:
        """Whether frames go through memory of the slot's own."""
        return self._staged is not None

    def start(
        self, model: DivisionModel, planes: Sequence[np.ndarray], out: Sequence[np.ndarray]
    ) -> Planes:
        """Enqueue one frame; returns the memory that it goes through."""
        for plane in self._distinct:
            plane.set_model(self._queue, model)
        if self._staged is None:
            memory: Planes = SharedPlanes(self._session, self._queue, planes, out)
        else:
            memory = self._staged
            self._staged.upload(planes, out)
        for plane, source, target in zip(self._planes, memory.sources, memory.outputs, strict=True):
            plane.enqueue(self._queue, *source, *target)
        if self._staged is not None:
            self._staged.download()
        self._queue.flush()
        return memory
