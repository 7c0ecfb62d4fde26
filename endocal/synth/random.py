"""Random scenes of a board, as wide as real lenses and careless users are.

The distribution, by ``random_board(seed)``:

- Frame sizes from 320x320 to 1920x1080, those of common scopes and cameras.
- The distortion lam R^2 is uniform in [-1.5, -0.05], R being the radius of the visible content: that of
  the content circle, or the distance from the distortion centre to the farthest corner of the frame where
  there is no circle or it leaves the frame. Below -0.9 the map would fold (at -1) within that radius, so
  there R is the farthest corner's and a content circle stops the picture at lam r^2 from -0.9 to -0.6.
- The distortion centre is uniform in a region of 0.1 width x 0.1 height around the frame's centre.
- Tilt uniform in 0 to 45 degrees, about any axis; any rotation; 8 to 20 inner lines each way; one scene in
  five shows parallel bars only.
- The pattern covers 30 to 75 % of the content, where it may lose a corner or two; in one scene of four it
  runs out of the content on one side or on all.
  Scenes whose typical visible square is too small for the blur (see ``_legible``) are drawn again: nobody
  would keep such a picture.
- Noise sigma uniform in 0 to 10 grey levels, blur sigma uniform in 0 to 2 px, JPEG quality 70 to 100.
- Each with some probability: vignetting, gamma, black level, colour, off-white light, cloudy background,
  specular highlights, instruments, interlace comb, burnt-in text.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ..model import DivisionModel
from .board import BoardScene, Overlay, true_corners
from .camera import Camera, ContentCircle
from .framing import covering
from .objects import Highlight, Instrument
from .pattern import Pattern, Pose

SIZES = (
    (320, 320),
    (400, 400),
    (470, 470),
    (640, 480),
    (720, 480),
    (720, 540),
    (768, 576),
    (854, 480),
    (1000, 750),
    (1280, 720),
    (1280, 1024),
    (1440, 1080),
    (1920, 1080),
)
STRONGEST, WEAKEST = -1.5, -0.05
DEEPEST = -0.9
FEWEST_LINES, MOST_LINES = 8, 20


def random_board(seed: int, size: tuple[int, int] | None = None) -> BoardScene:
    """Draw scene number ``seed``; the same seed gives the same scene and the same picture.

    ``size`` is the frame's, (width, height) px, where it is not to be drawn; all else is then drawn alike.
    """
    rng = np.random.default_rng(seed)
    model, circle, reach = _lens(rng, size)
    middle = circle.center if circle else ((model.size[0] - 1) / 2, (model.size[1] - 1) / 2)
    light = rng.uniform(0.55, 0.95)
    scene = BoardScene(
        model=model,
        pattern=Pattern(
            kind="lines" if rng.random() < 0.2 else "chessboard",
            dark=light * rng.uniform(0.03, 0.15),
            light=light,
            background=light * rng.uniform(0.0, 0.7),
        ),
        pose=Pose(middle, 1.0),
        circle=circle,
        camera=_camera(rng, reach),
        clutter=rng.uniform(0.1, 0.6) if rng.random() < 0.5 else 0.0,
        seed=seed,
    )
    while True:  # 99 draws of 100 pass
        placed = _place(rng, scene, middle, reach)
        if placed is not None and _legible(placed):
            break
    return replace(
        placed,
        instruments=_instruments(rng, placed, middle, reach) if rng.random() < 0.3 else (),
        highlights=_highlights(rng, middle, reach) if rng.random() < 0.4 else (),
        overlays=_overlays(model.size, circle) if rng.random() < 0.5 else (),
        comb=_comb(rng) if rng.random() < 0.15 else (0.0, 0.0),
    )


def _lens(
    rng: np.random.Generator, size: tuple[int, int] | None
) -> tuple[DivisionModel, ContentCircle | None, float]:
    """Draw the model, the content circle, and the radius that visible content reaches, in px."""
    drawn = SIZES[rng.integers(len(SIZES))]
    w, h = size or drawn
    cx = (w - 1) / 2 + rng.uniform(-0.05, 0.05) * w
    cy = (h - 1) / 2 + rng.uniform(-0.05, 0.05) * h
    corner = math.hypot(max(cx, w - 1 - cx), max(cy, h - 1 - cy)) + 1
    strength = rng.uniform(STRONGEST, WEAKEST)
    circle = None
    reach = corner
    if strength < DEEPEST or rng.random() < 0.5:
        if strength < DEEPEST:
            reach = corner * math.sqrt(rng.uniform(-0.9, -0.6) / strength)
        else:
            reach = min(w, h) / 2 * rng.uniform(0.75, 1.3)
        aside = np.clip(rng.normal(0, 0.01, 2), -0.02, 0.02) * min(w, h)
        diameter = 2 * (reach - math.hypot(*aside))
        circle = ContentCircle((cx + aside[0], cy + aside[1]), diameter, rng.uniform(1, 4))
        reach = min(reach, corner)
    lam = strength / (corner if strength < DEEPEST else reach) ** 2
    return DivisionModel(lam, (cx, cy), (w, h)), circle, reach


def _camera(rng: np.random.Generator, reach: float) -> Camera:
    blur, noise, jpeg = rng.uniform(0, 2), rng.uniform(0, 10), int(rng.integers(70, 101))
    tint = (rng.uniform(0.8, 1), rng.uniform(0.85, 1), rng.uniform(0.85, 1))
    return Camera(
        blur=blur,
        vignetting=rng.uniform(0.2, 0.9) if rng.random() < 0.6 else 0.0,
        vignetting_radius=reach,
        gamma=rng.uniform(1.2, 2.4) if rng.random() < 0.5 else 1.0,
        black=rng.uniform(0, 16) if rng.random() < 0.3 else 0.0,
        noise=noise,
        tint=tint if rng.random() < 0.5 else None,
        jpeg=jpeg,
    )


def _place(
    rng: np.random.Generator, scene: BoardScene, middle: tuple[float, float], reach: float
) -> BoardScene | None:
    """Draw the pattern's lines and pose; None where it cannot cover what it should."""
    lines = rng.integers(FEWEST_LINES, MOST_LINES + 1, 2)
    cut = rng.random() < 0.25
    aside = (0.5 if cut else 0.15) * reach * math.sqrt(rng.random())
    direction = rng.uniform(0, 2 * math.pi)
    x, y = middle[0] + aside * math.cos(direction), middle[1] + aside * math.sin(direction)
    w, h = scene.model.size
    pose = Pose(
        center=(float(np.clip(x, 0, w - 1)), float(np.clip(y, 0, h - 1))),
        square=1.0,
        tilt=rng.uniform(0, 45),
        tilt_axis=rng.uniform(0, 360),
        rotation=rng.uniform(0, 360),
        # Where a lens maps angles to radii evenly, lam * focal^2 is close to -1/3.
        focal=math.sqrt(rng.uniform(0.2, 0.6) / -scene.division.lam),
    )
    share = rng.uniform(0.3, 0.75)
    pattern = replace(scene.pattern, cols=int(lines[0]) + 1, rows=int(lines[1]) + 1)
    scene = replace(scene, pattern=pattern, pose=pose)
    placed = covering(scene, share)
    if placed is not None and cut and rng.random() < 0.5:
        square = placed.pose.square * rng.uniform(1.0, 1.4)
        return replace(placed, pose=replace(placed.pose, square=square))
    return placed


def _legible(scene: BoardScene) -> bool:
    """Whether a user would keep the picture.

    Half of the inner corners are visible, on six lines each way or more, and the typical visible square
    has a side of at least 7 px and twice the blur.
    """
    corners, seen = true_corners(scene)
    if seen.mean() < 0.5 or np.any(seen, 0).sum() < 6 or np.any(seen, 1).sum() < 6:
        return False
    side = np.linalg.norm(np.diff(corners, axis=1), axis=-1)[seen[:, 1:] & seen[:, :-1]]
    other = np.linalg.norm(np.diff(corners, axis=0), axis=-1)[seen[1:] & seen[:-1]]
    return min(np.median(side), np.median(other)) >= 7 + 2 * scene.camera.blur


def _instruments(
    rng: np.random.Generator, scene: BoardScene, middle: tuple[float, float], reach: float
) -> tuple[Instrument, ...]:
    model, focal = scene.model, scene.pose.focal
    found = []
    for _ in range(rng.integers(1, 3)):
        direction = rng.uniform(0, 2 * math.pi)
        r = rng.uniform(0.3, 0.8) * reach
        seen = (middle[0] + r * math.cos(direction), middle[1] + r * math.sin(direction))
        tip = (model.undistort(seen) - model.center) / focal
        found.append(
            Instrument(
                tip=(float(tip[0]), float(tip[1])),
                angle=math.degrees(direction) + rng.uniform(-30, 30),
                width=rng.uniform(0.06, 0.16) * reach / focal,
                radiance=rng.uniform(0.02, 0.3),
                shine=rng.uniform(0.2, 0.9),
            )
        )
    return tuple(found)


def _highlights(
    rng: np.random.Generator, middle: tuple[float, float], reach: float
) -> tuple[Highlight, ...]:
    return tuple(
        Highlight(
            center=(
                middle[0] + rng.normal(0, 0.35) * reach,
                middle[1] + rng.normal(0, 0.35) * reach,
            ),
            sigma=rng.uniform(0.01, 0.06) * reach,
            strength=rng.uniform(0.3, 1.5),
        )
        for _ in range(rng.integers(1, 5))
    )


def _overlays(size: tuple[int, int], circle: ContentCircle | None) -> tuple[Overlay, ...]:
    """Text in the upper left corner and lower right, where a content circle leaves room for it."""
    if circle is None:
        return ()
    w, h = size
    scale = 0.35 * h / 480
    places = ("02:14:07", (int(0.01 * w), int(0.05 * h))), ("REC", (int(0.92 * w), int(0.98 * h)))
    return tuple(Overlay(text, place, scale) for text, place in places)


def _comb(rng: np.random.Generator) -> tuple[float, float]:
    return rng.choice((-1.0, 1.0)) * rng.uniform(0.5, 4), rng.uniform(-0.5, 0.5)
