"""The benchmark on pictures with corners that are known: here one that is made, in the real folder's form."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest

from endocal.benchmarks import real_boards
from endocal.benchmarks.real_boards import Picture, Score
from endocal.errors import InputError
from endocal.files import write_image
from endocal.model import DivisionModel
from endocal.synth.board import BoardScene, render_board, true_corners
from endocal.synth.camera import Camera
from endocal.synth.framing import covering
from endocal.synth.pattern import Pattern, Pose

MODEL = DivisionModel(-3e-6, (322.0, 238.0), (640, 480))
SCORE = Score("good", (), -1e-6, None, (320.0, 240.0), s=0.2, floor=0.1)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with one lens of two pictures: one with corners in the list, one without."""
    root = tmp_path_factory.mktemp("boards")
    (root / "lens").mkdir()
    pose = Pose((320.0, 240.0), 1.0, tilt=12, tilt_axis=40, rotation=8, focal=370)
    scene = covering(BoardScene(MODEL, Pattern("chessboard", 9, 8), pose, camera=Camera(0.7)), 0.6)
    assert scene is not None
    for name in ("listed.png", "other.png"):
        write_image(root / "lens" / name, render_board(scene))
    corners, seen = true_corners(scene)
    assert seen.all()
    entry = {
        "grid": [corners.shape[0], corners.shape[1]],
        "corners": corners.reshape(-1, 2).tolist(),
        "floor_division": 0.01,
        "floor_division2": 0.01,
    }
    (root / "corners.json").write_text(json.dumps({"lens/listed.png": entry}))
    return root


def test_a_good_calibration_scores_near_nothing(folder: Path) -> None:
    listed, other = real_boards.run(folder)
    assert (listed.file, other.file) == ("listed.png", "other.png")
    for score in listed.scores.values():
        # 0.1 % of this lambda bends these lines by 0.02 px, and a tenth of a px of the centre by less.
        assert score.s < 0.03 < 1 < listed.uncorrected
        assert score.ratio == score.s / 0.01
        assert score.lam == pytest.approx(MODEL.lam, rel=0.02)
    # The other's corners were found, not given: to a tenth of a px or better.
    assert other.uncorrected == pytest.approx(listed.uncorrected, rel=0.02)
    assert other.scores["division"].s < 0.1
    assert other.scores["division"].ratio is None
    json.dumps([listed.data(), other.data()], allow_nan=False)


def test_no_pictures_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "corners.json").write_text("{}")
    with pytest.raises(InputError, match="no pictures"):
        real_boards.run(tmp_path)


def test_the_median_of_a_lens() -> None:
    def picture(s: float | None, lens: str = "a", floor: float | None = 0.1) -> Picture:
        score = replace(SCORE, s=s, floor=floor)
        return Picture(lens, "x.png", (640, 480), 1.0, {"division": score})

    pictures = (
        picture(0.1),
        picture(0.3),
        picture(0.2),
        picture(9.0, "b"),
        picture(1.0, "c", None),
    )
    assert real_boards.median_ratio(pictures, "a", "division") == pytest.approx(2)
    assert real_boards.median_ratio(pictures, "c", "division") is None
    # A picture where nothing was found is the worst there is.
    lost = (picture(None), picture(None), picture(0.1))
    assert real_boards.median_ratio(lost, "a", "division") == math.inf


def test_a_folded_corner_is_written_as_none() -> None:
    picture = Picture("a", "x.png", (640, 480), 1.0, {"division": replace(SCORE, s=math.inf)})
    data = json.loads(json.dumps(picture.data(), allow_nan=False))
    assert data["scores"]["division"]["s"] is None
