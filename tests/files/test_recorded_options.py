"""The key ``[source] options``: a wrong value is refused with its name."""

from __future__ import annotations

import pytest

from endocal.errors import InputError
from endocal.files import loads

DOCUMENT = """\
schema = "endocal.calibration/1"
[model]
type = "division"
lambda = -1e-6
center = [360.0, 270.0]
size = [720, 540]
[source]
options = {options}
"""


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ("3", "[source] options is 3; it must be a table"),
        ("{ sobol = 3 }", "unknown key [source] options: sobol"),
        ("{ sobel = 3.5 }", "[source] options: sobel is 3.5; it must be a whole number"),
        ("{ center = 3 }", "[source] options: center is 3; it must be two numbers"),
        ("{ roi = [1, 2, 3] }", "[source] options: roi is '[1, 2, 3]'; it must be [x, y, width"),
        ("{ lines = [[[1, 2], [3]]] }", "[source] options: lines must be a list of lines"),
        ("{ model = 'brown' }", "[source] options: model is 'brown'; it must be"),
        ("{ lines = 3 }", "[source] options: lines must be a list of lines"),
        ("{ epsilon = nan }", "[source] options: epsilon is nan; it must be a finite number"),
    ],
)
def test_a_wrong_option_is_named(options: str, words: str) -> None:
    with pytest.raises(InputError) as error:
        loads(DOCUMENT.format(options=options), "cal.toml")
    assert str(error.value).startswith(f"cal.toml: {words}")


def test_no_option_is_needed() -> None:
    assert loads(DOCUMENT.format(options="{}")).source.options == {}
