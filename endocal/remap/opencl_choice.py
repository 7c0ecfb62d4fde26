"""Which strategy a device takes: what was measured on it once, else what suits its kind."""

from __future__ import annotations

import json
import os
from contextlib import suppress
from pathlib import Path

from .._version import __version__
from .opencl_device import DeviceSession

STRATEGIES = ("baked", "direct")


def choose_strategy(session: DeviceSession) -> str:
    """Return the strategy remembered for the device, else baked for a CPU and direct for others."""
    remembered = _read().get(_key(session))
    if remembered in STRATEGIES:
        return remembered
    return "baked" if session.is_cpu else "direct"


def is_remembered(session: DeviceSession) -> bool:
    """Tell whether the device was measured, with this driver and this version of endocal."""
    return _read().get(_key(session)) in STRATEGIES


def remember(session: DeviceSession, strategy: str) -> None:
    """Keep a device's strategy for later runs; where the cache cannot be written, do nothing."""
    path = _path()
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        beside = path.with_name(f".{path.name}.{os.getpid()}")
        beside.write_text(json.dumps({**_read(), _key(session): strategy}, indent=1) + "\n")
        beside.replace(path)


def _path() -> Path:
    base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(base) / "endocal" / "strategies.json"


def _read() -> dict[str, str]:
    with suppress(OSError, ValueError, RuntimeError):
        kept = json.loads(_path().read_text(encoding="utf-8"))
        if isinstance(kept, dict):
            return {str(key): str(value) for key, value in kept.items()}
    return {}


def _key(session: DeviceSession) -> str:
    device = session.device
    return " | ".join((device.platform.name, session.name, device.driver_version, __version__))
