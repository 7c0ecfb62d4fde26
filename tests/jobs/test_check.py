"""A recorded calibration, made again: what moved, how far it may, and pictures that prove themselves."""

from __future__ import annotations

import hashlib
import os
import re
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from endocal.calibration import lens_fit
from endocal.calibration.result import Calibration, Source, Uncertainty
from endocal.calibration.spec import CalibrationSpec
from endocal.errors import InputError, UsageError
from endocal.files import load, save
from endocal.jobs import check as job
from endocal.jobs.calibrate import calibrate_files
from endocal.jobs.check import CheckReport, CheckSpec, check


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory, sample_data: Path) -> Path:
    """A folder with a picture, board-1.png, and its calibration, cal.toml."""
    folder = tmp_path_factory.mktemp("recorded")
    shutil.copy(sample_data / "board-1.png", folder)
    save(calibrate_files([folder / "board-1.png"]), folder / "cal.toml")
    return folder


@pytest.fixture
def folder(recorded: Path, tmp_path: Path) -> Path:
    """A copy of that folder to spoil."""
    return Path(shutil.copytree(recorded, tmp_path / "copy"))


@pytest.fixture
def again(recorded: Path, monkeypatch: pytest.MonkeyPatch) -> list[CalibrationSpec]:
    """Let the calibration repeat itself at once; its options are appended to the list."""
    calibration = load(recorded / "cal.toml")
    asked: list[CalibrationSpec] = []

    def repeat(paths: list[Path], spec: CalibrationSpec) -> object:
        asked.append(spec)
        return calibration

    monkeypatch.setattr(job, "calibrate_files", repeat)
    return asked


def edited(file: Path, **changes: object) -> Calibration:
    """Write the calibration with some fields replaced, and return it."""
    calibration = load(file)
    assert isinstance(calibration, Calibration)
    calibration = replace(calibration, **changes)
    save(calibration, file, overwrite=True)
    return calibration


def edited_by_hand(file: Path, **changes: object) -> None:
    """As ``edited``, and let the file state that it is sure of nothing, with no number rounded by that."""
    edited(file, **changes)
    before, after = file.read_text().split("[uncertainty]")
    after = re.sub(r"^(lambda2?) = \S+", r"\1 = 1e300", after, flags=re.MULTILINE)
    after = re.sub(r"^center = .*\]", "center = [1e300, 1e300]", after, count=1, flags=re.MULTILINE)
    file.write_text(f"{before}[uncertainty]{after}")


def run(folder: Path, **options: object) -> CheckReport:
    return check(CheckSpec(str(folder / "cal.toml"), **options))  # type: ignore[arg-type]


def test_the_same_pictures_give_the_same_numbers(recorded: Path) -> None:
    report = run(recorded)
    assert not report.failures
    assert [n.name for n in report.numbers] == ["lambda", "center x", "center y"]
    # On one machine nothing differs; the tolerance is for other machines.
    assert all(n.moved == 0 < n.allowed for n in report.numbers)
    assert report.recorded_verdict == report.found_verdict == "good"
    assert report.pictures == (str(recorded / "board-1.png"),)


def test_the_recorded_options_are_used(folder: Path) -> None:
    spec = CalibrationSpec(refine=False, center="image", samples=6, sobel=11)
    file = folder / "other.toml"
    save(calibrate_files([folder / "board-1.png"], spec), file)
    report = check(CheckSpec(str(file)))
    assert not report.failures
    assert report.numbers[1].found == 359.5  # the middle of 720 px
    by_default = check(CheckSpec(str(folder / "cal.toml")))
    assert report.numbers[0].found != by_default.numbers[0].found


@pytest.mark.parametrize("sigmas", [0.05, 0.3])
@pytest.mark.parametrize("name", ["lambda", "center x", "center y"])
def test_a_number_that_moved_is_named(
    folder: Path, again: list[CalibrationSpec], name: str, sigmas: float
) -> None:
    file = folder / "cal.toml"
    calibration = load(file)
    model, sigma = calibration.model, calibration.uncertainty
    x, y = model.center
    moved = {
        "lambda": replace(model, lam=model.lam + sigmas * sigma.lam),
        "center x": replace(model, center=(x + sigmas * sigma.center[0], y)),
        "center y": replace(model, center=(x, y + sigmas * sigma.center[1])),
    }[name]
    edited(file, model=moved)
    failing = [n.name for n in run(folder).numbers if not n.passed]
    assert failing == ([name] if sigmas > 0.1 else [])
    assert not run(folder, tolerance=0.5).failures


@pytest.mark.parametrize("axis", [0, 1])
def test_each_axis_of_the_centre_has_its_own_tolerance(
    folder: Path, monkeypatch: pytest.MonkeyPatch, axis: int
) -> None:
    sigma = Uncertainty(1e-9, (0.3, 0.01) if axis else (0.01, 0.3))
    found = edited(folder / "cal.toml", uncertainty=sigma)
    monkeypatch.setattr(job, "calibrate_files", lambda paths, spec: found)
    # Half a standard deviation of the surer axis is next to nothing of the other.
    x, y = found.model.center
    edited(folder / "cal.toml", model=replace(found.model, center=(x + 0.005, y + 0.005)))
    failing = [n.name for n in run(folder).numbers if not n.passed]
    assert failing == [f"center {'xy'[axis]}"]


@pytest.mark.parametrize("name", ["lambda", "center x", "center y"])
def test_an_uncertainty_edited_by_hand_allows_no_more(
    folder: Path, again: list[CalibrationSpec], name: str
) -> None:
    calibration = load(folder / "cal.toml")
    x, y = calibration.model.center
    changes: dict[str, Any] = {
        "lambda": {"lam": 0.99 * calibration.model.lam},
        "center x": {"center": (x + 1, y)},
        "center y": {"center": (x, y + 1)},
    }
    edited_by_hand(folder / "cal.toml", model=replace(calibration.model, **changes[name]))
    failing = [n.name for n in run(folder).numbers if not n.passed]
    assert failing == [name]


@pytest.mark.parametrize("uncertainty", [None, Uncertainty(1e-9, (0.01, 0.01), None)])
def test_a_second_lambda_that_is_gone_is_missed_however_unsure_it_was(
    folder: Path, monkeypatch: pytest.MonkeyPatch, uncertainty: Uncertainty | None
) -> None:
    calibration = load(folder / "cal.toml")
    found = replace(calibration, uncertainty=uncertainty)
    monkeypatch.setattr(job, "calibrate_files", lambda paths, spec: found)
    edited_by_hand(
        folder / "cal.toml",
        model=replace(calibration.model, lam2=1e-16),
        uncertainty=replace(calibration.uncertainty, lam2=1e-19),
    )
    assert [n.name for n in run(folder).numbers if not n.passed] == ["lambda2"]


def test_the_second_lambda_is_compared_too(folder: Path, again: list[CalibrationSpec]) -> None:
    calibration = load(folder / "cal.toml")
    model = replace(calibration.model, lam2=1e-16)
    sigma = replace(calibration.uncertainty, lam2=1e-19)
    edited(folder / "cal.toml", model=model, uncertainty=sigma)
    report = run(folder)
    number = report.numbers[1]
    assert (number.name, number.passed) == ("lambda2", False)
    assert number.allowed == pytest.approx(1e-20)
    assert again[0].model == "division2"


def test_without_stated_uncertainty_a_share_stands_in(
    folder: Path, again: list[CalibrationSpec]
) -> None:
    lam = edited(folder / "cal.toml", uncertainty=None).model.lam
    allowed = [n.allowed for n in run(folder).numbers]
    assert allowed == pytest.approx([abs(lam) / 1000, 0.1, 0.1])


def test_a_centre_that_was_given_must_not_move_at_all(
    folder: Path, again: list[CalibrationSpec]
) -> None:
    lam = load(folder / "cal.toml").uncertainty.lam
    edited(folder / "cal.toml", uncertainty=Uncertainty(lam, (0.0, 0.0)))
    report = run(folder)
    assert not report.failures
    assert report.numbers[1].allowed == 0


def test_pictures_are_found_below_a_folder_by_name_and_content(
    folder: Path, again: list[CalibrationSpec]
) -> None:
    pictures = folder / "pictures"
    (pictures / "right").mkdir(parents=True)
    (pictures / "a wrong one").mkdir()
    (pictures / "a wrong one" / "board-1.png").write_bytes(
        (folder / "board-1.png").read_bytes() + b"\n"
    )
    shutil.move(folder / "board-1.png", pictures / "right")
    report = run(folder, images=str(pictures))
    assert report.pictures == (str(pictures / "right" / "board-1.png"),)


def test_another_picture_of_that_name_is_refused(folder: Path) -> None:
    with open(folder / "board-1.png", "ab") as file:
        file.write(b"\n")
    with pytest.raises(
        InputError, match=r"board-1\.png: is not the picture that .*SHA-256 differs"
    ):
        run(folder)


@pytest.mark.parametrize("images", [None, "."])
@pytest.mark.parametrize("name", [b"board \xff.png", b"board ?.png"])
def test_a_name_that_is_no_text_is_found_again(
    folder: Path, again: list[CalibrationSpec], name: bytes, images: str | None
) -> None:
    """Such bytes of a name are recorded as question marks, and the SHA-256 tells who else is called so."""
    calibration = load(folder / "cal.toml")
    data = (folder / "board-1.png").read_bytes()
    (folder / "board-1.png").unlink()
    try:
        (folder / os.fsdecode(name)).write_bytes(data)
        (folder / os.fsdecode(b"board \xfe.png")).write_bytes(data + b"\n")
    except OSError:
        pytest.skip("names are text on this file system")
    image = replace(calibration.source.images[0], file=os.fsdecode(name))
    edited(folder / "cal.toml", source=replace(calibration.source, images=(image,)))
    report = run(folder, images=None if images is None else str(folder))
    assert report.pictures == (str(folder / os.fsdecode(name)),)


@pytest.mark.parametrize("images", [None, "pictures"])
def test_a_missing_picture_is_named(folder: Path, images: str | None) -> None:
    (folder / "board-1.png").unlink()
    (folder / "pictures").mkdir()
    where = None if images is None else str(folder / images)
    with pytest.raises(InputError, match=r"its picture board-1\.png is not .*--images DIR"):
        run(folder, images=where)


def test_a_missing_folder_is_named(folder: Path) -> None:
    with pytest.raises(InputError, match="nowhere: no such folder of pictures: check its name"):
        run(folder, images=str(folder / "nowhere"))


def test_a_picture_without_a_sum_proves_nothing(folder: Path) -> None:
    calibration = load(folder / "cal.toml")
    image = replace(calibration.source.images[0], sha256="")
    edited(folder / "cal.toml", source=replace(calibration.source, images=(image,)))
    with pytest.raises(InputError, match=r"no SHA-256 of board-1\.png"):
        run(folder)


def test_a_sum_in_capitals_is_the_same_sum(folder: Path, again: list[CalibrationSpec]) -> None:
    calibration = load(folder / "cal.toml")
    sha256 = hashlib.sha256((folder / "board-1.png").read_bytes()).hexdigest().upper()
    image = replace(calibration.source.images[0], sha256=sha256)
    edited(folder / "cal.toml", source=replace(calibration.source, images=(image,)))
    assert not run(folder).failures


@pytest.mark.parametrize("source", [None, Source()])
def test_a_calibration_that_names_no_picture_is_refused(
    folder: Path, source: Source | None
) -> None:
    edited(folder / "cal.toml", source=source)
    with pytest.raises(InputError, match="names no picture"):
        run(folder)


def test_a_zoom_table_is_refused(sample_data: Path) -> None:
    with pytest.raises(InputError, match="is a zoom table; check the calibrations"):
        check(CheckSpec(str(sample_data / "zoom.truth.toml")))


def test_an_option_that_makes_no_sense_is_the_files_fault(folder: Path) -> None:
    source = load(folder / "cal.toml").source
    edited(folder / "cal.toml", source=replace(source, options={"samples": 1}))
    with pytest.raises(InputError, match=r"cal\.toml: \[source\] .*samples 1"):
        run(folder)


def test_a_frame_size_that_is_not_the_pictures_is_told(
    folder: Path, again: list[CalibrationSpec]
) -> None:
    model = load(folder / "cal.toml").model
    edited(folder / "cal.toml", model=replace(model, size=(724, 540)))
    with pytest.raises(InputError, match="size is 724x540, but its pictures are 720x540"):
        run(folder)


@pytest.mark.parametrize("before", ["good", "failed"])
def test_a_verdict_that_is_failed_now_fails(
    folder: Path, monkeypatch: pytest.MonkeyPatch, before: str
) -> None:
    calibration = load(folder / "cal.toml")
    failed = replace(calibration, quality=replace(calibration.quality, verdict="failed"))
    monkeypatch.setattr(job, "calibrate_files", lambda paths, spec: failed)
    edited(folder / "cal.toml", quality=replace(calibration.quality, verdict=before))
    assert bool(run(folder).failures) == (before == "good")


@pytest.mark.parametrize("tolerance", [-1.0, float("nan"), float("inf")])
def test_a_tolerance_is_a_number_from_zero(tolerance: float) -> None:
    with pytest.raises(UsageError, match="--tolerance"):
        CheckSpec("cal.toml", tolerance=tolerance)


def test_two_parameters_of_which_one_was_lost_are_sought_again(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plain = lens_fit.refine

    def one_parameter(*arguments: Any) -> Any:
        return plain(*arguments) if len(arguments) == 4 else []

    asked: list[CalibrationSpec] = []

    def told(paths: list[Path], spec: CalibrationSpec) -> Calibration:
        asked.append(spec)
        return calibrate_files(paths, spec)

    monkeypatch.setattr(lens_fit, "refine", one_parameter)
    monkeypatch.setattr(job, "calibrate_files", told)
    spec = CalibrationSpec(model="division2")
    save(calibrate_files([folder / "board-1.png"], spec), folder / "cal.toml", overwrite=True)
    assert 'type = "division" ' in (folder / "cal.toml").read_text()
    report = run(folder, tolerance=0)
    assert asked == [replace(spec, pixel_aspect=1.0)]
    assert not report.failures
    assert report.found_verdict == report.recorded_verdict == "doubtful"
