"""The visible circle as a value."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Boundary:
    """The circular boundary of the visible content.

    ``center`` (x, y) in px of the frame; ``diameter`` in px of the frame's height (square pixels: for a
    pixel aspect a, the circle's width in frame pixels is diameter / a); ``area`` of the visible content
    in px^2; ``visible``: the fraction of the circumference that lies inside the frame, 0 to 1.
    """

    center: tuple[float, float]
    diameter: float
    area: float
    visible: float
