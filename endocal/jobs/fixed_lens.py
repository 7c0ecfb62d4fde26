"""One calibration for all frames, and whether they show the zoom that it was made at."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..boundary.circle import Boundary
from ..calibration.result import Calibration
from ..errors import InputError
from ..model import DivisionModel

if TYPE_CHECKING:
    from ..zoom.shift import CircleShift

# Where the centre does not follow it, the circle is looked at in every so manieth frame: every few seconds.
_LOOK_EVERY = 100
# A circle whose width differs by more than this, relative, is that of another zoom: lambda differs by twice
# as much. One that lies further off than this, in parts of the diameter, has moved on the sensor.
_SAME_ZOOM, _SAME_PLACE = 0.02, 0.01


class FixedModel:
    """One model for all frames; with ``center`` follow, its centre goes with the visible circle.

    Where the calibration tells its circle, it is compared with that of some frames: ``notes`` says where the
    zoom or the circle's place is another. Raises InputError where it does not and the centre is to follow.
    """

    def __init__(self, calibration: Calibration, center: str = "auto") -> None:
        self._model = calibration.model
        self._circle = calibration.boundary
        self._follows = center == "follow"
        if self._follows and self._circle is None:
            raise InputError(
                "--center follow: the calibration does not tell where its visible circle was; calibrate on a"
                " picture that shows the rim"
            )
        self._last: Boundary | None = None
        self._frame = 0
        self.models: tuple[DivisionModel, ...] = (self._model,)
        self.boundaries: tuple[Boundary | None, ...] = (self._circle,)
        self.sources: Counter[str] = Counter()
        self.diameters: tuple[float, float] | None = None
        self.notes: list[str] = []
        self._noted: set[str] = set()

    def model(self, luma: Callable[[], np.ndarray], time_s: float | None) -> DivisionModel:
        """Return the model for a frame, of which some are looked at."""
        if self._circle is not None and (self._follows or self._frame % _LOOK_EVERY == 0):
            self._look(luma(), self._circle, time_s)
        self._frame += 1
        return self._model

    @cached_property
    def _shift(self) -> CircleShift:
        from ..zoom.shift import CircleShift

        circle = self.boundaries[0]
        assert circle is not None
        return CircleShift(lambda diameter: circle.center, self._model.pixel_aspect)

    def _look(self, luma: np.ndarray, circle: Boundary, time_s: float | None) -> None:
        """Compare the frame's circle with the calibration's, and follow it."""
        # The search for the circle takes a while to import.
        from ..boundary.detect import locate_boundary
        from ..zoom.shift import shifted

        aspect = self._model.pixel_aspect
        located = locate_boundary(luma, aspect, guess=self._last)
        self._last = None if located is None else located.boundary
        self._shift.advance(1.0)
        if located is None:
            return
        seen = located.boundary
        when = f"frame {self._frame}" if time_s is None else f"{time_s:.2f} s"
        if abs(math.log(seen.diameter / circle.diameter)) > _SAME_ZOOM:
            off = (seen.diameter / circle.diameter) ** 2 - 1
            self._note(
                "zoom",
                f"the visible circle is {seen.diameter:.0f} px wide at {when}, where it was"
                f" {circle.diameter:.0f} px in the calibration: the zoom is another, and lambda"
                f" {abs(off):.0%} too {'strong' if off > 0 else 'weak'}; a zoom table follows it",
            )
            return
        if self._follows:
            self._shift.measure(located, circle.diameter)
            self._model = shifted(self.models[0], self._shift.value)
            return
        x, y = (a - b for a, b in zip(seen.center, circle.center, strict=True))
        moved = math.hypot(x * aspect, y)
        if moved > _SAME_PLACE * circle.diameter:
            self._note(
                "place",
                f"the visible circle lies {moved:.0f} px from where it was in the calibration, at {when}:"
                " --center follow moves the distortion centre with it",
            )

    def _note(self, about: str, text: str) -> None:
        """Say what is to be said of the circle, once each."""
        if about not in self._noted:
            self._noted.add(about)
            self.notes.append(text)
