"""``correct --preview``: the frame that was asked for, the model that correct would use, a straight grid."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from endocal.calibration.result import Calibration
from endocal.errors import UsageError
from endocal.files import load, save, write_image
from endocal.jobs.before_after import CELLS, before_after
from endocal.jobs.instant import Instant
from endocal.model import DivisionModel
from endocal.remap.geometry import output_geometry
from endocal.zoom.table import ZoomTable

Runner = Callable[..., Any]


@pytest.fixture(scope="module")
def clip(sample_data: Path) -> Path:
    return sample_data / "clip.mp4"


@pytest.fixture(scope="module")
def table(sample_data: Path) -> Path:
    return sample_data / "zoom.truth.toml"


@pytest.mark.parametrize(
    ("text", "instant"),
    [
        ("250", Instant(frame=250)),
        ("0", Instant(frame=0)),
        ("12.5s", Instant(time=12.5)),
        ("12.5", Instant(time=12.5)),
        ("3s", Instant(time=3.0)),
        ("1:02", Instant(time=62.0)),
        ("1:02:03.5", Instant(time=3723.5)),
        ("90:00", Instant(time=5400.0)),
    ],
)
def test_an_instant_is_a_frame_or_a_time(text: str, instant: Instant) -> None:
    assert Instant.parse(text) == instant


@pytest.mark.parametrize("text", ["", "-1", "x", "1:60", "1:2:3:4", "nan", "infs", "1h", "-1s"])
def test_what_is_no_instant_is_told(text: str) -> None:
    with pytest.raises(UsageError, match="is no instant"):
        Instant.parse(text)


def test_the_grid_is_straight_after_and_bent_before() -> None:
    model = DivisionModel(-3e-6, (330.0, 250.0), (640, 480))
    geometry = output_geometry([model], [None])
    grey = np.full((480, 640, 3), 100, np.uint8)
    both = before_after(grey, grey, model, geometry, "")
    bar = both.shape[0] - 480
    before, after = both[bar:, :640], both[bar:, -640:]
    green = [p[..., 1].astype(int) - p[..., 2] > 100 for p in (before, after)]
    # Straight: columns and rows that are green all the way, 11 and 9 of them.
    columns, rows = (np.flatnonzero(green[1].mean(axis=axis) > 0.9) for axis in (0, 1))
    assert len(np.split(columns, np.flatnonzero(np.diff(columns) > 1) + 1)) == CELLS - 1
    assert len(np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1)) == 9
    assert not (green[0].mean(axis=0) > 0.9).any()
    # Bent: each green point of the original, undistorted, lies on a line of the grid.
    y, x = np.nonzero(green[0])
    straight = model.undistort(np.stack([x, y], axis=1).astype(float))
    off = np.abs((straight + 0.5 - (320, 240) + 640 / 24) % (640 / 12) - 640 / 24)
    assert np.quantile(off.min(axis=1), 0.99) < 2.5


def test_it_shows_the_frame_that_is_asked_for(
    endocal: Runner, clip: Path, table: Path, tmp_path: Path
) -> None:
    log, out = tmp_path / "log.csv", tmp_path / "all.mp4"
    options = ("-c", table, "--zoom-log", log, "--codec", "mpeg4")
    assert endocal("correct", clip, "-o", out, *options).code == 0
    rows = log.read_text().splitlines()[1:]
    for instant, number in (("75", 75), ("3s", 75), ("3.03", 75), ("0:03", 75), ("0", 0)):
        picture = tmp_path / f"{instant.replace(':', '-')}.png"
        done = endocal("correct", clip, "-o", picture, "-c", table, "--preview", instant, "--json")
        assert done.code == 0, done.err
        report = json.loads(done.out)
        _, time, _, _, lam, *_ = rows[number].split(",")
        assert report["time"] == pytest.approx(float(time), abs=1e-3)
        # The clip is shorter than what is followed before a time, so that all is as in a whole run.
        assert report["lam"] == pytest.approx(float(lam), rel=1e-6)
        assert list(report["size"]) == list(cv2.imread(str(picture)).shape[1::-1])
    import av

    with av.open(str(clip)) as container:
        frames = [f.to_ndarray(format="bgr24") for f in container.decode(video=0)]
    shown = cv2.imread(str(tmp_path / "75.png"))
    before = shown[shown.shape[0] - 480 :, :640].astype(int)
    # Off the grid the frame is as it was decoded; another frame is another picture.
    off = [float(np.median(np.abs(before - frames[i]))) for i in (75, 20)]
    assert off[0] == 0
    assert off[1] > 5


def test_the_end_is_told(endocal: Runner, clip: Path, table: Path, tmp_path: Path) -> None:
    options = ("-o", tmp_path / "a.png", "-c", table, "--preview")
    assert "ends before frame 125" in endocal("correct", clip, *options, "125").fails()
    assert "ends before 5.1 s" in endocal("correct", clip, *options, "5.1").fails()
    assert endocal("correct", clip, *options, "4.99").code == 0


def test_what_does_not_go_together(
    endocal: Runner, clip: Path, table: Path, tmp_path: Path
) -> None:
    options = ("-o", tmp_path / "a.png", "-c", table, "--preview", "3")
    for more in (
        ("--side-by-side",),
        ("--zoom-log", tmp_path / "log.csv"),
        ("--report", tmp_path / "run.html"),
    ):
        endocal("correct", clip, *options, *more).fails(2)
    assert ".mp4" in endocal("correct", clip, "-o", tmp_path / "a.mp4", *options[2:]).fails(2)
    assert not list(tmp_path.iterdir())


def test_a_picture_and_a_pipe(endocal: Runner, sample_data: Path, tmp_path: Path) -> None:
    board, truth = sample_data / "board-2.png", sample_data / "board-2.truth.toml"
    done = endocal("correct", board, "-o", tmp_path / "a.png", "-c", truth, "--preview", "0")
    assert done.code == 0
    both = cv2.imread(str(tmp_path / "a.png"))
    w, h = load(truth).model.size
    assert both.shape[0] > h
    assert both.shape[1] > 2 * w
    done = endocal("correct", board, "-o", "-", "-c", truth, "--preview", "0")
    assert np.array_equal(cv2.imdecode(np.frombuffer(done.output, np.uint8), 1), both)
    assert (
        "is a picture, with no frame 3"
        in endocal(
            "correct", board, "-o", tmp_path / "b.png", "-c", truth, "--preview", "3"
        ).fails()
    )


def test_sixteen_bits_and_a_recorded_zoom(
    endocal: Runner, sample_data: Path, clip: Path, table: Path, tmp_path: Path
) -> None:
    grey = cv2.imread(str(sample_data / "board-2.png"), cv2.IMREAD_GRAYSCALE)
    write_image(tmp_path / "deep.png", grey.astype(np.uint16) * 257)
    truth = sample_data / "board-2.truth.toml"
    options = ("-c", truth, "--preview", "0", "--view", "full")
    assert endocal("correct", tmp_path / "deep.png", "-o", tmp_path / "a.png", *options).code == 0

    lens = load(table)
    assert isinstance(lens, ZoomTable)
    (tmp_path / "zoom.csv").write_text("frame,diameter\n0,500\n100,600\n")
    small = lens.rescale((640, 480))
    save(small, tmp_path / "small.toml")
    for instant in ("50", "2s"):
        done = endocal(
            *("correct", clip, "-o", tmp_path / "b.png", "-c", tmp_path / "small.toml", "--json"),
            *("--preview", instant, "--zoom-from", tmp_path / "zoom.csv", "--overwrite"),
        )
        expected = small.at_diameter((500 * 600) ** 0.5).lam
        assert json.loads(done.out)["lam"] == pytest.approx(expected, rel=1e-9)


def test_both_eyes_are_shown(endocal: Runner, tmp_path: Path) -> None:
    import av

    left, right = (
        DivisionModel(-4e-6, (150.0, 110.0), (320, 240)),
        DivisionModel(0.0, (160.0, 120.0), (320, 240)),
    )
    grey = np.tile(np.arange(320, dtype=np.uint8) // 2 + 40, (240, 2))
    with av.open(str(tmp_path / "in.mkv"), "w") as out:
        stream = out.add_stream("ffv1", 25, width=640, height=240, pix_fmt="gray")
        for _ in range(3):
            out.mux(stream.encode(av.VideoFrame.from_ndarray(grey, "gray")))
        out.mux(stream.encode())
    for name, model in (("left", left), ("right", right)):
        save(Calibration(model), tmp_path / f"{name}.toml")
    done = endocal(
        *("correct", tmp_path / "in.mkv", "-o", tmp_path / "a.png", "--stereo", "sbs", "--preview"),
        *("2", "-c", tmp_path / "left.toml", "-c", tmp_path / "right.toml"),
    )
    assert done.code == 0, done.err
    eyes = np.split(cv2.imread(str(tmp_path / "a.png")), 2)
    # The right eye has no distortion: before and after are alike, grid and all. The left's are not.
    differences = [
        np.abs(eye[-240:, :320].astype(int) - eye[-240:, -320:]).max(axis=2) for eye in eyes
    ]
    assert (differences[0] > 30).mean() > 0.05
    assert (differences[1] > 30).mean() < 0.01
