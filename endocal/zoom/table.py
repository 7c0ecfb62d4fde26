"""The zoom table: a lens at a few zoom settings, and its model at any other (Lee et al. 2013, III, IV-B).

A change of focal length by r scales the picture by r, and with it the visible circle; so lam scales with
1/r^2 and lam2 with 1/r^4 (eq. 15), that is, lam * diameter^2 is one constant of the lens: the law. The
article reads a table in two ways, by diameter and by area; ``auto`` interpolates what the law says is
constant.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

from ..boundary.circle import Boundary
from ..errors import InputError
from ..model import DivisionModel, rescaled_place
from .interpolate import MonotoneCurve, line_slope, linear

LOOKUPS = ("auto", "diameter", "area")

# A setting that departs from the law by more than this is no setting of the same lens. Of two settings, the
# weaker departs from the stronger: their mean would be half as far from each. Table I of the article has two
# of one lens that are 26 % apart.
_MAX_DEPARTURE = 0.30
# A setting stands out when it departs by this much, and by this many times more than the others do.
_OUTLIER_DEPARTURE = 0.05
_OUTLIER_RATIO = 3.0
# Below this |lam D^2| the picture moves by less than half a percent of the radius at the rim: such a lens
# is too straight for a relative departure to mean anything, so departures are taken relative to this.
_WEAKEST_LAW = 0.02
# Two diameters nearer than this (relative) are one setting measured twice.
_SAME_DIAMETER = 1e-3
# So far outside the settings, as a ratio, a table still covers the zoom for all purposes.
_RANGE_SLACK = 1.02


@dataclass(frozen=True)
class SettingSource:
    """What a setting was made from: a bare file name and the SHA-256 of that file's bytes."""

    file: str
    sha256: str = ""


@dataclass(frozen=True)
class Setting:
    """The lens at one zoom setting.

    ``lam`` in px^-2 and ``lam2`` in px^-4, ``center`` (x, y) in px, ``diameter`` of the visible circle in
    px of the frame's height, ``area`` of the visible content in px^2 (only the area look-up needs it),
    ``circle`` the visible circle's own centre (x, y) in px (only the follower of its shift needs it).
    """

    lam: float
    center: tuple[float, float]
    diameter: float
    area: float | None = None
    lam2: float = 0.0
    source: SettingSource | None = None
    circle: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if not (math.isfinite(self.diameter) and self.diameter > 0):
            raise InputError(f"a setting's diameter {self.diameter:g} is not a positive number")
        if self.area is not None and not (math.isfinite(self.area) and self.area > 0):
            raise InputError(f"a setting's area {self.area:g} is not a positive number")

    @property
    def strength(self) -> float:
        """lam * diameter^2, the law's constant; with lam2, of the one-parameter model equal at the rim."""
        return (self.lam + self.lam2 * self.diameter**2 / 4) * self.diameter**2

    def rescale(self, x: float, y: float) -> Setting:
        """Return the setting for frames of ``x`` times the width and ``y`` times the height.

        lam goes with 1/y^2, since it counts in pixels of the height, and places go by pixel centres.
        """
        return replace(
            self,
            lam=self.lam / y**2,
            lam2=self.lam2 / y**4,
            center=rescaled_place(self.center, (x, y)),
            diameter=self.diameter * y,
            area=None if self.area is None else self.area * x * y,
            circle=None if self.circle is None else rescaled_place(self.circle, (x, y)),
        )

    @property
    def title(self) -> str:
        """What messages call it: its diameter, and the file that it was made from."""
        return f"{self.diameter:g} px" + (f" ({self.source.file})" if self.source else "")


@dataclass(frozen=True)
class Law:
    """How well the settings obey eq. 15, lam * diameter^2 = constant.

    ``spread`` is the root mean square of ``departures``, each setting's relative distance from the
    constant; ``outlier`` is the index of the one setting that stands out from the rest, if any.
    """

    lambda_diameter2: float
    spread: float
    departures: tuple[float, ...]
    outlier: int | None


@dataclass(frozen=True)
class ZoomTable:
    """The settings of one lens, sorted by diameter, for frames of ``size`` (width, height) px.

    Raises InputError for fewer than two settings, two equal diameters, a setting whose model folds the
    picture within its own circle or whose circle lies far outside the frame, and one that breaks the law by
    more than 30 % (of two settings: if they differ by more than 30 % of the stronger).
    """

    settings: tuple[Setting, ...]
    size: tuple[int, int]
    pixel_aspect: float = 1.0

    def __post_init__(self) -> None:
        ordered = tuple(sorted(self.settings, key=lambda s: s.diameter))
        object.__setattr__(self, "settings", ordered)
        object.__setattr__(self, "size", (int(self.size[0]), int(self.size[1])))
        if len(ordered) < 2:
            raise InputError(
                f"a zoom table needs 2 settings or more, this one has {len(ordered)}: calibrate the lens"
                " at another zoom"
            )
        for a, b in pairwise(ordered):
            if b.diameter - a.diameter < _SAME_DIAMETER * b.diameter:
                raise InputError(
                    f"two settings have the same diameter, {a.title} and {b.title}: drop one of them"
                )
        for setting in ordered:
            if self._model(setting).valid_radius <= setting.diameter / 2:
                raise InputError(
                    f"lambda {setting.lam:g} at diameter {setting.title} folds the picture within its own"
                    " circle: calibrate that setting again"
                )
            self._check_circle(setting)
        self._check_law()

    def _check_circle(self, setting: Setting) -> None:
        """Refuse a circle whose centre is nowhere near the frame, as a model refuses such a centre."""
        if setting.circle is None:
            return
        (x, y), (w, h) = setting.circle, self.size
        if not (-w <= x <= 2 * w and -h <= y <= 2 * h):
            raise InputError(
                f"setting {setting.title}: its circle's centre ({x:g}, {y:g}) lies far outside the {w}x{h}"
                " frame"
            )

    def _check_law(self) -> None:
        # Of two settings, either may be the wrong one.
        named: Sequence[Setting] = self.settings
        if len(named) == 2:
            a, b = (s.strength for s in named)
            departure = abs(a - b) / max(abs(a), abs(b), _WEAKEST_LAW)
        else:
            departure, worst = max((abs(d), i) for i, d in enumerate(self.law.departures))
            named = [self.settings[worst]]
        if departure <= _MAX_DEPARTURE:
            return
        raise InputError(
            f"the law lambda * diameter^2 = constant is broken by {departure:.0%} at diameter"
            f" {' and '.join(s.title for s in named)}: is it the same lens? calibrate again there or leave it"
            " out"
        )

    @cached_property
    def law(self) -> Law:
        """The law's constant (the median over the settings) and the departures from it."""
        strengths = [s.strength for s in self.settings]
        constant = _median(strengths)
        scale = math.copysign(max(abs(constant), _WEAKEST_LAW), constant)
        departures = tuple((k - constant) / scale for k in strengths)
        spread = math.sqrt(sum(d * d for d in departures) / len(departures))
        return Law(constant, spread, departures, _outlier(departures))

    def covers(self, diameter: float) -> bool:
        """Say whether a diameter, px, is within the settings, or 2 % outside: beyond, the law serves."""
        low, high = self.settings[0].diameter, self.settings[-1].diameter
        return low / _RANGE_SLACK <= diameter <= high * _RANGE_SLACK

    def check_lookup(self, lookup: str) -> None:
        """Raise InputError where the settings lack what the look-up goes by: the area look-up their areas."""
        lacking = [s.title for s in self.settings if s.area is None]
        if lookup == "area" and lacking:
            raise InputError(
                f"--lookup area: the zoom table's setting {' and '.join(lacking)} has no area: give it there,"
                " in px^2, or use --lookup auto"
            )

    def at(self, boundary: Boundary, lookup: str = "auto") -> DivisionModel:
        """Return the model for a frame with this boundary; ``lookup`` is one of LOOKUPS."""
        if lookup == "area":
            return self._at_area(boundary)
        return self.at_diameter(boundary.diameter, lookup)

    def at_diameter(self, diameter: float, lookup: str = "auto") -> DivisionModel:
        """Return the model where the visible circle is ``diameter`` px wide, be it in the frame or not.

        ``diameter``: quadratic prediction (eq. 15) from the setting of the closest diameter; ``area``, too,
        since a diameter alone does not tell the area.
        ``auto``: lam D^2 (and lam2 D^4) through the settings' own values by a monotone curve, constant
        outside them: exact at the settings and smooth in the diameter.
        """
        if lookup not in LOOKUPS:
            raise ValueError(f"lookup {lookup!r} is none of {', '.join(LOOKUPS)}")
        if not (math.isfinite(diameter) and diameter > 0):
            raise InputError(f"the diameter {diameter:g} px is not a positive number")
        if lookup != "auto":
            closest = min(self.settings, key=lambda s: abs(s.diameter - diameter))
            ratio2 = (diameter / closest.diameter) ** 2
            lam, lam2 = closest.lam / ratio2, closest.lam2 / ratio2**2
        else:
            lam = self._lam_curve(diameter) / diameter**2
            lam2 = self._lam2_curve(diameter) / diameter**4
        return DivisionModel(lam, self._center(diameter), self.size, self.pixel_aspect, lam2)

    def circle_at(self, diameter: float) -> tuple[float, float] | None:
        """Return where the visible circle's centre is at ``diameter`` px; None unless every setting says."""
        circles = [s.circle for s in self.settings if s.circle is not None]
        return self._along(circles, diameter) if len(circles) == len(self.settings) else None

    def rescale(self, size: tuple[int, int]) -> ZoomTable:
        """Return the table for the same picture at another frame size; InputError for another shape."""
        # A model knows which shapes are one.
        size = self._model(self.settings[0]).rescale(size).size
        x, y = size[0] / self.size[0], size[1] / self.size[1]
        return replace(self, settings=tuple(s.rescale(x, y) for s in self.settings), size=size)

    def _at_area(self, boundary: Boundary) -> DivisionModel:
        """Interpolate linearly between the settings of the two areas about this one (section IV-B)."""
        self.check_lookup("area")
        known = sorted((s.area, s.lam, s.lam2) for s in self.settings if s.area is not None)
        areas = [k[0] for k in known]
        if not areas[0] <= boundary.area <= areas[-1]:
            return self.at_diameter(boundary.diameter, "diameter")
        lam = linear(areas, [k[1] for k in known], boundary.area)
        lam2 = linear(areas, [k[2] for k in known], boundary.area)
        center = self._center(boundary.diameter)
        return DivisionModel(lam, center, self.size, self.pixel_aspect, lam2)

    def _model(self, setting: Setting) -> DivisionModel:
        return DivisionModel(
            setting.lam, setting.center, self.size, self.pixel_aspect, setting.lam2
        )

    @cached_property
    def _diameters(self) -> list[float]:
        return [s.diameter for s in self.settings]

    @cached_property
    def _lam_curve(self) -> MonotoneCurve:
        return MonotoneCurve(self._diameters, [s.lam * s.diameter**2 for s in self.settings])

    @cached_property
    def _lam2_curve(self) -> MonotoneCurve:
        return MonotoneCurve(self._diameters, [s.lam2 * s.diameter**4 for s in self.settings])

    def _center(self, diameter: float) -> tuple[float, float]:
        return self._along([s.center for s in self.settings], diameter)

    def _along(self, places: Sequence[tuple[float, float]], diameter: float) -> tuple[float, float]:
        """Interpolate the settings' ``places`` linearly between the two neighbouring ones.

        A centre moves on a line with the zoom; beyond the settings it goes on from the last one, with the
        slope of all of them, since two close neighbours alone would carry their noise far.
        """
        d = self._diameters
        clamped = min(max(diameter, d[0]), d[-1])
        x, y = (
            linear(d, values, clamped) + line_slope(d, values) * (diameter - clamped)
            for values in zip(*places, strict=True)
        )
        return x, y


def _median(values: Sequence[float]) -> float:
    ordered = sorted(values)
    n = len(ordered)
    return (ordered[(n - 1) // 2] + ordered[n // 2]) / 2


def _outlier(departures: Sequence[float]) -> int | None:
    """Name the setting whose departure stands out; between two settings neither can be blamed."""
    if len(departures) < 3:
        return None
    size = [abs(d) for d in departures]
    worst = max(range(len(size)), key=size.__getitem__)
    rest = _median(size[:worst] + size[worst + 1 :])
    stands_out = size[worst] > max(_OUTLIER_DEPARTURE, _OUTLIER_RATIO * rest)
    return worst if stands_out else None
