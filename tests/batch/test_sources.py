"""Which files are recordings, and where their outputs go."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest

from endocal.batch.recording import BatchSpec
from endocal.batch.sources import Found, find_recordings
from endocal.errors import InputError, UsageError


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A tree in the working directory."""
    for name in (
        "raw/a.mp4",
        "raw/one/b.mp4",
        "raw/one/c.avi",
        "raw/.hidden.mp4",
        "raw/one/.d/e.mp4",
    ):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    monkeypatch.chdir(tmp_path)
    return tmp_path


def find(*sources: str, **options: Any) -> Found:
    return find_recordings(BatchSpec(sources, "out", "cal.toml", **options))


def places(*sources: str, **options: Any) -> list[str]:
    return list(find(*sources, **options).recordings)


def test_a_directory_is_mirrored(folder: Path) -> None:
    assert places("raw", recursive=True) == ["a.mp4", "one/b.mp4", "one/c.avi"]
    found = find("raw")
    assert list(found.recordings) == ["a.mp4"]
    assert found.notes == ["raw/one: is a directory, left out without --recursive"]
    assert found.recordings["a.mp4"].source == str(folder / "raw" / "a.mp4")


@pytest.mark.parametrize(
    ("pattern", "expected"),
    [
        ("raw/**/*.mp4", ["a.mp4", "one/b.mp4"]),
        ("raw/*/*", ["one/b.mp4", "one/c.avi"]),
        ("raw/one/[bc].*", ["b.mp4", "c.avi"]),
        ("*/a.mp4", ["raw/a.mp4"]),
    ],
)
def test_a_pattern_is_mirrored_from_its_fixed_part_on(
    folder: Path, pattern: str, expected: list[str]
) -> None:
    assert places(pattern) == expected


def test_files_keep_their_names_and_a_root_keeps_their_tree(folder: Path) -> None:
    files = ("raw/a.mp4", "raw/one/b.mp4")
    assert places(*files) == ["a.mp4", "b.mp4"]
    assert places(*files, root="raw") == ["a.mp4", "one/b.mp4"]
    with pytest.raises(UsageError, match="not below --root raw/one"):
        places(*files, root="raw/one")


def test_a_name_with_brackets_is_a_name(folder: Path) -> None:
    (folder / "raw" / "x[1].mp4").touch()
    assert places("raw/x[1].mp4") == ["x[1].mp4"]


def test_include_and_exclude(folder: Path) -> None:
    assert places("raw", recursive=True, include=("*.mp4",)) == ["a.mp4", "one/b.mp4"]
    assert places("raw", recursive=True, exclude=("one/*",)) == ["a.mp4"]
    assert places("raw", recursive=True, include=("*.mp4",), exclude=("a.*",)) == ["one/b.mp4"]


def test_a_new_suffix_is_for_videos(folder: Path) -> None:
    (folder / "raw" / "still.png").touch()
    found = places("raw", suffix=".mkv")
    assert found == ["a.mkv", "still.png"]


def test_two_recordings_for_one_output_are_refused(folder: Path) -> None:
    (folder / "raw" / "one" / "b.avi").touch()
    with pytest.raises(UsageError, match=r"would both become one/b\.mkv"):
        places("raw", recursive=True, suffix=".mkv")
    (folder / "more").mkdir()
    (folder / "more" / "a.mp4").touch()
    with pytest.raises(UsageError, match=r"would both become a\.mp4"):
        places("raw", "more")
    # The same file by two ways is one recording.
    assert places("raw", "raw/a.mp4") == ["a.mp4"]


def test_a_recording_of_two_sources_is_made_once(folder: Path) -> None:
    assert places("raw", "raw/one", recursive=True) == ["a.mp4", "one/b.mp4", "one/c.avi"]
    assert places("raw/one", "raw", recursive=True) == ["a.mp4", "b.mp4", "c.avi"]
    (folder / "other.toml").touch()
    (folder / "m.csv").write_text("files,calibration\nraw/a.mp4,other.toml\n")
    with pytest.raises(
        UsageError, match=r"two sources, with the calibrations .*cal\.toml and .*oth"
    ):
        places("raw", "m.csv")


def test_outputs_are_no_inputs(folder: Path) -> None:
    with pytest.raises(UsageError, match="would be an output and is an input"):
        find_recordings(BatchSpec(("raw/a.mp4",), "raw", "cal.toml"))
    with pytest.raises(UsageError, match="is both a source and --out"):
        find_recordings(BatchSpec(("raw",), "raw", "cal.toml"))


def test_the_outputs_of_batches_inside_the_tree_are_left_out(folder: Path) -> None:
    for name in ("raw/out/x.mp4", "raw/older/.endocal/ledger.sqlite", "raw/older/y.mp4"):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).touch()
    spec = BatchSpec(("raw",), "raw/out", "cal.toml", recursive=True)
    found = find_recordings(spec)
    assert list(found.recordings) == ["a.mp4", "one/b.mp4", "one/c.avi"]
    (note,) = found.notes
    assert note.startswith("raw/older: holds the outputs of another batch")


def test_a_pattern_leaves_outputs_out_as_a_directory_does(folder: Path) -> None:
    """A second run, another batch with its ledger inside, and one with --state elsewhere."""
    for name in (
        *("raw/out/a.mp4", "raw/out/one/b.mp4"),
        *("raw/older/.endocal/ledger.sqlite", "raw/older/deep/y.mp4"),
        *("raw/apart/batch-report.json", "raw/apart/z.mp4"),
    ):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).touch()
    for source in ("raw/**/*.mp4", "raw"):
        found = find_recordings(BatchSpec((source,), "raw/out", "cal.toml", recursive=True))
        assert [p for p in found.recordings if p.endswith("mp4")] == ["a.mp4", "one/b.mp4"]
        assert len(found.notes) == 2
        assert all("holds the outputs of another batch" in note for note in found.notes)
    # What is named is taken.
    assert places("raw/older/**/*.mp4") == ["deep/y.mp4"]


def test_a_pattern_below_the_directory_of_outputs(folder: Path) -> None:
    found = find_recordings(BatchSpec(("raw/*.mp4",), ".", "cal.toml"))
    assert list(found.recordings) == ["a.mp4"]


def test_a_pattern_in_a_directory_with_brackets(folder: Path) -> None:
    (folder / "raw").rename(folder / "case [1]")
    assert places("case [1]/**/*.mp4") == ["a.mp4", "one/b.mp4"]
    assert places(f"{folder}/case [1]/*.mp4") == ["a.mp4"]


def test_a_name_that_begins_with_dots_is_below_its_root(folder: Path) -> None:
    (folder / "raw" / "..a.mp4").touch()
    assert places("raw/..a.mp4") == ["..a.mp4"]


def test_links_to_directories_are_not_followed(folder: Path) -> None:
    (folder / "raw" / "loop").symlink_to(folder / "raw", target_is_directory=True)
    (folder / "raw" / "again.mp4").symlink_to(folder / "raw" / "a.mp4")
    found = find("raw", recursive=True)
    assert list(found.recordings) == ["a.mp4", "again.mp4", "one/b.mp4", "one/c.avi"]
    (note,) = found.notes
    assert "is a link to a directory" in note


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("nothing", "nothing: no such file or directory: check its name"),
        ("raw/*.mov", "matches no file"),
        ("raw/one/.d", None),
        ("empty", "no recording was found"),
    ],
)
def test_a_source_that_gives_nothing(folder: Path, source: str, words: str | None) -> None:
    (folder / "empty").mkdir()
    if words is None:
        assert places(source) == ["e.mp4"]
        return
    with pytest.raises(InputError, match=words.replace("*", r"\*")):
        places(source)


def test_a_calibration_is_needed(folder: Path) -> None:
    with pytest.raises(UsageError, match="-c FILE"):
        find_recordings(BatchSpec(("raw",), "out"))


def test_names_that_are_no_unicode(folder: Path) -> None:
    name = os.fsdecode(b"raw/caf\xe9\n.mp4")
    Path(name).touch()
    assert os.path.basename(name) in places("raw")
