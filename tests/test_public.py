"""The names that Python users get from ``endocal``."""

from __future__ import annotations

import pytest

import endocal


@pytest.mark.parametrize("name", endocal.__all__)
def test_every_public_name_is_there_and_explained(name: str) -> None:
    value = getattr(endocal, name)
    assert name == "__version__" or value.__doc__
    assert name in dir(endocal)


def test_other_names_are_not() -> None:
    with pytest.raises(AttributeError, match="has no attribute 'nonsense'"):
        endocal.nonsense  # noqa: B018
