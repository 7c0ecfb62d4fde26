"""A linker for PoCL's kernels, for machines that have none.

PoCL compiles a kernel to an object file and has Clang turn that into a shared library with the system's
``ld``, against libgcc and libc. A machine without compiler packages has none of them, and PoCL 3 does not
report that: it aborts the process (https://github.com/pocl/pocl/issues/482). So a program named ``ld`` is
put where Clang looks first (COMPILER_PATH); it asks the system's linker, and where that is missing or fails,
links here. That is little work, since a kernel is one object file of code and constants that refers to
itself and at most to functions of libc and libm. ELF-64 for x86-64 (System V ABI).

The file is run by itself as that program, so it imports the standard library alone.
"""

from __future__ import annotations

import os
import shlex
import shutil
import struct
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

_SEARCH = "COMPILER_PATH"

_PAGE = 0x1000
_X86_64, _RELOCATABLE, _SHARED = 62, 1, 3
_NOBITS, _SYMTAB, _RELA = 8, 2, 4
_WRITE, _ALLOC = 1, 2
_LOAD, _DYNAMIC, _STACK = 1, 2, 0x6474E551
# Relocation types by what they need: an absolute address, a distance, a distance to an entry of the table
# of addresses (GOT); and the two kinds that the loader applies.
_ABSOLUTE, _DISTANCES, _TABLE_DISTANCES = 1, (2, 4), (9, 41, 42)
_GLOB_DAT, _RELATIVE = 6, 8
_LIBRARIES = ("libm.so.6", "libc.so.6")
# A jump through the table: jmp *distance(%rip), padded to 16 bytes.
_JUMP = b"\xff\x25%s" + b"\xcc" * 10


class UnsupportedError(Exception):
    """The object holds something that this linker does not know."""


class _Section(NamedTuple):
    name: int
    type: int
    flags: int
    address: int
    offset: int
    size: int
    link: int
    info: int
    align: int
    entry: int


class _Symbol(NamedTuple):
    name: bytes
    info: int
    section: int
    value: int
    size: int


def provide_linker(folder: Path) -> None:
    """Put our ``ld`` into a directory, and have the Clang inside this process look there first."""
    command = shlex.join([sys.executable, "-I", "-S", os.path.abspath(__file__)])
    program = folder / "ld"
    program.write_text(f'#!/bin/sh\nexec {command} "$@"\n', encoding="utf-8")
    program.chmod(0o700)
    others = os.environ.get(_SEARCH)
    os.environ[_SEARCH] = f"{folder}{os.pathsep}{others}" if others else str(folder)


def main(arguments: Sequence[str]) -> int:
    """Link as ``ld`` would: with the system's linker, or else ourselves."""
    reason = "no ld was found"
    system = shutil.which("ld")
    if system is not None:
        done = subprocess.run([system, *arguments], capture_output=True, text=True, check=False)
        if done.returncode == 0:
            return 0
        reason = done.stderr
    try:
        output = arguments[arguments.index("-o") + 1]
        objects = [a for a in arguments if a.endswith(".o") and a != output]
        if "-shared" not in arguments or len(objects) != 1:
            raise UnsupportedError("not one object for a shared library")
        Path(output).write_bytes(link(Path(objects[0]).read_bytes()))
    except (UnsupportedError, ValueError, OSError, struct.error) as error:
        print(f"{reason}\nendocal's own linker: {error}", file=sys.stderr)
        return 1
    return 0


def link(data: bytes) -> bytes:
    """Return the shared library made of one relocatable object.

    Raises UnsupportedError where that needs more than a kernel does.
    """
    return _Linker(data).library()


class _Linker:
    """One object on its way: read, given addresses, relocated, and described for the loader."""

    def __init__(self, data: bytes) -> None:
        if data[:6] != b"\x7fELF\x02\x01":
            raise UnsupportedError("no ELF-64 object")
        kind, machine = struct.unpack_from("<HH", data, 16)
        if (kind, machine) != (_RELOCATABLE, _X86_64):
            raise UnsupportedError("no relocatable object for x86-64")
        (start,) = struct.unpack_from("<Q", data, 40)
        (count,) = struct.unpack_from("<H", data, 60)
        self.data = data
        self.sections = [
            _Section(*struct.unpack_from("<IIQQQQIIQQ", data, start + 64 * i)) for i in range(count)
        ]
        self.symbols = self._read_symbols()
        self.relocations = self._read_relocations()
        self.dynamic_relocations: list[tuple[int, int, int]] = []
        self._choose_names()
        self._place()

    def library(self) -> bytes:
        """Relocate, and write what the loader reads."""
        for section, at, kind, symbol, addend in self.relocations:
            self._apply(self.places[section] + at, kind, symbol, addend)
        for number, symbol in enumerate(self.table):
            slot = self.table_start + 8 * number
            if self.symbols[symbol].section == 0:
                self._need(slot, self.exported_number[symbol] << 32 | _GLOB_DAT, 0)
            else:
                self._need(slot, _RELATIVE, self._address(symbol))
        for number, symbol in enumerate(self.jumps):
            at = self.jump_start + 16 * number
            distance = self._slot(symbol) - (at + 6)
            self.image[at : at + 16] = _JUMP.replace(b"%s", struct.pack("<i", distance))
        self._write_headers()
        return bytes(self.image)

    def _read_symbols(self) -> list[_Symbol]:
        tables = [s for s in self.sections if s.type == _SYMTAB]
        if len(tables) != 1:
            raise UnsupportedError("not one symbol table")
        names = self.sections[tables[0].link].offset
        symbols = []
        for at in range(tables[0].offset, tables[0].offset + tables[0].size, 24):
            name, info, _, section, value, size = struct.unpack_from("<IBBHQQ", self.data, at)
            end = self.data.index(b"\0", names + name)
            symbols.append(_Symbol(self.data[names + name : end], info, section, value, size))
        return symbols

    def _read_relocations(self) -> list[tuple[int, int, int, int, int]]:
        found = []
        for s in self.sections:
            if s.type != _RELA or not self.sections[s.info].flags & _ALLOC:
                continue
            for at in range(s.offset, s.offset + s.size, 24):
                place, info, addend = struct.unpack_from("<QQq", self.data, at)
                found.append((s.info, place, info & 0xFFFFFFFF, info >> 32, addend))
        return found

    def _choose_names(self) -> None:
        """Find what the loader must know by name, what is called elsewhere, and what needs an address."""
        kinds: dict[int, set[int]] = {}
        for _, _, kind, symbol, _ in self.relocations:
            kinds.setdefault(symbol, set()).add(kind)
        outside = {n for n in kinds if self.symbols[n].section == 0 and self.symbols[n].name}
        self.jumps = sorted(n for n in outside if kinds[n] & set(_DISTANCES))
        through_table = {n for n, found in kinds.items() if found & set(_TABLE_DISTANCES)}
        self.table = sorted(through_table | set(self.jumps))
        given = {n for n, s in enumerate(self.symbols) if s.info >> 4 and s.section and s.name}
        self.exported = sorted(given | outside)
        self.exported_number = {symbol: i + 1 for i, symbol in enumerate(self.exported)}

    def _place(self) -> None:
        """Give everything its address, which is also its place in the file."""
        names = b"\0" + b"\0".join(self.symbols[n].name for n in self.exported) + b"\0"
        self.libraries_start = len(names)
        self.names = names + b"\0".join(name.encode() for name in _LIBRARIES) + b"\0"
        count = len(self.exported) + 1
        at = 64 + 56 * 4
        self.hash_start, at = at, at + 4 * (2 + 1 + count)
        self.symbols_start = at = _aligned(at, 8)
        self.names_start, at = at + 24 * count, at + 24 * count + len(self.names)
        self.rela_start = at = _aligned(at, 8)
        absolute = sum(kind == _ABSOLUTE for _, _, kind, _, _ in self.relocations)
        at += 24 * (len(self.table) + absolute)
        self.jump_start = at = _aligned(at, 16)
        at += 16 * len(self.jumps)
        self.places: dict[int, int] = {}
        at = self._place_sections(at, writable=False)
        self.writable_start = at = _aligned(at, _PAGE)
        self.table_start, at = at, at + 8 * len(self.table)
        self.dynamic_start, at = at, at + 16 * 12
        self.end = self._place_sections(at, writable=True)
        self.image = bytearray(self.end)
        for number, place in self.places.items():
            s = self.sections[number]
            if s.type != _NOBITS:
                self.image[place : place + s.size] = self.data[s.offset : s.offset + s.size]

    def _place_sections(self, at: int, writable: bool) -> int:
        for number, s in enumerate(self.sections):
            if s.flags & _ALLOC and bool(s.flags & _WRITE) == writable:
                self.places[number] = at = _aligned(at, max(s.align, 1))
                at += s.size
        return at

    def _address(self, number: int) -> int:
        symbol = self.symbols[number]
        if symbol.section not in self.places:
            raise UnsupportedError(f"{symbol.name.decode(errors='replace')} has no section")
        return self.places[symbol.section] + symbol.value

    def _slot(self, symbol: int) -> int:
        return self.table_start + 8 * self.table.index(symbol)

    def _need(self, place: int, info: int, addend: int) -> None:
        """Leave a place to the loader, which can write in the second segment alone."""
        if place < self.writable_start:
            raise UnsupportedError("an absolute address among code or constants")
        self.dynamic_relocations.append((place, info, addend))

    def _apply(self, place: int, kind: int, symbol: int, addend: int) -> None:
        outside = self.symbols[symbol].section == 0
        if kind == _ABSOLUTE:
            if outside:
                self._need(place, self.exported_number[symbol] << 32 | _ABSOLUTE, addend)
            else:
                self._need(place, _RELATIVE, self._address(symbol) + addend)
            return
        if kind in _TABLE_DISTANCES:
            target = self._slot(symbol)
        elif kind in _DISTANCES and outside:
            target = self.jump_start + 16 * self.jumps.index(symbol)
        elif kind in _DISTANCES:
            target = self._address(symbol)
        else:
            raise UnsupportedError(f"relocation type {kind}")
        struct.pack_into("<i", self.image, place, target + addend - place)

    def _write_headers(self) -> None:
        count = len(self.exported) + 1
        start = self.symbols_start + 24
        offset = 1
        for number in self.exported:
            s = self.symbols[number]
            address = self._address(number) if s.section else 0
            # Any section number but 0 says "defined"; the loader asks no more.
            row = (offset, s.info, 0, 1 if s.section else 0, address, s.size)
            struct.pack_into("<IBBHQQ", self.image, start, *row)
            start, offset = start + 24, offset + len(s.name) + 1
        # One chain of all symbols is search enough for the handful that a kernel has.
        chain = [*range(2, count), 0] if count > 1 else []
        words = [1, count, min(1, count - 1), 0, *chain]
        struct.pack_into(f"<{len(words)}I", self.image, self.hash_start, *words)
        self.image[self.names_start : self.names_start + len(self.names)] = self.names
        for i, relocation in enumerate(self.dynamic_relocations):
            struct.pack_into("<QQq", self.image, self.rela_start + 24 * i, *relocation)
        self._write_dynamic()
        ident = b"\x7fELF\x02\x01\x01" + bytes(9)
        fields = (_SHARED, _X86_64, 1, 0, 64, 0, 0, 64, 56, 4, 64, 0, 0)
        struct.pack_into("<16sHHIQQQIHHHHHH", self.image, 0, ident, *fields)
        end = self.end - self.writable_start
        for i, (kind, flags, first, size) in enumerate(
            [
                (_LOAD, 5, 0, self.writable_start),
                (_LOAD, 6, self.writable_start, end),
                (_DYNAMIC, 6, self.dynamic_start, 16 * 12),
                (_STACK, 6, 0, 0),
            ]
        ):
            header = (kind, flags, first, first, first, size, size, _PAGE if kind == _LOAD else 8)
            struct.pack_into("<IIQQQQQQ", self.image, 64 + 56 * i, *header)

    def _write_dynamic(self) -> None:
        library = self.libraries_start
        entries = [
            *((1, library + sum(len(n) + 1 for n in _LIBRARIES[:i])) for i in (0, 1)),
            (4, self.hash_start),
            (5, self.names_start),
            (6, self.symbols_start),
            (10, len(self.names)),
            (11, 24),
            (7, self.rela_start),
            (8, 24 * len(self.dynamic_relocations)),
            (9, 24),
            (0, 0),
        ]
        for i, entry in enumerate(entries):
            struct.pack_into("<QQ", self.image, self.dynamic_start + 16 * i, *entry)


def _aligned(at: int, align: int) -> int:
    return -(-at // align) * align


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
