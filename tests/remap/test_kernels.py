"""The kernel sources: one job a file, every argument and field explained, all of them used and shipped."""

from __future__ import annotations

import re
from importlib import resources

import numpy as np
import pytest

from endocal.remap import opencl_plane
from endocal.remap.opencl_mapping import MAPPING

SOURCES = {
    entry.name: entry.read_text(encoding="utf-8")
    for entry in resources.files("endocal.kernels").iterdir()
    if entry.name.endswith(".cl")
}


def test_every_file_is_used():
    assert set(SOURCES) == {*opencl_plane._DIRECT, *opencl_plane._CURVES}


@pytest.mark.parametrize("name", SOURCES)
def test_a_file_says_what_it_does_and_holds_one_kernel_at_most(name):
    assert SOURCES[name].startswith("// ")
    assert len(re.findall(r"^kernel void", SOURCES[name], re.MULTILINE)) <= 1


@pytest.mark.parametrize("name", SOURCES)
def test_every_argument_of_a_kernel_is_explained(name):
    for arguments in re.findall(
        r"^kernel void \w+\((.*?)^\{", SOURCES[name], re.DOTALL | re.MULTILINE
    ):
        lines = [line for line in arguments.splitlines() if line.strip()]
        assert lines
        for line in lines:
            assert re.search(r"// \S", line), f"{name}: {line.strip()}"


def test_the_mapping_is_packed_as_the_kernels_read_it():
    body = re.search(r"struct mapping \{(.*?)\};", SOURCES["mapping.cl"], re.DOTALL)[1]
    fields = []
    for line in body.strip().splitlines():
        declared = re.match(r"\s*(int|float) ([^;]+);\s+// \S", line)
        assert declared, line
        for field in declared[2].split(","):
            name, count = re.match(r"\s*(\w+?)(?:\[(\d+)\])?$", field).groups()
            fields += [(declared[1], name)] * int(count or 1)
    packed = []
    for name in MAPPING.names:
        kind, _ = MAPPING.fields[name]
        base, shape = kind.subdtype or (kind, ())
        packed += [("int" if base == np.int32 else "float", name)] * int(np.prod(shape, initial=1))
    assert [kind for kind, _ in fields] == [kind for kind, _ in packed]
    assert MAPPING.itemsize == 4 * len(fields)
    for (_, field), (_, name) in zip(fields, packed, strict=True):
        stem = name.removesuffix("_size")
        assert field == name or field.startswith(stem), (field, name)
