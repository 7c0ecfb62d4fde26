"""Devices: which one is meant, what is said where there is none, and processors unknown to PoCL."""

from __future__ import annotations

import ctypes
import sys

import pyopencl as cl
import pytest

from endocal.errors import DeviceError, UsageError
from endocal.model import DivisionModel
from endocal.remap import opencl_choice, opencl_device, pocl_processor
from endocal.remap.engine import FrameRemapper
from endocal.remap.geometry import OutputGeometry
from endocal.remap.layout import frame_layout
from endocal.remap.opencl_device import choose_device, list_devices, session


class FakePlatform:
    def __init__(self, name):
        self.name = name


class FakeDevice:
    def __init__(self, name, kind, units, platform):
        self.name, self.type, self.max_compute_units = name, kind, units
        self.platform = FakePlatform(platform)


@pytest.fixture
def three_devices(monkeypatch):
    """A CPU, and on another platform a small and a large GPU."""
    monkeypatch.delenv("PYOPENCL_CTX", raising=False)
    kinds = cl.device_type
    found = [
        opencl_device.ListedDevice(p, d, FakeDevice(name, kind, units, platform))
        for p, d, name, kind, units, platform in (
            (0, 0, "pthread-Ryzen", kinds.CPU, 64, "Portable Computing Language"),
            (1, 0, "Arc A310", kinds.GPU, 96, "Intel OpenCL"),
            (1, 1, "Arc A770", kinds.GPU, 512, "Intel OpenCL"),
        )
    ]
    monkeypatch.setattr(opencl_device, "list_devices", lambda: found)


def test_there_is_a_device_here():
    # The tests of the engine mean nothing without one: no skip.
    assert list_devices(), "no OpenCL device: pip install pocl-binary-distribution"


@pytest.mark.parametrize(
    ("name", "address"),
    [
        ("auto", "1:1"),
        ("0:0", "0:0"),
        ("1:0", "1:0"),
        ("arc a310", "1:0"),
        ("Ryzen", "0:0"),
        ("intel", "1:0"),
        ("portable", "0:0"),
    ],
)
def test_a_name_means_the_device_that_it_fits(three_devices, name, address):
    assert choose_device(name)[0].address == address


@pytest.mark.parametrize("name", ["2:0", "1:2", "nvidia", "1"])
def test_a_name_that_fits_none_is_refused_with_what_there_is(three_devices, name):
    with pytest.raises(UsageError, match=r"0:0 \(pthread-Ryzen\), 1:0 \(Arc A310\), .* and numpy"):
        choose_device(name)


@pytest.mark.parametrize(
    ("answers", "address"), [("0", "0:0"), ("1:0", "1:0"), (":1", "1:1"), ("intel:a770", "1:1")]
)
def test_auto_follows_pyopencls_own_variable(three_devices, monkeypatch, answers, address):
    monkeypatch.setenv("PYOPENCL_CTX", answers)
    found, reason = choose_device("auto")
    assert (found.address, reason) == (address, "named by PYOPENCL_CTX")
    assert choose_device("Ryzen")[0].address == "0:0"  # a name is a name
    monkeypatch.setenv("PYOPENCL_CTX", "7")
    with pytest.raises(DeviceError, match="PYOPENCL_CTX=7"):
        choose_device("auto")


def test_without_any_platform_one_line_says_what_to_do(monkeypatch):
    def none():
        raise cl.LogicError("clGetPlatformIDs failed: PLATFORM_NOT_FOUND_KHR")

    monkeypatch.setattr(cl, "get_platforms", none)
    layout = frame_layout("gray", (8, 8), full_range=True)
    geometry = OutputGeometry((8, 8), (8, 8))
    for name in ("auto", "0:0", "Arc"):
        with pytest.raises(
            DeviceError, match=r"install your GPU.s OpenCL driver, .* or pass --device numpy"
        ) as e:
            FrameRemapper(layout, geometry, device=name)
        assert "\n" not in str(e.value)
    FrameRemapper(layout, geometry, device="numpy")


def test_a_kernel_that_does_not_build_is_told_in_one_line(monkeypatch):
    monkeypatch.setattr(opencl_device, "_kernel_source", lambda file: "kernel void broken( {")
    with pytest.raises(
        DeviceError, match=r"cannot build the kernels .error: .* --device numpy"
    ) as e:
        session(list_devices()[0]).program(("broken.cl",), ())
    assert "\n" not in str(e.value)


def test_a_measured_strategy_is_remembered_for_its_driver(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    here = session(list_devices()[0])
    assert not opencl_choice.is_remembered(here)
    assert opencl_choice.choose_strategy(here) == ("baked" if here.is_cpu else "direct")
    opencl_choice.remember(here, "direct")
    assert opencl_choice.is_remembered(here)
    assert opencl_choice.choose_strategy(here) == "direct"
    kept = tmp_path / "endocal" / "strategies.json"
    for damage in ("", "[]", "{", '{"x": 3}'):
        kept.write_text(damage)
        assert not opencl_choice.is_remembered(here)
    monkeypatch.setenv("XDG_CACHE_HOME", str(kept))  # a file where a folder should be
    opencl_choice.remember(here, "baked")


needs_linux = pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="the processor's name is set on Linux alone"
)


def fake_record(*texts):
    """Memory laid out as PoCL's: pointers, some to text, in a record of 4 KiB."""
    strings = [ctypes.create_string_buffer(t) for t in texts]
    record = (ctypes.c_void_p * 512)()
    record[0], record[1] = 12345, 2**63
    for k, string in enumerate(strings):
        record[80 + k] = ctypes.addressof(string)
    return record, strings


@needs_linux
def test_an_unknown_processor_gets_the_name_of_its_family(monkeypatch):
    monkeypatch.setattr(pocl_processor.platform, "machine", lambda: "x86_64")
    version = "OpenCL 3.0 PoCL HSTR: pthread-x86_64-unknown-linux-gnu-generic"
    for flags, family in (
        ({"sse2"}, "x86-64"),
        (pocl_processor._FAMILIES["haswell"], "haswell"),
        (set().union(*pocl_processor._FAMILIES.values()), "icelake-server"),
    ):
        record, keep = fake_record(b"x86_64-unknown-linux-gnu", b"generic", b"generic")
        monkeypatch.setattr(pocl_processor, "_processor_flags", lambda flags=flags: flags)
        address = ctypes.addressof(record)
        assert pocl_processor.name_unknown_processor(address, version) == family
        assert ctypes.string_at(record[81]) == family.encode()
        assert record[82] == ctypes.addressof(keep[2])


@needs_linux
def test_no_other_record_is_touched():
    for texts, version in (
        ((b"x86_64-unknown-linux-gnu", b"generic"), "OpenCL 3.0 PoCL HSTR: pthread-x86_64-znver3"),
        ((b"x86_64-unknown-linux-gnu", b"generic"), "OpenCL 3.0 CUDA generic"),
        (
            (b"some name", b"generic"),
            "OpenCL 3.0 PoCL HSTR: pthread-x86_64-unknown-linux-gnu-generic",
        ),
    ):
        record, _keep = fake_record(*texts)
        before = list(record)
        assert pocl_processor.name_unknown_processor(ctypes.addressof(record), version) is None
        assert list(record) == before


def test_the_numpy_engine_needs_no_opencl(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyopencl", None)
    monkeypatch.delitem(sys.modules, "endocal.remap.opencl_engine", raising=False)
    layout = frame_layout("gray", (8, 8), full_range=True)
    work = FrameRemapper(layout, OutputGeometry((8, 8), (8, 8)), device="numpy")
    work.apply(DivisionModel(0.0, (4.0, 4.0), (8, 8)), layout.empty(), layout.empty())
