"""The linker of last resort: what it makes is loaded and called, and PoCL works with nothing else there."""

from __future__ import annotations

import ctypes
import os
import platform
import struct
import subprocess
import sys
from pathlib import Path

import pytest

from endocal.remap.pocl_linker import UnsupportedError, link, main

pytestmark = pytest.mark.skipif(
    (platform.system(), platform.machine()) != ("Linux", "x86_64"), reason="links for Linux x86-64"
)

PC32, PLT32, GOTPCREL, ABSOLUTE = 2, 4, 9, 1

Relocation = tuple[int, int, str, int]  # place, type, symbol, addend


def an_object(
    text: bytes,
    data: bytes = b"",
    functions: dict[str, int] | None = None,
    text_relocations: tuple[Relocation, ...] = (),
    data_relocations: tuple[Relocation, ...] = (),
) -> bytes:
    """A relocatable object: code, data, functions by their place in the code, and what is to be filled in."""
    functions = functions or {"f": 0}
    named = [*text_relocations, *data_relocations]
    outside = sorted({r[2] for r in named} - set(functions) - {".text", ".data"})
    # Symbols: none, the two sections, then the globals.
    order = ["", ".text", ".data", *functions, *outside]
    strings = b"\0" + b"".join(n.encode() + b"\0" for n in order[3:])
    rows, offset = [(0, 0, 0, 0, 0, 0), (0, 3, 0, 1, 0, 0), (0, 3, 0, 2, 0, 0)], 1
    for name in order[3:]:
        section, value = (1, functions[name]) if name in functions else (0, 0)
        rows.append((offset, 0x12 if section else 0x10, 0, section, value, 0))
        offset += len(name) + 1
    symbols = b"".join(struct.pack("<IBBHQQ", *row) for row in rows)

    def packed(relocations: tuple[Relocation, ...]) -> bytes:
        return b"".join(
            struct.pack("<QQq", place, order.index(name) << 32 | kind, addend)
            for place, kind, name, addend in relocations
        )

    # name, type, flags, contents, link, info, alignment, entry size
    sections = [
        (0, 0, b"", 0, 0, 0, 0),
        (1, 6, text, 0, 0, 16, 0),
        (1, 3, data, 0, 0, 8, 0),
        (4, 0, packed(text_relocations), 5, 1, 8, 24),
        (4, 0, packed(data_relocations), 5, 2, 8, 24),
        (2, 0, symbols, 6, 3, 8, 24),
        (3, 0, strings, 0, 0, 1, 0),
    ]
    body, headers = b"", b""
    for kind, flags, contents, linked, info, align, entry in sections:
        body += bytes(-len(body) % 16)
        place = 64 + len(body)
        body += contents
        headers += struct.pack(
            "<IIQQQQIIQQ", 0, kind, flags, 0, place, len(contents), linked, info, align, entry
        )
    ident = b"\x7fELF\x02\x01\x01" + bytes(9)
    head = struct.pack(
        "<16sHHIQQQIHHHHHH",
        ident,
        1,
        62,
        1,
        0,
        0,
        64 + len(body),
        0,
        64,
        0,
        0,
        64,
        len(sections),
        0,
    )
    return head + body + headers


def loaded(tmp_path: Path, data: bytes) -> ctypes.CDLL:
    path = tmp_path / "made.so"
    path.write_bytes(link(data))
    return ctypes.CDLL(str(path))


def test_a_function_is_found_by_name(tmp_path: Path) -> None:
    # Two functions: return 7; return 11.
    text = b"\xb8\x07\0\0\0\xc3".ljust(16, b"\xcc") + b"\xb8\x0b\0\0\0\xc3"
    made = loaded(tmp_path, an_object(text, functions={"seven": 0, "eleven": 16}))
    assert (made.seven(), made.eleven()) == (7, 11)


def test_constants_are_reached(tmp_path: Path) -> None:
    # mov eax, [rip + data]; ret
    text = b"\x8b\x05\0\0\0\0\xc3"
    made = loaded(
        tmp_path,
        an_object(text, struct.pack("<ii", 5, 99), text_relocations=((2, PC32, ".data", 4 - 4),)),
    )
    assert made.f() == 99


@pytest.mark.parametrize("kind", [PLT32, PC32])
def test_functions_of_other_libraries_are_called(tmp_path: Path, kind: int) -> None:
    # jmp labs
    text = b"\xe9\0\0\0\0"
    made = loaded(tmp_path, an_object(text, text_relocations=((1, kind, "labs", -4),)))
    assert made.f(-5) == 5


def test_addresses_come_from_the_table(tmp_path: Path) -> None:
    # mov rax, [rip + slot]; jmp rax: once to another library's function, once to one of its own.
    text = b"\x48\x8b\x05\0\0\0\0\xff\xe0".ljust(16, b"\xcc") * 2 + b"\xb8\x07\0\0\0\xc3"
    made = loaded(
        tmp_path,
        an_object(
            text,
            functions={"far": 0, "near": 16, "seven": 32},
            text_relocations=((3, GOTPCREL, "labs", -4), (19, GOTPCREL, "seven", -4)),
        ),
    )
    assert (made.far(-5), made.near()) == (5, 7)


def test_addresses_among_data_are_filled_in(tmp_path: Path) -> None:
    # jmp [rip + data]: to a function of its own, and to another library's.
    text = b"\xff\x25\0\0\0\0".ljust(16, b"\xcc") * 2 + b"\xb8\x07\0\0\0\xc3"
    made = loaded(
        tmp_path,
        an_object(
            text,
            bytes(16),
            functions={"near": 0, "far": 16},
            text_relocations=((2, PC32, ".data", -4), (18, PC32, ".data", 8 - 4)),
            data_relocations=((0, ABSOLUTE, ".text", 32), (8, ABSOLUTE, "labs", 0)),
        ),
    )
    assert (made.near(), made.far(-5)) == (7, 5)


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"no object at all",
        an_object(b"\xc3").replace(struct.pack("<HH", 1, 62), struct.pack("<HH", 1, 183), 1),
        an_object(b"\xe9\0\0\0\0", text_relocations=((1, 10, "labs", 0),)),
        an_object(bytes(8), text_relocations=((0, ABSOLUTE, ".text", 0),)),
    ],
    ids=["empty", "text", "another machine", "unknown relocation", "address in code"],
)
def test_what_it_does_not_know_it_refuses(data: bytes) -> None:
    with pytest.raises(UnsupportedError):
        link(data)


def test_it_stands_in_for_a_system_linker_that_is_not_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    source, output = tmp_path / "kernel.so.o", tmp_path / "kernel.so"
    source.write_bytes(an_object(b"\xb8\x07\0\0\0\xc3"))
    arguments = [
        "--eh-frame-hdr",
        "-shared",
        "-o",
        str(output),
        "-L/lib",
        str(source),
        "-lgcc",
        "-lc",
    ]
    assert main(arguments) == 0
    assert ctypes.CDLL(str(output)).f() == 7
    source.write_bytes(b"no object")
    assert main(arguments) == 1
    assert "no ld was found" in capsys.readouterr().err


REMAP = """
import numpy as np
from endocal.model import DivisionModel
from endocal.remap.remapper import Remapper

image = np.random.default_rng(1).integers(0, 256, (60, 80), np.uint8)
model = DivisionModel(-5e-5, (40.0, 31.0), (80, 60))
exact = Remapper(model, device="numpy").apply(image).astype(int)
found = Remapper(model, device="Portable Computing Language").apply(image)
print(abs(found - exact).max())
"""


def test_pocl_works_on_a_machine_without_compiler_packages(tmp_path: Path) -> None:
    from endocal.remap.opencl_device import list_devices

    # Here it comes with endocal.
    assert any("Portable" in listed.device.platform.name for listed in list_devices())
    done = subprocess.run(
        [sys.executable, "-c", REMAP],
        # A cache of its own, so that the kernels are linked anew, and no ld anywhere.
        env={**os.environ, "PATH": str(tmp_path), "POCL_CACHE_DIR": str(tmp_path / "cache")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) <= 1
