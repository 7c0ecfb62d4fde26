"""An output is complete or not there, and nothing is ever lost by writing one."""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

import pytest

from endocal.errors import OutputError
from endocal.files import atomic_output, check_output


def names(folder: Path) -> list[str]:
    return sorted(p.name for p in folder.iterdir())


def write(path: Path, text: str = "done", **options: object) -> None:
    with atomic_output(path, **options) as temporary:  # type: ignore[arg-type]
        temporary.write_text(text)


@pytest.mark.parametrize(
    "name",
    ["out.mp4", "a b.toml", "new\nline.png", "50%d.png", "内視鏡.mp4", "-", "--o.mp4", "x" * 255],
)
def test_the_file_appears_complete(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    with atomic_output(path) as temporary:
        assert temporary.parent == tmp_path
        assert temporary.suffix == path.suffix
        assert not path.exists()
        temporary.write_text("done")
        assert not path.exists()
    assert path.read_text() == "done"
    assert names(tmp_path) == [name]


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt, SystemExit])
@pytest.mark.parametrize("overwrite", [False, True])
def test_a_failure_leaves_everything_as_it_was(
    tmp_path: Path, error: type[BaseException], overwrite: bool
) -> None:
    path = tmp_path / "out.mp4"
    if overwrite:
        path.write_text("precious")
    before = names(tmp_path)

    def fail() -> None:
        with atomic_output(path, overwrite) as temporary:
            temporary.write_text("half")
            raise error

    with pytest.raises(error):
        fail()
    assert names(tmp_path) == before
    assert not overwrite or path.read_text() == "precious"


def test_an_existing_output_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "out.mp4"
    path.write_text("precious")
    with pytest.raises(OutputError, match=r"out\.mp4: exists already: give --overwrite"):
        write(path)
    assert path.read_text() == "precious"
    write(path, overwrite=True)
    assert path.read_text() == "done"


@pytest.mark.parametrize("links", [True, False])
def test_an_output_that_appears_meanwhile_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, links: bool
) -> None:
    if not links:
        monkeypatch.setattr(os, "link", no_links)
    path = tmp_path / "out.mp4"

    def lose_the_race() -> None:
        with atomic_output(path) as temporary:
            temporary.write_text("mine")
            path.write_text("theirs")

    with pytest.raises(OutputError, match="exists already"):
        lose_the_race()
    assert path.read_text() == "theirs"
    assert names(tmp_path) == ["out.mp4"]


def test_a_file_system_without_links_will_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "link", no_links)
    write(tmp_path / "out.mp4")
    assert names(tmp_path) == ["out.mp4"]


def no_links(*_: object) -> None:
    raise OSError(errno.EPERM, "Operation not permitted")


@pytest.mark.parametrize("alias", ["same", "symlink", "hardlink", "dots"])
def test_an_input_is_never_written_over(tmp_path: Path, alias: str) -> None:
    source = tmp_path / "in.mp4"
    source.write_text("precious")
    path = tmp_path / "alias.mp4"
    if alias == "same":
        path = source
    elif alias == "symlink":
        path.symlink_to(source)
    elif alias == "hardlink":
        path.hardlink_to(source)
    else:
        path = tmp_path / ".." / tmp_path.name / "in.mp4"
    with pytest.raises(OutputError, match="is also an input"):
        write(path, overwrite=True, inputs=[tmp_path / "other", source])
    assert source.read_text() == "precious"


def test_places_that_cannot_be(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"the directory .* does not exist"):
        write(tmp_path / "no" / "out.mp4")
    with pytest.raises(OutputError, match="is a directory"):
        write(tmp_path)
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match=r"directory .* does not exist"):
        write(tmp_path / "file" / "out.mp4")
    with pytest.raises(OutputError, match="no regular file"):
        write(Path(os.devnull), overwrite=True)
    with pytest.raises(OutputError, match="too long"):
        write(tmp_path / ("x" * 256))
    with pytest.raises(OutputError, match="null"):
        write(Path(f"{tmp_path}/out\0.mp4"))
    with pytest.raises(OutputError, match="name is empty"), atomic_output(""):
        pass
    assert Path(os.devnull).is_char_device()
    assert names(tmp_path) == ["file"]


def test_a_link_is_followed(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    link = tmp_path / "out.mp4"
    link.symlink_to(tmp_path / "there" / "real.mp4")
    write(link)
    assert link.is_symlink()
    assert names(tmp_path / "there") == ["real.mp4"]


def test_permissions_are_those_of_any_new_file(tmp_path: Path) -> None:
    write(tmp_path / "ours")
    (tmp_path / "plain").write_text("")
    modes = {stat.S_IMODE((tmp_path / n).stat().st_mode) for n in names(tmp_path)}
    assert len(modes) == 1


def test_a_full_disk_says_so(tmp_path: Path) -> None:
    with (
        pytest.raises(OutputError, match=r"out\.mp4: the disk is full"),
        atomic_output(tmp_path / "out.mp4"),
    ):
        raise OSError(errno.ENOSPC, "No space left on device")
    assert names(tmp_path) == []


def test_an_output_can_be_checked_before_the_work(tmp_path: Path) -> None:
    path = tmp_path / "out.mp4"
    check_output(path)
    check_output("-")
    path.write_text("precious")
    check_output(path, overwrite=True)
    with pytest.raises(OutputError, match="exists already"):
        check_output(path)
    with pytest.raises(OutputError, match="is also an input"):
        check_output(path, overwrite=True, inputs=[path])
    with pytest.raises(OutputError, match="does not exist"):
        check_output(tmp_path / "no" / "out.mp4")
