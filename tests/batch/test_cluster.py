"""The same tree on a real Dask cluster: a scheduler and two workers, each a process of its own."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from endocal.batch import cluster as cluster_module
from endocal.batch.remote import WorkerError, perform_on_worker
from endocal.batch.task import Task
from endocal.errors import InputError, UsageError
from endocal.jobs.correction import CorrectionSpec
from tests.batch import tree
from tests.batch.conftest import Tree

pytest.importorskip("distributed")

SCHEDULER = (
    sys.executable,
    "-m",
    "distributed.cli.dask_scheduler",
    "--no-dashboard",
    "--port",
    "0",
)
WORKER = (sys.executable, "-m", "distributed.cli.dask_worker", "--no-dashboard", "--no-nanny")
# The times that Dask gives itself are for clusters of machines.
ENVIRONMENT = {**os.environ, "DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT": "20s"}


@dataclass
class Cluster:
    """A scheduler, found by its file, and the processes of its workers."""

    file: Path
    processes: list[subprocess.Popen[bytes]]

    def add_worker(self, **env: str) -> subprocess.Popen[bytes]:
        """Start a worker with one thread."""
        command = [*WORKER, "--scheduler-file", str(self.file), "--nthreads", "1"]
        process = subprocess.Popen(
            command, env={**ENVIRONMENT, **env}, cwd=self.file.parent, stderr=subprocess.DEVNULL
        )
        self.processes.append(process)
        return process

    def wait_for(self, workers: int) -> None:
        """Wait until so many workers are there."""
        from distributed import Client

        with Client(scheduler_file=str(self.file), set_as_default=False) as client:
            client.wait_for_workers(workers, timeout=60)


@pytest.fixture(scope="module")
def dask(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    file = tmp_path_factory.mktemp("dask") / "scheduler.json"
    command = [*SCHEDULER, "--scheduler-file", str(file)]
    scheduler = subprocess.Popen(
        command, env=ENVIRONMENT, cwd=file.parent, stderr=subprocess.DEVNULL
    )
    cluster = Cluster(file, [scheduler])
    try:
        deadline = time.monotonic() + 60
        while not file.exists() and time.monotonic() < deadline:
            time.sleep(0.05)
        for _ in range(2):
            cluster.add_worker()
        cluster.wait_for(2)
        yield cluster
    finally:
        for process in reversed(cluster.processes):
            process.kill()
            process.wait()


def command(recordings: Tree, out: Path, dask: Cluster) -> list[str]:
    arguments = tree.command(recordings.source, out, recordings.lens)
    place = arguments.index("--jobs")
    return [*arguments[:place], *arguments[place + 2 :], "--scheduler", str(dask.file)]


def test_a_worker_that_dies_midway_changes_nothing(
    recordings: Tree, tmp_path: Path, dask: Cluster
) -> None:
    out = tmp_path / "out"
    process = subprocess.Popen(command(recordings, out, dask), stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    said, finished = [], 0
    for line in process.stderr:
        said.append(line)
        finished += '"event": "done"' in line
        if finished == 8 and len(dask.processes) == 3:
            dask.processes[1].send_signal(signal.SIGKILL)
            dask.processes.pop(1).wait()
    assert process.wait() == 1, "".join(said)
    assert len(dask.processes) == 2
    failed = [e["output"] for e in tree.events("".join(said)) if e["event"] == "failed"]
    assert sorted(failed) == sorted(tree.BROKEN)
    assert tree.outputs(out) == tree.outputs(recordings.whole)
    assert tree.recorded(out) == tree.recorded(recordings.whole)
    # Dask's own words about it stay out of ours; each recording starts once, or twice with a lost worker.
    assert all(line.startswith("{") for line in said)
    starts = [e["output"] for e in tree.events("".join(said)) if e["event"] == "start"]
    assert len(starts) < 40 + 5


def test_a_batch_that_is_killed_goes_on_from_there(
    recordings: Tree, tmp_path: Path, dask: Cluster
) -> None:
    out = tmp_path / "out"
    process = subprocess.Popen(command(recordings, out, dask), stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    while '"event": "done"' not in process.stderr.readline():
        pass
    process.kill()
    process.wait()
    process.stderr.close()
    again = subprocess.run(
        command(recordings, out, dask), stderr=subprocess.PIPE, text=True, check=False
    )
    assert again.returncode == 1, again.stderr
    assert tree.outputs(out) == tree.outputs(recordings.whole)
    assert tree.recorded(out) == tree.recorded(recordings.whole)


def test_a_worker_of_another_version_is_refused(
    endocal: Callable[..., Any], recordings: Tree, tmp_path: Path, dask: Cluster
) -> None:
    other = tmp_path / "older" / "endocal"
    other.mkdir(parents=True)
    (other / "__init__.py").write_text("__version__ = '0.0.1'\n")
    before = len(dask.processes) - 1
    worker = dask.add_worker(PYTHONPATH=str(other.parent))
    dask.wait_for(before + 1)
    arguments = command(recordings, tmp_path / "out", dask)[3:]
    try:
        line = endocal(*arguments).fails()
    finally:
        worker.kill()
        worker.wait()
        dask.processes.remove(worker)
    assert "has endocal 0.0.1, and this is" in line
    assert not tree.outputs(tmp_path / "out")


def test_a_worker_that_does_not_see_the_outputs_is_named(tmp_path: Path, dask: Cluster) -> None:
    with pytest.raises(InputError, match=r"the Dask worker tcp://.* does not see .*nowhere"):
        cluster_module.Cluster(str(dask.file), 0, 60, "run", tmp_path / "nowhere" / "lock")


def test_a_worker_that_joins_late_refuses_what_it_cannot_do(tmp_path: Path) -> None:
    spec = CorrectionSpec("a.mkv", "b.mkv", "cal.toml")
    task = Task("b.mkv", spec, "", "", None, "mark", version="0.0.1")
    with pytest.raises(WorkerError, match=r"and the batch 0\.0\.1"):
        perform_on_worker(task, "topic", "key", "run", str(tmp_path), 60)
    task = Task("b.mkv", spec, "", "", None, "mark")
    with pytest.raises(WorkerError, match="does not see"):
        perform_on_worker(task, "topic", "key", "run", str(tmp_path / "lock"), 60)


def test_without_dask_it_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(UsageError, match=r"pip install 'endocal-toolchain\[cluster\]'"):
        cluster_module.Cluster("tcp://x:1", 0, 60, "run", tmp_path)


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "nonsense://x", "no port"])
def test_a_scheduler_that_does_not_answer(
    endocal: Callable[..., Any],
    recordings: Tree,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    address: str,
) -> None:
    monkeypatch.setattr(cluster_module, "_CONNECT_S", 0.5)
    arguments = tree.command(recordings.source, tmp_path / "out", recordings.lens)[3:]
    arguments = [a for a in arguments if a not in ("--jobs", "2")]
    line = endocal(*arguments, "--scheduler", address).fails()
    assert f"no Dask scheduler answers at {address}" in line


def test_a_scheduler_that_goes_away(recordings: Tree, tmp_path: Path, dask: Cluster) -> None:
    """Last in this file: it takes the cluster along."""
    out = tmp_path / "out"
    process = subprocess.Popen(command(recordings, out, dask), stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    while '"event": "done"' not in process.stderr.readline():
        pass
    dask.processes[0].kill()
    said = process.stderr.read().splitlines()
    assert process.wait() == 1
    (line,) = [text for text in said if not text.startswith("{")]
    assert "went away: start the same batch again when it is back" in line
    # The workers notice by themselves, and what they have begun goes.
    deadline = time.monotonic() + 15
    while list(out.rglob(".endocal-*")) and time.monotonic() < deadline:
        time.sleep(0.1)
    again = tree.run(recordings.source, out, recordings.lens)
    assert again.returncode == 1
    assert tree.outputs(out) == tree.outputs(recordings.whole)
