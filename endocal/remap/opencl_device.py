"""OpenCL devices: which there are, which one is meant, and one session for each."""

from __future__ import annotations

import os
import threading
from dataclasses import dataclass
from functools import cache
from importlib import resources

import pyopencl as cl

from ..errors import DeviceError, UsageError
from .pocl_processor import name_unknown_processor
from .pocl_setup import prepare_pocl, require_pocl

_INSTALL = (
    "install your GPU's OpenCL driver, or PoCL for the CPU (pip install pocl-binary-distribution on Linux"
    " x86-64, apt install pocl-opencl-icd on Debian), or pass --device numpy"
)
# The order in which ``auto`` prefers kinds of device.
_KINDS = (
    (cl.device_type.GPU, "GPU"),
    (cl.device_type.ACCELERATOR, "accelerator"),
    (cl.device_type.CPU, "CPU"),
)


@dataclass(frozen=True)
class ListedDevice:
    """An OpenCL device and its number, ``P:D``, by platform and device."""

    platform: int
    number: int
    device: cl.Device

    @property
    def address(self) -> str:
        """The number as ``--device`` takes it."""
        return f"{self.platform}:{self.number}"

    @property
    def name(self) -> str:
        """The device's name."""
        return str(self.device.name).strip()

    @property
    def kind(self) -> str:
        """GPU, accelerator, CPU or other."""
        return next((name for bit, name in _KINDS if self.device.type & bit), "other")


def list_devices() -> list[ListedDevice]:
    """Return every OpenCL device of every platform; an empty list where there is no platform."""
    prepare_pocl()  # before any driver is loaded
    try:
        platforms = cl.get_platforms()
    except cl.Error:  # the loader knows no platform
        return []
    found = []
    for p, platform in enumerate(platforms):
        try:
            devices = platform.get_devices()
        except cl.Error:  # a driver without its hardware
            continue
        found += [ListedDevice(p, d, device) for d, device in enumerate(devices)]
    return found


def choose_device(name: str) -> tuple[ListedDevice, str]:
    """Return the device meant by ``auto``, ``P:D`` or part of a name, and why it was taken.

    ``auto`` takes what PYOPENCL_CTX names, where that is set (pyopencl's own convention: platform and
    device, each a number or part of a name, with a colon between); else a GPU before an accelerator before
    a CPU, and of one kind the one with the most compute units. Raises UsageError, naming what exists, for a
    name that none has, and DeviceError where there is none for ``auto``; there is no fallback.
    """
    devices = list_devices()
    if not devices:
        raise DeviceError(f"no OpenCL device was found: {prepare_pocl().trouble or _INSTALL}")
    if name == "auto":
        answers = os.environ.get("PYOPENCL_CTX", "")
        if not answers:
            return _best(devices)
        fitting = [entry for entry in devices if _answers(answers, entry)]
        asked, reason = f"PYOPENCL_CTX={answers}", "named by PYOPENCL_CTX"
    else:
        fitting = [entry for entry in devices if name in (entry.address, entry.name)]
        fitting += [entry for entry in devices if _is_part(name, entry)]
        asked, reason = repr(name), "named"
    if fitting:
        return fitting[0], reason
    known = ", ".join(f"{entry.address} ({entry.name})" for entry in devices)
    error = DeviceError if name == "auto" else UsageError
    raise error(f"no OpenCL device matches {asked}; there are {known}, and numpy")


def _is_part(name: str, entry: ListedDevice) -> bool:
    """Whether a name is part of the platform's and the device's; digits alone name nothing."""
    return (
        not name.isdigit() and name.lower() in f"{entry.device.platform.name} {entry.name}".lower()
    )


def _best(devices: list[ListedDevice]) -> tuple[ListedDevice, str]:
    kinds = [name for _, name in _KINDS] + ["other"]
    ranked = sorted(devices, key=lambda e: (kinds.index(e.kind), -e.device.max_compute_units))
    first = ranked[0]
    if len(devices) == 1:
        return first, "the only OpenCL device"
    rivals = [entry for entry in devices if entry.kind == first.kind]
    if len(rivals) > 1:
        return first, f"the {first.kind} with the most compute units"
    return first, f"a {first.kind} is taken before a {ranked[1].kind}"


def _answers(wanted: str, entry: ListedDevice) -> bool:
    """Whether a device is the one that PYOPENCL_CTX's answers pick."""
    parts = (*wanted.split(":"), "")[:2]
    facts = ((entry.platform, entry.device.platform.name), (entry.number, entry.name))
    return all(
        not part or part == str(number) or (not part.isdigit() and part.lower() in name.lower())
        for part, (number, name) in zip(parts, facts, strict=True)
    )


class DeviceSession:
    """A device with its context and the programs built for it, shared by every engine on it.

    ``looks_up`` lets kernels look taps up in registers where the processor can: kernels/look_up.cl.
    """

    looks_up = True

    def __init__(self, listed: ListedDevice) -> None:
        self.device = listed.device
        self.name = listed.name
        self.is_cpu = listed.kind == "CPU"
        name_unknown_processor(self.device.int_ptr, self.device.version)
        if "PoCL" in self.device.version:
            require_pocl()
        try:
            self.context = cl.Context([self.device])
        except cl.Error as error:
            raise DeviceError(f"{self.name} cannot be used: {_first_line(error)}") from error
        self._programs: dict[tuple[tuple[str, ...], tuple[str, ...]], cl.Program] = {}
        self._lock = threading.Lock()

    @property
    def shares_memory(self) -> bool:
        """Whether the device works on the host's memory, so that planes need no copy."""
        return self.is_cpu or bool(self.device.host_unified_memory)

    @property
    def lanes(self) -> int:
        """How many floats the device's vectors hold, as the kernels can use them: 8 or 16."""
        return 16 if self.device.native_vector_width_float >= 16 else 8

    def program(self, files: tuple[str, ...], options: tuple[str, ...]) -> cl.Program:
        """Build the named kernel files, joined in that order, once for each set of options.

        Raises DeviceError where the device's compiler refuses them.
        """
        with self._lock:
            if (files, options) not in self._programs:
                source = "\n".join(_kernel_source(file) for file in files)
                try:
                    program = cl.Program(self.context, source).build(list(options))
                except cl.Error as error:
                    raise DeviceError(
                        f"{self.name} cannot build the kernels ({_first_line(error)});"
                        " pass another --device, or --device numpy"
                    ) from error
                self._programs[files, options] = program
            return self._programs[files, options]


def _first_line(error: Exception) -> str:
    """The most telling line of an OpenCL error: the compiler's first complaint, else the first line."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    return next((line for line in lines if line.startswith("error:")), lines[0] if lines else "")


@cache
def _kernel_source(file: str) -> str:
    return resources.files("endocal.kernels").joinpath(file).read_text(encoding="utf-8")


_sessions: dict[int, DeviceSession] = {}
_sessions_lock = threading.Lock()


def session(listed: ListedDevice) -> DeviceSession:
    """Return the one session of a device."""
    with _sessions_lock:
        if listed.device.int_ptr not in _sessions:
            _sessions[listed.device.int_ptr] = DeviceSession(listed)
        return _sessions[listed.device.int_ptr]
