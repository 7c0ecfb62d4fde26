"""The streams beside the video: copied packet by packet, with their tags."""

from __future__ import annotations

import av
import av.container
import av.stream

from .container import ContainerKind
from .reader import VideoReader
from .tags import container_tags, stream_tags


class Copies:
    """Copies of a source's other streams in an output, and the source's tags and chapters.

    ``strip`` leaves out all tags and chapters, and the streams that may tell who is seen: data,
    attachments, cover pictures. ``notes`` says which streams the container does not take; ``dropped``
    counts the damaged packets that no container takes.
    """

    def __init__(
        self,
        output: av.container.OutputContainer,
        kind: ContainerKind,
        like: VideoReader,
        strip: bool,
    ) -> None:
        self.notes: list[str] = []
        self.dropped = 0
        self._output = output
        self._kind = kind
        self._like = like
        self._strip = strip
        self._last_dts: dict[int, int] = {}
        self._by_source = self._add()

    def _add(self) -> dict[int, av.stream.Stream]:
        """Add a copy of each stream; return them by the index of their source."""
        copies: dict[int, av.stream.Stream] = {}
        for source in self._like.others:
            if self._strip and source.type in ("data", "attachment", "video"):
                continue
            if not self._kind.takes_stream(source):
                what = " ".join(filter(None, (source.name, source.type)))
                self.notes.append(
                    f"{self._kind.shown} does not take stream {source.index} ({what}), which is left out"
                )
                continue
            copy = self._output.add_stream_from_template(source, opaque=True)
            copy.disposition = source.disposition
            copies[source.index] = copy
        return copies

    def copy_tags(self, video: av.VideoStream) -> None:
        """Give the output, ``video`` in it, and the copies what the source says of them."""
        if self._strip:
            return
        source = self._like.container
        self._output.metadata.update(container_tags(source.metadata))
        pairs: list[tuple[av.stream.Stream, av.stream.Stream]] = [(self._like.stream, video)]
        pairs += [(source.streams[i], copy) for i, copy in self._by_source.items()]
        for original, copy in pairs:
            copy.metadata.update(stream_tags(original.metadata, self._kind.name))
        chapters = source.chapters()
        if chapters:
            self._output.set_chapters(chapters)

    def write(self, packet: av.Packet) -> None:
        """Copy a packet of any of the streams; raises what the muxer raises."""
        copy = self._by_source.get(packet.stream_index)
        if copy is None:
            return
        if packet.dts is None:
            packet.dts = packet.pts
        last = self._last_dts.get(copy.index)
        if packet.dts is not None:
            if last is not None and packet.dts < last:
                # Only damage does that; a container does not take a packet that goes back in time.
                packet.dts = last
                packet.pts = None if packet.pts is None else max(packet.pts, last)
            self._last_dts[copy.index] = packet.dts
        packet.stream = copy
        try:
            self._output.mux_one(packet)
        except (av.error.InvalidDataError, av.error.ArgumentError, av.error.PatchWelcomeError):
            # A damaged packet that the container cannot even repackage. The rest is worth having.
            self.dropped += 1
