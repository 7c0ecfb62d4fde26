"""The correction of videos: geometry, zoom, fields, pixels that are not square, damage."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest

from endocal.errors import DeviceError, InputError, OutputError, UsageError
from endocal.jobs import correct_video
from endocal.jobs.correct import correct
from endocal.jobs.correction import CorrectionReport, CorrectionSpec, Progress
from endocal.jobs.zoom_history import zoom_history
from endocal.model import DivisionModel
from endocal.remap.engine import FrameRemapper
from endocal.remap.geometry import output_geometry
from endocal.remap.layout import frame_layout
from endocal.video.frames import plane_views
from tests.jobs.lenses import calibration, zoom_table
from tests.video.clips import Clip, contents, drifting

CLIP = Clip(frames=6)
DELIVERY = Clip(frames=12, codec="libx264", options={"preset": "ultrafast"})
LAM, CENTER = -1.5e-4, (30.0, 25.0)


def run(
    tmp_path: Path, source: Path, lens: str, out: str = "out.mkv", **options: Any
) -> CorrectionReport:
    options.setdefault("device", "numpy")
    return correct(CorrectionSpec(str(source), str(tmp_path / out), lens, **options))


def circles(diameters: list[float], size: tuple[int, int]) -> Clip:
    """A clip of a bright textured disc on black, of these diameters."""

    def picture(number: int, width: int, height: int) -> np.ndarray:
        x, y = np.meshgrid(np.arange(width), np.arange(height))
        radius = np.hypot(x - (width - 1) / 2, y - (height - 1) / 2)
        soft = np.clip(diameters[number] / 2 - radius + 0.5, 0, 1)
        texture = 150 + 40 * np.sin(x / 5) * np.sin(y / 6)
        return (soft * texture).astype(np.uint8)[..., None].repeat(3, axis=2)

    return Clip(frames=len(diameters), size=size, picture=picture)


@pytest.mark.parametrize("device", ["numpy", "auto"])
@pytest.mark.parametrize("view", ["same", "crop", "full"])
def test_frames_are_remapped_as_pictures_are(tmp_path: Path, device: str, view: str) -> None:
    """Against the reference engine on the decoded planes: one level of 8 bit."""
    source = CLIP.make(tmp_path / "a.mkv")
    lens = calibration(tmp_path / "cal.toml", LAM, CENTER)
    report = run(tmp_path, source, lens, view=view, device=device)
    before, after = contents(source), contents(tmp_path / "out.mkv")
    assert after.times == before.times
    model = DivisionModel(LAM, CENTER, CLIP.size)
    layout = frame_layout("yuv420p", CLIP.size, full_range=False)
    remapper = FrameRemapper(layout, output_geometry([model], [None], view), device="numpy")
    assert report.size_out == remapper.output_layout.size
    for a, b in zip(before.frames, after.frames, strict=True):
        expected = remapper.output_layout.empty()
        remapper.apply(model, plane_views(a), expected)
        for p, q in zip(plane_views(b), expected, strict=True):
            assert np.abs(p.astype(int) - q).max() <= 1


def test_frames_under_way_to_a_device_come_back_in_order(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The way of a GPU, on the device that there is: staged, coordinates on the fly, two frames at once."""
    from endocal.remap.opencl_device import DeviceSession

    source = replace(CLIP, frames=12).make(tmp_path / "a.mkv")
    lens = calibration(tmp_path / "cal.toml", LAM, CENTER)
    run(tmp_path, source, lens, "plain.mkv", device="numpy")
    monkeypatch.setattr(DeviceSession, "shares_memory", False)
    monkeypatch.setattr("endocal.remap.opencl_engine.choose_strategy", lambda session: "direct")
    report = run(tmp_path, source, lens, "staged.mkv", device="auto")
    assert report.frames == 12
    frames = [contents(tmp_path / name).frames for name in ("plain.mkv", "staged.mkv")]
    for a, b in zip(*frames, strict=True):
        for p, q in zip(plane_views(a), plane_views(b), strict=True):
            assert np.abs(p.astype(int) - q).max() <= 1


def test_the_report_tells_what_was_done(tmp_path: Path) -> None:
    source = DELIVERY.make(tmp_path / "a.mp4")
    steps: list[Progress] = []
    lens = calibration(tmp_path / "cal.toml", LAM, CENTER)
    spec = CorrectionSpec(str(source), str(tmp_path / "out.mp4"), lens, device="numpy")
    report = correct(spec, steps.append)
    assert (report.frames, report.codec, report.device) == (12, "libx264", "numpy")
    assert (report.size_in, report.size_out) == ((64, 48), (64, 48))
    assert (report.damaged, report.corrupt, report.warnings, report.notes) == (0, 0, (), ())
    assert steps[-1].frames == steps[-1].total == 12


@pytest.mark.parametrize("threads", [1, 2])
def test_the_encoder_has_the_threads_that_were_given(tmp_path: Path, threads: int) -> None:
    source = DELIVERY.make(tmp_path / "a.mp4")
    lens = calibration(tmp_path / "cal.toml", LAM, CENTER)
    run(tmp_path, source, lens, "out.mp4", threads=threads)
    # x264 writes its settings into the stream.
    assert f" threads={threads} ".encode() in (tmp_path / "out.mp4").read_bytes()


def test_a_calibration_of_another_size_is_rescaled_and_told(tmp_path: Path) -> None:
    source = CLIP.make(tmp_path / "a.mkv")
    half = calibration(tmp_path / "half.toml", LAM * 4, (14.75, 12.25), (32, 24))
    whole = calibration(tmp_path / "whole.toml", LAM, CENTER)
    report = run(tmp_path, source, half, "half.mkv")
    assert "32x24 and is rescaled to 64x48" in report.notes[0]
    assert run(tmp_path, source, whole, "whole.mkv").notes == ()
    for a, b in zip(
        contents(tmp_path / "half.mkv").frames, contents(tmp_path / "whole.mkv").frames, strict=True
    ):
        assert all(
            np.array_equal(p, q) for p, q in zip(plane_views(a), plane_views(b), strict=True)
        )


def test_a_calibration_of_another_shape_is_refused(tmp_path: Path) -> None:
    source = CLIP.make(tmp_path / "a.mkv")
    lens = calibration(tmp_path / "cal.toml", LAM, CENTER, (64, 60))
    with pytest.raises(InputError, match="another shape"):
        run(tmp_path, source, lens)
    assert not (tmp_path / "out.mkv").exists()


def test_pixels_become_square_unless_kept(tmp_path: Path) -> None:
    """64x48 with pixels of 4:3 shows 85.3x48; a calibration on square pixels of that shape fits."""
    source = replace(DELIVERY, sample_aspect=Fraction(4, 3)).make(tmp_path / "a.mp4")
    lens = calibration(tmp_path / "cal.toml", LAM / 4, (84, 48), (170, 96))
    for keep, size, aspect in ((False, (86, 48), 1), (True, (64, 48), Fraction(4, 3))):
        report = run(tmp_path, source, lens, f"{keep}.mp4", keep_sar=keep)
        assert report.size_out == size
        with av.open(str(tmp_path / f"{keep}.mp4")) as file:
            assert file.streams.video[0].sample_aspect_ratio == aspect


def test_original_and_corrected_side_by_side(tmp_path: Path) -> None:
    source = replace(CLIP, size=(66, 50)).make(tmp_path / "a.mkv")
    lens = calibration(tmp_path / "cal.toml", LAM, CENTER, (66, 50))
    run(tmp_path, source, lens, "alone.mkv", scale=0.5)
    report = run(tmp_path, source, lens, "both.mkv", scale=0.5, side_by_side=True)
    # Half of 25 rows is not whole in chroma: 26.
    assert report.size_out == (66 + 34, 50)
    before, alone, both = (
        contents(p).frames for p in (source, tmp_path / "alone.mkv", tmp_path / "both.mkv")
    )
    for a, b, c in zip(before, alone, both, strict=True):
        left, right, whole = plane_views(a)[0], plane_views(b)[0], plane_views(c)[0]
        assert np.array_equal(whole[:, :66], left)
        assert np.array_equal(whole[12:38, 66:], right)
        assert (whole[:12, 66:] == 16).all()
        assert (whole[38:, 66:] == 16).all()


@pytest.mark.parametrize("arrangement", ["sbs", "tb"])
def test_two_eyes_are_corrected_each_by_its_own_lens(tmp_path: Path, arrangement: str) -> None:
    axis = 1 if arrangement == "sbs" else 0

    def picture(number: int, width: int, height: int) -> np.ndarray:
        return np.concatenate([drifting(number + 5 * eye, 64, 48) for eye in (0, 1)], axis=axis)

    size = (128, 48) if arrangement == "sbs" else (64, 96)
    both = replace(CLIP, size=size, picture=picture).make(tmp_path / "both.mkv")
    lenses = [
        calibration(tmp_path / "left.toml", LAM, CENTER),
        calibration(tmp_path / "right.toml", -LAM, (34.0, 22.0)),
    ]
    report = run(tmp_path, both, lenses[0], stereo=arrangement, right_calibration=lenses[1])
    assert report.size_out == size
    whole = contents(tmp_path / "out.mkv").frames
    for eye, lens in enumerate(lenses):
        one = replace(CLIP, picture=lambda n, w, h, eye=eye: drifting(n + 5 * eye, w, h))
        run(tmp_path, one.make(tmp_path / f"{eye}.mkv"), lens, f"out{eye}.mkv")
        for a, b in zip(whole, contents(tmp_path / f"out{eye}.mkv").frames, strict=True):
            part = np.split(plane_views(a)[0], 2, axis=axis)[eye]
            # The encoder's rearrangement from RGB is each frame's own: chroma may differ, luma not.
            assert np.array_equal(part, plane_views(b)[0])


def test_a_frame_that_cannot_be_halved_is_refused(tmp_path: Path) -> None:
    source = replace(CLIP, size=(66, 48)).make(tmp_path / "a.mkv")
    lens = calibration(tmp_path / "cal.toml", LAM, (16, 24), (33, 48))
    with pytest.raises(InputError, match="cannot be halved"):
        run(tmp_path, source, lens, stereo="sbs")


@pytest.mark.parametrize(
    ("interlace", "mode", "frames", "words"),
    [
        ("tff", "auto", 10, "combed, top field first, and were deinterlaced"),
        ("bff", "field", 20, None),
        ("tff", "off", 10, "remapped so"),
        ("", "auto", 10, None),
    ],
)
def test_woven_frames_are_parted_and_told(
    tmp_path: Path, interlace: str, mode: str, frames: int, words: str | None
) -> None:
    clip = Clip(frames=10, size=(160, 96), interlace=interlace)
    lens = calibration(tmp_path / "cal.toml", size=clip.size)
    report = run(tmp_path, clip.make(tmp_path / "a.mkv"), lens, deinterlace=mode)
    assert report.frames == frames
    assert (words in report.notes[0]) if words else report.notes == ()
    times = contents(tmp_path / "out.mkv").times
    assert np.diff(times) == pytest.approx([0.4 / frames] * (frames - 1), abs=1.1e-3)


def test_the_zoom_is_followed_logged_and_fed_back(tmp_path: Path) -> None:
    size, diameters = (160, 120), [80 + 2 * i for i in range(12)]
    source = circles(diameters, size).make(tmp_path / "a.mkv")
    table = zoom_table(tmp_path / "zoom.toml", size, (70.0, 110.0))
    report = run(tmp_path, source, table, zoom_log=str(tmp_path / "log.jsonl"))
    rows = [json.loads(line) for line in (tmp_path / "log.jsonl").read_text().splitlines()]
    assert [row["frame"] for row in rows] == list(range(12))
    # A quick zoom may surprise the filter once.
    assert report.zoom["rim"] >= 11
    assert report.diameters is not None
    assert report.diameters[0] < report.diameters[1]
    # The circle is small and the zoom quick: two frames of lag are four px.
    assert [row["diameter"] for row in rows] == pytest.approx(diameters, abs=4)
    for row in rows:
        assert row["lambda"] * row["diameter"] ** 2 == pytest.approx(-0.8, rel=0.02)
    again = run(
        tmp_path,
        source,
        table,
        "again.mkv",
        zoom_from=str(tmp_path / "log.jsonl"),
        zoom_log=str(tmp_path / "again.csv"),
    )
    assert again.zoom == {"given": 12}
    # And as much in doubt.
    doubts = zoom_history(str(tmp_path / "again.csv")).uncertainty
    assert doubts == pytest.approx([row["uncertainty"] for row in rows], rel=0.01)
    for a, b in zip(
        contents(tmp_path / "out.mkv").frames, contents(tmp_path / "again.mkv").frames, strict=True
    ):
        # The log is rounded.
        assert np.abs(plane_views(a)[0].astype(int) - plane_views(b)[0]).max() <= 2


def test_a_fade_from_black_takes_the_first_circle_that_follows(tmp_path: Path) -> None:
    size = (160, 120)
    source = circles([1.0] * 5 + [92.0] * 9, size).make(tmp_path / "a.mkv")
    table = zoom_table(tmp_path / "zoom.toml", size, (70.0, 110.0))
    report = run(tmp_path, source, table, zoom_log=str(tmp_path / "log.jsonl"))
    rows = [json.loads(line) for line in (tmp_path / "log.jsonl").read_text().splitlines()]
    assert [row["diameter"] for row in rows] == pytest.approx([92.0] * 14, abs=0.5)
    assert report.zoom == {"held": 5, "rim": 9}
    assert any("first frames show no circle" in note for note in report.notes)


def test_no_rim_and_nothing_given_is_an_error(tmp_path: Path) -> None:
    source = Clip(frames=3, size=(160, 120)).make(tmp_path / "a.mkv")
    table = zoom_table(tmp_path / "zoom.toml", (160, 120), (70.0, 110.0))
    with pytest.raises(InputError, match=r"no frame shows .*--assume-diameter"):
        run(tmp_path, source, table)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.mkv", "zoom.toml"]
    assert run(tmp_path, source, table, assume_diameter=90.0).zoom == {"given": 3}


def test_damage_is_a_warning_and_with_strict_an_error(tmp_path: Path) -> None:
    source = replace(DELIVERY, frames=50).make(tmp_path / "a.mp4", movflags="faststart")
    data = source.read_bytes()
    source.write_bytes(data[: len(data) * 2 // 3])
    lens = calibration(tmp_path / "cal.toml", LAM, CENTER)
    report = run(tmp_path, source, lens, "out.mp4")
    assert report.warnings
    assert 10 < report.frames < 50
    with pytest.raises(InputError, match="--strict"):
        run(tmp_path, source, lens, "strict.mp4", strict=True)
    assert not (tmp_path / "strict.mp4").exists()


def test_a_failure_leaves_no_file(tmp_path: Path) -> None:
    """The frames change halfway: what was written until then goes."""
    small = Clip(frames=30, codec="libx264").make(tmp_path / "a.ts")
    large = Clip(frames=5, codec="libx264", size=(96, 48)).make(tmp_path / "b.ts")
    both = tmp_path / "both.ts"
    both.write_bytes(small.read_bytes() + large.read_bytes())
    out = tmp_path / "out"
    out.mkdir()
    with pytest.raises(InputError, match="split the file there"):
        run(tmp_path, both, calibration(tmp_path / "cal.toml", LAM, CENTER), "out/x.mp4")
    assert list(out.iterdir()) == []


def test_options_that_do_not_go_together(tmp_path: Path) -> None:
    source = CLIP.make(tmp_path / "a.mkv")
    lens = calibration(tmp_path / "cal.toml", LAM, CENTER)
    for options in (
        {"zoom_log": "x.csv"},
        {"zoom_from": "x.csv"},
        {"assume_diameter": 9.0},
        {"lookup": "area"},
        {"lookup": "sideways"},
        {"assume_diameter": 0.0},
        {"assume_diameter": math.nan},
        {"assume_diameter": 90.0, "zoom_from": "log.csv"},
        {"deinterlace": "always"},
        {"stereo": "left"},
        {"right_calibration": lens},
        {"stereo": "tb", "side_by_side": True},
        {"size": (64, 48), "scale": 2.0},
        {"interpolation": "magic"},
    ):
        with pytest.raises(UsageError):
            run(tmp_path, source, lens, **options)
    with pytest.raises(OutputError, match="is also an input"):
        run(tmp_path, source, lens, "a.mkv", overwrite=True)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.mkv", "cal.toml"]


def test_moving_pictures_under_a_still_ones_name(tmp_path: Path) -> None:
    """Motion JPEG by another name, and an animated PNG: every frame, or a refusal."""
    lens = calibration(tmp_path / "cal.toml", LAM, CENTER)
    jpegs = Clip(frames=6, codec="mjpeg", pix_fmt="yuvj420p", options={"strict": "-1"})
    clips = (
        jpegs.make(tmp_path / "a.dat", "mjpeg"),
        Clip(frames=6, codec="apng", pix_fmt="rgb24").make(tmp_path / "a.png", "apng"),
    )
    for clip in clips:
        assert run(tmp_path, clip, lens, overwrite=True).frames == 6
        with pytest.raises(UsageError, match="names no video file"):
            run(tmp_path, clip, lens, out="out.png")
        assert not (tmp_path / "out.png").exists()


def test_transparency_that_is_lost_is_named(tmp_path: Path) -> None:
    lens = calibration(tmp_path / "cal.toml", LAM, CENTER)
    for pix_fmt, words in (("ya8", ["transparency cannot be kept, and is left out"]), ("rgba", [])):
        source = Clip(frames=2, codec="rawvideo", pix_fmt=pix_fmt).make(tmp_path / "a.nut")
        report = run(tmp_path, source, lens, overwrite=True)
        assert [note for note in report.notes if "transparency" in note] == words


def test_a_device_that_cannot_be_opened_ends_the_work_before_there_is_output(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # It is opened in a thread of its own: what fails there must not be lost.
    def broken(name: str) -> None:
        raise DeviceError(f"{name} is broken")

    monkeypatch.setattr(correct_video, "load_device", broken)
    source = CLIP.make(tmp_path / "a.mkv")
    lens = calibration(tmp_path / "cal.toml", LAM, CENTER)
    with pytest.raises(DeviceError, match="numpy is broken"):
        run(tmp_path, source, lens)
    assert not list(tmp_path.glob("*out*"))
