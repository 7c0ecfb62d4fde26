"""The truths that are written are those of the pictures, and endocal's own files."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest

from endocal.boundary.detect import find_boundary
from endocal.calibration.result import Calibration
from endocal.files import load, read_image
from endocal.jobs.synth import synth_board, synth_clip, synth_zoom, truth_name
from endocal.jobs.synth_scenes import BoardSpec, ClipSpec, ZoomSpec, board_scene
from endocal.jobs.synth_truth import HEADER, true_boundary
from endocal.jobs.zoom_log import RecordedZoom
from endocal.model import DivisionModel
from endocal.synth.camera import ContentCircle
from endocal.zoom.table import ZoomTable


def test_a_board_and_its_truth(tmp_path: Path) -> None:
    spec = BoardSpec(size=(400, 300), lam=-4e-6, center=(210.0, 140.0), diameter=290.0, noise=0)
    picture = tmp_path / "b.png"
    synth_board(board_scene(spec), str(picture))
    truth = load(truth_name(str(picture), ".toml"))
    assert isinstance(truth, Calibration)
    assert truth.model == DivisionModel(-4e-6, (210.0, 140.0), (400, 300))
    assert read_image(picture).shape == (300, 400, 3)
    found = find_boundary(read_image(picture))
    assert found is not None
    assert truth.boundary is not None
    assert found.diameter == pytest.approx(290.0, abs=0.5)
    np.testing.assert_allclose(found.center, truth.boundary.center, atol=0.3)


def test_a_board_without_a_circle_has_none_in_its_truth(tmp_path: Path) -> None:
    scene = board_scene(BoardSpec(size=(320, 240), diameter=0))
    truth = synth_board(scene, str(tmp_path / "b.png"))
    assert truth.boundary is None
    read = load(tmp_path / "b.truth.toml")
    assert isinstance(read, Calibration)
    assert read.boundary is None
    assert read.model.lam == pytest.approx(truth.model.lam, rel=1e-8)


def test_boards_over_the_zoom_and_their_table(tmp_path: Path) -> None:
    spec = ZoomSpec(zooms=(1.0, 1.4, 2.0), size=(320, 240), squares=(9, 7), noise=0, strength=-1.1)
    pictures = synth_zoom(spec, str(tmp_path / "z"))
    assert [Path(p).name for p in pictures] == ["board-1.png", "board-2.png", "board-3.png"]
    table = load(tmp_path / "z" / "zoom.truth.toml")
    assert isinstance(table, ZoomTable)
    assert table.law.lambda_diameter2 == pytest.approx(-1.1)
    for picture, setting, zoom in zip(pictures, table.settings, spec.zooms, strict=True):
        truth = load(truth_name(picture, ".toml"))
        assert isinstance(truth, Calibration)
        assert truth.boundary is not None
        assert truth.model.lam == pytest.approx(setting.lam)
        assert truth.model.center == pytest.approx(setting.center)
        assert truth.boundary.diameter == pytest.approx(0.8 * 240 * zoom)
        assert truth.boundary.area == pytest.approx(setting.area, rel=1e-6)


def test_area_and_visible_share_of_a_circle() -> None:
    model = DivisionModel(0.0, (100.0, 100.0), (201, 201))
    whole = true_boundary(ContentCircle((100.0, 100.0), 150.0), model)
    assert whole.visible == 1
    assert whole.area == pytest.approx(np.pi * 75**2, rel=1e-3)
    # Cut on all sides: each side loses a segment whose half angle is acos(100.5 / 120).
    cut = true_boundary(ContentCircle((100.0, 100.0), 240.0), model)
    half = np.arccos(100.5 / 120)
    assert cut.visible == pytest.approx(1 - 8 * half / (2 * np.pi), abs=2e-3)
    segment = 120**2 * (half - np.sin(half) * np.cos(half))
    assert cut.area == pytest.approx(np.pi * 120**2 - 4 * segment, rel=1e-3)


def test_a_clip_and_the_truth_of_each_frame(tmp_path: Path) -> None:
    spec = ClipSpec(
        zooms=(1.0, 1.5), size=(160, 128), duration=1.0, scene="tissue", sound="clicks", noise=1.0
    )
    seen: list[int] = []
    path = tmp_path / "c.mp4"
    count = synth_clip(spec, str(path), progress=lambda p: seen.append(p.frames))
    assert count == 25
    assert seen == list(range(1, 26))
    text = (tmp_path / "c.truth.csv").read_text()
    assert text.startswith(HEADER + "\n")
    rows = list(csv.DictReader(text.splitlines()))
    table = load(tmp_path / "c.truth.toml")
    assert isinstance(table, ZoomTable)
    with av.open(str(path)) as container:
        assert [(f.width, f.height) for f in container.decode(video=0)] == [(160, 128)] * 25
    assert len(rows) == 25
    recorded = RecordedZoom(str(tmp_path / "c.truth.csv"))
    for i, row in enumerate(rows):
        assert recorded.diameter(i, i / 25) == pytest.approx(float(row["diameter"]), rel=1e-5)
        assert int(row["frame"]) == i
        assert float(row["time"]) == pytest.approx(i / 25, abs=1e-6)
        # The table at the frame's diameter is the frame's own truth.
        model = table.at_diameter(float(row["diameter"]))
        assert float(row["lambda"]) == pytest.approx(model.lam, rel=1e-6)
        np.testing.assert_allclose(
            (float(row["center_x"]), float(row["center_y"])), model.center, atol=1e-4
        )


def test_a_clip_at_one_zoom_has_a_calibration_for_truth(tmp_path: Path) -> None:
    spec = ClipSpec(zooms=(1.2,), size=(160, 128), duration=0.2, instruments=0, sound="none")
    assert synth_clip(spec, str(tmp_path / "c.mp4")) == 5
    assert isinstance(load(tmp_path / "c.truth.toml"), Calibration)


def test_commands_write_the_same_bytes_each_time(
    tmp_path: Path, endocal: Callable[..., Any]
) -> None:
    lines = {
        "board": ["--size", "200x160", "--noise", "3"],
        "clip": ["--size", "160x128", "--duration", "0.2", "--fps", "30000/1001"],
    }
    for name, options in lines.items():
        suffix = ".png" if name == "board" else ".mp4"
        made = []
        for run in ("1", "2"):
            output = tmp_path / (name + run + suffix)
            result = endocal("synth", name, "-o", output, *options, "--seed", "5")
            assert result.code == 0, result.err
            assert not result.out
            made.append(output.read_bytes())
        assert made[0] == made[1]


def test_json_says_what_was_made(tmp_path: Path, endocal: Callable[..., Any]) -> None:
    import json

    output = tmp_path / "r.png"
    line = json.loads(
        endocal("synth", "board", "--random", "--seed", "6", "-o", output, "--json").out
    )
    truth = load(line["truth"])
    assert isinstance(truth, Calibration)
    assert line["lambda"] == pytest.approx(truth.model.lam)
    assert line["size"] == list(truth.model.size)
    assert read_image(output).shape[:2] == truth.model.size[::-1]
    made = json.loads(
        endocal(
            "synth", "zoom", "-o", tmp_path / "z", "--zooms", "1,2", "--size", "96x96", "--json"
        ).out
    )
    assert [Path(p).exists() for p in made["pictures"]] == [True, True]


@pytest.mark.parametrize(
    ("code", "args"),
    [
        (2, ["board", "-o", "-"]),
        (2, ["board", "-o", "x.png", "--random", "--tilt", "3"]),
        (2, ["board", "-o", "x.png", "--lambda", "-1e-3"]),
        (2, ["board", "-o", "x.png", "--tilt", "89", "--share", "0.95"]),
        (2, ["board", "-o", "x.png", "--pattern", "dots"]),
        (2, ["board", "-o", "x.png", "--jpeg", "0"]),
        (2, ["board", "-o", "x.png", "--blur", "-1"]),
        (2, ["board", "-o", "x.png", "--gamma", "0"]),
        (2, ["board", "-o", "x.png", "--size", "20000x20000"]),
        (2, ["board", "-o", "x.png", "--center", "9,nan"]),
        (1, ["board", "-o", "x.gif"]),
        (1, ["board", "-o", "no/x.png"]),
        (1, ["board", "-o", "there.png"]),
        (2, ["zoom", "-o", "z", "--zooms", "1,1"]),
        (2, ["zoom", "-o", "z", "--zooms", "1,0"]),
        (2, ["zoom", "-o", "z", "--strength", "-9"]),
        (1, ["zoom", "-o", "there.png"]),
        (1, ["zoom", "-o", "no/z"]),
        (2, ["clip", "-o", "x.mp4", "--size", "161x128"]),
        (2, ["clip", "-o", "x.mp4", "--size", "96x96"]),
        (2, ["clip", "-o", "x.nothing"]),
        (2, ["clip", "-o", "x.mp4", "--fps", "1/0"]),
        (2, ["clip", "-o", "x.mp4", "--scene", "moon"]),
        (2, ["clip", "-o", "x.mp4", "--sound", "song"]),
        (2, ["clip", "-o", "x.mp4", "--duration", "0"]),
        (2, ["clip", "-o", "x.mp4", "--instruments", "-1"]),
        (2, ["clip", "-o", "x.mp4", "--noise", "-1"]),
        (2, ["clip", "-o", "x.mp4", "--approach", "2"]),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else str(value),
)
def test_what_makes_no_sense_is_refused_in_one_line(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    endocal: Callable[..., Any],
    code: int,
    args: list[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "there.png").write_bytes(b"mine")
    endocal("synth", *args).fails(code)
    left = [p for p in tmp_path.rglob("*") if p.name != "z"]
    assert [p.name for p in left] == ["there.png"]
    assert left[0].read_bytes() == b"mine"
