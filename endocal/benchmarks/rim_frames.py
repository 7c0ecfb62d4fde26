"""Frames with a known visible circle, and frames with none, to measure the boundary detection on.

Grey frames only: a video is searched in its luma. The scene's texture does not matter here, what happens
at the rim does; each ``Trouble`` is one thing that happens there.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Frame = NDArray[np.uint8]
Field = NDArray[np.float32]

TROUBLES = (
    "plain",
    "noise",
    "vignette",
    "raised black",
    "notch",
    "instruments",
    "dark tissue",
    "smoke",
    "over-exposure",
    "logos",
    "cut 2 sides",
    "cut 3 sides",
    "cut 4 sides",
    "pixel aspect",
    "all at once",
)
SIZES = ((720, 540), (720, 576), (854, 480), (1280, 720), (1920, 1080))


@dataclass(frozen=True)
class RimFrame:
    """A frame, uint8 (h, w), and its circle: ``center`` in px, ``diameter`` in px of the height."""

    image: Frame
    center: tuple[float, float]
    diameter: float
    pixel_aspect: float
    trouble: str
    seed: int


def texture(rng: np.random.Generator, size: tuple[int, int], roughness: float = 1.6) -> Field:
    """Noise of power-law spectrum f^-roughness, float32 (h, w), from 0 to 1: what tissue looks like."""
    w, h = size
    small = (max(w // 2, 1), max(h // 2, 1))
    frequency = np.hypot(
        np.fft.fftfreq(small[1])[:, None] * small[1], np.fft.rfftfreq(small[0]) * small[0]
    )
    spectrum = np.fft.rfft2(rng.standard_normal((small[1], small[0])))
    spectrum /= np.maximum(frequency, 1.0) ** roughness
    field = np.fft.irfft2(spectrum, s=(small[1], small[0])).astype(np.float32)
    low, high = np.percentile(field, (1, 99))
    field = np.clip((field - low) / max(high - low, 1e-9), 0, 1)
    return cv2.resize(field, size, interpolation=cv2.INTER_LINEAR)


def random_rim_frame(
    seed: int, trouble: str = "all at once", size: tuple[int, int] | None = None
) -> RimFrame:
    """Draw a frame with a visible circle and one of TROUBLES."""
    rng = np.random.default_rng((seed, TROUBLES.index(trouble)))
    size = size or SIZES[rng.integers(len(SIZES))]
    aspect = 1.0
    if trouble == "pixel aspect" or (trouble == "all at once" and rng.random() < 0.2):
        aspect = float(rng.choice([16 / 15, 10 / 11, 64 / 45, 4 / 3]))
    center, diameter = _random_circle(rng, size, aspect, trouble)
    return RimFrame(
        _render(rng, size, center, diameter, aspect, trouble),
        center,
        diameter,
        aspect,
        trouble,
        seed,
    )


def visible_fraction(
    center: tuple[float, float], diameter: float, size: tuple[int, int], aspect: float
) -> float:
    """The fraction of a circle's circumference that lies in the frame, by counting."""
    angle = np.arange(3600) * (2 * np.pi / 3600)
    x = center[0] + diameter / 2 / aspect * np.cos(angle)
    y = center[1] + diameter / 2 * np.sin(angle)
    inside = (x >= -0.5) & (x <= size[0] - 0.5) & (y >= -0.5) & (y <= size[1] - 0.5)
    return float(inside.mean())


def _random_circle(
    rng: np.random.Generator, size: tuple[int, int], aspect: float, trouble: str
) -> tuple[tuple[float, float], float]:
    """Draw a circle, cut as the trouble says, of which 15 % or more of the circumference is visible."""
    w, h = size[0] * aspect, size[1]
    short, diagonal = min(w, h), float(np.hypot(w, h))
    while True:
        shift = rng.uniform(-0.04, 0.04, 2) * (w, h)
        if trouble == "cut 2 sides":
            radius = rng.uniform(0.505, 0.49 * max(w, h) / short) * short
        elif trouble == "cut 3 sides":
            radius = rng.uniform(0.45, 0.6) * max(w, h)
            shift[int(w < h)] = rng.choice([-1, 1]) * rng.uniform(0.08, 0.3) * max(w, h)
        elif trouble == "cut 4 sides":
            radius = rng.uniform(0.505 * max(w, h), 0.49 * diagonal)
        elif trouble == "all at once":
            radius = rng.uniform(0.3 * short, 0.48 * diagonal)
        else:
            radius = rng.uniform(0.3, 0.47) * short
        x, y = (w - 1) / 2 + shift[0], (h - 1) / 2 + shift[1]
        center = (float(x / aspect), float(y))
        sides = (x - radius < 0, x + radius > w - 1, y - radius < 0, y + radius > h - 1)
        wanted = int(trouble[4]) if trouble.startswith("cut") else None
        if wanted is None and trouble != "all at once":
            wanted = 0
        if wanted is not None and sum(sides) != wanted:
            continue
        if visible_fraction(center, 2 * radius, size, aspect) >= 0.15:
            return center, float(2 * radius)


def _render(
    rng: np.random.Generator,
    size: tuple[int, int],
    center: tuple[float, float],
    diameter: float,
    aspect: float,
    trouble: str,
) -> Frame:
    def has(name: str, chance: float) -> bool:
        return trouble == name or (trouble == "all at once" and rng.random() < chance)

    w, h = size
    x = (np.arange(w, dtype=np.float32) - np.float32(center[0])) * np.float32(aspect)
    y = np.arange(h, dtype=np.float32)[:, None] - np.float32(center[1])
    r, radius = np.hypot(x, y), diameter / 2
    scene = rng.uniform(60, 170) * (0.55 + 0.9 * texture(rng, size))
    if has("vignette", 0.3):
        scene *= np.clip(1 - (r / radius) ** 2, 0, 1)
    else:
        scene *= 1 - rng.uniform(0, 0.6) * (r / radius) ** 2
    if has("dark tissue", 0.3):
        _darken_sector(rng, scene, x, y, radius)
    if has("instruments", 0.4):
        for _ in range(rng.integers(1, 4)):
            _draw_instrument(rng, scene, x, y, radius)
    if has("smoke", 0.3):
        veil = rng.uniform(0.3, 0.7)
        scene = scene * (1 - veil) + veil * rng.uniform(90, 170) * (0.6 + 0.4 * texture(rng, size))
    if has("over-exposure", 0.2):
        scene *= rng.uniform(1.8, 3.5)
    coverage = np.clip(radius - r + 0.5, 0, 1)
    if has("notch", 0.3):
        coverage = np.maximum(coverage, _notch(rng, x, y, radius))
    frame = np.minimum(scene, 255) * coverage
    if has("logos", 0.4):
        _draw_logos(rng, frame, coverage)
    frame = cv2.GaussianBlur(frame, (0, 0), float(rng.uniform(0.5, 1.4)))
    black = rng.uniform(8, 40) if has("raised black", 0.4) else rng.uniform(0, 4)
    frame = black + frame * (255 - black) / 255
    sigma = rng.uniform(3, 8) if has("noise", 0.5) else rng.uniform(0.3, 1.5)
    frame = frame + rng.normal(0, sigma, frame.shape).astype(np.float32)
    return np.clip(np.rint(frame), 0, 255).astype(np.uint8)


def _darken_sector(
    rng: np.random.Generator, scene: Field, x: Field, y: Field, radius: float
) -> None:
    """Sink a part of the rim, up to two fifths of it, in unlit tissue."""
    middle, half = rng.uniform(-np.pi, np.pi), rng.uniform(0.1, 0.4) * np.pi
    away = np.abs(np.angle(np.exp(1j * (np.arctan2(y, x) - middle))))
    depth = rng.uniform(0.4, 0.9)
    edge = np.clip((half - away) / 0.25 + (np.hypot(x, y) / radius - depth) / 0.2 - 1, 0, 1)
    scene *= 1 - edge * rng.uniform(0.9, 1.0)


def _draw_instrument(
    rng: np.random.Generator, scene: Field, x: Field, y: Field, radius: float
) -> None:
    """Push a shaft, dark or shining, from the rim towards the middle."""
    angle, half = rng.uniform(-np.pi, np.pi), rng.uniform(0.03, 0.12) * radius
    along = x * np.cos(angle) + y * np.sin(angle)
    across = -x * np.sin(angle) + y * np.cos(angle) + rng.uniform(-0.3, 0.3) * radius
    shaft = (np.abs(across) < half) & (along > rng.uniform(-0.2, 0.6) * radius)
    level = rng.uniform(2, 25) if rng.random() < 0.6 else rng.uniform(120, 250)
    shade = level * (1 - 0.6 * (across / half) ** 2)
    scene[shaft] = shade[shaft]


def _notch(rng: np.random.Generator, x: Field, y: Field, radius: float) -> Field:
    """The orientation mark of many scopes: a small triangle pointing out of the circle."""
    angle, height = rng.uniform(-np.pi, np.pi), rng.uniform(0.03, 0.06) * radius
    out = x * np.cos(angle) + y * np.sin(angle) - radius
    across = np.abs(-x * np.sin(angle) + y * np.cos(angle))
    return ((out > -height) & (out < height) & (across < (height - out) * 0.7)).astype(np.float32)


def _draw_logos(rng: np.random.Generator, frame: Field, coverage: Field) -> None:
    """Burn a clock, a name or a mark into the dark, clear of the circle."""
    h, w = frame.shape
    overlay = np.zeros(frame.shape, np.uint8)
    for _ in range(rng.integers(1, 4)):
        corner = (int(rng.uniform(0, 0.85) * w), int(rng.choice([0.06, 0.5, 0.97]) * h))
        words = str(rng.choice(["12:34:56", "REC", "PATIENT 0815", "[S] 3D", "HD"]))
        scale = h / 540 * rng.uniform(0.4, 0.9)
        cv2.putText(
            overlay, words, corner, cv2.FONT_HERSHEY_SIMPLEX, scale, float(rng.uniform(120, 255)), 2
        )
    clear = cv2.dilate((coverage > 0).astype(np.uint8), np.ones((9, 9), np.uint8)) == 0
    frame[clear] = np.maximum(frame, overlay.astype(np.float32))[clear]
