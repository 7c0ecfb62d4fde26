"""Manifests: the calibration of each recording, by name, by pattern, by serial number."""

from __future__ import annotations

from pathlib import Path

import pytest

from endocal.batch.manifest import read_manifest
from endocal.batch.recording import BatchSpec
from endocal.batch.sources import find_recordings
from endocal.errors import InputError, UsageError

HEAD = 'schema = "endocal.manifest/1"\n'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Recordings of two scopes, and their calibrations."""
    for name in (
        *("raw/2026_A1_x.mp4", "raw/2026_B2_y.mp4", "raw/deep/2025_A1_z.mp4", "raw/plain.mp4"),
        *("cal/A1.toml", "cal/B2.toml", "cal/other.toml"),
    ):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    return tmp_path


def read(folder: Path, text: str, name: str = "m.toml") -> dict[str, str | None]:
    """Return the calibration of each recording, both by their names."""
    path = folder / name
    path.write_text(text)
    manifest = read_manifest(str(path))
    return {
        str(Path(e.source).relative_to(folder)): e.calibration and Path(e.calibration).name
        for e in manifest.entries
    }


def error(folder: Path, text: str, name: str = "m.toml") -> str:
    with pytest.raises(InputError) as raised:
        read(folder, text, name)
    return str(raised.value)


def test_the_first_row_that_fits_counts(folder: Path) -> None:
    found = read(
        folder,
        HEAD
        + """
        [[recording]]
        files = "raw/plain.mp4"
        calibration = "cal/other.toml"
        [[recording]]
        files = ["raw/**/*_A1_*.mp4", "raw/*.mp4"]
        calibration = "cal/A1.toml"
        """,
    )
    assert found == {
        "raw/plain.mp4": "other.toml",
        "raw/2026_A1_x.mp4": "A1.toml",
        "raw/deep/2025_A1_z.mp4": "A1.toml",
        "raw/2026_B2_y.mp4": "A1.toml",
    }


def test_scopes_are_known_by_the_serial_number_in_a_name(folder: Path) -> None:
    scopes = """
        [[scope]]
        serial = "A1"
        calibration = "cal/other.toml"
        [[scope]]
        serial = "B2"
        calibration = "cal/B2.toml"
        """
    rows = '[[recording]]\nfiles = "raw/**/*_{serial}_*.mp4"\n'
    assert read(folder, HEAD + scopes + rows) == {
        "raw/2026_A1_x.mp4": "other.toml",
        "raw/2026_B2_y.mp4": "B2.toml",
        "raw/deep/2025_A1_z.mp4": "other.toml",
    }
    named = '[[recording]]\nfiles = "raw/plain.mp4"\nserial = "B2"\n'
    assert read(folder, HEAD + scopes + named) == {"raw/plain.mp4": "B2.toml"}


def test_a_serial_number_may_name_the_calibration(folder: Path) -> None:
    rows = "files,calibration\nraw/**/*_{serial}_*.mp4,cal/{serial}.toml\n"
    assert read(folder, rows, "m.csv") == {
        "raw/2026_A1_x.mp4": "A1.toml",
        "raw/2026_B2_y.mp4": "B2.toml",
        "raw/deep/2025_A1_z.mp4": "A1.toml",
    }


def test_a_known_serial_number_goes_before_a_longer_match(folder: Path) -> None:
    (folder / "raw" / "2026_A1_B2_x.mp4").touch()
    scopes = '[[scope]]\nserial = "B2"\ncalibration = "cal/B2.toml"\n'
    rows = '[[recording]]\nfiles = "raw/2026_*{serial}_x.mp4"\n'
    (folder / "raw" / "2026_A1_x.mp4").unlink()
    assert read(folder, HEAD + scopes + rows) == {"raw/2026_A1_B2_x.mp4": "B2.toml"}


SCOPES = "".join(
    f'[[scope]]\nserial = "{serial}"\ncalibration = "cal/{name}.toml"\n'
    for serial, name in (("42", "A1"), ("1042", "B2"))
)


@pytest.mark.parametrize(
    ("name", "pattern", "lens"),
    [
        ("case1042.mp4", "*{serial}*.mp4", "B2"),
        ("case42.mp4", "*{serial}*.mp4", "A1"),
        ("case1042.mp4", "*{serial}.mp4", "B2"),
        ("case1042.mp4", "case10{serial}.mp4", "A1"),
        ("t_1042_x.mp4", "*_{serial}_*", "B2"),
        ("42/t_42.mp4", "**/*{serial}*.mp4", "A1"),
        ("t_1042_42_x.mp4", "*_1042_{serial}_*", "A1"),
        ("42/t_42.mp4", "{serial}/t_{serial}.mp4", "A1"),
        ("x42.mp4", "[!z-a]{serial}.mp4", "A1"),
    ],
)
def test_a_serial_number_that_ends_with_another(
    folder: Path, name: str, pattern: str, lens: str
) -> None:
    """Whichever is longer at one place is meant, or what the rest of the pattern leaves."""
    (folder / "new" / name).parent.mkdir(parents=True)
    (folder / "new" / name).touch()
    rows = f'[[recording]]\nfiles = "new/{pattern}"\n'
    assert read(folder, HEAD + SCOPES + rows) == {f"new/{name}": f"{lens}.toml"}


@pytest.mark.parametrize("pattern", ["*_{serial}_*", "*{serial}*"])
def test_two_serial_numbers_in_one_name_are_refused(folder: Path, pattern: str) -> None:
    (folder / "new").mkdir()
    (folder / "new" / "t_1042_42_x.mp4").touch()
    rows = f'[[recording]]\nfiles = "new/{pattern}"\n'
    said = error(folder, HEAD + SCOPES + rows)
    assert "t_1042_42_x.mp4" in said
    assert "finds the serial numbers '1042' and '42'" in said
    # Told which, it goes on.
    assert read(folder, HEAD + SCOPES + rows + 'serial = "42"\n') == {
        "new/t_1042_42_x.mp4": "A1.toml"
    }


def test_calibrations_by_name_make_their_serial_numbers_known(folder: Path) -> None:
    (folder / "raw" / "2026_B2_A1_x.mp4").touch()
    rows = "files,calibration\nraw/*_{serial}_*.mp4,cal/{serial}.toml\n"
    assert "'A1' and 'B2'" in error(folder, rows, "m.csv")


def test_a_manifest_in_a_directory_with_brackets(folder: Path) -> None:
    inside = folder / "case [1]"
    inside.mkdir()
    (folder / "raw").rename(inside / "raw")
    (folder / "cal").rename(inside / "cal")
    rows = "files,calibration\nraw/*_{serial}_*.mp4,cal/{serial}.toml\n"
    assert read(inside, rows, "m.csv") == {
        "raw/2026_A1_x.mp4": "A1.toml",
        "raw/2026_B2_y.mp4": "B2.toml",
    }


@pytest.mark.parametrize(
    ("output", "words"),
    [
        ("x/", "is a directory, not a file"),
        (".", "is a directory, not a file"),
        ("./.endocal/x.mp4", "is in the ledger's directory"),
        ("a/../../x.mp4", "is not below --out"),
    ],
)
def test_outputs_that_are_no_places(folder: Path, output: str, words: str) -> None:
    row = f'[[recording]]\nfiles = "raw/plain.mp4"\noutput = "{output}"\n'
    assert words in error(folder, HEAD + row)


def test_one_output_written_in_two_ways_is_refused(folder: Path) -> None:
    (folder / "raw" / "x.mp4").touch()
    rows = (
        "files,calibration,output\nraw/x.mp4,cal/A1.toml,x.mp4\nraw/plain.mp4,cal/A1.toml,./x.mp4\n"
    )
    (folder / "m.csv").write_text(rows)
    with pytest.raises(UsageError, match=r"would both become x\.mp4"):
        find_recordings(BatchSpec((str(folder / "m.csv"),), str(folder / "out")))


def test_outputs_are_no_recordings_of_a_manifest(folder: Path) -> None:
    (folder / "out" / "raw").mkdir(parents=True)
    (folder / "out" / "raw" / "plain.mp4").touch()
    (folder / "m.csv").write_text("files,calibration\n**/plain.mp4,cal/A1.toml\n")
    found = find_recordings(BatchSpec((str(folder / "m.csv"),), str(folder / "out")))
    assert list(found.recordings) == ["raw/plain.mp4"]


def test_tables_from_a_spreadsheet(folder: Path) -> None:
    text = "\ufefffiles; calibration; output\r\nraw/plain.mp4; cal/A1.toml; case 1.mp4\r\n;;\r\n"
    assert read(folder, text, "m.csv") == {"raw/plain.mp4": "A1.toml"}
    spec = BatchSpec((str(folder / "m.csv"),), str(folder / "out"))
    assert list(find_recordings(spec).recordings) == ["case 1.mp4"]


def test_what_gives_no_calibration_takes_that_of_the_command_line(folder: Path) -> None:
    assert read(folder, "files\nraw/plain.mp4\n", "m.csv") == {"raw/plain.mp4": None}
    manifest = str(folder / "m.csv")
    spec = BatchSpec((manifest,), str(folder / "out"), str(folder / "cal" / "A1.toml"))
    (recording,) = find_recordings(spec).recordings.values()
    assert recording.place == "raw/plain.mp4"
    assert recording.calibration.endswith("cal/A1.toml")
    with pytest.raises(InputError, match="line 2 gives no calibration, nor does --config"):
        find_recordings(BatchSpec((manifest,), str(folder / "out")))


def test_what_is_not_there_is_named_and_the_rest_goes_on(folder: Path) -> None:
    text = "files,calibration\nraw/gone.mp4,cal/A1.toml\nraw/plain.mp4,cal/A1.toml\n"
    assert list(read(folder, text, "m.csv")) == ["raw/plain.mp4"]
    found = find_recordings(BatchSpec((str(folder / "m.csv"),), str(folder / "out")))
    assert found.missing == ["raw/gone.mp4 (line 2): no such file"]


ROW = '[[recording]]\nfiles = "raw/*"\n'


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[[recording]]", 'm.toml: a manifest begins with schema = "endocal.manifest/1"'),
        ("a = ", "not a TOML document"),
        (HEAD, "names no recordings"),
        (HEAD + ROW + 'calibration = "cal/none.toml"\n', "cal/none.toml is missing"),
        (HEAD + ROW + 'serial = "C3"\n', "has the serial number 'C3', and no [[scope]] has that"),
        (HEAD + ROW + 'calibration = "cal/{serial}.toml"\n', "needs a serial number"),
        (HEAD + ROW + 'output = "a.mp4"\n', "output goes with one file, not with a pattern"),
        (
            HEAD + '[[recording]]\nfiles = "raw/plain.mp4"\noutput = "../a.mp4"',
            "is not below --out",
        ),
        (HEAD + '[[recording]]\nfiles = "raw"\n', "[[recording]] 1: raw is a directory"),
        (HEAD + ROW + "calibraton = 1\n", "did you mean calibration?"),
        (HEAD + '[[scope]]\nserial = "A1"\n', "[[scope]] 1: calibration is missing"),
        (
            HEAD + 2 * '[[scope]]\nserial = "A"\ncalibration = "x"\n',
            "two [[scope]] have the serial",
        ),
    ],
)
def test_wrong_manifests(folder: Path, text: str, words: str) -> None:
    assert words in error(folder, text)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("recording\nx\n", "the column 'recording' is unknown"),
        ("calibration\nx\n", "no column is called files"),
        ("files,calibration\n,cal/A1.toml\n", "line 2: names no files"),
        ("files\nraw/plain.mp4,a,b\n", "line 2: has more fields"),
        ("", "no column is called files"),
        ('files\n"raw/pl', "line 1: unexpected end of data"),
    ],
)
def test_wrong_tables(folder: Path, text: str, words: str) -> None:
    assert words in error(folder, text, "m.csv")


def test_a_calibration_among_the_sources_is_taken_for_what_it_is(folder: Path) -> None:
    (folder / "cal" / "A1.toml").write_text('schema = "endocal.calibration/1"\n')
    spec = BatchSpec((str(folder / "cal" / "A1.toml"),), str(folder / "out"))
    with pytest.raises(InputError, match="a calibration is given with --config"):
        find_recordings(spec)


def test_a_recording_of_the_manifest_elsewhere_keeps_its_name(folder: Path, tmp_path: Path) -> None:
    (folder / "list").mkdir()
    text = f"files,calibration\n{folder}/raw/plain.mp4,{folder}/cal/A1.toml\n"
    (folder / "list" / "m.csv").write_text(text)
    spec = BatchSpec((str(folder / "list" / "m.csv"),), str(folder / "out"))
    assert list(find_recordings(spec).recordings) == ["plain.mp4"]
    with pytest.raises(UsageError, match="jobs"):
        BatchSpec(("x",), "out", jobs=0)
