"""Real worker processes: one that dies takes only its own recording along, and kernels are built apart."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from endocal.batch.executor import Ended, Started
from endocal.batch.processes import Processes
from endocal.batch.task import Task, lens_digest
from endocal.jobs.correction import CorrectionSpec
from tests.jobs.lenses import calibration
from tests.video.clips import Clip


@pytest.fixture
def lock(tmp_path: Path) -> Iterator[int]:
    descriptor = os.open(tmp_path / "lock", os.O_RDWR | os.O_CREAT)
    yield descriptor
    os.close(descriptor)


def task(folder: Path, name: str, **options: object) -> Task:
    lens = calibration(folder / "cal.toml", -1.5e-4)
    spec = CorrectionSpec(
        str(folder / name), str(folder / "out" / name), lens, threads=1, device="numpy"
    )
    return Task(name, spec, lens_digest(spec), "", None, "mark")


def instead_of_correct(folder: Path, monkeypatch: pytest.MonkeyPatch, *lines: str) -> None:
    """Let workers run these lines before the real correction."""
    (folder / "fake").mkdir()
    body = "".join(f"        {line}\n" for line in lines)
    # Imported by every interpreter at its start.
    (folder / "fake" / "sitecustomize.py").write_text(
        "import sys, os, time\n"
        "if 'endocal.batch.worker' in ' '.join(sys.orig_argv):\n"
        "    import endocal.batch.task as t\n"
        "    def correct(spec, tell, real=t.correct):\n"
        f"{body}"
        "        return real(spec, tell)\n"
        "    t.correct = correct\n"
    )
    monkeypatch.setenv("PYTHONPATH", str(folder / "fake"))


def test_a_process_that_dies_is_replaced_and_its_recording_tried_again(
    tmp_path: Path, lock: int
) -> None:
    Clip(frames=3).make(tmp_path / "a.mkv")
    Clip(frames=600).make(tmp_path / "long.mkv")
    orders = iter([task(tmp_path, "long.mkv"), task(tmp_path, "a.mkv")])
    workers, outcomes = [], {}
    for event in Processes(1, 1, 1, 3600, lock).run(orders):
        if isinstance(event, Started):
            workers.append(int(event.worker.split()[1]))
            if len(workers) == 1:
                threading.Timer(0.6, os.kill, (workers[0], signal.SIGKILL)).start()
        elif isinstance(event, Ended):
            outcomes[event.place] = event.outcome
    assert outcomes["long.mkv"].made is not None
    assert outcomes["a.mkv"].made is not None
    assert len(set(workers)) == 2


def test_a_recording_that_kills_every_process_fails_alone(
    tmp_path: Path, lock: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    Clip(frames=3).make(tmp_path / "a.mkv")
    Clip(frames=3).make(tmp_path / "deadly.mkv")
    instead_of_correct(
        tmp_path,
        monkeypatch,
        "if 'deadly' in spec.input:",
        "    print('the library gives up', file=sys.stderr, flush=True)",
        "    os.abort()",
    )
    orders = iter([task(tmp_path, "deadly.mkv"), task(tmp_path, "a.mkv")])
    events = list(Processes(1, 1, 1, 3600, lock).run(orders))
    outcomes = {e.place: e.outcome for e in events if isinstance(e, Ended)}
    assert outcomes["a.mkv"].made is not None
    assert "its process died (SIGABRT): the library gives up" in str(outcomes["deadly.mkv"].error)
    assert len([e for e in events if isinstance(e, Started) and e.place == "deadly.mkv"]) == 2


def test_a_recording_that_stands_still_is_given_up(
    tmp_path: Path, lock: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("a.mkv", "stuck.mkv"):
        Clip(frames=3).make(tmp_path / name)
    instead_of_correct(tmp_path, monkeypatch, "if 'stuck' in spec.input:", "    time.sleep(60)")
    orders = iter([task(tmp_path, "stuck.mkv"), task(tmp_path, "a.mkv")])
    events = list(Processes(1, 1, 1, 12.0, lock).run(orders))
    outcomes = {e.place: e.outcome for e in events if isinstance(e, Ended)}
    assert outcomes["a.mkv"].made is not None
    assert "has not moved on for 0.2 minutes" in str(outcomes["stuck.mkv"].error)


def test_closing_the_run_ends_the_processes_and_their_temporary_files(
    tmp_path: Path, lock: int
) -> None:
    Clip(frames=600).make(tmp_path / "long.mkv")
    run = Processes(1, 1, 1, 3600, lock).run(iter([task(tmp_path, "long.mkv")]))
    started = next(run)
    assert isinstance(started, Started)
    deadline = time.monotonic() + 20
    while not list(tmp_path.glob("out/.endocal-mark-*")) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert list(tmp_path.glob("out/.endocal-mark-*"))
    run.close()  # type: ignore[attr-defined]
    assert not list(tmp_path.glob("out/*"))
    assert not list(tmp_path.glob("out/.*"))
    with pytest.raises(ProcessLookupError):
        os.kill(int(started.worker.split()[1]), 0)


def test_processes_build_kernels_apart(tmp_path: Path) -> None:
    code = (
        "import os, time; from endocal.batch.kernel_cache import use_own_kernel_cache as use\n"
        "use(); print(os.environ['POCL_CACHE_DIR'], flush=True); time.sleep(30)"
    )
    environment = {k: v for k, v in os.environ.items() if k != "POCL_CACHE_DIR"}
    environment["XDG_CACHE_HOME"] = str(tmp_path)
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", code], env=environment, stdout=subprocess.PIPE, text=True
        )
        for _ in range(3)
    ]
    places = [p.stdout.readline().strip() for p in processes if p.stdout is not None]
    kernels = tmp_path / "endocal" / "kernels"
    assert sorted(places) == [str(kernels / str(n)) for n in range(3)]
    for process in processes:
        process.kill()
        process.communicate()
