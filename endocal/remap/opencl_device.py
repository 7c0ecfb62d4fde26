"""OpenCL devices: which there are, which one is meant, and one context for each."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from functools import cache
from importlib import resources

import pyopencl as cl

from ..errors import DeviceError
from .pocl_processor import name_unknown_processor

_INSTALL = (
    "install an OpenCL driver (pip install 'pyopencl[pocl]' brings one for the CPU)"
    " or pass --device numpy"
)


@dataclass(frozen=True)
class DeviceAddress:
    """A device by platform and device number, as ``--device P:D`` names it."""

    platform: int
    device: int

    def __str__(self) -> str:
        return f"{self.platform}:{self.device}"


def list_devices() -> list[tuple[DeviceAddress, cl.Device]]:
    """Return every OpenCL device of every platform; an empty list where there is no platform."""
    try:
        platforms = cl.get_platforms()
    except cl.LogicError:  # the loader has no platform at all
        return []
    found = []
    for p, platform in enumerate(platforms):
        try:
            devices = platform.get_devices()
        except cl.Error:  # a driver without its hardware
            continue
        found += [(DeviceAddress(p, d), device) for d, device in enumerate(devices)]
    return found


def choose_device(name: str) -> tuple[cl.Device, str]:
    """Return the device meant by ``auto``, ``P:D`` or part of a name, and why it was taken.

    Raises DeviceError, naming what exists, where none fits; there is no fallback.
    """
    devices = list_devices()
    if not devices:
        raise DeviceError(f"no OpenCL device was found: {_INSTALL}")
    if name == "auto":
        ranked = sorted(devices, key=lambda entry: _rank(entry[1]))
        return ranked[0][1], _reason(ranked[0][1])
    for address, device in devices:
        if str(address) == name:
            return device, "named by its number"
    for _, device in devices:
        if name.lower() in f"{device.platform.name} {device.name}".lower():
            return device, "named"
    known = ", ".join(f"{address} ({device.name.strip()})" for address, device in devices)
    raise DeviceError(f"no OpenCL device matches {name!r}; there are {known}, and numpy")


def _rank(device: cl.Device) -> tuple[int, int]:
    """GPUs first, then accelerators, then CPUs; more compute units first."""
    kinds = (cl.device_type.GPU, cl.device_type.ACCELERATOR, cl.device_type.CPU)
    kind = next((k for k, bit in enumerate(kinds) if device.type & bit), len(kinds))
    return kind, -device.max_compute_units


def _reason(device: cl.Device) -> str:
    return "a GPU is taken before a CPU" if device.type & cl.device_type.GPU else "no GPU was found"


class DeviceSession:
    """A device with its context, its queue and the programs built for it, shared by every engine on it."""

    def __init__(self, device: cl.Device) -> None:
        self.device = device
        name_unknown_processor(device.int_ptr, device.version)
        self.context = cl.Context([device])
        self._programs: dict[tuple[tuple[str, ...], tuple[str, ...]], cl.Program] = {}
        self._lock = threading.Lock()

    @property
    def shares_memory(self) -> bool:
        """Whether the device works on the host's memory, so that planes need no copy."""
        return bool(self.device.host_unified_memory)

    def program(self, files: tuple[str, ...], options: tuple[str, ...]) -> cl.Program:
        """Build the named kernel files, joined in that order, once for each set of options."""
        with self._lock:
            if (files, options) not in self._programs:
                source = "\n".join(_kernel_source(file) for file in files)
                self._programs[files, options] = cl.Program(self.context, source).build(
                    list(options)
                )
            return self._programs[files, options]


@cache
def _kernel_source(file: str) -> str:
    return resources.files("endocal.kernels").joinpath(file).read_text(encoding="utf-8")


_sessions: dict[int, DeviceSession] = {}
_sessions_lock = threading.Lock()


def session(device: cl.Device) -> DeviceSession:
    """Return the one session of a device."""
    with _sessions_lock:
        if device.int_ptr not in _sessions:
            _sessions[device.int_ptr] = DeviceSession(device)
        return _sessions[device.int_ptr]
