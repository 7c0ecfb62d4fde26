"""Lines as text: read as written, and refused with file and row."""

from __future__ import annotations

import io
import sys
from pathlib import Path

import pytest

from endocal.errors import InputError
from endocal.files import read_lines

TEXT = """\
# left edge of the board
10 20.5
12, 40   # with a comma
# a comment between points ends nothing
13,60

1e2 -3
110 0
120 5
"""
LINES = (((10, 20.5), (12, 40), (13, 60)), ((100, -3), (110, 0), (120, 5)))


def test_points_and_lines(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "lines.txt"
    file.write_text(TEXT)
    assert read_lines(file) == LINES
    file.write_bytes(b"\xef\xbb\xbf" + TEXT.replace("\n", "\r\n").encode())
    assert read_lines(file) == LINES
    monkeypatch.setattr(sys, "stdin", io.StringIO(TEXT))
    assert read_lines("-") == LINES


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "holds no line; write a point x y a row"),
        ("# nothing\n\n", "holds no line"),
        ("1 2\n3 4\n\n", "the line that ends before row 3 has 2 points; 3 or more are needed"),
        ("1 2\n3\n", "row 2: '3' is no point: write two numbers, x y, in px"),
        ("1 2 3\n", "row 1: '1 2 3' is no point"),
        ("1 nan\n", "row 1: '1 nan' is no point"),
    ],
)
def test_what_is_wrong_is_said(tmp_path: Path, text: str, words: str) -> None:
    file = tmp_path / "lines.txt"
    file.write_text(text)
    with pytest.raises(InputError) as error:
        read_lines(file)
    assert str(error.value).startswith(f"{file}: ")
    assert words in str(error.value)


def test_no_text(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(b"\x89PNG\xff\xfe")
    with pytest.raises(InputError, match="is no text"):
        read_lines(tmp_path / "a.png")
    with pytest.raises(InputError, match=r"no such file: check its name$"):
        read_lines(tmp_path / "none.txt")
