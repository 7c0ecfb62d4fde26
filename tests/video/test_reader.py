"""What the reader gives, and what it refuses."""

from __future__ import annotations

import io
import os
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest

from endocal.errors import InputError
from endocal.video.decoder import MAX_CONSECUTIVE_FAILURES
from endocal.video.frames import luma_view
from endocal.video.reader import VideoReader, is_frame
from tests.video.clips import Clip


def frames_of(reader: VideoReader) -> list[av.VideoFrame]:
    return [item for item in reader.items() if is_frame(item)]


def refusal(path: Path | str) -> str:
    with pytest.raises(InputError) as caught, VideoReader(str(path), name="it") as reader:
        frames_of(reader)
    message = str(caught.value)
    assert message.startswith("it: ")
    assert "\n" not in message
    return message


def test_frames_come_in_order_with_their_times(tmp_path: Path) -> None:
    path = Clip(frames=30, codec="libx264", sounds=("deu",)).make(tmp_path / "a.mp4")
    with VideoReader(str(path), name="a") as reader:
        items = list(reader.items())
        assert (reader.damaged, reader.corrupt, reader.truncated) == (0, 0, False)
    times = [item.time for item in items if is_frame(item)]
    assert times == pytest.approx([i / 25 for i in range(30)])
    assert any(not is_frame(item) for item in items), "the sound's packets come along"


def test_the_stream_is_described(tmp_path: Path) -> None:
    clip = Clip(
        frames=5,
        codec="libx264",
        sample_aspect=Fraction(64, 45),
        colour=(1, 1, 1, 1),
        rate=Fraction(30000, 1001),
    )
    with VideoReader(str(clip.make(tmp_path / "a.mp4")), name="a") as reader:
        info = reader.info
    assert (info.size, info.pix_fmt, info.bits) == ((64, 48), "yuv420p", 8)
    assert info.sample_aspect == Fraction(64, 45)
    assert info.rate == Fraction(30000, 1001)
    assert info.frames == 5
    assert info.duration == pytest.approx(5 * 1001 / 30000, abs=1e-3)
    assert info.colour.full_range is False
    assert (info.colour.matrix, info.colour.primaries, info.colour.transfer) == (1, 1, 1)
    assert info.colour.chroma_location == "left"
    assert not info.interlaced


def test_a_pipe_is_read_as_a_file_is(tmp_path: Path) -> None:
    path = Clip(frames=8).make(tmp_path / "a.mkv")
    with VideoReader(io.BytesIO(path.read_bytes()), name="pipe") as reader:
        assert len(frames_of(reader)) == 8


def test_an_index_at_the_end_cannot_flow_through_a_pipe(tmp_path: Path) -> None:
    class Pipe:
        def __init__(self, data: bytes) -> None:
            self._rest = io.BytesIO(data)

        def read(self, size: int) -> bytes:
            return self._rest.read(size)

    def noise(number: int, width: int, height: int) -> np.ndarray:
        return np.random.default_rng(number).integers(0, 255, (height, width, 3)).astype(np.uint8)

    # Longer than what is read ahead, 1 MiB: a short one lies in the buffer as a whole.
    options = {"preset": "ultrafast", "crf": "1"}
    clip = Clip(frames=8, size=(480, 360), codec="libx264", picture=noise, options=options)
    data = clip.make(tmp_path / "a.mp4").read_bytes()
    assert len(data) > 2 << 20
    with pytest.raises(InputError, match="index at the end cannot flow through a pipe"):
        VideoReader(Pipe(data), name="stdin")
    front = clip.make(tmp_path / "b.mp4", movflags="faststart").read_bytes()
    with VideoReader(Pipe(front), name="stdin") as reader:
        assert len(frames_of(reader)) == 8


@pytest.mark.parametrize(
    ("name", "codec"), [("a.h264", "libx264"), ("a.avi", "libx264"), ("a.avi", "mpeg4")]
)
def test_frames_without_times_of_their_own_get_them_in_order(
    tmp_path: Path, name: str, codec: str
) -> None:
    """Such files hold no presentation times, and B-frames make the decoder give frames late."""
    clip = Clip(frames=20, codec=codec, options={"bf": "2"})
    with VideoReader(str(clip.make(tmp_path / name)), name="a") as reader:
        times = [f.time for f in frames_of(reader)]
    assert times == pytest.approx([i / 25 for i in range(20)])


@pytest.mark.parametrize(
    ("pix_fmt", "worked_in"),
    [("yuyv422", "yuv422p"), ("gray10be", "gray10le"), ("rgb48be", "gbrp16le"), ("nv12", "nv12")],
)
def test_other_pixel_formats_are_rearranged_without_loss(
    tmp_path: Path, pix_fmt: str, worked_in: str
) -> None:
    path = Clip(frames=2, codec="rawvideo", pix_fmt=pix_fmt).make(tmp_path / "a.nut")

    def accepts(name: str) -> bool:
        return name != pix_fmt or name == "nv12"

    with VideoReader(str(path), name="a", accepts=accepts) as reader:
        assert reader.info.pix_fmt == worked_in
        frame = frames_of(reader)[0]
    with av.open(str(path)) as file:
        plain = next(file.decode(video=0))
    there_and_back = frame.reformat(format=pix_fmt)
    assert bytes(there_and_back.planes[0]) == bytes(plain.planes[0])


def test_what_is_no_video_is_refused_in_one_line(tmp_path: Path) -> None:
    empty, text, noise = (tmp_path / name for name in ("empty.mp4", "text.mp4", "noise.mkv"))
    empty.touch()
    text.write_text("no video " * 500)
    noise.write_bytes(np.random.default_rng(1).bytes(20000))
    assert "empty" in refusal(empty)
    assert "cannot be read as a video" in refusal(text)
    assert "cannot be read as a video" in refusal(noise)
    assert "no such file: check its name" in refusal(tmp_path / "missing.mp4")
    assert "directory" in refusal(tmp_path)


def test_a_file_without_a_video_stream_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "sound.m4a"
    with av.open(str(path), "w", format="mp4") as out:
        stream = out.add_stream("aac", rate=48000)
        frame = av.AudioFrame.from_ndarray(np.zeros((2, 1024), np.float32), "fltp", "stereo")
        frame.sample_rate = 48000
        out.mux(stream.encode(frame))
        out.mux(stream.encode(None))
    assert "no video stream" in refusal(path)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("list.m3u8", "#EXTM3U\n#EXT-X-TARGETDURATION:9\n#EXTINF:9,\n{0}\n#EXT-X-ENDLIST\n"),
        ("list.mp4", "ffconcat version 1.0\nfile '{0}'\n"),
        (
            "session.sdp",
            "v=0\no=- 0 0 IN IP4 127.0.0.1\ns=x\nc=IN IP4 127.0.0.1\nm=video 5004 RTP/AVP 96\n",
        ),
    ],
)
def test_scripts_that_name_other_files_are_refused(tmp_path: Path, name: str, text: str) -> None:
    inner = Clip(frames=3, codec="libx264").make(tmp_path / "inner.ts")
    script = tmp_path / name
    script.write_text(text.format(inner.name))
    assert "playlist or script" in refusal(script)


def test_a_playlist_opens_when_its_protocol_is_allowed_by_name(tmp_path: Path) -> None:
    Clip(frames=3, codec="libx264").make(tmp_path / "inner.ts")
    script = tmp_path / "list.m3u8"
    script.write_text("#EXTM3U\n#EXT-X-TARGETDURATION:9\n#EXTINF:9,\ninner.ts\n#EXT-X-ENDLIST\n")
    with VideoReader(str(script), name="list", allow_protocols=("file",)) as reader:
        assert len(frames_of(reader)) == 3


def test_names_are_taken_as_they_are(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A percent sign is no number pattern, a colon no protocol, a dash no option."""
    monkeypatch.chdir(tmp_path)
    made = Clip(frames=2).make(tmp_path / "made.mkv").read_bytes()
    for name in ("a %03d.mkv", "http:x.mkv", "-dash.mkv", "new\nline.mkv", "[x] é 日本.mkv"):
        Path(name).write_bytes(made)
        with VideoReader(name, name="n") as reader:
            assert len(frames_of(reader)) == 2, name


def test_a_size_that_changes_midway_is_an_error_that_names_the_time(tmp_path: Path) -> None:
    """Two transport streams end to end make one whose frames change."""
    small = Clip(frames=10, codec="libx264").make(tmp_path / "a.ts")
    large = Clip(frames=10, codec="libx264", size=(96, 48)).make(tmp_path / "b.ts")
    both = tmp_path / "both.ts"
    both.write_bytes(small.read_bytes() + large.read_bytes())
    message = refusal(both)
    assert "64x48" in message
    assert "96x48" in message
    assert " s: split the file there" in message


def test_a_frame_too_large_is_refused_before_it_is_decoded(tmp_path: Path) -> None:
    path = tmp_path / "huge.mkv"
    with av.open(str(path), "w") as out:
        stream = out.add_mux_stream("mjpeg", rate=25, width=20000, height=64)
        packet = av.Packet(b"\xff\xd8\xff\xe0" + bytes(200))
        packet.stream, packet.time_base = stream, Fraction(1, 1000)
        packet.pts = packet.dts = 0
        out.mux(packet)
    assert "larger than 16384 px a side" in refusal(path)


def test_damage_is_counted_and_the_rest_decoded(tmp_path: Path) -> None:
    path = Clip(frames=40, codec="libx264", options={"g": "10"}).make(tmp_path / "a.mp4")
    data = bytearray(path.read_bytes())
    start = data.find(b"mdat") + 1500
    for i in range(start, start + 1500, 30):
        data[i] ^= 0xFF
    path.write_bytes(data)
    with VideoReader(str(path), name="a") as reader:
        count = len(frames_of(reader))
        assert reader.damaged + reader.corrupt > 0
    assert 20 <= count <= 40


def test_a_file_that_breaks_off_gives_what_is_there(tmp_path: Path) -> None:
    path = Clip(frames=100, rate=Fraction(25)).make(tmp_path / "a.mkv")
    os.truncate(path, path.stat().st_size // 2)
    with VideoReader(str(path), name="a") as reader:
        count = len(frames_of(reader))
        assert reader.truncated
    assert 20 < count < 80


def test_an_avi_or_mp4_that_breaks_off(tmp_path: Path) -> None:
    """An AVI without its index still knows how many frames it had; an MP4 without its own holds nothing."""
    clip = Clip(frames=100, codec="libx264", options={"g": "10", "bf": "0"})
    for name in ("a.avi", "a.mp4"):
        path = clip.make(tmp_path / name)
        os.truncate(path, path.stat().st_size // 2)
    with VideoReader(str(tmp_path / "a.avi"), name="a") as reader:
        assert 20 < len(frames_of(reader)) < 80
        assert reader.truncated
    assert "breaks off before its index" in refusal(tmp_path / "a.mp4")


def test_it_gives_up_after_many_failures_in_a_row(tmp_path: Path) -> None:
    count = MAX_CONSECUTIVE_FAILURES + 40
    path = Clip(frames=count, codec="png", pix_fmt="rgb24", size=(32, 32)).make(tmp_path / "a.mov")
    data = path.read_bytes()
    first, *rest = data.split(b"\x89PNG\r\n\x1a\n")
    # The first picture stays whole; the others lose their signature.
    path.write_bytes(first + b"\x89PNG\r\n\x1a\n" + b"????????".join(rest))
    assert f"{MAX_CONSECUTIVE_FAILURES} packets in a row" in refusal(path)


def test_samples_leave_every_frame_to_be_read(tmp_path: Path) -> None:
    path = Clip(frames=40, codec="libx264", options={"g": "8"}).make(tmp_path / "a.mp4")
    for source in (str(path), io.BytesIO(path.read_bytes())):
        with VideoReader(source, name="a") as reader:
            runs = list(reader.samples(places=3, frames=4))
            assert all(len(run) >= 4 for run in runs)
            assert len(runs) == (3 if isinstance(source, str) else 1)
            assert len(frames_of(reader)) == 40


@pytest.mark.parametrize("suffix", ["mp4", "mkv", "ts", "avi"])
def test_samples_from_further_on_are_the_frames_that_items_yields(
    tmp_path: Path, suffix: str
) -> None:
    path = Clip(frames=40, codec="libx264", options={"g": "8", "bf": "0"}).make(
        tmp_path / f"a.{suffix}"
    )
    with VideoReader(str(path), name="a") as reader:
        runs = list(reader.samples(places=3, frames=4))
        frames = {luma_view(frame).tobytes() for frame in frames_of(reader)}
    assert len(runs) == 3
    assert all(luma_view(frame).tobytes() in frames for run in runs for frame in run)
    assert len({luma_view(frame).tobytes() for run in runs for frame in run}) > 8


def test_samples_do_not_repeat_what_follows_one_key_frame(tmp_path: Path) -> None:
    path = Clip(frames=40, codec="libx264", options={"g": "25"}).make(tmp_path / "a.mp4")
    with VideoReader(str(path), name="a") as reader:
        runs = [[frame.pts for frame in run] for run in reader.samples(places=4, frames=4)]
        assert [len(run) for run in runs] == [4, 4]
        assert runs[1][0] > runs[0][-1]
        assert len(frames_of(reader)) == 40
