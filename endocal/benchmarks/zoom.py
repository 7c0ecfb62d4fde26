"""How well the zoom is tabulated and followed: rendered clips whose every frame's lambda is known."""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from fractions import Fraction
from typing import Any

import cv2
import numpy as np

from ..boundary.detect import boundary_of
from ..synth.camera import Camera
from ..synth.clip import ClipScene, clip_frames
from ..synth.lens import ZoomLens, typical_lens
from ..synth.motion import CouplerPlay, EyeMotion, ZoomPath
from ..synth.objects import Instrument, MovingInstrument
from ..synth.tissue import Organ
from ..zoom.follow import FollowSpec, ZoomFollower
from ..zoom.table import LOOKUPS, Setting, ZoomTable

SIZE = (1280, 720)
RATE = Fraction(25)
# Zooms at which the table has a setting; beyond the last the law takes over.
_SETTINGS = (1.0, 1.3, 1.6, 2.0)
_STRENGTH = -1.3


@dataclass(frozen=True)
class ClipScore:
    """How a clip's zoom was followed.

    ``visible`` and ``hidden`` count the frames whose circle reaches into the frame and those whose does
    not; the pairs are the median and the 95th percentile of lambda's relative error over each, and
    ``hidden_doubts`` of the diameter's error in stated standard deviations where the circle does not.
    ``visible_center`` is that of the distortion centre's error, px, where it does.
    ``sources`` counts the frames by source; ``worst`` is the frame with the largest error, and
    ``milliseconds`` the processor's time per frame.
    """

    name: str
    frames: int
    visible: int
    hidden: int
    visible_error: tuple[float, float]
    visible_center: tuple[float, float]
    hidden_error: tuple[float, float] | None
    hidden_doubts: tuple[float, float] | None
    worst: int
    worst_error: float
    sources: dict[str, int]
    milliseconds: float

    def data(self) -> dict[str, Any]:
        """Return it as plain data."""
        return asdict(self)


def zooming_clip(seed: int, seconds: float = 20.0, approach: float = 0.0) -> ClipScene:
    """Return a clip that zooms from 1x to 2.5x and back, over tissue with two moving instruments.

    The circle is as high as the frame at 1x and leaves it altogether for the third quarter or so of the
    way; the hand sways. ``approach`` is how far the lens goes towards the tissue and back meanwhile, in
    parts of the distance.
    """
    keys = ((0.0, 1.0), (0.2, 1.0), (0.4, 2.5), (0.6, 2.5), (0.8, 1.0), (1.0, 1.0))
    return _clip(
        seed,
        ZoomPath(tuple((seconds * t, zoom) for t, zoom in keys)),
        seconds,
        EyeMotion(
            sway=(0.03, 0.02, 0.02), turn=(1.5, 1.0, 2.0), approach=approach, duration=seconds
        ),
        _instruments(seed),
    )


def rough_clip(seed: int, seconds: float = 12.0) -> ClipScene:
    """Return a clip that zooms beyond its rim within 3 s, and then rests while the camera roams.

    Organs stand before the tissue, and the camera goes towards them and back and about: no smooth scene
    explains what that does to the picture, and none of it is zoom.
    """
    rng = np.random.default_rng((seed, 2))
    organs = tuple(
        Organ(
            (
                float(rng.uniform(-0.6, 0.6)),
                float(rng.uniform(-0.45, 0.45)),
                float(rng.uniform(0.75, 1)),
            ),
            float(rng.uniform(0.12, 0.3)),
        )
        for _ in range(5)
    )
    path = ZoomPath(((0.0, 1.0), (1.0, 1.0), (3.0, 2.3), (seconds, 2.3)))
    roaming = EyeMotion(
        sway=(0.10, 0.08, 0.08), turn=(7.0, 5.0, 5.0), period=4.5, approach=0.25, duration=seconds
    )
    return replace(_clip(seed, path, seconds, roaming, _instruments(seed)), organs=organs)


def loose_clip(seed: int, seconds: float = 8.0) -> ClipScene:
    """Return a clip of a scope that wanders in its coupler by 2.5 % of the height as it zooms to 1.3x."""
    path = ZoomPath(((0.0, 1.0), (seconds, 1.3)))
    clip = _clip(seed, path, seconds, EyeMotion(sway=(0.03, 0.02, 0.02)), _instruments(seed))
    return replace(clip, play=CouplerPlay((0.025 * SIZE[1], 0.015 * SIZE[1]), period=4.0))


def still_clip(seed: int, seconds: float = 3.0, noise: float = 5.0) -> ClipScene:
    """Return a clip in which nothing moves but the noise."""
    return _clip(seed, ZoomPath(((0.0, 1.15),)), seconds, EyeMotion(), (), noise)


def steady_clip(seed: int, seconds: float = 2.0) -> ClipScene:
    """Return a clip that zooms from 1x to 1.6x without a pause."""
    # Keys close together along an exponential: between two of them the path eases in and out.
    keys = tuple((float(t), 1.6 ** float(t / seconds)) for t in np.arange(0, seconds + 0.04, 0.04))
    return _clip(seed, ZoomPath(keys), seconds, EyeMotion(), ())


def table_of(lens: ZoomLens) -> ZoomTable:
    """Return the zoom table that exact calibrations of the lens would give."""
    settings = []
    size = lens.model.size
    for zoom in _SETTINGS:
        model, circle = lens.model_at(zoom), lens.circle_at(zoom)
        area = boundary_of(circle.center, circle.diameter, size).area
        settings.append(
            Setting(model.lam, model.center, circle.diameter, area, circle=circle.center)
        )
    return ZoomTable(tuple(settings), size)


def follow_clip(
    name: str,
    scene: ClipScene,
    tick: Callable[[int], None] = lambda frame: None,
    spec: FollowSpec = FollowSpec(),
) -> tuple[ClipScore, np.ndarray]:
    """Follow a clip's zoom; returns the score and lambda's signed relative error per frame (n,)."""
    follower = ZoomFollower(table_of(scene.lens), spec)
    errors, centers, doubts, hidden, spent = [], [], [], [], 0.0
    sources: Counter[str] = Counter()
    for frame in clip_frames(scene):
        luma = cv2.cvtColor(frame.image, cv2.COLOR_BGR2GRAY)
        began = time.thread_time()
        estimate = follower.update(np.asarray(luma, np.uint8), float(frame.time))
        spent += time.thread_time() - began
        errors.append(estimate.model.lam / frame.model.lam - 1)
        centers.append(math.dist(estimate.model.center, frame.model.center))
        circle = frame.circle
        wrong = math.log(estimate.diameter / circle.diameter)
        doubts.append(wrong / estimate.relative_uncertainty)
        limits = boundary_of(circle.center, circle.diameter, frame.model.size)
        hidden.append(limits.visible == 0)
        sources[estimate.source] += 1
        tick(frame.index)
    error, out = np.array(errors), np.array(hidden)
    worst = int(np.abs(error).argmax())
    score = ClipScore(
        name,
        len(error),
        int((~out).sum()),
        int(out.sum()),
        _spread(error[~out]),
        _spread(np.array(centers)[~out]),
        _spread(error[out]) if out.any() else None,
        _spread(np.array(doubts)[out]) if out.any() else None,
        worst,
        float(error[worst]),
        dict(sources),
        1e3 * spent / len(error),
    )
    return score, error


@dataclass(frozen=True)
class LookupScore:
    """Lambda's relative error at settings left out of the table: root mean square and worst."""

    lookup: str
    rms: float
    worst: float


def score_lookups(seed: int, lenses: int = 300) -> list[LookupScore]:
    """Leave each setting out of random tables in turn, and predict it from the rest.

    The lenses depart from the law by a drift over the zoom (5 % per third of it, at most twice that) and
    their calibrations have errors of 1 %: what Table I of the article shows is more than that.
    """
    rng = np.random.default_rng((seed, 5))
    errors: dict[str, list[float]] = {name: [] for name in LOOKUPS}
    for _ in range(lenses):
        diameters = 560 * np.cumprod(np.concatenate([[1], rng.uniform(1.08, 1.35, 3)]))
        # Twice as much at most: more would break the law so far that a table is refused.
        steepness = np.clip(rng.normal(0, 0.05), -0.1, 0.1)
        drift = steepness * np.log(diameters / diameters[1]) / np.log(1.33)
        strengths = _STRENGTH * (1 + drift + rng.normal(0, 0.01, 4))
        settings = []
        for d, k in zip(diameters.tolist(), strengths.tolist(), strict=True):
            area = boundary_of((639.5, 359.5), d, SIZE).area
            settings.append(Setting(k / d**2, (639.5, 359.5), d, area))
        for i, out in enumerate(settings):
            rest = ZoomTable(tuple(settings[:i] + settings[i + 1 :]), SIZE)
            boundary = boundary_of(out.center, out.diameter, SIZE)
            for name in LOOKUPS:
                errors[name].append(rest.at(boundary, name).lam / out.lam - 1)
    return [
        LookupScore(name, float(np.sqrt(np.mean(np.square(e)))), float(np.abs(e).max()))
        for name, e in errors.items()
    ]


def _clip(
    seed: int,
    path: ZoomPath,
    seconds: float,
    motion: EyeMotion,
    instruments: tuple[MovingInstrument, ...],
    noise: float = 2.0,
) -> ClipScene:
    return ClipScene(
        typical_lens(SIZE, _STRENGTH, fill=1.0),
        path,
        round(seconds * RATE),
        RATE,
        Camera(blur=0.8, vignetting=0.35, gamma=2.0, black=4.0, noise=noise),
        motion,
        instruments,
        seed=seed,
    )


def _instruments(seed: int) -> tuple[MovingInstrument, ...]:
    """Two shafts from two sides whose tips move about in the middle."""
    rng = np.random.default_rng((seed, 1))
    shafts = []
    for side in (25.0, 162.0):
        angle = side + rng.uniform(-15, 15)
        reach = rng.uniform(0.25, 0.5)
        tip = (reach * np.cos(np.radians(angle)), reach * np.sin(np.radians(angle)))
        shaft = Instrument((float(tip[0]), float(tip[1])), angle, rng.uniform(0.10, 0.14))
        sway = (rng.uniform(0.04, 0.12), rng.uniform(0.04, 0.12))
        shafts.append(MovingInstrument(shaft, sway, rng.uniform(3, 6), rng.uniform(0, 1)))
    return tuple(shafts)


def _spread(errors: np.ndarray) -> tuple[float, float]:
    median, most = np.percentile(np.abs(errors), (50, 95)).tolist()
    return median, most
