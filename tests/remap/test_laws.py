"""What holds for every engine whatever the picture: identity, bounds, memory, order, threads."""

from __future__ import annotations

import threading

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings

from endocal.errors import InputError, UsageError
from endocal.model import DivisionModel
from endocal.remap.engine import FrameRemapper
from endocal.remap.geometry import OutputGeometry, output_geometry
from endocal.remap.layout import frame_layout
from tests.remap.cases import CASES, FORMATS, INTERPOLATIONS, noise
from tests.remap.test_conformance import ENGINES, make_engine

sizes = st.tuples(st.integers(1, 90), st.integers(1, 40))
shares = st.tuples(st.floats(-1, 2), st.floats(-1, 2))


def remapper(name, layout, geometry, interpolation):
    engine = make_engine(name, layout, geometry, interpolation)
    return FrameRemapper(layout, geometry, interpolation, engine=engine)


def padded(plane, before, after, fill):
    """A copy of a plane as a view into wider rows, and the whole that it lies in."""
    rows, columns = plane.shape
    whole = np.full((rows + 2, before + columns + after), fill, plane.dtype)
    view = whole[1 : rows + 1, before : before + columns]
    view[:] = plane
    return view, whole


@pytest.mark.parametrize("engine", ENGINES)
@given(data=st.data())
@settings(max_examples=25)
def test_no_distortion_gives_back_the_input_exactly(engine, data):
    size, share = data.draw(sizes), data.draw(shares)
    layout = frame_layout(
        data.draw(st.sampled_from(FORMATS)), size, full_range=data.draw(st.booleans())
    )
    center = (share[0] * size[0], share[1] * size[1])
    model = DivisionModel(0.0, center, size, data.draw(st.sampled_from([1.0, 64 / 45])))
    interpolation = data.draw(st.sampled_from(INTERPOLATIONS))
    work = remapper(engine, layout, output_geometry([model]), interpolation)
    planes = noise(layout, data.draw(st.integers(0, 99)))
    for _ in range(2):
        out = layout.empty()
        work.apply(model, planes, out)
        for plane, got in zip(planes, out, strict=True):
            np.testing.assert_array_equal(got, plane)


@pytest.mark.parametrize("engine", ENGINES)
@given(data=st.data())
@settings(max_examples=20)
def test_a_grey_frame_stays_grey_and_values_stay_between_its_and_the_fill(engine, data):
    size = data.draw(sizes)
    radius = np.hypot(*size) / 2
    bend = data.draw(st.floats(-1.2, 0.9))
    model = DivisionModel(bend / radius**2, (size[0] * 0.4, size[1] * 0.6), size)
    scale = data.draw(st.floats(0.4, 2.5))
    interpolation = data.draw(st.sampled_from(INTERPOLATIONS))
    layout = frame_layout("yuv420p10le", size, full_range=False)
    work = remapper(engine, layout, output_geometry([model], scale=scale), interpolation)
    planes = [np.full(p.shape, 700, p.dtype) for p in layout.planes]
    out = work.output_layout.empty()
    work.apply(model, planes, out)
    for plane, got in zip(work.output_layout.planes, out, strict=True):
        assert got.min() >= plane.fill[0]
        assert got.max() <= 700


@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
@pytest.mark.parametrize("engine", ENGINES)
def test_what_lies_around_the_planes_is_neither_read_nor_written(engine, interpolation):
    case = CASES["pincushion"]
    for pix_fmt in ("yuv420p", "nv12", "rgb24", "yuv420p10le"):
        layout = frame_layout(pix_fmt, case.model.size, full_range=False)
        work = remapper(engine, layout, case.geometry, interpolation)
        planes, results = noise(layout), []
        for before, after, fill in ((0, 3, 0), (5, 70, 255)):
            inputs = [padded(p, before, after, fill)[0] for p in planes]
            targets = [
                padded(np.zeros_like(p), before, after, 99) for p in work.output_layout.empty()
            ]
            work.apply(case.model, inputs, [view for view, _ in targets])
            results.append([view.copy() for view, _ in targets])
            for view, whole in targets:
                view[:] = 99
                assert (whole == 99).all()
        for first, second in zip(*results, strict=True):
            np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize("engine", ENGINES)
def test_arrays_of_any_order_and_read_only_ones_are_taken(engine):
    size = (90, 31)
    model = DivisionModel(-6e-5, (40.0, 15.0), size)
    layout = frame_layout("gray", size, full_range=True)
    work = remapper(engine, layout, output_geometry([model]), "bilinear")
    plane = noise(layout)[0]
    plain = np.empty_like(plane)
    work.apply(model, [plane], [plain])
    read_only = plane.copy()
    read_only.flags.writeable = False
    doubled = np.repeat(plane, 2, axis=1)[:, ::2]
    for given_ in (np.asfortranarray(plane), plane[::-1].copy()[::-1], doubled, read_only):
        for out in (np.empty_like(plane), np.empty((31, 180), np.uint8)[:, ::2]):
            work.apply(model, [given_], [out])
            np.testing.assert_array_equal(out, plain)


@pytest.mark.parametrize("engine", ENGINES)
def test_each_frame_goes_through_its_own_model(engine):
    size = (120, 50)
    layout = frame_layout("yuv420p", size, full_range=False)
    models = [
        DivisionModel(-s * 1e-5, (55.0, 24.0), size, lam2=b) for s in (1, 7) for b in (0.0, -1e-9)
    ]
    geometry = OutputGeometry(size, size)
    planes = noise(layout)

    def fresh(model):
        out = layout.empty()
        remapper(engine, layout, geometry, "bilinear").apply(model, planes, out)
        return out

    singles = [fresh(m) for m in models]
    work = remapper(engine, layout, geometry, "bilinear")
    # Two frames on their way at a time, as the pipeline does.
    pending = []
    order = [0, 0, 1, 2, 2, 2, 3, 0, 1, 1]
    outs = [layout.empty() for _ in order]
    for number, out in zip(order, outs, strict=True):
        pending.append(work.submit(models[number], planes, out))
        if len(pending) == 2:
            pending.pop(0).wait()
    pending.pop().wait()
    for number, out in zip(order, outs, strict=True):
        for got, want in zip(out, singles[number], strict=True):
            np.testing.assert_array_equal(got, want)


@pytest.mark.parametrize("engine", ENGINES)
def test_threads_take_turns(engine):
    size = (200, 60)
    layout = frame_layout("gray", size, full_range=True)
    model = DivisionModel(-2e-5, (90.0, 31.0), size)
    work = remapper(engine, layout, OutputGeometry(size, size), "bilinear")
    frames = [noise(layout, seed) for seed in range(4)]
    want = [layout.empty() for _ in frames]
    for frame, out in zip(frames, want, strict=True):
        work.apply(model, frame, out)
    wrong = []

    def run(number):
        for _ in range(10):
            out = layout.empty()
            work.apply(model, frames[number], out)
            if not np.array_equal(out[0], want[number][0]):
                wrong.append(number)

    threads = [threading.Thread(target=run, args=(n,)) for n in range(len(frames))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong


def test_what_does_not_fit_is_refused_by_name():
    size = (16, 8)
    layout = frame_layout("yuv420p", size, full_range=False)
    geometry, model = OutputGeometry(size, size), DivisionModel(0.0, (8.0, 4.0), size)
    with pytest.raises(UsageError, match="interpolation 'cubic'"):
        FrameRemapper(layout, geometry, "cubic", "numpy")
    with pytest.raises(InputError, match="does not fit frames of 16x8"):
        FrameRemapper(layout, OutputGeometry((8, 8), (8, 8)), device="numpy")
    work = FrameRemapper(layout, geometry, device="numpy")
    planes, out = noise(layout), layout.empty()
    with pytest.raises(InputError, match="rescale it"):
        work.apply(model.rescale((32, 16)), planes, out)
    with pytest.raises(InputError, match="2 input planes"):
        work.apply(model, planes[:2], out)
    with pytest.raises(InputError, match="output plane 1 is uint8"):
        work.apply(model, planes, [out[0], out[0], out[2]])
    with pytest.raises(InputError, match="input plane 0 is uint16"):
        work.apply(model, [planes[0].astype(np.uint16), *planes[1:]], out)
