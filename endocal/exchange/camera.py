"""The camera of OpenCV and ROS: a pinhole with distortion coefficients, evaluated by OpenCV itself."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from ..errors import InputError
from ..model import Points

# How many coefficients OpenCV's models have: k1 k2 p1 p2, then k3, k4-k6, s1-s4, tau x and y.
_COUNTS = (4, 5, 8, 12, 14)


@dataclass(frozen=True)
class Camera:
    """A camera matrix without skew, and distortion coefficients in OpenCV's order.

    ``focal`` (fx, fy) and ``center`` (cx, cy) in px, ``size`` (width, height) in px. ``fisheye``: the
    coefficients are the four of OpenCV's fisheye model, which ROS calls equidistant. ``circle`` is the
    visible circle (x, y, diameter), px, where the file tells it. Raises InputError for what is no camera.
    """

    focal: tuple[float, float]
    center: tuple[float, float]
    coefficients: tuple[float, ...]
    size: tuple[int, int]
    fisheye: bool = False
    circle: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        if not np.isfinite([*self.focal, *self.center, *self.coefficients]).all():
            raise InputError("the camera holds a value that is not a finite number")
        if min(self.focal) <= 0:
            raise InputError(f"the focal length {min(self.focal):g} px is not positive")
        if min(self.size) < 1:
            raise InputError(f"{self.size[0]}x{self.size[1]} is no image size")
        known = (4,) if self.fisheye else _COUNTS
        if len(self.coefficients) not in known:
            counts = ", ".join(str(n) for n in known)
            raise InputError(
                f"{len(self.coefficients)} distortion coefficients fit no model of OpenCV's: give {counts}"
            )
        if self.circle is not None and not (np.isfinite(self.circle).all() and self.circle[2] > 0):
            raise InputError(f"{list(self.circle)} is no visible circle: x, y, diameter in px")

    @property
    def matrix(self) -> Points:
        """The camera matrix, (3, 3)."""
        (fx, fy), (cx, cy) = self.focal, self.center
        return np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]], np.float64)

    def undistorted(self, rays: Points) -> Points:
        """Return the undistorted px of rays (n, 2), x/z and y/z, where the camera matrix stays the same."""
        return rays * self.focal + self.center

    def distorted(self, rays: Points) -> Points:
        """Return the distorted px of rays (n, 2), x/z and y/z, as OpenCV computes them."""
        coefficients = np.array(self.coefficients)
        if self.fisheye:
            plain = np.ascontiguousarray(rays, np.float64)[:, None]
            return np.asarray(cv2.fisheye.distortPoints(plain, self.matrix, coefficients), float)[
                :, 0
            ]
        solid = np.column_stack([rays, np.ones(len(rays))])
        none = np.zeros(3)
        points, _ = cv2.projectPoints(solid, none, none, self.matrix, coefficients)
        return np.asarray(points, np.float64)[:, 0]
