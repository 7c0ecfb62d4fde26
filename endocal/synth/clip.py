"""Clips of a zooming endoscope, with the truth of every frame."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from fractions import Fraction

import numpy as np

from ..model import DivisionModel
from .board import BoardScene, board_light
from .camera import Camera, ContentCircle, Light, Picture, to_grey_levels
from .lens import ZoomLens
from .motion import CouplerPlay, EyeMotion, ZoomPath
from .objects import MovingInstrument
from .pattern import Pattern, Pose
from .rays import pixel_rays
from .tissue import Eye, Organ, Tissue, texels_for


@dataclass(frozen=True)
class BoardStand:
    """A board that stands before the tissue, at the usual distance from the lens.

    ``direction`` (x, y) in which its middle is seen and ``square``, the side of a square, are tangents of
    angles; the angles are in degrees.
    """

    pattern: Pattern
    direction: tuple[float, float] = (0.0, 0.0)
    square: float = 0.12
    tilt: float = 15.0
    tilt_axis: float = 30.0
    rotation: float = 5.0

    def seen_by(self, model: DivisionModel, focal: float, eye: Eye) -> Pose:
        """Return its pose at a zoom, as the eye moves; small angles are taken as tangents."""
        x = self.direction[0] - eye.position[0] - np.radians(eye.yaw)
        y = self.direction[1] - eye.position[1] - np.radians(eye.pitch)
        place = np.array([x * focal / model.pixel_aspect, y * focal]) + model.center
        seen = model.distort(place)
        return Pose(
            center=(float(seen[0]), float(seen[1])),
            square=self.square * focal / (1 - eye.position[2]),
            tilt=self.tilt,
            tilt_axis=self.tilt_axis,
            rotation=self.rotation - eye.roll,
            focal=focal,
        )


@dataclass(frozen=True)
class ClipScene:
    """Everything that makes one clip.

    ``frames`` pictures at ``rate`` per second, through ``lens`` as it zooms along ``path``. The camera's
    ``vignetting_radius`` follows the content circle by itself. The lens has ``play`` before the sensor.
    ``organs`` stand before the tissue, and ``board``, if there is one.
    """

    lens: ZoomLens
    path: ZoomPath
    frames: int
    rate: Fraction = Fraction(25)
    camera: Camera = field(default_factory=Camera)
    motion: EyeMotion = field(default_factory=EyeMotion)
    instruments: tuple[MovingInstrument, ...] = ()
    board: BoardStand | None = None
    organs: tuple[Organ, ...] = ()
    play: CouplerPlay = field(default_factory=CouplerPlay)
    seed: int = 0


@dataclass(frozen=True)
class ClipFrame:
    """One frame, uint8 (h, w, 3) BGR at ``time`` s, and what is true of it."""

    index: int
    time: Fraction
    image: Picture
    zoom: float
    model: DivisionModel
    circle: ContentCircle
    shift: tuple[float, float]


def clip_frames(scene: ClipScene) -> Iterator[ClipFrame]:
    """Render the clip frame by frame; the same scene gives the same bytes."""
    nearest = max(zoom for _, zoom in scene.path.keys)
    tissue = Tissue(scene.seed, texels_for(scene.lens.focal_at(nearest)), organs=scene.organs)
    for index in range(scene.frames):
        time = index / scene.rate
        zoom = scene.path.at(float(time))
        shift = scene.play.at(float(time))
        lens = scene.lens.shifted(shift)
        model, circle = lens.model_at(zoom), lens.circle_at(zoom)
        camera = replace(scene.camera, vignetting_radius=circle.diameter / 2)
        light = _light(scene, lens, tissue, float(time), zoom)
        light = camera.focus(light, circle, model.pixel_aspect)
        # Each frame's own stream of random numbers, so that one frame does not depend on the others.
        rng = np.random.default_rng([scene.seed, index])
        level = camera.expose(light, circle, model.pixel_aspect, rng)
        yield ClipFrame(index, time, to_grey_levels(level), zoom, model, circle, shift)


def _light(scene: ClipScene, lens: ZoomLens, tissue: Tissue, time: float, zoom: float) -> Light:
    """Radiance of all that is seen at ``time``, float32 (H, W, 3), widened by the camera's reach."""
    model, focal = lens.model_at(zoom), lens.focal_at(zoom)
    eye = scene.motion.at(time)
    rays = pixel_rays(model, focal, scene.camera.reach)
    light = tissue.light(rays, eye)
    if scene.board is not None:
        pose = scene.board.seen_by(model, focal, eye)
        stand = BoardScene(model, scene.board.pattern, pose, camera=scene.camera)
        light = board_light(stand, light)
    for item in scene.instruments:
        item.at(time).paint(light, rays)
    return light
