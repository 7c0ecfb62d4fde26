"""One chooser for two engines: the frame remapper of the video pipeline and of still pictures."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from typing import Protocol

import numpy as np

from ..errors import InputError, UsageError
from ..model import DivisionModel
from .geometry import OutputGeometry
from .grid import plane_grids
from .interpolation import TAPS
from .layout import FrameLayout, PlaneLayout
from .numpy_engine import NumpyEngine


class Pending(Protocol):
    """A frame on its way."""

    def wait(self) -> None:
        """Return when the output planes are written."""
        ...


class Engine(Protocol):
    """What an engine does: resample the planes of a frame through a model.

    ``staged`` says that planes travel through memory of its own.
    """

    device_name: str
    staged: bool

    def submit(
        self, model: DivisionModel, planes: Sequence[np.ndarray], out: Sequence[np.ndarray]
    ) -> Pending:
        """Start to write every plane of ``out`` from ``planes``; both fit the layout."""
        ...


class FrameRemapper:
    """Resamples frames of one layout into one output geometry.

    ``interpolation`` is nearest, bilinear, bicubic or lanczos. ``device`` is ``auto`` (the best OpenCL
    device), ``numpy``, part of an OpenCL device's name, or its number as ``P:D``. Calls from several
    threads take turns. Raises UsageError where the device does not exist; it never takes another.
    """

    def __init__(
        self,
        layout: FrameLayout,
        geometry: OutputGeometry,
        interpolation: str = "bilinear",
        device: str = "auto",
        engine: Engine | None = None,
    ) -> None:
        if interpolation not in TAPS:
            raise UsageError(
                f"interpolation {interpolation!r} is unknown; it is one of {', '.join(TAPS)}"
            )
        if geometry.source_size != layout.size:
            raise InputError(
                f"a geometry for {geometry.source_size[0]}x{geometry.source_size[1]} does not fit frames"
                f" of {layout.size[0]}x{layout.size[1]}"
            )
        self.layout = layout
        self.output_layout = layout.resized(geometry.size)
        self.geometry = geometry
        self._engine = engine or choose_engine(layout, geometry, interpolation, device)
        self._lock = threading.Lock()

    @property
    def is_staged(self) -> bool:
        """Whether frames travel to a device's own memory and back, so that two under way are quicker."""
        return self._engine.staged

    @property
    def device_name(self) -> str:
        """The name of the device that does the work."""
        return self._engine.device_name

    def apply(
        self, model: DivisionModel, planes: Sequence[np.ndarray], out: Sequence[np.ndarray]
    ) -> None:
        """Resample one frame through ``model`` and return when ``out`` is written.

        ``planes`` and ``out`` hold one 2-D array (rows, columns * components) for each plane of ``layout``
        and ``output_layout``, uint8 or uint16, with any number of bytes from row to row; they must not
        overlap. What the model determines is worked out again only when it differs from the last one.
        Raises InputError where a model or an array does not fit, DeviceError where the device failed.
        """
        self.submit(model, planes, out).wait()

    def submit(
        self, model: DivisionModel, planes: Sequence[np.ndarray], out: Sequence[np.ndarray]
    ) -> Pending:
        """Start on one frame and return while it is on its way; ``wait`` on the result for ``out``.

        As ``apply``; the arrays must be left alone until then. A device with memory of its own works on
        two frames at a time, so that one's transfer overlaps the other's resampling.
        """
        if model.size != self.layout.size:
            raise InputError(
                f"a model for {model.size[0]}x{model.size[1]} does not fit frames of"
                f" {self.layout.size[0]}x{self.layout.size[1]}; rescale it"
            )
        _check("input", planes, self.layout.planes)
        _check("output", out, self.output_layout.planes)
        plain_in = [p if _is_plain(p) else np.ascontiguousarray(p) for p in planes]
        plain_out = [p if _is_plain(p) else np.empty(p.shape, p.dtype) for p in out]
        with self._lock:
            pending = self._engine.submit(model, plain_in, plain_out)
        returns = [(o, p) for o, p in zip(out, plain_out, strict=True) if o is not p]
        return _Return(pending, returns) if returns else pending


class _Return:
    """A frame on its way to arrays that an engine cannot write itself."""

    def __init__(self, pending: Pending, returns: list[tuple[np.ndarray, np.ndarray]]) -> None:
        self._pending = pending
        self._returns = returns

    def wait(self) -> None:
        """Return when the output planes are written."""
        self._pending.wait()
        for out, plain in self._returns:
            np.copyto(out, plain)


def prepare_device(name: str) -> None:
    """Set in the environment what the device's libraries read there.

    To be done before they are imported, and before other threads start: what those read of the environment
    meanwhile is undefined.
    """
    if name != "numpy":
        from .pocl_setup import prepare_pocl

        prepare_pocl()


def load_device(name: str) -> None:
    """Load the libraries of the device that a FrameRemapper will be asked for, and open it.

    That takes a while, and may be done in another thread meanwhile, after ``prepare_device`` in this one.
    Raises what the remapper would.
    """
    if name != "numpy":
        from .opencl_device import choose_device, session

        session(choose_device(name)[0])


def choose_engine(
    layout: FrameLayout, geometry: OutputGeometry, interpolation: str, device: str
) -> Engine:
    """Return the engine for a device; pyopencl is imported only where it is needed."""
    grids = plane_grids(layout, geometry)
    if device == "numpy":
        return NumpyEngine(grids, interpolation)
    prepare_device(device)
    from .opencl_engine import OpenCLEngine

    return OpenCLEngine(grids, interpolation, device)


def _check(role: str, arrays: Sequence[np.ndarray], planes: Sequence[PlaneLayout]) -> None:
    if len(arrays) != len(planes):
        raise InputError(
            f"{len(arrays)} {role} planes were given where the format has {len(planes)}"
        )
    for number, (array, plane) in enumerate(zip(arrays, planes, strict=True)):
        if array.shape != plane.shape or array.dtype != plane.dtype:
            raise InputError(
                f"{role} plane {number} is {array.dtype} {array.shape}; the format asks for"
                f" {plane.dtype} {plane.shape}"
            )


def _is_plain(plane: np.ndarray) -> bool:
    """Whether a plane's rows run forward in memory, each without gaps."""
    rows, columns = plane.shape
    along = columns == 1 or plane.strides[1] == plane.itemsize
    down = plane.strides[0] >= columns * plane.itemsize and plane.strides[0] % plane.itemsize == 0
    return along and (down or rows == 1)
