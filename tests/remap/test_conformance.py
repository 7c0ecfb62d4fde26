"""Every engine against the float64 reference: formats x interpolations x models, views and sizes."""

from __future__ import annotations

import numpy as np
import pytest

from endocal.model import DivisionModel
from endocal.remap.engine import FrameRemapper
from endocal.remap.geometry import OutputGeometry
from endocal.remap.grid import plane_grids
from endocal.remap.layout import frame_layout
from endocal.remap.numpy_engine import NumpyEngine
from endocal.remap.opencl_device import DeviceSession
from endocal.remap.opencl_engine import OpenCLEngine
from tests.remap.cases import CASES, FORMATS, INTERPOLATIONS, expected, noise
from tests.remap.reference import remap

# Name -> strategy and staging of the OpenCL engine. Where there is no device these tests fail.
OPENCL = {
    "opencl baked": ("baked", False),
    "opencl direct": ("direct", False),
    "opencl direct, staged": ("direct", True),
}
ENGINES = ("numpy", *OPENCL)


def make_engine(name, layout, geometry, interpolation):
    grids = plane_grids(layout, geometry)
    if name == "numpy":
        return NumpyEngine(grids, interpolation)
    strategy, staged = OPENCL[name]
    return OpenCLEngine(grids, interpolation, "auto", strategy, staged)


def tolerance(engine: str, depth: int) -> float:
    """Levels: rounding for float64; for a device 1 of 8 bits, 4 of 10, as its places have 8 bits."""
    return 0.5 + 1e-6 if engine == "numpy" else 0.5 + max(1.0, 2.0 ** (depth - 8))


def check(name, pix_fmt, case, interpolation, location="left"):
    truth = expected(pix_fmt, case, interpolation, location)
    model, geometry = CASES[case].model, CASES[case].geometry
    engine = make_engine(name, truth.layout, geometry, interpolation)
    remapper = FrameRemapper(truth.layout, geometry, interpolation, engine=engine)
    # The second frame of a model may go another way than the first: through a baked map.
    for turn in ("first", "second"):
        out = [np.full(p.shape, 77, p.dtype) for p in remapper.output_layout.planes]
        remapper.apply(model, truth.planes, out)
        for number, (plane, got, (want, sure)) in enumerate(
            zip(remapper.output_layout.planes, out, truth.values, strict=True)
        ):
            assert not np.any(got & ((1 << plane.shift) - 1)), "bits below the depth are set"
            samples = (got >> plane.shift).astype(float).reshape(want.shape)
            error = np.abs(samples - want)[sure]
            assert error.size == 0 or error.max() <= tolerance(name, plane.depth), (
                f"{case}, plane {number}, {turn} frame: off by {error.max():.2f} levels at"
                f" {np.argwhere((np.abs(samples - want) == error.max()).any(axis=-1))[0]}"
            )


@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
@pytest.mark.parametrize("pix_fmt", FORMATS)
@pytest.mark.parametrize("engine", ENGINES)
def test_every_format_matches_the_reference(engine, pix_fmt, interpolation):
    for case in ("barrel", "pincushion", "few pixels"):
        check(engine, pix_fmt, case, interpolation)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("engine", ENGINES)
def test_every_model_and_view_matches_the_reference(engine, case):
    for interpolation in INTERPOLATIONS:
        check(engine, "yuv420p", case, interpolation)
    check(engine, "yuv444p10le", case, "bilinear")


@pytest.mark.parametrize("location", ["center", "topleft", "top", "bottomleft", "bottom"])
@pytest.mark.parametrize("engine", ENGINES)
def test_chroma_locations_match_the_reference(engine, location):
    for pix_fmt in ("yuv420p", "nv12", "yuv422p"):
        check(engine, pix_fmt, "barrel", "bilinear", location)


@pytest.mark.parametrize("lanes", [8, 16])
@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
def test_vectors_of_either_length_match_the_reference(monkeypatch, lanes, interpolation):
    # A device takes one of them; a driver's fault in the other would show on the next machine alone.
    monkeypatch.setattr(DeviceSession, "lanes", lanes)
    for pix_fmt in ("yuv420p", "yuv420p10le", "nv12"):
        for case in ("barrel", "pincushion", "two parameters"):
            check("opencl baked", pix_fmt, case, interpolation)


@pytest.mark.parametrize("looks_up", [True, False])
def test_taps_loaded_or_looked_up_in_registers_match_the_reference(monkeypatch, looks_up):
    # A processor that can look them up would hide a fault of the other way, which most take.
    monkeypatch.setattr(DeviceSession, "looks_up", looks_up)
    for case in CASES:
        check("opencl baked", "yuv420p", case, "bilinear")


# Two-parameter models by (lambda R^2, lambda2 R^4), R being half the frame's diagonal: from strong barrels
# over folds and poles in the frame to strong pincushions, and some for which Newton's steps go far astray.
SWEEP = [(a, b) for a in np.linspace(-1.2, 1.2, 9) for b in np.linspace(-1.2, 1.2, 10)]
SWEEP += [(0.1, -0.95), (0.075, -0.6), (0.1, -0.7), (-0.025, -0.85), (1.1, -0.1), (-1.0, 0.25)]


def test_every_two_parameter_model_matches_the_reference_up_to_its_fold():
    size, radius = (120, 90), 75.0
    # Twice the frame's place each way: most of what a model reaches, and its border where that ends.
    geometry = OutputGeometry(size, size, (-60.0, -45.0), (2.0, 2.0))
    layout = frame_layout("gray", size, full_range=True)
    planes, plane = noise(layout), layout.planes[0]
    engines = {name: make_engine(name, layout, geometry, "bilinear") for name in ENGINES}
    for a, b in SWEEP:
        model = DivisionModel(a / radius**2, (58.7, 45.9), size, lam2=b / radius**4)
        want, sure = remap(planes[0], plane, plane, geometry, model, "bilinear")
        for name, engine in engines.items():
            out = layout.empty()
            engine.submit(model, planes, out).wait()
            error = np.abs(out[0][..., None] - want)[sure]
            assert error.max() <= tolerance(name, plane.depth), f"{name} at {a:g}, {b:g}"
