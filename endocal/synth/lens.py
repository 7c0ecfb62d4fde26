"""A zoom lens that is known at every zoom."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ..model import DivisionModel
from .camera import ContentCircle


@dataclass(frozen=True)
class ZoomLens:
    """An endoscope behind a zoom coupler: zooming by z magnifies the whole picture by z (eq. 15).

    ``model``, ``diameter`` (of the content circle, px of the frame's height) and ``focal`` (of the
    undistorted picture, likewise) hold at zoom 1; lam follows as 1/z^2, lam2 as 1/z^4. The distortion
    centre moves by ``drift`` (x, y) px per unit of zoom; the circle's centre lies ``aside`` (x, y) px from
    it at zoom 1 and z times that at zoom z. ``softness`` is that of the circle's rim at zoom 1, px.
    """

    model: DivisionModel
    diameter: float
    focal: float
    drift: tuple[float, float] = (0.0, 0.0)
    aside: tuple[float, float] = (0.0, 0.0)
    softness: float = 2.0

    def model_at(self, zoom: float) -> DivisionModel:
        """Return the model at this zoom."""
        x, y = (c + d * (zoom - 1) for c, d in zip(self.model.center, self.drift, strict=True))
        m = self.model
        return replace(m, lam=m.lam / zoom**2, lam2=m.lam2 / zoom**4, center=(x, y))

    def circle_at(self, zoom: float) -> ContentCircle:
        """Return the content circle at this zoom."""
        x, y = (c + a * zoom for c, a in zip(self.model_at(zoom).center, self.aside, strict=True))
        return ContentCircle((x, y), self.diameter * zoom, self.softness * zoom)

    def shifted(self, by: tuple[float, float]) -> ZoomLens:
        """Return the lens moved before the sensor, (x, y) px."""
        x, y = self.model.center
        return replace(self, model=replace(self.model, center=(x + by[0], y + by[1])))

    def focal_at(self, zoom: float) -> float:
        """Return the focal length of the undistorted picture at this zoom, px."""
        return self.focal * zoom


def typical_lens(size: tuple[int, int], strength: float = -1.3, fill: float = 0.8) -> ZoomLens:
    """Return a lens like the article's: lam * diameter^2 = ``strength``, the circle ``fill`` of the height.

    Its centres lie off the frame's by a little, and move with the zoom.
    """
    w, h = size
    diameter = fill * h
    lam = strength / diameter**2
    center = ((w - 1) / 2 + 0.012 * h, (h - 1) / 2 - 0.009 * h)
    # Where a lens maps angles to radii evenly, lam * focal^2 is -1/3; real ones lie around that.
    focal = (0.4 / abs(lam)) ** 0.5 if lam else 1.2 * h
    return ZoomLens(
        DivisionModel(lam, center, size),
        diameter,
        focal,
        drift=(-0.008 * h, 0.011 * h),
        aside=(0.002 * h, -0.003 * h),
        softness=0.004 * h,
    )
