"""A batch that is killed and started again, and again, ends as one that nothing disturbed."""

from __future__ import annotations

import json
import random
import signal
import subprocess
import time
from pathlib import Path

import pytest

from tests.batch import tree
from tests.batch.conftest import Tree

KILLS = 10


def kill_midway(command: list[str], chance: random.Random) -> int:
    """Start a batch, kill it with SIGKILL at a random moment, and return how many recordings it finished.

    A moment after one of its first events: at the plan, between two recordings, or in the middle of some.
    """
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    wanted, finished = chance.randrange(0, 4), 0
    for line in process.stderr:
        finished += '"event": "done"' in line
        if finished >= wanted:
            time.sleep(chance.uniform(0, 0.03))
            break
    process.send_signal(signal.SIGKILL)
    process.stderr.close()
    assert process.wait() == -signal.SIGKILL
    return finished


def test_killed_ten_times_it_ends_as_if_it_had_not_been(recordings: Tree, tmp_path: Path) -> None:
    out, chance = tmp_path / "out", random.Random(7)
    command = tree.command(recordings.source, out, recordings.lens)
    finished = [kill_midway(command, chance) for _ in range(KILLS)]
    last = tree.run(recordings.source, out, recordings.lens)
    assert last.returncode == 1, last.stderr
    assert tree.outputs(out) == tree.outputs(recordings.whole)
    assert tree.recorded(out) == tree.recorded(recordings.whole)
    failed = [e["output"] for e in tree.events(last.stderr) if e["event"] == "failed"]
    assert sorted(failed) == sorted(tree.BROKEN)
    # What was finished was not done again: at most the two in flight were lost each time.
    (end,) = [e for e in tree.events(last.stderr) if e["event"] == "end"]
    assert end["done_now"] <= 37 - sum(finished)


def test_the_next_run_has_nothing_to_do(recordings: Tree) -> None:
    # The failed ones are tried again, and what was made before its times had settled is compared.
    before = tree.outputs(recordings.whole)
    done = tree.run(recordings.source, recordings.whole, recordings.lens)
    (end,) = [e for e in tree.events(done.stderr) if e["event"] == "end"]
    assert (end["done"], end["done_now"], end["failed"]) == (37, 0, 3)
    assert tree.outputs(recordings.whole) == before


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_ends_it_well(
    recordings: Tree, tmp_path: Path, number: signal.Signals
) -> None:
    out = tmp_path / "out"
    process = subprocess.Popen(
        tree.command(recordings.source, out, recordings.lens), stderr=subprocess.PIPE, text=True
    )
    assert process.stderr is not None
    while "done" not in process.stderr.readline():
        pass
    process.send_signal(number)
    rest = process.stderr.read()
    assert process.wait() == (130 if number == signal.SIGINT else 128 + number)
    assert "Traceback" not in rest
    *_, end, last = rest.splitlines()
    assert (json.loads(end)["event"], json.loads(end)["interrupted"]) == ("end", True)
    words = "interrupted" if number == signal.SIGINT else "ended by SIGTERM"
    assert last == f"endocal: {words}"
    assert json.loads((out / "batch-report.json").read_text())["interrupted"]
    assert not [place for place in tree.outputs(out) if Path(place).name.startswith(".")]
    again = tree.run(recordings.source, out, recordings.lens)
    assert again.returncode == 1
    assert tree.outputs(out) == tree.outputs(recordings.whole)
