"""A flat calibration pattern and where it stands before the camera."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import UsageError
from .sampling import Coordinates

KINDS = ("chessboard", "lines")

# Labels of the surfaces of a board; the squares follow from SQUARES on, row by row.
BACKGROUND, SHEET, SQUARES = 0, 1, 2


@dataclass(frozen=True)
class Pattern:
    """A chessboard of ``cols`` x ``rows`` squares, or ``cols`` parallel bars that are ``rows`` long.

    The unit of length is one square's side, the origin is the middle of the pattern, x runs along the
    columns. ``dark``, ``light`` and ``background`` are linear radiances from 0 to 1; ``margin`` is the
    width of the light sheet around the pattern, in squares; beyond it is the background.
    """

    kind: str = "chessboard"
    cols: int = 12
    rows: int = 9
    dark: float = 0.05
    light: float = 0.8
    background: float = 0.25
    margin: float = 1.0

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise UsageError(f"pattern {self.kind!r} is none of {', '.join(KINDS)}")
        if self.cols < 1 or self.rows < 1:
            raise UsageError(f"a pattern of {self.cols}x{self.rows} squares has none")

    @property
    def radiances(self) -> NDArray[np.float32]:
        """The radiance of each label, as float32."""
        i, j = np.meshgrid(np.arange(self.cols), np.arange(self.rows))
        dark = i % 2 == 0 if self.kind == "lines" else (i + j) % 2 == 0
        squares = np.where(dark, self.dark, self.light).ravel()
        return np.array([self.background, self.light, *squares], np.float32)

    def labels(self, x: Coordinates, y: Coordinates) -> NDArray[np.int32]:
        """Which surface lies at plane coordinates (x, y), in squares; NaN counts as background."""
        across, along = self.cols / 2, self.rows / 2
        with np.errstate(invalid="ignore"):
            ax, ay = np.abs(x), np.abs(y)
            on_sheet = (ax < across + self.margin) & (ay < along + self.margin)
            on_pattern = (ax < across) & (ay < along)
            # Truncation is floor here: what is negative or undefined does not lie on the pattern.
            column, row = (x + across).astype(np.int32), (y + along).astype(np.int32)
        # x + across may round up to the pattern's far side.
        np.minimum(column, self.cols - 1, out=column)
        np.minimum(row, self.rows - 1, out=row)
        square = row * np.int32(self.cols) + column + np.int32(SQUARES)
        return np.where(on_pattern, square, on_sheet)

    def inner_corners(self) -> NDArray[np.float64]:
        """Plane coordinates of the inner corners, (rows - 1, cols - 1, 2), in squares."""
        x = np.arange(1, self.cols) - self.cols / 2
        y = np.arange(1, self.rows) - self.rows / 2
        return np.stack(np.meshgrid(x, y), axis=-1)

    def lines(self, samples: int) -> list[NDArray[np.float64]]:
        """Plane coordinates along each inner line, (samples, 2) each; bars have lines one way only."""
        x = np.linspace(-self.cols / 2, self.cols / 2, samples)
        y = np.linspace(-self.rows / 2, self.rows / 2, samples)
        found = [
            np.column_stack([np.full(samples, i - self.cols / 2), y]) for i in range(1, self.cols)
        ]
        if self.kind == "chessboard":
            found += [
                np.column_stack([x, np.full(samples, j - self.rows / 2)])
                for j in range(1, self.rows)
            ]
        return found


@dataclass(frozen=True)
class Pose:
    """Where the pattern stands.

    ``center`` (x, y) is where the middle of the pattern is seen, in distorted px; ``square`` is the side
    of a square there in undistorted px, were it seen from straight ahead; ``tilt`` is the angle between
    the pattern's normal and the optical axis, about an axis at ``tilt_axis`` in the picture plane;
    ``rotation`` turns the pattern in its own plane. Degrees. ``focal`` is the focal length of the
    undistorted picture, in px (of the frame's height).
    """

    center: tuple[float, float]
    square: float
    tilt: float = 0.0
    tilt_axis: float = 0.0
    rotation: float = 0.0
    focal: float = 500.0

    def homography(self, center_offset: NDArray[np.float64]) -> NDArray[np.float64]:
        """Map plane coordinates, (x, y, 1) in squares, to undistorted offsets from the distortion centre.

        ``center_offset`` (2,) is the undistorted offset of the pattern's middle, in square px. Returns
        (3, 3), scaled so that the third coordinate of an image is positive before the camera.
        """
        axis = _turn(self.tilt_axis)
        tilt = math.radians(self.tilt)
        lean = np.array(
            [
                [1, 0, 0],
                [0, math.cos(tilt), -math.sin(tilt)],
                [0, math.sin(tilt), math.cos(tilt)],
            ]
        )
        rotation = axis @ lean @ axis.T @ _turn(self.rotation)
        distance = self.focal / self.square
        position = np.array([*(center_offset / self.focal), 1.0]) * distance
        return np.diag([self.focal, self.focal, 1.0]) @ np.column_stack(
            [rotation[:, 0], rotation[:, 1], position]
        )


def _turn(degrees: float) -> NDArray[np.float64]:
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
