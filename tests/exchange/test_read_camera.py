"""Camera files that are none."""

from __future__ import annotations

import pytest

from endocal.errors import InputError
from endocal.exchange.read_camera import read_camera


@pytest.mark.parametrize(
    "text",
    [
        "[" * 200_000,
        "%YAML:1.0\n---\nK: " + "[" * 100_000,
        "%YAML:1.0\n---\n" + "- " * 50_000 + "1",
    ],
    ids=["json", "yaml in brackets", "yaml in dashes"],
)
def test_what_is_nested_without_end_is_refused(text: str) -> None:
    """OpenCV's parser would take the process with it."""
    with pytest.raises(InputError):
        read_camera(text)
