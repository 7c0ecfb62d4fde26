"""A key picture: places of it are found again in pictures seconds later, whatever lies between.

The steps from frame to frame add up, and with them what each is off by. The zoom since a key picture is off
by the errors of a single match.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from .likeness import Likeness
from .matching import Luma, best_corners, follow_places
from .planar import PlanarFit, PlanarMotion, PlanarSpec, fit_planar
from .view import Points, View

# The lens is drawn exactly at every so many px of a picture, and evenly between.
_GRID = 8
# Places so near to a picture's border, reduced px, have much of what is about them outside.
_BORDER = 4.0
# The key is drawn as it should be seen now: what is left to be found is near, and may be compared at large.
_WINDOW, _LEVELS = 23, 1


@dataclass(frozen=True)
class KeySpec:
    """How a key picture is matched.

    Up to ``points`` places of it are sought, ``spacing`` reduced px apart so that no two are compared by the
    same pixels, and not nearer to the rim than at ``reach`` of the circle's radius; in a soft picture a
    corner counts from ``worth`` of its median strength on. With fewer than ``least`` found nothing is told.
    ``noise`` is the least error of a place, reduced px.
    """

    points: int = 150
    spacing: float = 24.0
    reach: float = 0.94
    worth: float = 1.0
    least: int = 24
    noise: float = 0.05
    planar: PlanarSpec = field(default_factory=PlanarSpec)


class KeyPicture:
    """A ``picture``, as it was seen in a ``view``, and what became of it since."""

    def __init__(self, picture: Luma, view: View, spec: KeySpec = KeySpec()) -> None:
        self._spec = spec
        self._picture, self._view = picture, view
        corners = best_corners(picture, spec.points, spec.spacing, spec.worth)[:, 0]
        self._places = view.undistorted(corners[self._within(corners, view)])
        self._motion = PlanarMotion()
        self._found = 0

    @property
    def view(self) -> View:
        """How it was seen."""
        return self._view

    @property
    def motion(self) -> PlanarMotion:
        """The motion since, as far as it is known."""
        return self._motion

    @property
    def found(self) -> int:
        """How many places were found when it was last matched."""
        return self._found

    def go_on(self, generator: Points, logarithm: float) -> None:
        """Take in what a step from frame to frame says of camera and zoom."""
        self._motion = self._motion.then(generator, logarithm)

    def match(
        self,
        picture: Luma,
        view: View,
        drift: tuple[float, float],
        hand: float,
        likeness: Likeness,
    ) -> PlanarFit | None:
        """Return the motion up to a ``picture``, seen in a ``view`` if the zoom since is as it is known.

        ``drift`` is how its centre moves with the logarithm of the diameter, px, and ``hand`` by how much the
        camera may have come nearer. None where too little of the key is found.
        """
        spec = self._spec
        expected = view.places(self._motion.forth(self._places))
        there = self._within(expected, view)
        expected = np.asarray(expected[there], np.float32)
        self._found = 0
        if len(expected) < spec.least:
            return None
        drawn, origin = self._drawn(view)
        moved, found = follow_places(
            drawn, picture, np.asarray(expected[:, None], np.float32), _WINDOW, _LEVELS
        )
        self._found = int(found.sum())
        if self._found < spec.least:
            return None
        # A place is that of the key which was drawn there.
        x, y = expected[found].T
        remapped = cv2.remap(origin, x[:, None], y[:, None], cv2.INTER_LINEAR)
        start = np.asarray(remapped, np.float64)[:, 0]
        fit = fit_planar(
            self._view.undistorted(start),
            moved[found][:, 0],
            view,
            drift,
            self._motion,
            hand,
            spec.noise * view.reduction,
            likeness,
            spec.planar,
        )
        self._motion = fit.motion
        return fit

    def _drawn(self, view: View) -> tuple[Luma, NDArray[np.float32]]:
        """Draw the key as it should be seen in a ``view``; returns where each pixel comes from besides."""
        height, width = self._picture.shape
        rows, columns = (n // _GRID + 2 for n in (height, width))
        y, x = np.mgrid[:rows, :columns] * float(_GRID)
        scene = self._motion.back(view.undistorted(np.stack([x.ravel(), y.ravel()], axis=1)))
        # What the lens does not show is far outside.
        coarse = np.nan_to_num(self._view.places(scene), nan=-float(width)).astype(np.float32)
        finer = np.array([[1 / _GRID, 0, 0], [0, 1 / _GRID, 0]])
        origin = cv2.warpAffine(
            coarse.reshape(rows, columns, 2),
            finer,
            (width, height),
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        )
        # OpenCV takes one map of both coordinates, whatever its annotations say.
        none: Any = None
        drawn = cv2.remap(
            self._picture, origin, none, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
        )
        return np.asarray(drawn, np.uint8), np.asarray(origin, np.float32)

    def _within(self, places: NDArray[np.floating], view: View) -> NDArray[np.bool_]:
        """Say which places (n, 2) lie in the picture, away from its border and the rim."""
        height, width = self._picture.shape
        inside = (places > _BORDER) & (places < np.array([width, height]) - 1 - _BORDER)
        offset = view.offsets(places)
        near = np.hypot(offset[:, 0], offset[:, 1]) < self._spec.reach * view.diameter / 2
        return np.asarray(inside.all(axis=1) & near, np.bool_)
