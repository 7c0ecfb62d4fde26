"""The tree of recordings and what an uninterrupted batch makes of it, each made once."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.batch import tree


@dataclass(frozen=True)
class Tree:
    """A tree of sources, its calibration, and the outputs of a batch that nothing disturbed."""

    source: Path
    lens: str
    whole: Path


@pytest.fixture(scope="session")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> Tree:
    folder = tmp_path_factory.mktemp("batch")
    source, lens = tree.make_tree(folder), tree.lens(folder)
    done = tree.run(source, folder / "whole", lens)
    assert done.returncode == 1, done.stderr
    return Tree(source, lens, folder / "whole")
