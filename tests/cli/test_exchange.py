"""``endocal export`` and ``endocal import`` as a user meets them, the other tools run on what they wrote."""

from __future__ import annotations

import json
import shlex
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from endocal.calibration.result import Calibration
from endocal.files import load
from endocal.remap.remapper import Remapper

Runner = Callable[..., Any]

SIZE = (320, 240)
CALIBRATION = """
schema = "endocal.calibration/1"
[model]
type = "division"
lambda = -2e-5
center = [163.2, 117.4]
size = [320, 240]
[boundary]
center = [160, 119.5]
diameter = 236
"""
TABLE = """
schema = "endocal.zoomtable/1"
size = [320, 240]
[[setting]]
lambda = -4e-5
center = [161, 118]
diameter = 150
[[setting]]
lambda = -1.6e-5
center = [163, 117]
diameter = 237.2
"""
OUTPUTS = {
    "opencv": "out.yaml",
    "ros": "out.yml",
    "gyroflow": "out.json",
    "ffmpeg": "out.pgm",
    "stmap": "out.tif",
    "npz": "out.npz",
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "cal.toml").write_text(CALIBRATION)
    (tmp_path / "zoom.toml").write_text(TABLE)
    return tmp_path


def export(
    endocal: Runner, folder: Path, kind: str, *options: str, config: str = "cal.toml"
) -> Any:
    names = ["-c", folder / config, "--to", kind, "-o", folder / OUTPUTS.get(kind, "out.yaml")]
    return endocal("export", *names, *options)


@pytest.mark.parametrize("kind", OUTPUTS)
def test_every_kind_is_written_whole_and_the_same_each_time(
    endocal: Runner, folder: Path, kind: str
) -> None:
    before = set(folder.iterdir())
    first = export(endocal, folder, kind)
    assert first.code == 0, first.err
    made = {p: p.read_bytes() for p in set(folder.iterdir()) - before}
    assert len(made) == (2 if kind == "ffmpeg" else 1)
    assert all(made.values())
    assert "exists already" in export(endocal, folder, kind).fails()
    again = export(endocal, folder, kind, "--overwrite", "--json")
    assert again.code == 0, again.err
    assert {p: p.read_bytes() for p in made} == made
    assert json.loads(again.out)["files"] == sorted(str(p) for p in made)


def run_ffmpeg(*words: str | Path, cwd: Path | None = None) -> None:
    command = ["ffmpeg", "-v", "error", "-nostdin", "-y", *map(str, words)]
    subprocess.run(command, check=True, cwd=cwd, timeout=60)


def levels(clip: Path) -> np.ndarray:
    """The frames of a 4:4:4 clip, (frames, planes, h, w)."""
    raw = clip.with_suffix(".raw")
    run_ffmpeg("-i", clip, "-f", "rawvideo", "-pix_fmt", "yuv444p", raw)
    return np.fromfile(raw, np.uint8).reshape(-1, 3, *SIZE[::-1]).astype(int)


def write_clip(clip: Path, frames: np.ndarray) -> None:
    raw = clip.with_suffix(".source")
    frames.astype(np.uint8).tofile(raw)
    size = f"{SIZE[0]}x{SIZE[1]}"
    source = ["-f", "rawvideo", "-pix_fmt", "yuv444p", "-s", size, "-r", "10", "-i", raw]
    run_ffmpeg(*source, "-c:v", "ffv1", clip)


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="no ffmpeg on this machine")
def test_ffmpeg_remaps_as_correct_does(endocal: Runner, folder: Path) -> None:
    # One frame of noise, where every wrong pixel shows, and smooth ones that change by up to a level a pixel.
    x, y = np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1]))
    waves = [128 + 50 * np.sin(x / 55 + p) + 40 * np.cos(y / 50 - p) for p in range(6)]
    noise = np.random.default_rng(7).integers(16, 235, (1, 3, *x.shape))
    frames = np.concatenate([noise, np.round(waves).reshape(2, 3, *x.shape)])
    write_clip(folder / "in.mkv", frames)
    # A name that ffmpeg would take for a numbered sequence.
    maps = folder / "my lens %d.pgm"
    told = endocal("export", "-c", folder / "cal.toml", "--to", "ffmpeg", "-o", maps)
    words = shlex.split(told.out)
    assert words[0] == "ffmpeg"
    words = [str(folder / "in.mkv") if w == "INPUT" else w for w in words[1:-1]]
    run_ffmpeg(*words, "-c:v", "ffv1", folder / "theirs.mkv")
    for interpolation in ("nearest", "bilinear"):
        done = endocal(
            "correct",
            folder / "in.mkv",
            "-o",
            folder / f"{interpolation}.mkv",
            *("-c", folder / "cal.toml", "--codec", "ffv1", "--device", "numpy"),
            *("--interpolation", interpolation),
        )
        assert done.code == 0, done.err
    theirs = levels(folder / "theirs.mkv")
    assert theirs.shape == (3, 3, *x.shape)
    # The same nearest pixel everywhere, noise and black surroundings included.
    assert np.array_equal(theirs, levels(folder / "nearest.mkv"))
    # Half a pixel along either axis, at a level a pixel, and two roundings: 2 levels.
    calibration = load(folder / "cal.toml")
    assert isinstance(calibration, Calibration)
    shown = (
        Remapper(calibration.model, device="numpy").apply(np.full(x.shape, 255, np.uint8)) == 255
    )
    gap = np.abs(theirs - levels(folder / "bilinear.mkv"))[1:, :, shown]
    assert gap.max() <= 2


def test_opencv_undistorts_as_correct_does(endocal: Runner, folder: Path) -> None:
    report = export(endocal, folder, "opencv", "--rational", "--json")
    told = json.loads(report.out)
    assert told["largest_error"] < 1e-3
    storage = cv2.FileStorage(str(folder / "out.yaml"), cv2.FILE_STORAGE_READ)
    matrix, coefficients = (
        storage.getNode(k).mat() for k in ("camera_matrix", "distortion_coefficients")
    )
    x, y = np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1]))
    picture = np.round(128 + 50 * np.sin(x / 20) + 40 * np.cos(y / 18)).astype(np.uint8)
    theirs = cv2.undistort(picture, matrix, coefficients).astype(int)
    calibration = load(folder / "cal.toml")
    assert isinstance(calibration, Calibration)
    ours = Remapper(calibration.model, device="numpy").apply(picture)
    columns, rows = np.meshgrid(*(np.arange(n) for n in SIZE))
    source = calibration.model.distort(np.stack([columns, rows], axis=-1))
    shown = np.hypot(*np.moveaxis(source - calibration.boundary.center, -1, 0)) < 116
    # 2.5 levels a pixel: undistort rounds places to 1/32 px and values once, as ours are.
    assert np.abs(theirs - ours)[shown].max() <= 1


@pytest.mark.parametrize("kind", ["opencv", "ros"])
@pytest.mark.parametrize("options", [[], ["--rational"]], ids=["polynomial", "rational"])
def test_what_is_exported_comes_back(
    endocal: Runner, folder: Path, kind: str, options: list[str]
) -> None:
    out = json.loads(export(endocal, folder, kind, *options, "--json").out)
    back = folder / "back.toml"
    names = [folder / OUTPUTS[kind], "-o", back, "--circle", "160,119.5,236"]
    done = endocal("import", *names, "--json")
    assert done.code == 0, done.err
    told = json.loads(done.out)
    error = out["largest_error"] + told["largest_error"]
    assert error < (1e-2 if options else 3.0)
    model, found = load(folder / "cal.toml").model, load(back).model
    assert abs(found.lam - model.lam) * out["radius"] ** 3 <= error
    assert np.abs(np.subtract(found.center, model.center)).max() <= error
    assert told["boundary"]["visible"] == 1.0
    assert endocal("show", back).code == 0


def test_opencv_carries_the_visible_circle(endocal: Runner, folder: Path) -> None:
    export(endocal, folder, "opencv")
    assert endocal("import", folder / "out.yaml", "-o", folder / "back.toml").code == 0
    calibration = load(folder / "back.toml")
    assert isinstance(calibration, Calibration)
    assert calibration.boundary is not None
    assert calibration.boundary.diameter == 236


def test_a_model_that_one_parameter_does_not_say(endocal: Runner, folder: Path) -> None:
    # The polynomial of a wide lens folds just beyond the circle that it was fitted to.
    export(endocal, folder, "ros")
    done = endocal("import", folder / "out.yml", "-o", folder / "back.toml", "--json")
    notes = json.loads(done.out)["notes"]
    assert len(notes) == 2
    assert "one-to-one only up to" in notes[0]
    assert "--model division2" in notes[1]
    assert all(text in done.err for text in notes)
    calibration = load(folder / "back.toml")
    assert isinstance(calibration, Calibration)
    assert calibration.usable_radius is not None
    assert 110 < calibration.usable_radius < 160


def test_text_goes_through_pipes(endocal: Runner, folder: Path) -> None:
    piped = endocal("export", "-c", "-", "--to", "ros", "-o", "-", stdin=CALIBRATION.encode())
    assert piped.code == 0, piped.err
    back = endocal("import", "-", "-o", "-", stdin=piped.output)
    assert back.code == 0, back.err
    assert back.out.startswith('schema = "endocal.calibration/1"')


def test_a_zoom_table_at_one_zoom(endocal: Runner, folder: Path) -> None:
    by = {}
    for option, value in (("--setting", "2"), ("--diameter", "237.2"), ("--diameter", "200")):
        done = export(
            endocal,
            folder,
            "opencv",
            option,
            value,
            "--rational",
            "--overwrite",
            config="zoom.toml",
        )
        assert done.code == 0, done.err
        back = folder / "back.toml"
        assert endocal("import", folder / "out.yaml", "-o", back, "--overwrite").code == 0
        by[option, value] = load(back).model
    assert by["--setting", "2"] == by["--diameter", "237.2"]
    assert by["--setting", "2"].lam == pytest.approx(-1.6e-5, rel=1e-4)
    # Eq. 15, between settings that obey it.
    assert by["--diameter", "200"].lam == pytest.approx(-0.9e0 / 200**2, rel=1e-3)


@pytest.mark.parametrize(("diameter", "outside"), [("149", False), ("120", True), ("400", True)])
def test_a_zoom_that_nobody_calibrated_is_told(
    endocal: Runner, folder: Path, diameter: str, outside: bool
) -> None:
    done = export(endocal, folder, "opencv", "--diameter", diameter, config="zoom.toml")
    assert done.code == 0
    assert ("outside the table's 150 to 237 px" in done.err) == outside


def test_a_zoom_that_no_lens_has_is_refused(endocal: Runner, folder: Path) -> None:
    done = export(endocal, folder, "opencv", "--diameter", "20000", config="zoom.toml")
    assert "the zoom table goes from 150 to 237 px, and 38 to 1600 px can be" in done.fails(2)
    assert not (folder / "out.yaml").exists()


def test_frames_of_another_size(endocal: Runner, folder: Path) -> None:
    done = export(endocal, folder, "npz", "--frame", "640x480")
    assert "is rescaled to 640x480" in done.err
    stored = np.load(folder / "out.npz")
    assert tuple(stored["source_size"]) == (640, 480)
    assert stored["map_x"].shape == (480, 640)


@pytest.mark.parametrize(
    ("kind", "options", "config", "words"),
    [
        ("matlab", [], "cal.toml", "it is one of opencv"),
        ("ffmpeg", ["--rational"], "cal.toml", "--rational is for --to opencv"),
        ("opencv", ["--view", "crop"], "cal.toml", "--view is for"),
        ("npz", ["--depth", "16"], "cal.toml", "--depth is for"),
        ("stmap", ["--depth", "8"], "cal.toml", "--depth 8"),
        ("opencv", ["--focal", "0"], "cal.toml", "--focal 0"),
        ("opencv", ["--name", "x"], "cal.toml", "--name is for"),
        ("opencv", ["--diameter", "200"], "cal.toml", "are for zoom tables"),
        ("opencv", [], "zoom.toml", "name one zoom by --diameter PX or --setting N (1 to 2)"),
        ("opencv", ["--setting", "1", "--diameter", "9"], "zoom.toml", "name one zoom"),
        ("opencv", ["--setting", "3"], "zoom.toml", "has the settings 1 to 2"),
    ],
)
def test_export_options_that_make_no_sense(
    endocal: Runner, folder: Path, kind: str, options: list[str], config: str, words: str
) -> None:
    before = set(folder.iterdir())
    assert words in export(endocal, folder, kind, *options, config=config).fails(2)
    assert set(folder.iterdir()) == before


@pytest.mark.parametrize(
    ("output", "code", "words"),
    [
        ("out.txt", 2, "is written as .yaml"),
        ("no/out.yaml", 1, "does not exist"),
        ("cal.toml", 2, "is written as .yaml"),
    ],
)
def test_export_to_a_wrong_place(
    endocal: Runner, folder: Path, output: str, code: int, words: str
) -> None:
    names = ["-c", folder / "cal.toml", "--to", "opencv", "-o", folder / output, "--overwrite"]
    assert words in endocal("export", *names).fails(code)


def test_of_two_maps_neither_is_left_where_one_exists(endocal: Runner, folder: Path) -> None:
    (folder / "out-y.pgm").write_text("precious")
    assert "out-y.pgm: exists already" in export(endocal, folder, "ffmpeg").fails()
    assert not (folder / "out-x.pgm").exists()
    assert (folder / "out-y.pgm").read_text() == "precious"


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (None, "no such file: check its name"),
        (b"", "is empty"),
        (b"\xff\xfe\x00\x01", "it is no text"),
        (b"a: 1\n", "camera_matrix holds 0 numbers"),
        (CALIBRATION.encode(), "cam.yaml: "),
        (b"x" * (2 << 20), "too large"),
    ],
)
def test_import_of_what_is_no_calibration(
    endocal: Runner, folder: Path, data: bytes | None, words: str
) -> None:
    if data is not None:
        (folder / "cam.yaml").write_bytes(data)
    before = set(folder.iterdir())
    assert words in endocal("import", folder / "cam.yaml", "-o", folder / "out.toml").fails()
    assert set(folder.iterdir()) == before


@pytest.mark.parametrize(
    ("options", "code", "words"),
    [
        (["--model", "cubic"], 2, "--model cubic"),
        (["--circle", "1,2"], 2, "give 3 numbers"),
        (["--circle", "1,2,0"], 1, "no visible circle"),
        (["--size", "32x24"], 1, "another size"),
    ],
)
def test_import_options_that_make_no_sense(
    endocal: Runner, folder: Path, options: list[str], code: int, words: str
) -> None:
    export(endocal, folder, "ros")
    names = [folder / "out.yml", "-o", folder / "out.toml"]
    assert words in endocal("import", *names, *options).fails(code)
    assert not (folder / "out.toml").exists()
