"""Lenses for the tests of the exchange: (model, radius of the content in px)."""

from __future__ import annotations

from endocal.boundary.content import content_radius
from endocal.boundary.detect import boundary_of
from endocal.model import DivisionModel


def endoscope() -> tuple[DivisionModel, float]:
    """A circle off the frame's middle, the rim moved by half its radius."""
    return _in_circle(DivisionModel(-4.68e-6, (365.08, 265.93), (720, 540)), (360.0, 268.0), 527.0)


def narrow() -> tuple[DivisionModel, float]:
    """A long lens that fills the frame."""
    model = DivisionModel(-4e-7, (475.0, 274.0), (960, 540))
    return model, content_radius(model.center, model.size)


def anamorphic() -> tuple[DivisionModel, float]:
    """PAL pixels, 16:15."""
    model = DivisionModel(-3e-6, (366.0, 280.0), (720, 576), pixel_aspect=16 / 15)
    return _in_circle(model, (360.0, 288.0), 560.0)


def pincushion() -> tuple[DivisionModel, float]:
    """The other sign."""
    model = DivisionModel(8e-7, (310.0, 245.0), (640, 480))
    return model, content_radius(model.center, model.size)


def two_parameters() -> tuple[DivisionModel, float]:
    """A lens that one parameter does not tell."""
    model = DivisionModel(-3e-6, (365.0, 266.0), (720, 540), lam2=-1.2e-11)
    return _in_circle(model, (360.0, 268.0), 500.0)


ALL = (endoscope, narrow, anamorphic, pincushion, two_parameters)


def _in_circle(
    model: DivisionModel, center: tuple[float, float], diameter: float
) -> tuple[DivisionModel, float]:
    boundary = boundary_of(center, diameter, model.size, model.pixel_aspect)
    return model, content_radius(model.center, model.size, boundary, model.pixel_aspect)
