"""A flat scene before a division-model lens that zooms and a camera that moves: what is seen is known."""

from __future__ import annotations

import math

import cv2
import numpy as np

from endocal.benchmarks.rim_frames import texture
from endocal.model import DivisionModel
from endocal.zoom.view import View

SIZE = (480, 360)
MIDDLE = (243.0, 177.0)
DIAMETER = 560.0
STRENGTH = -1.3
# In units of the diameter; what a fisheye of this strength has.
FOCAL = 0.55
# Texture px to a diameter: about as fine as a picture.
_FINE = 700.0
SCENE, OTHER_SCENE = (
    (30 + 200 * texture(np.random.default_rng(seed), (1200, 900), 1.2)).astype(np.uint8)
    for seed in (3, 4)
)


def view(diameter: float = DIAMETER, strength: float = STRENGTH) -> View:
    """How a full-size picture is seen with a circle of this diameter, px, and this lam D^2."""
    return View(DivisionModel(strength / diameter**2, MIDDLE, SIZE), diameter, 1)


def turned(degrees: tuple[float, float, float]) -> np.ndarray:
    """The homography of undistorted places by a camera that turns right, down and about its axis."""
    rotation, _ = cv2.Rodrigues(np.radians([-degrees[1], degrees[0], degrees[2]]))
    lens = np.diag([FOCAL, FOCAL, 1.0])
    return _normal(lens @ rotation @ np.linalg.inv(lens))


def moved(
    aside: tuple[float, float] = (0.0, 0.0),
    roll: float = 0.0,
    nearer: float = 0.0,
    tilt: tuple[float, float] = (0.0, 0.0),
) -> np.ndarray:
    """A homography of undistorted places, in units of the diameter; ``nearer`` is a logarithm."""
    c, s = math.exp(nearer) * math.cos(roll), math.exp(nearer) * math.sin(roll)
    return np.array([[c, -s, aside[0]], [s, c, aside[1]], [*tilt, 1.0]])


def seen(
    scene: np.ndarray, homography: np.ndarray, zoom: float, strength: float = STRENGTH
) -> np.ndarray:
    """Where undistorted places (n, 2) are seen, px, after a homography and a zoom by a logarithm."""
    lens = view(strength=strength).model
    there = cv2.perspectiveTransform(scene[:, None], homography)[:, 0]
    return (lens.distort(there * DIAMETER + MIDDLE) - MIDDLE) * math.exp(zoom) + MIDDLE


def picture(
    homography: np.ndarray | None = None,
    zoom: float = 0.0,
    scene: np.ndarray = SCENE,
    seed: int = 0,
) -> np.ndarray:
    """What is seen of a scene after a homography and a zoom by a logarithm, uint8 (h, w), with noise."""
    y, x = np.mgrid[0 : SIZE[1], 0 : SIZE[0]].astype(np.float64)
    places = np.stack([x.ravel(), y.ravel()], axis=1)
    before = (places - MIDDLE) * math.exp(-zoom) + MIDDLE
    away = (view().model.undistort(before) - MIDDLE) / DIAMETER
    back = np.linalg.inv(np.eye(3) if homography is None else homography)
    away = cv2.perspectiveTransform(away[:, None], back)[:, 0]
    source = (away * _FINE + np.array(scene.shape[::-1]) / 2).astype(np.float32)
    drawn = cv2.remap(scene, source.reshape(SIZE[1], SIZE[0], 2), None, cv2.INTER_LINEAR)
    noise = np.random.default_rng(seed).normal(0, 1.0, drawn.shape)
    return np.clip(np.rint(drawn + noise), 0, 255).astype(np.uint8)


def _normal(homography: np.ndarray) -> np.ndarray:
    return homography / homography[2, 2]
