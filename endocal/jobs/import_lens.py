"""Read a lens from another tool's calibration: the division model that corrects most alike."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace

from .._version import __version__
from ..boundary.detect import boundary_of
from ..calibration.result import Calibration, Source
from ..errors import InputError, UsageError
from ..exchange.fit_division import DivisionFit, fit_division
from ..exchange.read_camera import read_camera
from ..files import check_output, save
from ..files.names import NO_SUCH_FILE, shown

MODELS = ("division", "division2")

_MAX_BYTES = 1 << 20
# Beyond this error, px, the two are no longer the same lens to the eye.
_VISIBLE = 0.5


@dataclass(frozen=True)
class ImportSpec:
    """What to read, as the command's options.

    ``size`` (width, height) px, where the file tells none; ``circle`` (x, y, diameter) px: the visible
    circle, within which alone the lens is compared.
    """

    input: str
    output: str
    model: str = "division"
    size: tuple[int, int] | None = None
    circle: tuple[float, float, float] | None = None
    overwrite: bool = False


@dataclass(frozen=True)
class ImportReport:
    """The calibration, how far it is from the file's model over the content, in distorted px, and notes."""

    calibration: Calibration
    largest_error: float
    rms_error: float
    notes: tuple[str, ...] = ()


def import_lens(spec: ImportSpec) -> ImportReport:
    """Fit a division model to OpenCV's or ROS's and write it as a calibration.

    Raises InputError for a file that is no such calibration, UsageError for options that make no sense, and
    OutputError for an output that exists or cannot be written.
    """
    if spec.model not in MODELS:
        raise UsageError(f"--model {spec.model}: it is one of {', '.join(MODELS)}")
    check_output(spec.output, spec.overwrite, [] if spec.input == "-" else [spec.input])
    name = "<stdin>" if spec.input == "-" else shown(spec.input)
    try:
        camera = read_camera(_read(spec.input), spec.size)
        if spec.circle is not None:
            camera = replace(camera, circle=spec.circle)
        fit = fit_division(camera, spec.model == "division2")
        boundary = None
        if camera.circle is not None:
            x, y, diameter = camera.circle
            boundary = boundary_of((x, y), diameter, fit.model.size, fit.model.pixel_aspect)
        calibration = Calibration(
            fit.model,
            boundary=boundary,
            source=Source("import", refined=False, endocal=__version__),
            usable_radius=fit.reach,
        )
        save(calibration, spec.output, spec.overwrite)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None
    return ImportReport(calibration, fit.largest, fit.rms, tuple(_notes(fit, spec, name)))


def _notes(fit: DivisionFit, spec: ImportSpec, name: str) -> Iterator[str]:
    if fit.reach is not None:
        yield (
            f"the model in {name} is one-to-one only up to {fit.reach:.0f} px from the centre;"
            " --circle limits the fit to what the lens shows"
        )
    if fit.largest > _VISIBLE and spec.model == "division":
        yield "one parameter does not say all of this lens; --model division2 comes nearer"


def _read(path: str) -> str:
    try:
        if path == "-":
            data = sys.stdin.buffer.read(_MAX_BYTES + 1)
        else:
            with open(path, "rb") as file:
                data = file.read(_MAX_BYTES + 1)
    except FileNotFoundError:
        raise InputError(NO_SUCH_FILE) from None
    except IsADirectoryError:
        raise InputError("is a directory, not a calibration file") from None
    except (OSError, ValueError) as error:
        raise InputError(f"cannot be read: {getattr(error, 'strerror', error)}") from None
    if len(data) > _MAX_BYTES:
        raise InputError("too large to be a calibration file")
    if not data.strip():
        raise InputError("is empty: take another copy of it")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError("not a calibration file: it is no text") from None
