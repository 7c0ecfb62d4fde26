"""Fixtures of batches: a tree of recordings with what is made of it undisturbed, and a batch of two clips."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest

from endocal.batch import fingerprint
from tests.batch import tree
from tests.batch.local import Batch, make_batch


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


@pytest.fixture
def batch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Batch:
    # The clips are as new as can be; here their times count as settled, save where a test says otherwise.
    monkeypatch.setattr(fingerprint, "_SETTLED_S", -3600)
    return make_batch(tmp_path, monkeypatch)
