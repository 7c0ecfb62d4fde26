"""How many jobs a machine gets: its cores or its container's share, as far as the memory goes."""

from __future__ import annotations

from pathlib import Path

import pytest

from endocal.batch import resources


@pytest.fixture
def cgroup(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A machine of 16 cores and 64 GiB, and the limits of its container."""
    monkeypatch.setattr(resources, "_CGROUP", tmp_path)
    monkeypatch.setattr(resources.os, "sched_getaffinity", lambda pid: range(16))
    pages = {"SC_PAGE_SIZE": 4096, "SC_PHYS_PAGES": 16 << 20}
    monkeypatch.setattr(resources.os, "sysconf", lambda name: pages[name])
    return tmp_path


@pytest.mark.parametrize(
    ("cpu", "memory", "jobs"),
    [
        (None, None, 16),
        ("max 100000", "max", 16),
        ("400000 100000", None, 4),
        ("50000 100000", None, 1),
        (None, str(5 << 30), 5),
        (None, str(1 << 29), 1),
    ],
)
def test_the_limits_count(cgroup: Path, cpu: str | None, memory: str | None, jobs: int) -> None:
    for name, text in (("cpu.max", cpu), ("memory.max", memory)):
        if text is not None:
            (cgroup / name).write_text(text + "\n")
    assert resources.default_jobs() == jobs
