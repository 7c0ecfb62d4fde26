"""Reading, changing and writing at once, in threads joined by short queues.

Each stage runs as fast as the slowest; a queue that is full stops the stage before it, so memory does not
grow with the length of a video. An error in any stage, or an interrupt, ends all of them.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterable
from typing import Generic, TypeVar

T = TypeVar("T")

# Frames that wait between two stages: enough to smooth out uneven frames, few enough at 2160p.
QUEUE_DEPTH = 3


class _Stopped(Exception):
    """The pipeline is being taken down: no error, but the end of a stage."""


class Channel(Generic[T]):
    """A bounded queue between two threads that ends and stops.

    Only items for which ``counts`` is true take up room: small ones travel with the large ones. With
    ``drop``, a full queue gives up its oldest such item, and tells, rather than let the new one wait.
    """

    def __init__(
        self,
        depth: int,
        counts: Callable[[T], bool] = lambda item: True,
        drop: Callable[[T], None] | None = None,
    ) -> None:
        self._depth = depth
        self._drop = drop
        self._counts = counts
        self._items: deque[T] = deque()
        self._used = 0
        self._ended = False
        self._stopped = False
        self._changed = threading.Condition()

    def put(self, item: T) -> None:
        """Append an item, waiting while the queue is full; raises _Stopped after stop()."""
        with self._changed:
            while self._used >= self._depth and not self._stopped:
                if self._drop is None:
                    self._changed.wait()
                elif self._counts(item):
                    self._drop_oldest(self._drop)
                else:
                    break
            if self._stopped:
                raise _Stopped
            self._items.append(item)
            self._used += self._counts(item)
            self._changed.notify_all()

    def _drop_oldest(self, tell: Callable[[T], None]) -> None:
        oldest = next(i for i, item in enumerate(self._items) if self._counts(item))
        tell(self._items[oldest])
        del self._items[oldest]
        self._used -= 1

    def __iter__(self) -> Channel[T]:
        return self

    def __next__(self) -> T:
        with self._changed:
            while not self._items and not self._ended and not self._stopped:
                self._changed.wait()
            if self._stopped:
                raise _Stopped
            if not self._items:
                raise StopIteration
            item = self._items.popleft()
            self._used -= self._counts(item)
            self._changed.notify_all()
            return item

    def end(self) -> None:
        """Say that no item follows."""
        with self._changed:
            self._ended = True
            self._changed.notify_all()

    def stop(self) -> None:
        """Let both sides go at once."""
        with self._changed:
            self._stopped = True
            self._changed.notify_all()


class _Run:
    """The threads of one pipeline and the first error among them."""

    def __init__(self) -> None:
        self.channels: list[Channel] = []
        self.threads: list[threading.Thread] = []
        self.error: BaseException | None = None
        self._lock = threading.Lock()

    def start(self, name: str, work: Callable[[], None]) -> None:
        def body() -> None:
            try:
                work()
            except _Stopped:
                return
            except BaseException as error:
                self.fail(error)

        thread = threading.Thread(target=body, name=name, daemon=True)
        self.threads.append(thread)
        thread.start()

    def fail(self, error: BaseException) -> None:
        with self._lock:
            self.error = self.error or error
        self.stop()

    def stop(self) -> None:
        for channel in self.channels:
            channel.stop()


def run(
    source: Iterable[T],
    change: Callable[[T], T],
    sink: Callable[[T], None],
    *,
    is_large: Callable[[T], bool] = lambda item: True,
    tick: Callable[[], None] = lambda: None,
    on_stop: Callable[[], None] = lambda: None,
    on_interrupt: Callable[[], None] | None = None,
    drop: Callable[[T], None] | None = None,
    tick_s: float = 0.1,
    patience_s: float = 3.0,
) -> None:
    """Pass every item of ``source`` through ``change`` into ``sink``, each in a thread of its own.

    Items for which ``is_large`` is true are bounded in number. ``tick`` is called in the calling thread
    every ``tick_s`` seconds, and an exception that it or an interrupt raises there ends the run; ``on_stop``
    is called when it ends before its time, to wake a source that waits. All threads have ended on return,
    save one that blocks for ``patience_s`` in an output that takes nothing; the first error of a stage is
    raised.

    For a live source, ``drop`` is told of the items that are left out when the stages cannot keep up, and
    ``on_interrupt``, called at the first interrupt, asks the source to end, so that the run ends well.
    """
    state = _Run()
    read: Channel[T] = Channel(QUEUE_DEPTH if drop is None else 1, is_large, drop)
    changed: Channel[T] = Channel(QUEUE_DEPTH if drop is None else 1, is_large)
    state.channels += [read, changed]

    def reading() -> None:
        for item in source:
            read.put(item)
        read.end()

    def changing() -> None:
        for item in read:
            changed.put(change(item))
        changed.end()

    def writing() -> None:
        for item in changed:
            sink(item)

    try:
        state.start("endocal-read", reading)
        state.start("endocal-change", changing)
        state.start("endocal-write", writing)
        while any(thread.is_alive() for thread in state.threads):
            try:
                tick()
                state.threads[-1].join(tick_s)
            except KeyboardInterrupt:
                if on_interrupt is None:
                    raise
                on_interrupt()
                on_interrupt = None
            if state.error is not None:
                on_stop()
                break
    except BaseException:
        state.stop()
        on_stop()
        raise
    finally:
        for thread in state.threads:
            if thread.ident is not None:  # an interrupt may come before it has been started
                thread.join(patience_s)
    tick()
    if state.error is not None:
        raise state.error
