"""Frames with what recordings put at and about the circle: glows, reflections, panels, masks of other shapes.

Unlike the troubles of ``rim_frames``, where the circle has to be found, some of these may leave it in doubt;
none must give a circle that is not there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from ..boundary.circle import Boundary
from ..boundary.detect import find_boundary
from .rim_frames import SIZES, Field, Frame, texture

# A circle further than this from the truth somewhere on its visible part, px besides the rim's softness, is
# wrong.
TOLERANCE = 4.0


class Scene(NamedTuple):
    """A lit scene, (h, w), the circle to limit it, and where each pixel is from its centre, px."""

    light: Field
    x: Field
    y: Field
    r: Field
    center: tuple[float, float]
    radius: float


class Look(NamedTuple):
    """A frame, its circle or None where it has none, and how soft the rim is, px.

    ``sides`` are where a mask cuts the circle: how far to the right, left, bottom and top of its centre, px.
    """

    image: Frame
    center: tuple[float, float]
    radius: float | None
    softness: float = 0.0
    sides: tuple[float, ...] = (math.inf,) * 4


Painter = Callable[[np.random.Generator, Scene], Look]


def random_look(seed: int, kind: str) -> Look:
    """Draw a frame of one of LOOKS."""
    rng = np.random.default_rng((seed, LOOKS.index(kind), 5))
    return PAINTERS[kind](rng, _scene(rng))


@dataclass(frozen=True)
class LookScore:
    """How many circles of ``frames`` were found, how many not, and how many wrong; their seeds."""

    kind: str
    frames: int
    found: int
    none: int
    wrong: tuple[int, ...]

    def data(self) -> dict[str, Any]:
        """Return it as plain data."""
        return asdict(self)


def score_look(kind: str, seeds: Iterable[int]) -> LookScore:
    """Find the circle in random frames of one of LOOKS; one in a frame without a circle is wrong."""
    found, none, wrong = 0, 0, []
    for seed in seeds:
        look = random_look(seed, kind)
        boundary = find_boundary(look.image)
        if boundary is None:
            none += 1
        elif distance(boundary, look) > TOLERANCE + look.softness:
            wrong.append(seed)
        else:
            found += 1
    return LookScore(kind, found + none + len(wrong), found, none, tuple(wrong))


def distance(boundary: Boundary, look: Look) -> float:
    """Return how far the circle is from the true one at most, where that can be seen, px."""
    if look.radius is None:
        return math.inf
    h, w = look.image.shape
    angle = np.linspace(0, 2 * np.pi, 720, endpoint=False)
    x = boundary.center[0] + boundary.diameter / 2 * np.cos(angle)
    y = boundary.center[1] + boundary.diameter / 2 * np.sin(angle)
    inside = (x > 0) & (x < w - 1) & (y > 0) & (y < h - 1)
    x, y = x - look.center[0], y - look.center[1]
    for reach, side in zip((x, -x, y, -y), look.sides, strict=True):
        inside &= reach < side
    off = np.hypot(x, y) - look.radius
    return float(np.abs(off[inside]).max(initial=0.0))


def _scene(rng: np.random.Generator) -> Scene:
    size = SIZES[rng.integers(len(SIZES))]
    w, h = size
    radius = float(rng.uniform(0.52, 0.6) if rng.random() < 0.35 else rng.uniform(0.3, 0.45)) * h
    center = (
        float((w - 1) / 2 + rng.uniform(-0.04, 0.04) * w),
        float((h - 1) / 2 + rng.uniform(-0.03, 0.03) * h),
    )
    x = np.arange(w, dtype=np.float32)[None] - np.float32(center[0])
    y = np.arange(h, dtype=np.float32)[:, None] - np.float32(center[1])
    r = np.hypot(x, y)
    light = rng.uniform(60, 170) * (0.55 + 0.9 * texture(rng, size))
    light *= 1 - rng.uniform(0, 0.6) * np.minimum(r / radius, 1.2) ** 2
    return Scene(np.asarray(light, np.float32), x, y, r, center, radius)


def _masked(scene: Scene) -> Field:
    return np.minimum(scene.light, 255) * np.clip(scene.radius - scene.r + 0.5, 0, 1)


def _look(
    rng: np.random.Generator, scene: Scene, frame: Field, black: float = 4.0, noise: float = 2.0
) -> Look:
    """Blur a frame and put it on its black, at most ``black``, under at most ``noise``; both in levels."""
    frame = np.asarray(cv2.GaussianBlur(frame, (0, 0), float(rng.uniform(0.5, 1.4))), np.float32)
    level = rng.uniform(0, black)
    levels = level + frame * (255 - level) / 255
    levels = levels + rng.normal(0, rng.uniform(0.3, noise), frame.shape)
    return Look(_levels(levels), scene.center, scene.radius)


def _levels(frame: NDArray[np.floating[Any]]) -> Frame:
    return np.clip(np.rint(frame), 0, 255).astype(np.uint8)


def _glow(rng: np.random.Generator, scene: Scene) -> Look:
    """A soft rim with light about it that decays on a grey ground, as fisheye lenses have."""
    soft, decay = (rng.uniform(a, b) * scene.radius for a, b in ((0.004, 0.03), (0.05, 0.6)))
    edge = 1 / (1 + np.exp(np.clip(2 * (scene.r - scene.radius) / soft, -50, 50)))
    beyond = np.maximum(scene.r - scene.radius, 0)
    about = rng.uniform(0, 50) + rng.uniform(8, 50) * np.exp(-beyond / decay)
    frame = np.clip(scene.light, 0, 255) * edge + about * (1 - edge)
    return _look(rng, scene, frame.astype(np.float32))._replace(softness=float(soft))


def _ring(rng: np.random.Generator, scene: Scene) -> Look:
    """A ring of reflections about the circle, whole or in part."""
    radius, width = rng.uniform(1.05, 1.25) * scene.radius, rng.uniform(0.005, 0.03) * scene.radius
    away = np.abs(
        np.angle(np.exp(1j * (np.arctan2(scene.y, scene.x) - rng.uniform(-np.pi, np.pi))))
    )
    extent = np.clip((rng.uniform(0.2, 1) * np.pi - away) / 0.3, 0, 1)
    ring = rng.uniform(10, 90) * np.exp(-(((scene.r - radius) / width) ** 2)) * extent
    return _look(rng, scene, np.minimum(_masked(scene) + ring, 255).astype(np.float32))


def _rounded_box(rng: np.random.Generator, scene: Scene) -> Look:
    """A rectangle with rounded corners: no circle at all."""
    h, w = scene.r.shape
    half = np.array([rng.uniform(0.3, 0.48) * w, rng.uniform(0.3, 0.48) * h])
    if rng.random() < 0.5:
        half[:] = half.min()
    corner = rng.uniform(0.05, 0.85) * half.min()
    outwards = [
        np.maximum(np.abs(v) - (a - corner), 0) for v, a in zip(scene[1:3], half, strict=True)
    ]
    inside = np.clip(corner - np.hypot(*outwards) + 0.5, 0, 1)
    frame = np.clip(scene.light, 0, 255) * inside
    return _look(rng, scene, frame.astype(np.float32))._replace(radius=None)


def _flat_sides(rng: np.random.Generator, scene: Scene) -> Look:
    """A circle that a mask cuts straight on one to three sides."""
    frame, sides = _masked(scene), [math.inf] * 4
    reaches = (scene.x, -scene.x, scene.y, -scene.y)
    for side in rng.permutation(4)[: rng.integers(1, 4)]:
        sides[side] = float(scene.radius * rng.uniform(0.6, 0.92))
        frame = frame * np.clip(sides[side] - reaches[side] + 0.5, 0, 1)
    return _look(rng, scene, frame)._replace(sides=tuple(sides))


def _write(rng: np.random.Generator, panel: Frame, lines: int) -> None:
    h, w = panel.shape
    for _ in range(lines):
        at = (int(rng.uniform(0, 0.4) * w), int(rng.uniform(0.05, 1) * h))
        words = str(rng.choice(["ID 000471", "12:34:56", "ZOOM 1.2", "P 12 mmHg", "REC"]))
        shade = float(255 - panel[0, 0] if rng.random() < 0.5 else rng.uniform(90, 255))
        cv2.putText(panel, words, at, cv2.FONT_HERSHEY_SIMPLEX, rng.uniform(0.4, 0.9), shade, 1)


def _side_panel(rng: np.random.Generator, scene: Scene) -> Look:
    """A column of text and a second picture beside the endoscope's own."""
    own = _look(rng, scene, _masked(scene))
    h, w = own.image.shape
    panel = np.full((h, int(rng.uniform(0.2, 0.45) * w)), rng.choice([0, 2, 12, 60, 200]), np.uint8)
    _write(rng, panel, int(rng.integers(3, 14)))
    if rng.random() < 0.5:
        side = panel.shape[1]
        other = _levels(_masked(_scene(rng)))
        second = cv2.resize(other, (side, side * other.shape[0] // other.shape[1]))[:h]
        top = int(rng.uniform(0, h - second.shape[0] + 1))
        panel[top : top + second.shape[0]] = second
    if rng.random() < 0.5:
        return own._replace(image=np.hstack([own.image, panel]))
    center = (own.center[0] + panel.shape[1], own.center[1])
    return own._replace(image=np.hstack([panel, own.image]), center=center)


def _corner_mark(rng: np.random.Generator, scene: Scene) -> Look:
    """A plate with a name in a corner, which may lie over the rim."""
    look = _look(rng, scene, _masked(scene))
    h, w = look.image.shape
    for _ in range(rng.integers(1, 3)):
        plate = np.full(
            (int(rng.uniform(0.05, 0.25) * h), int(rng.uniform(0.08, 0.3) * w)), 0, np.uint8
        )
        plate[:] = int(rng.uniform(30, 230))
        _write(rng, plate, 2)
        top, left = (int(rng.choice([0, a - b])) for a, b in zip((h, w), plate.shape, strict=True))
        look.image[top : top + plate.shape[0], left : left + plate.shape[1]] = plate
    return look


def _dim(rng: np.random.Generator, scene: Scene) -> Look:
    """The first frames, while the picture fades in, and a light that is nearly off."""
    return _look(rng, scene, _masked(scene) * np.float32(rng.uniform(0, 1) ** 3))


def _white(rng: np.random.Generator, scene: Scene) -> Look:
    """The white balance before a white cloth."""
    white = rng.uniform(200, 320) * (1 - rng.uniform(0, 0.3) * (scene.r / scene.radius) ** 2)
    return _look(rng, scene, _masked(scene._replace(light=white.astype(np.float32))))


def _smoke(rng: np.random.Generator, scene: Scene) -> Look:
    """Smoke that leaves nearly nothing of the scene."""
    veil, h, w = rng.uniform(0.6, 0.97), *scene.r.shape
    smoke = rng.uniform(60, 190) * (0.7 + 0.3 * texture(rng, (w, h)))
    return _look(rng, scene, _masked(scene._replace(light=scene.light * (1 - veil) + veil * smoke)))


def _room(rng: np.random.Generator, scene: Scene) -> Look:
    """The lens outside the body: a dark room with lamps, out of focus."""
    h, w = scene.r.shape
    light = rng.uniform(0, 25) * texture(rng, (w, h), 2.2)
    for _ in range(rng.integers(1, 6)):
        x, y = rng.uniform(-w / 2, w / 2), rng.uniform(-h / 2, h / 2)
        away2 = (scene.x - x) ** 2 + (scene.y - y) ** 2
        light = light + rng.uniform(60, 400) * np.exp(
            -away2 / (2 * (rng.uniform(0.03, 0.3) * h) ** 2)
        )
    return _look(rng, scene, _masked(scene._replace(light=light.astype(np.float32))))


def _bare_ring(rng: np.random.Generator, scene: Scene) -> Look:
    """A gauge, a sign that something loads or a logo's outline: a ring or most of one, black within."""
    h, w = scene.r.shape
    ground = np.full((h, w), rng.choice([0, 5, 15]), np.uint8)
    center = (round(scene.center[0]), round(scene.center[1]))
    radius, width = round(0.9 * scene.radius), max(round(rng.uniform(0.02, 0.1) * h), 1)
    begin, extent = rng.uniform(0, 360), rng.uniform(200, 360)
    level = float(rng.uniform(90, 255))
    cv2.ellipse(ground, center, (radius, radius), 0, begin, begin + extent, level, width)
    at = (center[0] - h // 20, center[1] + h // 40)
    cv2.putText(ground, "72", at, cv2.FONT_HERSHEY_SIMPLEX, h / 400, level, 2)
    return _look(rng, scene, ground.astype(np.float32))._replace(radius=None)


PAINTERS: dict[str, Painter] = {
    "glowing rim": _glow,
    "reflection ring": _ring,
    "rounded box": _rounded_box,
    "flat sides": _flat_sides,
    "side panel": _side_panel,
    "corner mark": _corner_mark,
    "dim": _dim,
    "white balance": _white,
    "smoke-filled": _smoke,
    "outside the body": _room,
    "bare ring": _bare_ring,
}
LOOKS = tuple(PAINTERS)
