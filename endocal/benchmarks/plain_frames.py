"""Full-frame pictures without a visible circle: what the boundary detection must find nothing in."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np

from .rim_frames import SIZES, Field, Frame, texture

Painter = Callable[[np.random.Generator, tuple[int, int]], Field]


def random_plain_frame(seed: int) -> tuple[Frame, str]:
    """Draw a frame, uint8 (h, w), without a visible circle, and name its kind."""
    rng = np.random.default_rng((seed, 77))
    kind = KINDS[seed % len(KINDS)]
    size = SIZES[rng.integers(len(SIZES))]
    frame = PAINTERS[kind](rng, size)
    if rng.random() < 0.3:
        frame = _darken(rng, frame)
    if rng.random() < 0.5:
        frame = np.asarray(cv2.GaussianBlur(frame, (0, 0), float(rng.uniform(0.5, 2))), np.float32)
    black = rng.uniform(0, 30) if rng.random() < 0.3 else 0.0
    noise = rng.normal(0, rng.uniform(0.3, 8), frame.shape)
    levels = black + frame * (255 - black) / 255 + noise
    return np.clip(np.rint(levels), 0, 255).astype(np.uint8), kind


def _darken(rng: np.random.Generator, frame: Field) -> Field:
    """Light the scene from one side or in a spot that does not end in black."""
    h, w = frame.shape
    x, y = np.meshgrid(np.linspace(-1, 1, w), np.linspace(-1, 1, h))
    x0, y0 = rng.uniform(-1.5, 1.5, 2)
    fall = np.exp(-rng.uniform(0.3, 1.5) * ((x - x0) ** 2 + (y - y0) ** 2))
    return (frame * fall).astype(np.float32)


def _tissue(rng: np.random.Generator, size: tuple[int, int]) -> Field:
    return 255 * texture(rng, size, rng.uniform(1.0, 2.2)) ** rng.uniform(0.5, 3)


def _board(rng: np.random.Generator, size: tuple[int, int]) -> Field:
    """A chessboard in perspective, on a plain or a dark ground."""
    n, m = int(rng.integers(6, 18)), int(rng.integers(5, 14))
    cell = 40
    squares = np.indices((m, n)).sum(axis=0) % 2
    board = np.kron(squares, np.ones((cell, cell))).astype(np.float32) * rng.uniform(100, 200) + 15
    corners = np.array([[0, 0], [n * cell, 0], [n * cell, m * cell], [0, m * cell]], np.float32)
    w, h = size
    target = np.array([[0.1, 0.1], [0.9, 0.1], [0.9, 0.9], [0.1, 0.9]]) + rng.uniform(
        -0.25, 0.15, (4, 2)
    )
    homography = cv2.getPerspectiveTransform(corners, (target * size).astype(np.float32))
    ground = float(rng.choice([0, 3, 12, 60, 180]))
    picture = cv2.warpPerspective(
        board,
        homography,
        (w, h),
        flags=cv2.INTER_AREA,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=ground,
    )
    return np.asarray(picture, np.float32)


def _gradient(rng: np.random.Generator, size: tuple[int, int]) -> Field:
    w, h = size
    x, y = np.meshgrid(np.linspace(-1, 1, w), np.linspace(-1, 1, h))
    angle = rng.uniform(-np.pi, np.pi)
    ramp = (x * np.cos(angle) + y * np.sin(angle)) * rng.uniform(0.3, 1) + rng.uniform(0, 1)
    return (np.clip(ramp, 0, 1) * 230).astype(np.float32)


def _vignetted(rng: np.random.Generator, size: tuple[int, int]) -> Field:
    """A whole frame that darkens towards its corners, by cos^4, without ever going black."""
    w, h = size
    x, y = np.meshgrid(np.arange(w) - w / 2, np.arange(h) - h / 2)
    focal = rng.uniform(0.35, 1.2) * np.hypot(w, h) / 2
    fall = (1 + (x * x + y * y) / focal**2) ** -2
    scene = 60 + 190 * texture(rng, size) if rng.random() < 0.5 else np.full((h, w), 220.0)
    return (scene * fall).astype(np.float32)


def _boxed(rng: np.random.Generator, size: tuple[int, int]) -> Field:
    """A scene between black bars: letterboxed, pillarboxed or both."""
    frame = _tissue(rng, size) if rng.random() < 0.6 else _photo(rng, size)
    w, h = size
    bars = rng.integers(1, 4)
    if bars & 1:
        bar = int(rng.uniform(0.02, 0.2) * h)
        frame[:bar] = frame[h - bar :] = 0
    if bars & 2:
        bar = int(rng.uniform(0.02, 0.2) * w)
        frame[:, :bar] = frame[:, w - bar :] = 0
    return frame


def _screenshot(rng: np.random.Generator, size: tuple[int, int]) -> Field:
    """Windows, text and a dark desktop."""
    w, h = size
    frame = np.full((h, w), rng.choice([0, 10, 30, 200]), np.uint8)
    for _ in range(rng.integers(2, 12)):
        x0, y0 = int(rng.uniform(0, w * 0.8)), int(rng.uniform(0, h * 0.8))
        x1, y1 = x0 + int(rng.uniform(0.05, 0.6) * w), y0 + int(rng.uniform(0.05, 0.6) * h)
        cv2.rectangle(frame, (x0, y0), (x1, y1), float(rng.uniform(10, 250)), -1)
    for _ in range(rng.integers(5, 30)):
        at = (int(rng.uniform(0, w)), int(rng.uniform(0, h)))
        cv2.putText(
            frame,
            "Patient 4711 / 12:03",
            at,
            cv2.FONT_HERSHEY_SIMPLEX,
            h / 900,
            float(rng.uniform(0, 255)),
            1,
        )
    return frame.astype(np.float32)


def _photo(rng: np.random.Generator, size: tuple[int, int]) -> Field:
    """Overlapping objects of all sizes and shades, as in a natural picture (dead leaves)."""
    w, h = size
    frame = np.full((h, w), rng.uniform(0, 200), np.float32)
    for _ in range(rng.integers(20, 200)):
        at = (int(rng.uniform(-0.1, 1.1) * w), int(rng.uniform(-0.1, 1.1) * h))
        radius = 0.02 * h * rng.uniform(0.05, 1) ** -0.9
        axes = (int(radius), int(radius * rng.uniform(0.3, 1)))
        cv2.ellipse(
            frame, at, axes, float(rng.uniform(0, 180)), 0, 360, float(rng.uniform(0, 255)), -1
        )
    return frame * (0.8 + 0.2 * texture(rng, size))


def _round_things(rng: np.random.Generator, size: tuple[int, int]) -> Field:
    """Plates and holes: large bright discs on a dark scene that is not empty."""
    w, h = size
    frame = rng.uniform(30, 90) * texture(rng, size, rng.uniform(1.0, 1.8))
    for _ in range(rng.integers(1, 4)):
        at = (int(rng.uniform(0.2, 0.8) * w), int(rng.uniform(0.2, 0.8) * h))
        radius = int(rng.uniform(0.15, 0.5) * h)
        cv2.circle(frame, at, radius, float(rng.uniform(90, 250)), -1, cv2.LINE_8)
    return (frame * (0.7 + 0.3 * texture(rng, size))).astype(np.float32)


def _night(rng: np.random.Generator, size: tuple[int, int]) -> Field:
    """Blobs of light of no particular shape in the dark."""
    field = texture(rng, size, rng.uniform(1.4, 2.4))
    level = rng.uniform(0.5, 0.8)
    return (np.clip((field - level) / (1 - level), 0, 1) * rng.uniform(100, 600)).astype(np.float32)


def _black(rng: np.random.Generator, size: tuple[int, int]) -> Field:
    return np.full((size[1], size[0]), rng.uniform(0, 20), np.float32)


PAINTERS: dict[str, Painter] = {
    "tissue": _tissue,
    "board": _board,
    "gradient": _gradient,
    "vignetted": _vignetted,
    "boxed": _boxed,
    "screenshot": _screenshot,
    "photo": _photo,
    "round things": _round_things,
    "night": _night,
    "black": _black,
}
KINDS = tuple(PAINTERS)
