"""What an output container takes, found out by asking it."""

from __future__ import annotations

import io
from fractions import Fraction

import av
import av.container
import av.stream

MOV_FAMILY = frozenset(("mp4", "mov", "ipod", "3gp", "3g2", "ismv", "f4v", "psp"))
# Containers that never refuse a codec, but whose readers know these only.
_READABLE = {
    "mpegts": {"h264", "hevc", "mpeg2video", "mpeg1video", "mpeg4"},
    "yuv4mpegpipe": {"rawvideo"},
    "avi": {"h264", "mpeg4", "mjpeg", "ffv1", "rawvideo", "mpeg2video", "mpeg1video", "huffyuv"},
    "ogg": {"theora", "vp8"},
    "ogv": {"theora", "vp8"},
    "rawvideo": {"rawvideo"},
}
# Containers that take raw video in any pixel format, and may name it so that it is read as another.
_RAW_BY_NAME = ("matroska", "avi", "mov")
# Tags of the MP4 family's own vocabulary. Others only travel in QuickTime's keyed form.
_MOV_TAGS = {
    *(
        "title",
        "artist",
        "album_artist",
        "composer",
        "album",
        "date",
        "comment",
        "genre",
        "copyright",
    ),
    *("grouping", "lyrics", "description", "synopsis", "show", "episode_id", "network", "keywords"),
    *("location", "timecode", "creation_time", "track", "disc", "rating"),
}


class ContainerKind:
    """A container format by FFmpeg's name."""

    def __init__(self, name: str) -> None:
        self.name = name

    @property
    def shown(self) -> str:
        """The name that people give it."""
        return {"yuv4mpegpipe": "y4m"}.get(self.name, self.name)

    def takes_codec(self, encoder: str, pix_fmt: str = "") -> bool:
        """Tell whether video from the named encoder, fed with ``pix_fmt``, goes into this container."""
        codec = av.Codec(encoder, "w").canonical_name
        if self.name in _READABLE and codec not in _READABLE[self.name]:
            return False
        if codec == "rawvideo" and pix_fmt and self.name in _RAW_BY_NAME:
            return self._gives_back(pix_fmt)
        if self.name in _READABLE:
            return True
        scratch = self._scratch()
        try:
            scratch.add_stream(encoder)
        except ValueError:
            return False
        return True

    def _gives_back(self, pix_fmt: str) -> bool:
        """Tell whether raw frames in ``pix_fmt`` are read again as what they were written as."""
        file = io.BytesIO()
        try:
            with av.open(file, mode="w", format=self.name) as container:
                stream = container.add_stream("rawvideo", rate=25)
                assert isinstance(stream, av.VideoStream)
                stream.width, stream.height, stream.pix_fmt = 16, 16, pix_fmt
                container.mux([*stream.encode(av.VideoFrame(16, 16, pix_fmt)), *stream.encode()])
            file.seek(0)
            with av.open(file) as container:
                return container.streams.video[0].codec_context.pix_fmt == pix_fmt
        except (ValueError, av.error.FFmpegError):
            return False

    def takes_stream(self, stream: av.stream.Stream) -> bool:
        """Tell whether a copy of a stream goes into this container."""
        if self.name == "yuv4mpegpipe":
            return False
        scratch = self._scratch()
        try:
            scratch.add_stream_from_template(stream, opaque=True)
            scratch.start_encoding()
            scratch.close()
        except (ValueError, av.error.FFmpegError):
            return False
        return True

    @property
    def reorders(self) -> bool:
        """Whether frames may be stored in another order than they are shown in."""
        return self.name not in ("avi", "asf", "yuv4mpegpipe", "rawvideo", "mjpeg")

    @property
    def describes_itself(self) -> bool:
        """Whether a file of this kind can be opened and looked at with nothing but itself."""
        return self.name != "rawvideo"

    @property
    def holds_gaps(self) -> bool:
        """Whether a frame may be left out where frames have no time but their number."""
        return self.name == "avi"

    @property
    def counts_frames(self) -> bool:
        """Whether frames have no time but their number, from 0 on."""
        return self.name in ("avi", "yuv4mpegpipe", "h264", "hevc", "rawvideo", "mjpeg")

    def options(
        self, time_base: Fraction, tags: dict[str, str], flows: bool = False
    ) -> dict[str, str]:
        """Return muxer options that keep times and ``tags`` as they are.

        ``flows``: the output is a pipe, so that nothing can be put in later at its front.
        """
        # Nothing is shifted to begin at zero, except where a time below zero cannot be written at all.
        options = {} if self.name == "nut" else {"avoid_negative_ts": "disabled"}
        if self.name in MOV_FAMILY:
            if time_base.numerator == 1:
                options["video_track_timescale"] = str(time_base.denominator)
            flags = [] if {key.lower() for key in tags} <= _MOV_TAGS else ["use_metadata_tags"]
            flags += ["frag_keyframe", "empty_moov", "default_base_moof"] if flows else []
            if flags:
                options["movflags"] = "+".join(flags)
        if self.name == "yuv4mpegpipe":
            # More than 8 bits a sample are an extension, which every reader knows.
            options["strict"] = "-1"
        if self.name == "mpegts":
            options["mpegts_copyts"] = "1"
        return options

    def _scratch(self) -> av.container.OutputContainer:
        return av.open(io.BytesIO(), mode="w", format=self.name)
