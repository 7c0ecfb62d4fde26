"""What goes in comes out: with lambda 0 nothing at all may change, and in any case all but the pixels."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest

from endocal.jobs.correct import CorrectionReport, CorrectionSpec, correct
from endocal.video.frames import plane_views
from tests.jobs.lenses import calibration
from tests.video.clips import Clip, Contents, contents

ARCHIVE = Clip(frames=6)
DELIVERY = Clip(frames=12, codec="libx264", options={"preset": "ultrafast"})


def identity(
    tmp_path: Path, clip: Clip, name: str, out: str | None = None, **options: Any
) -> tuple[Contents, Contents, CorrectionReport]:
    """Correct a clip with lambda 0 and return what is in the source and in the result."""
    source = clip.make(tmp_path / name)
    result = tmp_path / f"out-{out or name}"
    lens = calibration(tmp_path / "cal.toml", size=clip.size)
    report = correct(CorrectionSpec(str(source), str(result), lens, device="numpy", **options))
    return contents(source), contents(result), report


@pytest.mark.parametrize(
    "pix_fmt",
    [
        *("yuv420p", "yuv422p", "yuv444p", "gray", "gray16le", "yuv420p10le", "yuv422p12le"),
        *("gbrp12le", "bgr0", "yuva420p", "gbrp16le"),
    ],
)
@pytest.mark.parametrize("size", [(64, 48), (67, 35)])
def test_without_distortion_every_sample_stays(
    tmp_path: Path, pix_fmt: str, size: tuple[int, int]
) -> None:
    clip = replace(ARCHIVE, pix_fmt=pix_fmt, size=size)
    before, after, report = identity(tmp_path, clip, "a.mkv")
    assert report.codec == "ffv1"
    assert len(after.frames) == clip.frames
    for a, b in zip(before.frames, after.frames, strict=True):
        assert b.format.name == pix_fmt
        for p, q in zip(plane_views(a), plane_views(b), strict=True):
            assert np.array_equal(p, q)


@pytest.mark.parametrize("name", ["a.mp4", "a.mov", "a.mkv", "a.ts"])
@pytest.mark.parametrize("b_frames", ["0", "3"])
def test_uneven_times_and_a_late_start_stay(tmp_path: Path, name: str, b_frames: str) -> None:
    """Variable frame rate, first frame at 0.7 s."""
    ticks = [63000 + 3600 * i + (1800 if i % 3 else 0) + (9000 if i > 6 else 0) for i in range(12)]
    clip = replace(
        DELIVERY,
        time_base=Fraction(1, 90000),
        pts=ticks,
        sounds=("deu",),
        options={"preset": "ultrafast", "bf": b_frames},
    )
    before, after, _ = identity(tmp_path, clip, name)
    assert after.times == pytest.approx(before.times, abs=1e-6)
    for i, packets in before.packets.items():
        times = [time for time, _ in packets]
        assert [time for time, _ in after.packets[i]] == pytest.approx(times, abs=1e-3)


def test_an_edit_list_that_hides_frames_is_kept_in_effect(tmp_path: Path) -> None:
    """A cut without re-encoding: the first frames are in the file but before time zero."""
    whole = replace(DELIVERY, frames=30, sounds=("deu",)).make(tmp_path / "whole.mp4")
    cut = tmp_path / "cut.mp4"
    with av.open(str(whole)) as source, av.open(str(cut), "w") as out:
        copies = {s.index: out.add_stream_from_template(s, opaque=True) for s in source.streams}
        for packet in source.demux():
            if packet.size:
                packet.stream = copies[packet.stream_index]
                shift = int(Fraction(2, 5) / packet.time_base)
                packet.pts, packet.dts = packet.pts - shift, packet.dts - shift
                out.mux(packet)
    lens = calibration(tmp_path / "cal.toml")
    report = correct(CorrectionSpec(str(cut), str(tmp_path / "out.mp4"), lens, device="numpy"))
    before, after = contents(cut), contents(tmp_path / "out.mp4")
    assert 0 < len(before.times) < 30, "the edit list hides some frames"
    assert after.times == pytest.approx(before.times, abs=1e-6)
    assert report.warnings == ()
    for i in before.packets:
        kept = dict.fromkeys(round(t, 3) for t, _ in after.packets[i])
        assert all(round(t, 3) in kept for t, _ in before.packets[i] if t >= 0)


@pytest.mark.parametrize("name", ["a.mkv", "a.mp4"])
def test_every_stream_chapter_and_tag_is_kept(tmp_path: Path, name: str) -> None:
    clip = replace(
        DELIVERY,
        sounds=("deu", "fra"),
        subtitles=name.endswith("mkv"),
        attachment=b"scope 4711" if name.endswith("mkv") else None,
        metadata={"title": "Cholecystectomy", "comment": "theatre 3"},
        chapters=[(0, 0.2, "port"), (0.2, 0.48, "clip")],
    )
    before, after, report = identity(tmp_path, clip, name)
    assert after.types == before.types
    assert after.languages == before.languages
    assert after.chapters == before.chapters
    assert {k.lower(): v for k, v in after.metadata.items()}.items() >= {
        "title": "Cholecystectomy",
        "comment": "theatre 3",
    }.items()
    assert {i: [d for _, d in p] for i, p in after.packets.items()} == {
        i: [d for _, d in p] for i, p in before.packets.items()
    }
    assert report.notes == ()
    if clip.attachment is not None:
        with av.open(str(tmp_path / f"out-{name}")) as file:
            assert [s.data for s in file.streams.attachments] == [clip.attachment]


def test_patient_data_can_be_left_out(tmp_path: Path) -> None:
    clip = replace(
        DELIVERY,
        sounds=("deu",),
        attachment=b"Jane Doe",
        metadata={"title": "Jane Doe 1960-01-01"},
        chapters=[(0, 0.4, "Jane Doe")],
    )
    _, after, _ = identity(tmp_path, clip, "a.mkv", strip_metadata=True)
    assert after.types == ["video", "audio"]
    assert b"Jane Doe" not in (tmp_path / "out-a.mkv").read_bytes()


def test_what_does_not_fit_into_the_container_is_told(tmp_path: Path) -> None:
    clip = replace(DELIVERY, subtitles=True)
    _, after, report = identity(tmp_path, clip, "a.mkv", out="a.mp4")
    assert after.types == ["video"]
    assert report.notes == ("mp4 does not take stream 1 (srt subtitle), which is left out",)


@pytest.mark.parametrize("colour", [(1, 1, 1, 1), (2, 5, 5, 6), (1, 9, 9, 16)])
@pytest.mark.parametrize("name", ["a.mp4", "a.mkv"])
def test_colour_tags_stay(tmp_path: Path, name: str, colour: tuple[int, int, int, int]) -> None:
    _, after, _ = identity(tmp_path, replace(DELIVERY, colour=colour), name)
    frame = after.frames[0]
    assert (
        *(frame.color_range, frame.colorspace),
        *(frame.color_primaries, frame.color_trc),
    ) == colour


@pytest.mark.parametrize("place", ["left", "topleft", "center"])
def test_the_chroma_location_stays(tmp_path: Path, place: str) -> None:
    from endocal.video.reader import VideoReader

    options = {"preset": "ultrafast", "chroma_sample_location": place}
    identity(tmp_path, replace(DELIVERY, options=options), "a.mp4")
    for name in ("a.mp4", "out-a.mp4"):
        with VideoReader(str(tmp_path / name), name=name) as reader:
            assert reader.info.colour.chroma_location == place


def test_hdr_metadata_stays(tmp_path: Path) -> None:
    mastering = "G(13250,34500)B(7500,3000)R(34000,16000)WP(15635,16450)L(10000000,50)"
    clip = Clip(
        frames=3,
        size=(128, 96),
        codec="libx265",
        pix_fmt="yuv420p10le",
        colour=(1, 9, 9, 16),
        options={
            "preset": "ultrafast",
            "x265-params": f"log-level=none:master-display={mastering}:max-cll=1000,400",
        },
    )
    before, after, report = identity(tmp_path, clip, "a.mp4")
    assert report.codec == "libx265"
    for kind in ("MASTERING_DISPLAY_METADATA", "CONTENT_LIGHT_LEVEL"):
        data = [
            {s.type.name: bytes(s) for s in list(c.frames[0].side_data)}[kind]
            for c in (before, after)
        ]
        assert data[0] == data[1]


def test_the_rotation_stays(tmp_path: Path) -> None:
    turned = (0, 65536, 0, -65536, 0, 0, 0, 0, 1 << 30)
    before, after, _ = identity(tmp_path, replace(DELIVERY, display_matrix=turned), "a.mp4")
    assert before.frames[0].rotation != 0
    assert after.frames[0].rotation == before.frames[0].rotation


def test_the_timecode_stays(tmp_path: Path) -> None:
    source = tmp_path / "a.mov"
    with av.open(str(source), "w") as out:
        from tests.video.clips import Maker

        maker = Maker(DELIVERY, out)
        maker.video.metadata["timecode"] = "10:20:30:04"
        maker.run()
    lens = calibration(tmp_path / "cal.toml")
    correct(CorrectionSpec(str(source), str(tmp_path / "out.mov"), lens, device="numpy"))
    with av.open(str(tmp_path / "out.mov")) as file:
        assert file.streams.video[0].metadata["timecode"] == "10:20:30:04"
        assert len(file.streams.data) == 1


def test_a_frame_rate_that_is_a_fraction_stays(tmp_path: Path) -> None:
    clip = replace(DELIVERY, rate=Fraction(30000, 1001))
    before, after, _ = identity(tmp_path, clip, "a.mp4")
    assert after.times == pytest.approx(before.times, abs=1e-9)


def test_a_container_without_times_says_how_far_frames_moved(tmp_path: Path) -> None:
    ticks = [40 * i + (15 if i % 3 else 0) for i in range(12)]
    uneven = replace(DELIVERY, time_base=Fraction(1, 1000), pts=ticks)
    _, after, report = identity(tmp_path, uneven, "a.mkv", out="a.avi")
    assert len(after.frames) == 12
    assert report.notes == (
        "avi holds no times but a constant rate: frames moved by up to 0.015 s; .mp4 and .mkv keep the times",
    )
    _, _, report = identity(tmp_path, DELIVERY, "b.mkv", out="b.avi")
    assert report.notes == ()
    # A gap of 2 s is a gap in an AVI, and no more than the next frame in Y4M.
    gap = replace(uneven, pts=[40 * i + (2000 if i > 5 else 0) for i in range(12)])
    _, _, report = identity(tmp_path, gap, "c.mkv", out="c.avi")
    assert report.notes == ()
    _, _, report = identity(tmp_path, gap, "d.mkv", out="d.y4m")
    assert "moved by up to 2.000 s" in report.notes[0]


def test_a_gap_in_an_avi_is_no_damage(tmp_path: Path) -> None:
    """The frames that it declares count the gap too; nothing is missing."""
    gap = replace(DELIVERY, pts=[*range(5), *range(8, 15)])
    _, after, report = identity(tmp_path, gap, "a.avi", out="a.mkv")
    assert report.warnings == ()
    assert after.times == pytest.approx([pts / 25 for pts in gap.pts or ()], abs=1e-3)


def test_the_part_that_a_stream_plays_is_kept(tmp_path: Path) -> None:
    """Default or not, and the language by the code that QuickTime has for it."""
    from av.stream import Disposition

    source = tmp_path / "a.mkv"
    with av.open(str(source), "w") as out:
        from tests.video.clips import Maker

        maker = Maker(replace(DELIVERY, sounds=("deu", "fra")), out)
        maker.video.disposition = Disposition.default | Disposition.original
        maker.sounds[1].disposition = Disposition.comment
        maker.run()
    lens = calibration(tmp_path / "cal.toml")
    for name, german in (("out.mkv", "deu"), ("out.mov", "ger")):
        correct(CorrectionSpec(str(source), str(tmp_path / name), lens, device="numpy"))
        with av.open(str(tmp_path / name)) as file:
            assert [s.language for s in file.streams.audio] == [german, "fra"]
            if name == "out.mkv":
                assert file.streams.video[0].disposition == maker.video.disposition
                assert file.streams.audio[1].disposition & Disposition.comment


def test_the_titles_of_chapters_do_not_become_subtitles(tmp_path: Path) -> None:
    """Corrected twice, a recording with chapters and a timecode has no more streams than at first."""
    source = tmp_path / "a.mp4"
    with av.open(str(source), "w") as out:
        from tests.video.clips import Maker

        maker = Maker(replace(DELIVERY, chapters=[(0, 0.2, "port"), (0.2, 0.48, "clip")]), out)
        maker.video.metadata["timecode"] = "10:20:30:04"
        maker.run()
    lens = calibration(tmp_path / "cal.toml")
    for before, after in (("a.mp4", "b.mp4"), ("b.mp4", "c.mp4")):
        spec = CorrectionSpec(str(tmp_path / before), str(tmp_path / after), lens, device="numpy")
        correct(spec)
    found = contents(tmp_path / "c.mp4")
    assert found.types == contents(source).types
    assert found.chapters == contents(source).chapters


def test_a_data_stream_is_copied(tmp_path: Path) -> None:
    """What a device writes beside the picture, in a transport stream."""
    source = tmp_path / "a.ts"
    with av.open(str(source), "w") as out:
        from tests.video.clips import Maker

        maker = Maker(DELIVERY, out)
        data = out.add_data_stream("bin_data")
        maker.run()
        for second in range(3):
            packet = av.Packet(bytes([second]) * 40)
            packet.stream, packet.time_base = data, Fraction(1, 90000)
            packet.pts = packet.dts = second * 9000
            out.mux(packet)
    lens = calibration(tmp_path / "cal.toml")
    report = correct(CorrectionSpec(str(source), str(tmp_path / "b.ts"), lens, device="numpy"))
    before, after = contents(source), contents(tmp_path / "b.ts")
    assert report.notes == ()
    assert after.types == before.types == ["video", "data"]
    assert [d for _, d in before.packets[1]] == [bytes([n]) * 40 for n in range(3)]
    assert [d for _, d in after.packets[1]] == [d for _, d in before.packets[1]]


def test_planes_of_two_chroma_components_stay(tmp_path: Path) -> None:
    clip = replace(ARCHIVE, codec="rawvideo", pix_fmt="nv12", size=(66, 34))
    before, after, report = identity(tmp_path, clip, "a.mkv")
    assert report.codec == "rawvideo"
    for a, b in zip(before.frames, after.frames, strict=True):
        assert b.format.name == "nv12"
        for p, q in zip(plane_views(a), plane_views(b), strict=True):
            assert np.array_equal(p, q)
