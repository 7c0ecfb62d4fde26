"""The library's messages: none on the terminal, whichever thread they come from and whenever."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import av.logging

from endocal.video.messages import heard

from .clips import Clip

# Two threads make the library complain, while this one listens and stops listening over and over.
_NOISE = """
import sys, threading, av, av.logging
from endocal.video.messages import heard

done = threading.Event()

def complain():
    while not done.is_set():
        for _ in range(50):
            av.logging.log(av.logging.ERROR, "stray", "an error of another thread")
        av.open(sys.argv[1], options={"codec_whitelist": "none"}).close()

threads = [threading.Thread(target=complain) for _ in range(2)]
for thread in threads:
    thread.start()
for i in range(300):
    with heard(av.logging.WARNING, in_detail=i % 2 == 0) as messages:
        av.logging.log(av.logging.WARNING, "own", str(i))
    assert [text for _, _, text in messages] == [str(i)], messages
done.set()
for thread in threads:
    thread.join()
"""


def test_nothing_reaches_the_terminal(tmp_path: Path) -> None:
    clip = Clip(codec="libx264").make(tmp_path / "a.mp4")
    done = subprocess.run(
        [sys.executable, "-c", _NOISE, str(clip)], capture_output=True, text=True, timeout=120
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_the_same_message_is_heard_each_time() -> None:
    for _ in range(2):
        with heard(av.logging.WARNING) as messages:
            av.logging.log(av.logging.WARNING, "it", "again")
            av.logging.log(av.logging.INFO, "it", "less")
        assert messages == [(av.logging.WARNING, "it", "again")]
