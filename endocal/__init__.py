"""endocal: calibrate a wide-angle zoom lens from one picture and correct its video."""

from __future__ import annotations

import importlib
from typing import Any

from ._version import __version__

# Public name -> module that defines it; loaded on first use, so that `import endocal` stays quick.
_PUBLIC = {
    "Boundary": "boundary.circle",
    "Calibration": "calibration.result",
    "CalibrationSpec": "calibration.spec",
    "DivisionModel": "model",
    "EndocalError": "errors",
    "Remapper": "remap.remapper",
    "ZoomTable": "zoom.table",
    "calibrate": "calibration.calibrate",
    "load": "files",
}

__all__ = ["__version__", *sorted(_PUBLIC)]


def __getattr__(name: str) -> Any:
    if name in _PUBLIC:
        return getattr(importlib.import_module(f".{_PUBLIC[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
