"""The models, views and frame sizes that every engine meets with every format and interpolation."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from endocal.model import DivisionModel
from endocal.remap.geometry import OutputGeometry, output_geometry
from endocal.remap.layout import FrameLayout, frame_layout
from tests.remap.reference import remap

INTERPOLATIONS = ("nearest", "bilinear", "bicubic", "lanczos")
FORMATS = (
    "yuv420p",
    "yuv422p",
    "yuv444p",
    "gray",
    "nv12",
    "rgb24",
    "bgra",
    "gbrp",
    "yuv420p10le",
    "yuv422p12le",
    "yuv444p10le",
    "gray16le",
    "p010le",
    "bgr48le",
)


@dataclass(frozen=True)
class Case:
    """A model on a frame of a size, seen in a view."""

    model: DivisionModel
    view: str = "same"
    size: tuple[int, int] | None = None
    scale: float | None = None
    square_pixels: bool = False

    @property
    def geometry(self) -> OutputGeometry:
        return _geometry(self)


@cache
def _geometry(case: Case) -> OutputGeometry:
    return output_geometry(
        [case.model], [None], case.view, case.size, case.scale, case.square_pixels
    )


WIDE = (150, 37)  # two strips and a part; odd height
ODD = (67, 41)
LARGE = (301, 181)  # wider than what registers hold of a row
# lam R^2 is about -0.5 for barrels with R = 77 px, half of WIDE's diagonal.
CASES = {
    "barrel": Case(DivisionModel(-8e-5, (70.3, 19.6), WIDE)),
    "strong barrel": Case(DivisionModel(-1.3e-4, (77.7, 15.2), WIDE)),
    "barrel, crop": Case(DivisionModel(-8e-5, (70.3, 19.6), WIDE), view="crop"),
    "barrel, full": Case(DivisionModel(-8e-5, (70.3, 19.6), WIDE), view="full"),
    "barrel, enlarged": Case(DivisionModel(-3e-4, (30.1, 22.6), ODD), size=(143, 80)),
    "barrel, reduced": Case(DivisionModel(-8e-5, (70.3, 19.6), WIDE), scale=0.45),
    "pincushion": Case(DivisionModel(4e-5, (74.8, 17.1), WIDE)),
    "pincushion, crop": Case(DivisionModel(4e-5, (74.8, 17.1), WIDE), view="crop"),
    "fold in the frame": Case(DivisionModel(1.5e-4, (74.8, 17.1), WIDE)),
    "two parameters": Case(DivisionModel(-6e-5, (70.3, 19.6), WIDE, lam2=-4e-9)),
    "two parameters, opposed": Case(DivisionModel(-9e-5, (70.3, 19.6), WIDE, lam2=7e-9)),
    "centre outside": Case(DivisionModel(-1.2e-5, (-20.0, 60.5), WIDE)),
    "wide pixels": Case(DivisionModel(-2.5e-4, (33.0, 19.0), ODD, 1.42), square_pixels=True),
    "no distortion": Case(DivisionModel(0.0, (11.3, 80.0), ODD)),
    "no distortion, shifted": Case(DivisionModel(0.0, (11.3, 30.0), ODD), size=(100, 41)),
    "large barrel": Case(DivisionModel(-3.2e-5, (140.2, 101.3), LARGE)),
    "large, steep": Case(DivisionModel(-1.6e-4, (150.6, 60.3), LARGE, lam2=3e-9), scale=0.7),
    "large, no distortion": Case(DivisionModel(0.0, (140.0, 90.0), LARGE)),
    "one column": Case(DivisionModel(-1e-2, (0.3, 3.1), (1, 9))),
    "one row": Case(DivisionModel(-1e-2, (4.2, 0.0), (9, 1))),
    "one pixel": Case(DivisionModel(-1e-2, (0.2, 0.1), (1, 1))),
    "few pixels": Case(DivisionModel(3e-3, (2.0, 1.4), (5, 3)), size=(70, 7)),
}


def noise(layout: FrameLayout, seed: int = 0) -> list[np.ndarray]:
    """Planes of white noise over the whole range: the hardest picture to interpolate."""
    rng = np.random.default_rng(seed)
    return [
        (rng.integers(0, p.maximum + 1, p.shape) << p.shift).astype(p.dtype) for p in layout.planes
    ]


@dataclass(frozen=True)
class Expected:
    """The input of a case, and what must come out: per plane float values and the mask of sure samples."""

    layout: FrameLayout
    planes: list[np.ndarray]
    values: list[tuple[np.ndarray, np.ndarray]]


@cache
def expected(pix_fmt: str, name: str, interpolation: str, location: str = "left") -> Expected:
    """Work out a case with the reference; the same for every engine."""
    case = CASES[name]
    layout = frame_layout(pix_fmt, case.model.size, full_range=False, chroma_location=location)
    output = layout.resized(case.geometry.size)
    planes = noise(layout)
    values = [
        remap(source, plane, out, case.geometry, case.model, interpolation)
        for source, plane, out in zip(planes, layout.planes, output.planes, strict=True)
    ]
    return Expected(layout, planes, values)
