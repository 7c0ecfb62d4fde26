"""The packets of a container in its order, and whether they break off before its time."""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction

import av
import av.container

from .extent import is_cut_off

# A file that ends by so many seconds before its declared duration has been cut off.
_MISSING_S = 0.5
# Containers that hold no presentation times: what the library gives for them is a guess, and wrong where
# frames are stored in another order than they are shown in.
_WITHOUT_TIMES = frozenset(("avi", "h264", "hevc", "mpegvideo", "m4v", "mjpeg", "rawvideo"))
# Containers whose duration counts from time zero, not from their first frame.
_DURATION_FROM_ZERO = frozenset(("matroska,webm", "asf", "nut"))


def is_without_times(container: av.container.InputContainer) -> bool:
    """Tell whether a container holds no presentation times."""
    return container.format.name in _WITHOUT_TIMES


class Packets:
    """The packets of ``container``, with one in the end that flushes the decoder of ``stream``.

    ``path`` is that of the file, None for a pipe; a ``live`` source never ends before its time.
    ``truncated`` says that the file ended before its time: final when the packets have ended.
    """

    def __init__(
        self,
        container: av.container.InputContainer,
        stream: av.VideoStream,
        path: str | None,
        live: bool,
    ) -> None:
        self.truncated = False
        self._container = container
        self._stream = stream
        self._path = path
        self._live = live
        self._end = -math.inf
        self._packets = self._demux()

    def next(self) -> av.Packet | None:
        """Return the next packet; None at the end."""
        return next(self._packets, None)

    def _demux(self) -> Iterator[av.Packet]:
        """Yield packets; the dummy packets that end a stream only for the video, which they flush."""
        packets = self._container.demux()
        while True:
            try:
                packet = next(packets)
            except StopIteration:
                break
            except av.error.FFmpegError:
                # The container breaks off here, as a live one does in the end. What the decoder still holds
                # is worth having.
                self.truncated = not self._live
                yield self._flush_packet()
                return
            if packet.size == 0 and packet.dts is None:
                if packet.stream is self._stream:
                    yield self._flush_packet()
                continue
            self._note_time(packet)
            yield packet
        self.truncated = not self._live and self._ends_early()

    def _flush_packet(self) -> av.Packet:
        packet = av.Packet()
        packet.stream = self._stream
        packet.time_base = self._stream.time_base or Fraction(1, av.time_base)
        return packet

    def _note_time(self, packet: av.Packet) -> None:
        time = packet.pts if packet.pts is not None else packet.dts
        if time is not None and packet.time_base:
            end = float((time + (packet.duration or 0)) * packet.time_base)
            self._end = max(self._end, end)

    def _ends_early(self) -> bool:
        """Tell whether the file lacks its end, or all streams end well before the container says."""
        container = self._container
        if self._path is not None and (cut := is_cut_off(self._path)) is not None:
            # Times do not tell then: the last frame may be declared to be shown for long.
            return cut
        if not container.duration or self._end == -math.inf:
            return False
        start = 0 if container.format.name in _DURATION_FROM_ZERO else container.start_time or 0
        declared = (start + container.duration) / av.time_base
        rate = self._stream.average_rate
        if is_without_times(container) and self._stream.frames and rate:
            # Its duration may be a guess from what is left of the file.
            declared = max(declared, float(self._stream.frames / rate))
        return declared - self._end > _MISSING_S
