"""Write docs/results.md: ``make tables``."""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable

# Before NumPy is loaded, here and in the processes that inherit it: they fill the processors already.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

from . import figure1, figure3, figure11, table1, table4, table5, tables23
from .lenses import real_folder
from .page import PAGE, PICTURES

# What is made from pictures that a checkout may lack stays as it is where they lack.
REAL_BEGINS, REAL_ENDS = "<!-- real pictures -->", "<!-- end of real pictures -->"

HEAD = """# The article's tables and figures, made anew

`make tables` writes this page. The article is Lee et al. 2013,
[doi:10.1109/TBME.2013.2261816](https://doi.org/10.1109/TBME.2013.2261816); its own figures stand beside each table. Its
pictures are not public, so that ours are of other lenses: magnitudes do not compare, orders may. Every method is
the one behind `endocal calibrate --method`, bare; [method.md](method.md#the-methods) says what each is.
"""


def main() -> None:
    """Make every section and write the page."""
    args = parse()
    began = time.monotonic()
    page = PAGE.read_text(encoding="utf-8") if PAGE.exists() else ""

    def made(name: str, make: Callable[[], str]) -> str:
        start = time.monotonic()
        text = make()
        print(f"{name}: {time.monotonic() - start:.0f} s", file=sys.stderr, flush=True)
        return text.rstrip("\n") + "\n"

    study = None

    def tables23_text() -> str:
        nonlocal study
        study = tables23.synthetic_study(args.processes)
        return tables23.synthetic_section(study)

    sections = [HEAD, made("Table I", table1.section), made("Tables II and III", tables23_text)]
    folder = real_folder()
    real = None
    if folder is None:
        print("no real pictures: their section stays as it was", file=sys.stderr)
        kept = page.partition(REAL_BEGINS)[2].partition(REAL_ENDS)[0]
    else:
        start = time.monotonic()
        real = tables23.real_study(folder, args.processes)
        kept = f"\n{tables23.real_section(real).rstrip()}\n\n{tables23.claims('real lenses', real)}"
        print(f"real lenses: {time.monotonic() - start:.0f} s", file=sys.stderr, flush=True)
    sections.append(f"{REAL_BEGINS}{kept}{REAL_ENDS}\n")
    assert study is not None
    eleven = figure11.run(args.processes)
    print(f"Fig. 11: {time.monotonic() - began:.0f} s so far", file=sys.stderr, flush=True)
    tilted = tables23.perspective(args.processes)
    sections += [
        made("claims", lambda: tables23.findings(study, eleven, tilted)),
        made("Fig. 1", figure1.section),
        made("Fig. 3", figure3.section),
        made("Fig. 11", lambda: figure11.section(eleven)),
        made("Table V", lambda: table5.section(table5.run(args.processes))),
        made("Table IV", table4.section),
    ]
    PAGE.write_text("\n".join(sections), encoding="utf-8")
    size = sum(p.stat().st_size for p in PICTURES.glob("*.png")) / 1024
    print(f"{PAGE}: {time.monotonic() - began:.0f} s; pictures {size:.0f} KiB", file=sys.stderr)


def parse() -> argparse.Namespace:
    """Return the options of the command line."""
    parser = argparse.ArgumentParser(prog="bench.tables", description=__doc__, allow_abbrev=False)
    parser.add_argument("--processes", type=int, default=min(2, os.cpu_count() or 1))
    return parser.parse_args()


if __name__ == "__main__":
    main()
