"""``endocal devices`` and ``endocal bench remap``."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pyopencl as cl
import pytest

Endocal = Callable[..., Any]


@pytest.fixture(autouse=True)
def own_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.delenv("PYOPENCL_CTX", raising=False)


def test_devices_tells_what_there_is_and_what_auto_takes(endocal: Endocal) -> None:
    shown = endocal("devices")
    assert shown.code == 0
    for platform in cl.get_platforms():
        for device in platform.get_devices():
            assert device.name.strip() in shown.out
    for word in ("driver", "compute units", "images", "numpy", "auto  takes 0:0:"):
        assert word in shown.out


def test_devices_as_json_measures_when_asked_and_remembers(endocal: Endocal) -> None:
    before = json.loads(endocal("devices", "--json").out)
    assert before["auto"] == next(d["address"] for d in before["devices"] if d["auto"])
    assert not before["devices"][0]["resampling"]["measured"]
    measured = json.loads(endocal("devices", "--json", "-v").out)["devices"][0]["resampling"]
    assert measured["strategy"] == min(measured["milliseconds"], key=measured["milliseconds"].get)
    assert all(seconds > 0 for seconds in measured["first_seconds"].values())
    assert 0 < measured["deviation"] <= 1
    after = json.loads(endocal("devices", "--json").out)["devices"][0]["resampling"]
    assert after["measured"]
    assert after["strategy"] == measured["strategy"]


def test_a_device_that_computes_wrong_pixels_is_told(
    endocal: Endocal, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("endocal.remap.opencl_measure.deviation", lambda *_: 3.0)
    shown = endocal("devices", "-v")
    assert shown.code == 1
    assert "3 of 255 levels off NumPy: WRONG" in shown.out
    assert "device 0:0 computes wrong pixels" in shown.err


def test_devices_without_opencl_says_what_to_do(
    endocal: Endocal, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cl, "get_platforms", list)
    shown = endocal("devices")
    assert shown.code == 0
    assert (
        "auto  takes none: no OpenCL device was found: install your GPU's OpenCL driver"
        in shown.out
    )
    data = json.loads(endocal("devices", "--json").out)
    assert (data["auto"], data["devices"]) == (None, [])


def test_bench_remap_prints_endocal_beside_its_peers(endocal: Endocal) -> None:
    args = ("bench", "remap", "--size", "160x90", "--repeats", "2")
    shown = endocal(*args)
    assert shown.code == 0
    assert "cv2.remap, float maps" in shown.out
    data = json.loads(endocal(*args, "--json").out)
    assert data["size"] == [160, 90]
    for row in data["rows"]:
        assert row["endocal"]["least"] <= row["endocal"]["median"]
        assert row["ratio"] == pytest.approx(row["peers"]["median"] / row["endocal"]["median"])


@pytest.mark.parametrize("device", ["auto", "numpy"])
def test_bench_table4_prints_the_articles_rates(
    endocal: Endocal, monkeypatch: pytest.MonkeyPatch, device: str
) -> None:
    from endocal.benchmarks import table4

    monkeypatch.setattr(table4, "ARTICLE", {(163, 109): (5.097, 16.006, 64.103)})
    args = ("bench", "table4", "--device", device, "--repeats", "2")
    assert "163x109" in endocal(*args).out
    (row,) = json.loads(endocal(*args, "--json").out)["rows"]
    assert row["article"] == [5.097, 16.006, 64.103]
    assert row["frames_per_second"] > 0
    assert (row["kernel_per_second"] is None) == (device == "numpy")


def test_bench_remap_refuses_what_it_cannot_do(endocal: Endocal) -> None:
    assert "voodoo" in endocal("bench", "remap", "--device", "voodoo").fails(2)
    assert "1920" in endocal("bench", "remap", "--size", "1920").fails(2)
