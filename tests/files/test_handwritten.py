"""Files that people write: the short ones that will do, and the wrong ones, each refused by name."""

from __future__ import annotations

from pathlib import Path

import pytest

from endocal.calibration.result import Calibration
from endocal.errors import InputError
from endocal.files import load, loads
from endocal.model import DivisionModel
from endocal.zoom.table import ZoomTable

HAND_WRITTEN = """
schema = "endocal.calibration/1"
[model]
type = "division"
lambda = -2.83e-6
center = [388.6, 275]
size = [768, 576]
"""
HAND_WRITTEN_TABLE = """
schema = "endocal.zoomtable/1"
size = [720, 540]
[[setting]]
lambda = -1.2742e-5
center = [360, 270.5]
diameter = 312
[[setting]]
lambda = -2.9644e-5
center = [360, 270.5]
diameter = 210
area = 34000
"""


def test_a_person_can_write_a_calibration() -> None:
    expected = DivisionModel(-2.83e-6, (388.6, 275.0), (768, 576))
    assert loads(HAND_WRITTEN) == Calibration(expected)


def test_a_person_can_write_a_table() -> None:
    table = loads(HAND_WRITTEN_TABLE)
    assert isinstance(table, ZoomTable)
    assert [s.diameter for s in table.settings] == [210, 312]
    assert [s.area for s in table.settings] == [34000, None]


def test_a_byte_order_mark_is_no_matter(tmp_path: Path) -> None:
    (tmp_path / "cal.toml").write_text(HAND_WRITTEN, encoding="utf-8-sig")
    assert load(tmp_path / "cal.toml") == loads(HAND_WRITTEN)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('schema = "endocal.calibration/1"', "", "no key schema"),
        ("calibration/1", "calibration/2", 'schema "endocal.calibration/2" is newer'),
        ("calibration/1", "calibration/x", "schema is 'endocal.calibration/x'; it must be"),
        ("endocal.calibration/1", "other.thing/1", "schema is 'other.thing/1'; it must be"),
        ('"endocal.calibration/1"', "1", "schema is 1; it must be a string"),
        ("[model]", "[modell]", r"model is missing; is modell meant for it\?"),
        ("[model]", "model = 3\n[other]", "model is 3; it must be a table"),
        ("type", "typ", r"\[model\] type is missing"),
        (
            '"division"',
            '"brown"',
            r'\[model\] type is .brown.; it must be "division" or "division2"',
        ),
        ('"division"', "[1]", r"\[model\] type is \[1\]"),
        ('"division"', '"division2"', r"\[model\] lambda2 is missing"),
        ("center", "lambda2 = 1e-13\ncenter", r'\[model\] lambda2 needs type = "division2"'),
        ("lambda", "lamda", r"\[model\] lambda is missing; is lamda meant for it\?"),
        ("center", "centre", r"\[model\] center is missing; is centre meant for it\?"),
        ("lambda", "lambda = -1e-6\nlamda", r"unknown key \[model\] lamda; did you mean lambda\?"),
        ("size", "k1 = 1\nk2 = 2\nsize", r"unknown keys \[model\] k1, \[model\] k2"),
        ("[model]", '"new\\nline" = 1\n[model]', r"unknown key 'new\\nline'"),
        ("-2.83e-6", "nan", r"\[model\] lambda is nan; it must be a finite number"),
        ("-2.83e-6", "-inf", r"\[model\] lambda is -inf; it must be a finite number"),
        ("-2.83e-6", "1" + "0" * 400, r"\[model\] lambda is 1000.*; it must be a finite number"),
        ("-2.83e-6", "true", r"\[model\] lambda is True; it must be a number"),
        ("-2.83e-6", '"-2.83e-6"', r"\[model\] lambda is '-2.83e-6'; it must be a number"),
        (
            "-2.83e-6",
            "-2.83e-4",
            r"\[model\] lambda -0.000283 folds the picture over 59\.4 px from",
        ),
        ("-2.83e-6", "2.83e-3", r"\[model\] lambda 0\.00283 folds the picture"),
        ("[388.6, 275]", "[388.6]", r"\[model\] center is \[388.6\]; it must be two numbers"),
        ("[388.6, 275]", "[388.6, nan]", r"\[model\] center\[1\] is nan; it must be a finite"),
        ("[388.6, 275]", "[-800, 275]", r"\[model\] the centre \(-800, 275\) lies far outside"),
        ("[768, 576]", "[768.0, 576]", r"\[model\] size is \[768.0, 576\]; it must be .* whole"),
        ("[768, 576]", "[768, 0]", r"\[model\] size is \[768, 0\]"),
        (
            "[768, 576]",
            "[768, 576]\npixel_aspect = 0",
            r"\[model\] pixel_aspect is 0; it must be 0\.1 to 10",
        ),
        ("[768, 576]", "[768, 576]\npixel_aspect = 20", r"\[model\] pixel_aspect is 20; it must"),
        ("[model]", "[uncertainty]\nlambda = 1e-9\n[model]", r"\[uncertainty\] center is missing"),
        (
            "[model]",
            "[uncertainty]\nlambda = -1e-9\ncenter=[1,1]\n[model]",
            r"\[uncertainty\] lambda is -1e-09; it must be 0 or more",
        ),
        (
            "[model]",
            "[boundary]\ncenter=[380,280]\ndiameter=0\n[model]",
            r"\[boundary\] diameter is 0; it must be positive",
        ),
        (
            "[model]",
            "[boundary]\ncenter=[380,280]\ndiameter=700\nvisible=2\n[model]",
            r"\[boundary\] visible is 2; it must be 0 to 1",
        ),
        (
            "[model]",
            "[boundary]\ncenter=[2000,280]\ndiameter=700\n[model]",
            "boundary circle lies outside the 768x576 frame",
        ),
        (
            "[model]",
            '[quality]\nverdict="fine"\n[model]',
            r"\[quality\] verdict is 'fine'; it must",
        ),
        (
            "[model]",
            '[quality]\nverdict="good"\nlines=2.5\n[model]',
            r"\[quality\] lines is 2.5; it must be a whole number",
        ),
        ("[model]", "[source]\nrefined=1\n[model]", r"\[source\] refined is 1; it must be true or"),
        (
            "[model]",
            "[source]\nimages=[3]\n[model]",
            r"\[source\] images is \[3\]; it must be a list",
        ),
        (
            "[model]",
            '[source]\nimages=[{file="a"}, {fil="a"}]\n[model]',
            r"\[source\] images, number 2: file is missing",
        ),
        ("[model]", "[model", "not a TOML document"),
        ("-2.83e-6", "[" * 5000, "not a TOML document: nested too deeply"),
    ],
)
def test_a_wrong_calibration_is_named(tmp_path: Path, old: str, new: str, message: str) -> None:
    assert old in HAND_WRITTEN
    check_refused(tmp_path, HAND_WRITTEN.replace(old, new, 1), message)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("zoomtable/1", "zoomtable/7", 'schema "endocal.zoomtable/7" is newer'),
        ("size", "sizes", "size is missing"),
        ("size", "pixel_aspect = 0.05\nsize", r"pixel_aspect is 0\.05; it must be 0\.1 to 10"),
        ("diameter = 210", "", r"\[\[setting\]\] number 2: diameter is missing"),
        (
            "diameter = 210",
            "diameter = -210",
            r"\[\[setting\]\] number 2: .* -210 is not a positive",
        ),
        ("diameter = 210", "diameter = 312", "same diameter"),
        (
            "area = 34000",
            "areas = 34000",
            r"unknown key \[\[setting\]\] number 2: areas; did you mean",
        ),
        ("-2.9644e-5", "nan", r"\[\[setting\]\] number 2: lambda is nan"),
        ("-2.9644e-5", "-1.5e-5", "law"),
        ("-2.9644e-5", "-2.9644e-3", "folds"),
        ("area = 34000", 'source = {files="a"}', r"number 2: source, file is missing"),
        ("[[setting]]", "[law]\nspread=nan\n[[setting]]", r"\[law\] spread is nan"),
        ("[[setting]]", "[law]\nlambda=1\n[[setting]]", r"unknown key \[law\] lambda"),
    ],
)
def test_a_wrong_table_is_named(tmp_path: Path, old: str, new: str, message: str) -> None:
    assert old in HAND_WRITTEN_TABLE
    check_refused(tmp_path, HAND_WRITTEN_TABLE.replace(old, new, 1), message)


def check_refused(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "the file.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=message) as caught:
        load(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "is empty: take another copy"),
        (b" \n", "is empty"),
        (b"\x89PNG\r\n\x1a\n\xff\xfe", "it is no text"),
        (b"# \n" * 2_000_000, "too large"),
        (b"\x00", "not a TOML document"),
    ],
)
def test_a_file_that_is_no_calibration(tmp_path: Path, data: bytes, message: str) -> None:
    path = tmp_path / "cal.toml"
    path.write_bytes(data)
    with pytest.raises(InputError, match=message):
        load(path)


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no such file: check its name$"):
        load(tmp_path / "cal.toml")
    with pytest.raises(InputError, match="is a directory"):
        load(tmp_path)
    with pytest.raises(InputError, match="null"):
        load("cal\0.toml")


@pytest.mark.parametrize("stated", ["-1.3", "-1.31", "-1.24"])
def test_a_law_that_contradicts_its_settings_is_refused(stated: str) -> None:
    """The settings give about -1.27: one per cent is rounding, more is a contradiction."""
    text = HAND_WRITTEN_TABLE.replace(
        "[[setting]]", f"[law]\nlambda_diameter2 = {stated}\n[[setting]]", 1
    )
    with pytest.raises(InputError, match=r"\[law\] lambda_diameter2 is .*, but the settings give"):
        loads(text)
    assert isinstance(loads(text.replace(stated, "-1.274")), ZoomTable)
