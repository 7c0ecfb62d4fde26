"""Write a lens as other tools take it: their lens model, fitted, or the maps of the remapping."""

from __future__ import annotations

import contextlib
import shlex
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from ..boundary.circle import Boundary
from ..boundary.content import content_radius
from ..boundary.detect import boundary_of
from ..calibration.result import Calibration
from ..errors import UsageError
from ..exchange import camera_text, maps
from ..exchange.fit_camera import CameraFit, fit_camera
from ..files import atomic_output, check_output, load
from ..files.names import shown
from ..model import DivisionModel
from ..remap.geometry import output_geometry
from ..zoom.table import ZoomTable
from .lens import fit_lens
from .zoom_bounds import beyond_table, check_named

# What each kind's file may be called; those of the first line hold a fitted model, the others maps.
FITTED = {
    "opencv": (".yaml", ".yml", ".json"),
    "ros": (".yaml", ".yml"),
    "gyroflow": (".json",),
}
MAPPED = {"ffmpeg": (".pgm",), "stmap": (".tif", ".tiff"), "npz": (".npz",)}
KINDS = (*FITTED, *MAPPED)
DEPTHS = (16, 32)

# Beyond this error, px, a fitted model is no longer the same lens to the eye.
_VISIBLE = 0.5


@dataclass(frozen=True)
class ExportSpec:
    """What to export, as the command's options; lengths in px.

    ``diameter`` or ``setting`` (from 1) tells the zoom where ``calibration`` is a zoom table. ``frame`` is
    the size (width, height) of the frames where they differ from the calibration's.
    """

    calibration: str
    output: str
    to: str
    diameter: float | None = None
    setting: int | None = None
    frame: tuple[int, int] | None = None
    rational: bool = False
    focal: float | None = None
    name: str | None = None
    view: str = "same"
    size: tuple[int, int] | None = None
    scale: float | None = None
    depth: int | None = None
    overwrite: bool = False


@dataclass(frozen=True)
class ExportReport:
    """What was written: ``files``, the model's errors (px; None for maps, which have none), and notes.

    ``radius``: the content over which the model was fitted, px from the centre. ``command``: how ffmpeg
    takes the maps.
    """

    to: str
    files: tuple[str, ...]
    largest_error: float | None = None
    rms_error: float | None = None
    radius: float | None = None
    coefficients: tuple[float, ...] = ()
    command: str | None = None
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Lens:
    """The model, the visible circle, and how far from the centre the content is to be met, px."""

    model: DivisionModel
    boundary: Boundary | None
    radius: float


def export(spec: ExportSpec) -> ExportReport:
    """Export a calibration, or one zoom of a table.

    Raises UsageError for options that do not go together, InputError for a lens that cannot be used, and
    OutputError for a file that exists or cannot be written.
    """
    _check(spec)
    lens, notes = _lens(spec)
    report = _export_maps(spec, lens) if spec.to in MAPPED else _export_fit(spec, lens)
    return replace(report, notes=(*notes, *report.notes))


def _check(spec: ExportSpec) -> None:
    if spec.to not in KINDS:
        raise UsageError(f"--to {spec.to}: it is one of {', '.join(KINDS)}")
    for option, given, kinds in (
        ("--rational", spec.rational, FITTED),
        ("--focal", spec.focal is not None, FITTED),
        ("--name", spec.name is not None, ("ros", "gyroflow")),
        ("--view", spec.view != "same", MAPPED),
        ("--size", spec.size is not None, MAPPED),
        ("--scale", spec.scale is not None, MAPPED),
        ("--depth", spec.depth is not None, ("stmap",)),
    ):
        if given and spec.to not in kinds:
            raise UsageError(f"{option} is for --to {' and '.join(kinds)}, not {spec.to}")
    if spec.depth is not None and spec.depth not in DEPTHS:
        raise UsageError(f"--depth {spec.depth}: it is one of {', '.join(map(str, DEPTHS))}")
    if spec.focal is not None and not 0 < spec.focal < float("inf"):
        raise UsageError(f"--focal {spec.focal:g} is not a positive number of px")
    suffixes = FITTED.get(spec.to) or MAPPED[spec.to]
    piped = spec.output == "-" and spec.to in FITTED
    if not piped and Path(spec.output).suffix.lower() not in suffixes:
        raise UsageError(
            f"{shown(spec.output)}: --to {spec.to} is written as {' or '.join(suffixes)}"
        )
    inputs = [] if spec.calibration == "-" else [spec.calibration]
    for path in _places(spec):
        check_output(path, spec.overwrite, inputs)


def _places(spec: ExportSpec) -> tuple[str, ...]:
    """The files that will be written: ffmpeg takes two."""
    if spec.to != "ffmpeg":
        return (spec.output,)
    place = Path(spec.output)
    return tuple(str(place.with_name(f"{place.stem}-{axis}{place.suffix}")) for axis in "xy")


def _lens(spec: ExportSpec) -> tuple[_Lens, tuple[str, ...]]:
    name = "<stdin>" if spec.calibration == "-" else shown(spec.calibration)
    obj = load(spec.calibration)
    zoomed = spec.diameter is not None or spec.setting is not None
    reach = None
    notes: list[str] = []
    if isinstance(obj, ZoomTable):
        obj = _at_zoom(obj, spec, name, notes)
    elif zoomed:
        raise UsageError(f"{name}: is a calibration; --diameter and --setting are for zoom tables")
    if spec.frame is not None:
        fitted, note = fit_lens(obj, spec.frame, None, name)
        assert isinstance(fitted, Calibration)
        if obj.usable_radius is not None:
            reach = obj.usable_radius * fitted.model.size[1] / obj.model.size[1]
        obj = replace(fitted, usable_radius=reach)
        notes += [note] if note else []
    model, boundary = obj.model, obj.boundary
    radius = content_radius(model.center, model.size, boundary, model.pixel_aspect)
    if obj.usable_radius is not None:
        radius = min(radius, obj.usable_radius)
    return _Lens(model, boundary, radius), tuple(notes)


def _at_zoom(table: ZoomTable, spec: ExportSpec, name: str, notes: list[str]) -> Calibration:
    """Return the table's lens at the zoom that the options name; ``notes`` tell of one outside its range."""
    count = len(table.settings)
    if (spec.diameter is None) == (spec.setting is None):
        raise UsageError(
            f"{name}: is a zoom table: name one zoom by --diameter PX or --setting N (1 to {count})"
        )
    if spec.setting is not None:
        if not 1 <= spec.setting <= count:
            raise UsageError(f"--setting {spec.setting}: {name} has the settings 1 to {count}")
        diameter = table.settings[spec.setting - 1].diameter
    else:
        diameter = spec.diameter or 0.0
        check_named("--diameter", diameter, table, "auto")
    model = table.at_diameter(diameter)
    if not table.covers(diameter):
        notes.append(beyond_table(diameter, table))
    # A table does not say where the circle lies; its centre is near the lens's.
    circle = boundary_of(model.center, diameter, table.size, table.pixel_aspect)
    return Calibration(model, boundary=circle)


def _export_fit(spec: ExportSpec, lens: _Lens) -> ExportReport:
    rational = spec.rational or spec.to == "gyroflow"
    fit = fit_camera(lens.model, lens.radius, rational, spec.focal)
    if lens.boundary is not None:
        (x, y), diameter = lens.boundary.center, lens.boundary.diameter
        fit = replace(fit, camera=replace(fit.camera, circle=(x, y, diameter)))
    notes = []
    if fit.largest > _VISIBLE:
        remedy = "" if rational else "; --rational comes nearer"
        notes.append(f"the fitted model is up to {fit.largest:.2g} px off{remedy}")
    _write(spec, (_text(spec, fit).encode(),))
    return ExportReport(
        to=spec.to,
        files=_places(spec),
        largest_error=fit.largest,
        rms_error=fit.rms,
        radius=lens.radius,
        coefficients=fit.camera.coefficients,
        notes=tuple(notes),
    )


def _text(spec: ExportSpec, fit: CameraFit) -> str:
    name = spec.name or "endoscope"
    as_json = Path(spec.output).suffix.lower() == ".json"
    writers: dict[str, Callable[[], str]] = {
        "opencv": lambda: (camera_text.opencv_json if as_json else camera_text.opencv_yaml)(fit),
        "ros": lambda: camera_text.ros_camera_info(fit, name),
        "gyroflow": lambda: camera_text.gyroflow_profile(fit, name),
    }
    return writers[spec.to]()


def _export_maps(spec: ExportSpec, lens: _Lens) -> ExportReport:
    geometry = output_geometry([lens.model], [lens.boundary], spec.view, spec.size, spec.scale)
    x, y = maps.source_maps(lens.model, geometry)
    command = None
    contents: tuple[bytes, ...]
    if spec.to == "ffmpeg":
        contents = maps.pgm_maps(x, y, lens.model.size)
        command = _ffmpeg_command(_places(spec))
    elif spec.to == "stmap":
        contents = (maps.stmap_tiff(x, y, lens.model.size, spec.depth or 32),)
    else:
        contents = (maps.npz_maps(x, y, lens.model),)
    _write(spec, contents)
    return ExportReport(to=spec.to, files=_places(spec), command=command)


def _ffmpeg_command(places: tuple[str, ...]) -> str:
    inputs = " ".join(shlex.join(_as_input(p)) for p in places)
    graph = shlex.quote("[0:v][1:v][2:v]remap[v]")
    return (
        f"ffmpeg -i INPUT {inputs} -filter_complex {graph} -map '[v]' -map '0:a?' -c:a copy OUTPUT"
    )


def _as_input(path: str) -> list[str]:
    """The words that make ffmpeg read this file, where its name could be an option, a URL or a pattern."""
    plain = ["-pattern_type", "none"] if "%" in path else []
    return [*plain, "-i", f"file:{path}" if path.startswith("-") or ":" in path else path]


def _write(spec: ExportSpec, contents: tuple[bytes, ...]) -> None:
    """Write all files or none."""
    if spec.output == "-":
        sys.stdout.buffer.write(contents[0])
        sys.stdout.buffer.flush()
        return
    with contextlib.ExitStack() as stack:
        for path, data in zip(_places(spec), contents, strict=True):
            stack.enter_context(atomic_output(path, spec.overwrite)).write_bytes(data)
