"""Tell PoCL what processor it runs on, where it does not know.

PoCL asks LLVM for the processor's name and hands it to Clang. For an AMD processor newer than its LLVM the
answer is "generic", which Clang refuses on x86, so that no kernel can be built: PoCL's wheel (3.0, LLVM 14)
and Debian 12's package (3.1, LLVM 14) fail so on Zen 5. See https://github.com/pocl/pocl/issues/1049.
There is no setting for it. PoCL keeps the name in the device's own record, next to the target triple; here
that one pointer is set to the name of the processor family whose instructions this one has.
"""

from __future__ import annotations

import ctypes
import os
import platform
import struct
from pathlib import Path

# LLVM's name -> the flags of /proc/cpuinfo that it stands for; the same steps as PoCL's own libraries.
_FAMILIES = {
    "icelake-server": {
        *("avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl", "avx512vbmi", "avx512_vbmi2"),
        *("avx512ifma", "avx512_vnni", "avx512_bitalg", "avx512_vpopcntdq"),
        *("gfni", "vaes", "vpclmulqdq", "sha_ni", "rdpid"),
    },
    "skylake-avx512": {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"},
    "haswell": {"avx2", "fma", "bmi1", "bmi2", "f16c", "movbe"},
    "x86-64": set(),
}
_UNKNOWN = b"generic\0"
_RECORD = (
    4096  # bytes of the device's record that are looked at; the pointer lies within its first 1000
)
_POINTER = struct.calcsize("P")


def name_unknown_processor(device_pointer: int, device_version: str) -> str | None:
    """Give a PoCL device the name of its processor family where PoCL has none.

    ``device_pointer`` is the address of the OpenCL device's record and ``device_version`` its version
    string, which ends with the name that PoCL has. Returns the name set, or None where nothing was to do.
    """
    if "PoCL" not in device_version or not device_version.strip().endswith("-generic"):
        return None
    if platform.system() != "Linux" or platform.machine() != "x86_64":
        return None
    place = _find_name(device_pointer)
    if place is None:
        return None
    flags = _processor_flags()
    family = next(name for name, needs in _FAMILIES.items() if needs <= flags)
    libc = ctypes.CDLL(None)
    libc.strdup.restype = ctypes.c_void_p
    # PoCL may free the string when it unloads, so it comes from the same allocator.
    ctypes.c_void_p.from_address(place).value = libc.strdup(family.encode())
    return family


def _find_name(record: int) -> int | None:
    """Return the address of the pointer to "generic" that follows the one to the target triple."""
    with open("/proc/self/mem", "rb", buffering=0) as memory:
        words = os.pread(memory.fileno(), _RECORD, record)
        pointers = [
            p for (p,) in struct.iter_unpack("P", words[: len(words) // _POINTER * _POINTER])
        ]
        for k in range(1, len(pointers)):
            if (
                _read(memory.fileno(), pointers[k], len(_UNKNOWN)) == _UNKNOWN
                and _read(memory.fileno(), pointers[k - 1], 7) == b"x86_64-"
            ):
                return record + k * _POINTER
    return None


def _read(memory: int, address: int, length: int) -> bytes:
    """Read bytes at an address that may not exist."""
    try:
        return os.pread(memory, length, address)
    except (OSError, OverflowError):
        return b""


def _processor_flags() -> set[str]:
    for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
        if line.startswith("flags"):
            return set(line.partition(":")[2].split())
    return set()
