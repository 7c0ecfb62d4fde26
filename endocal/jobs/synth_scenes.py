"""What ``endocal synth`` can be asked for, and the scenes that answer."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from ..errors import UsageError
from ..model import DivisionModel
from ..synth.board import BoardScene
from ..synth.camera import Camera, ContentCircle
from ..synth.clip import BoardStand, ClipScene
from ..synth.framing import covering
from ..synth.lens import ZoomLens, typical_lens
from ..synth.motion import CouplerPlay, EyeMotion, zoom_path
from ..synth.objects import Instrument, MovingInstrument
from ..synth.pattern import Pattern, Pose
from ..synth.sound import KINDS as SOUNDS

SCENES = ("board", "tissue")

# What a scope's lamp and sensor make of white: gains of blue, green and red.
_TINT = (0.90, 0.97, 1.0)
# Larger pictures than any scope's, and yet rendered in a few hundred MB.
_LARGEST_SIDE = 8192
# In narrower clips libx264's look-ahead gives now these bytes, now those (seen below 112 px).
_SMALLEST_CLIP = 128
# A stronger lens shows its rim more than ten times as large, and nothing can be read there.
_STRONGEST = -3.6


@dataclass(frozen=True)
class BoardSpec:
    """One picture of a pattern.

    ``size`` in px; ``lam`` in px^-2 and ``center`` (x, y) in px, None for a typical lens; ``diameter`` of
    the content circle in px, 0 for none, None for one that fits the frame; ``squares`` columns and rows;
    ``tilt`` and ``rotation`` in degrees; ``share`` of the content that the pattern covers; the rest as in
    ``Camera``.
    """

    size: tuple[int, int] = (720, 540)
    lam: float | None = None
    center: tuple[float, float] | None = None
    diameter: float | None = None
    pattern: str = "chessboard"
    squares: tuple[int, int] = (14, 11)
    tilt: float = 15.0
    rotation: float = 10.0
    share: float = 0.6
    blur: float = 0.8
    noise: float = 2.0
    vignetting: float = 0.4
    gamma: float = 1.8
    jpeg: int | None = None
    seed: int = 0

    def __post_init__(self) -> None:
        _check_size(self.size)


@dataclass(frozen=True)
class ZoomSpec:
    """Boards at several zoom settings of one lens.

    ``zooms`` are relative to the setting at which the content circle is ``fill`` times the frame's height;
    ``strength`` is lambda * diameter^2, the same at each; ``size``, ``squares``, ``noise`` as for a board.
    """

    zooms: tuple[float, ...] = (1.0, 1.25, 1.5, 1.8)
    size: tuple[int, int] = (720, 540)
    strength: float = -1.3
    fill: float = 0.8
    squares: tuple[int, int] = (14, 11)
    noise: float = 1.5
    seed: int = 0

    def __post_init__(self) -> None:
        _check_size(self.size)
        if not self.zooms or not all(0 < z < 100 for z in self.zooms):
            raise UsageError("--zooms: give numbers above 0, such as 1,1.5,2")
        if not _STRONGEST <= self.strength <= 1:
            raise UsageError(f"--strength {self.strength:g}: it lies from {_STRONGEST} to 1")
        if not 0.1 <= self.fill <= 3:
            raise UsageError(f"--fill {self.fill:g}: it lies from 0.1 to 3")

    @property
    def lens(self) -> ZoomLens:
        """The lens that both pictures and clips are taken with."""
        return typical_lens(self.size, self.strength, self.fill)


@dataclass(frozen=True)
class ClipSpec(ZoomSpec):
    """A clip that goes through ``zooms``, evenly spread over ``duration`` s; equal neighbours are a rest.

    ``rate`` in frames per second; ``scene`` is one of SCENES and ``sound`` one of SOUNDS; ``motion`` scales
    the sway of the hand (1: usual, 0: still); ``approach`` is how far the lens goes towards the tissue and
    back, in parts of the distance; ``play`` is how far, px, the picture wanders on the sensor, as of a scope
    that is loose in its coupler; ``instruments`` is how many move about; ``crf`` is the encoder's quality.
    """

    zooms: tuple[float, ...] = (1.0, 1.25, 1.5, 1.8, 1.0)
    size: tuple[int, int] = (640, 480)
    duration: float = 4.0
    rate: Fraction = Fraction(25)
    scene: str = "board"
    sound: str = "sweep"
    instruments: int = 1
    motion: float = 1.0
    approach: float = 0.0
    play: float = 0.0
    crf: float = 18.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if min(self.size) < _SMALLEST_CLIP:
            raise UsageError(f"--size: a clip has at least {_SMALLEST_CLIP} px a side")
        if self.scene not in SCENES:
            raise UsageError(f"--scene {self.scene}: it is one of {', '.join(SCENES)}")
        if self.sound not in SOUNDS:
            raise UsageError(f"--sound {self.sound}: it is one of {', '.join(SOUNDS)}")
        if not (0 < self.duration <= 3600 and 1 <= self.rate <= 1000):
            raise UsageError("a clip lasts up to 3600 s, at 1 to 1000 frames per second")
        if not (0 <= self.motion <= 10 and -2 <= self.approach <= 0.5):
            raise UsageError("--motion lies from 0 to 10, --approach from -2 to 0.5")
        if not 0 <= self.play <= 0.1 * min(self.size):
            raise UsageError(f"--play {self.play:g}: from 0 to a tenth of the frame, px")
        if not 0 <= self.instruments <= 8:
            raise UsageError(f"--instruments {self.instruments}: from 0 to 8")

    @property
    def frames(self) -> int:
        """How many frames the clip has."""
        return max(round(self.duration * self.rate), 1)


def board_scene(spec: BoardSpec) -> BoardScene:
    """Return the scene of a picture; UsageError where nothing can be seen so."""
    w, h = spec.size
    diameter = 0.95 * h if spec.diameter is None else spec.diameter
    lens = typical_lens(spec.size, fill=(diameter or h) / h)
    center = lens.model.center if spec.center is None else spec.center
    lam = lens.model.lam if spec.lam is None else spec.lam
    model = DivisionModel(lam, center, spec.size)
    circle = ContentCircle(lens.circle_at(1).center, diameter, 2.0) if diameter else None
    reach = diameter / 2 or np.hypot(max(center[0], w - center[0]), max(center[1], h - center[1]))
    if model.valid_radius <= reach:
        raise UsageError(
            f"--lambda {lam:g} folds the picture {model.valid_radius:.0f} px from the centre"
        )
    camera = Camera(
        blur=spec.blur,
        vignetting=spec.vignetting,
        vignetting_radius=float(reach),
        gamma=spec.gamma,
        black=4.0,
        noise=spec.noise,
        tint=_TINT,
        jpeg=spec.jpeg,
    )
    middle = circle.center if circle else ((w - 1) / 2, (h - 1) / 2)
    pose = Pose(middle, 1.0, spec.tilt, 40.0, spec.rotation, lens.focal)
    cols, rows = spec.squares
    pattern = Pattern(spec.pattern, cols, rows)
    scene = BoardScene(model, pattern, pose, circle, camera, clutter=0.25, seed=spec.seed)
    return _covering(scene, spec.share)


def zoom_scene(spec: ZoomSpec, index: int) -> BoardScene:
    """Return the scene at the zoom number ``index``: the board held anew, as a user would."""
    zoom, lens = spec.zooms[index], spec.lens
    rng = np.random.default_rng([spec.seed, index])
    model, circle = lens.model_at(zoom), lens.circle_at(zoom)
    camera = Camera(
        blur=0.8,
        vignetting=0.4,
        vignetting_radius=circle.diameter / 2,
        gamma=1.8,
        black=4.0,
        noise=spec.noise,
        tint=_TINT,
    )
    tilt, axis, turn = rng.uniform(8, 20), rng.uniform(0, 360), rng.uniform(-15, 15)
    pose = Pose(circle.center, 1.0, tilt, axis, turn, lens.focal_at(zoom))
    pattern = Pattern("chessboard", *spec.squares)
    scene = BoardScene(model, pattern, pose, circle, camera, clutter=0.25, seed=spec.seed + index)
    return _covering(scene, 0.62)


def clip_scene(spec: ClipSpec) -> ClipScene:
    """Return the scene of a clip."""
    cols, rows = spec.squares
    still = spec.motion
    return ClipScene(
        lens=spec.lens,
        path=zoom_path(spec.zooms, spec.duration),
        frames=spec.frames,
        rate=spec.rate,
        camera=Camera(
            blur=0.8, vignetting=0.35, gamma=2.0, black=4.0, noise=spec.noise, tint=_TINT
        ),
        motion=EyeMotion(
            sway=(0.03 * still, 0.02 * still, 0.02 * still),
            turn=(1.5 * still, 1.0 * still, 2.0 * still),
            approach=spec.approach,
            duration=spec.duration,
        ),
        play=CouplerPlay((spec.play, 0.6 * spec.play)),
        instruments=_instruments(spec),
        board=BoardStand(
            Pattern("chessboard", cols, rows, dark=0.03, light=0.75, margin=0.6),
            square=1.45 / max(cols, rows),
        )
        if spec.scene == "board"
        else None,
        seed=spec.seed,
    )


def _check_size(size: tuple[int, int]) -> None:
    if not all(16 <= n <= _LARGEST_SIDE for n in size):
        raise UsageError(f"--size {size[0]}x{size[1]}: from 16 to {_LARGEST_SIDE} px a side")


def _covering(scene: BoardScene, share: float) -> BoardScene:
    placed = covering(scene, share) if 0 < share <= 1 else None
    if placed is None:
        raise UsageError(
            f"a board tilted by {scene.pose.tilt:g} degrees cannot cover {share:.0%} of this view"
        )
    return placed


def _instruments(spec: ClipSpec) -> tuple[MovingInstrument, ...]:
    """Shafts from all around that move about their tips."""
    rng = np.random.default_rng([spec.seed, 1])
    found = []
    for i in range(spec.instruments):
        # The golden angle keeps any number of them apart.
        angle = 25 + 137.5 * i + rng.uniform(-10, 10)
        reach = rng.uniform(0.35, 0.6)
        tip = reach * np.cos(np.radians(angle)), reach * np.sin(np.radians(angle))
        shaft = Instrument((float(tip[0]), float(tip[1])), angle, rng.uniform(0.10, 0.14))
        sway = rng.uniform(0.04, 0.12), rng.uniform(0.04, 0.12)
        found.append(MovingInstrument(shaft, sway, rng.uniform(3, 6), rng.uniform(0, 1)))
    return tuple(found)
