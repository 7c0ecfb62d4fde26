"""Print how accurate calibration is: ``make bench-calibration``.

On random boards with known truth, a fixed range of seeds and a fresh one; on boards seen through fisheyes,
which are no division models; and on real pictures. The latter two are scored on corners that were found
without endocal's calibration. ``--json FILE`` writes all of it for programs.
"""

from __future__ import annotations

import argparse
import json
import os
import secrets
import sys
from collections.abc import Sequence
from pathlib import Path

# Before NumPy is loaded, here and in the processes that inherit it: they fill the processors already.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from endocal.benchmarks import fisheye_boards, real_boards, synthetic_boards
from endocal.benchmarks.synthetic_boards import Outcome

ROOT = Path(__file__).resolve().parent.parent
WORST = 6
VERDICTS = ("good", "doubtful", "failed", synthetic_boards.REFUSED, synthetic_boards.CRASHED)


def main() -> None:
    """Run what the command line asks for, and print it."""
    args = parse(sys.argv[1:])
    report: dict[str, object] = {}
    if args.boards:
        fresh = secrets.randbelow(10**8) + 10**6 if args.fresh is None else args.fresh
        for name, first in (("fixed", args.first), ("fresh", fresh)):
            seeds = range(first, first + args.boards)
            tell(f"{args.boards} random boards, {name} seeds {seeds[0]} to {seeds[-1]}")
            outcomes = synthetic_boards.run(seeds, args.processes, tick)
            tell("")
            print_boards(name, seeds, outcomes)
            report[name] = {
                "first_seed": first,
                "summary": synthetic_boards.summarise(outcomes).data(),
                "boards": [o.data() for o in outcomes],
            }
    if args.fisheyes:
        seeds = range(args.first, args.first + args.fisheyes)
        tell(f"{args.fisheyes} boards through fisheyes, seeds {seeds[0]} to {seeds[-1]}")
        through = fisheye_boards.run(seeds, args.processes, tick)
        tell("")
        print_fisheyes(seeds, through)
        report["fisheyes"] = [o.data() for o in through]
    folder = Path(os.environ.get("ENDOCAL_REAL_DATA", ROOT.parent / "shared" / "data")) / "boards"
    if args.no_real or not (folder / "corners.json").exists():
        tell(
            "no real pictures"
            if args.no_real
            else f"no real pictures at {folder}: set ENDOCAL_REAL_DATA"
        )
    else:
        pictures = real_boards.run(folder, lambda p: tell(f"{p.lens}/{p.file}"))
        print_pictures(pictures)
        report["real"] = [p.data() for p in pictures]
    if args.json:
        Path(args.json).write_text(json.dumps(report, indent=1, allow_nan=False) + "\n")
        tell(f"{args.json} written")


def parse(line: Sequence[str]) -> argparse.Namespace:
    """Return the options of the command line."""
    parser = argparse.ArgumentParser(description=__doc__, allow_abbrev=False)
    parser.add_argument(
        "--boards", type=int, default=400, help="of each range of seeds; 0 for none"
    )
    parser.add_argument(
        "--fisheyes", type=int, default=60, help="boards through fisheyes; 0 for none"
    )
    parser.add_argument("--first", type=int, default=0, help="the first fixed seed (default 0)")
    parser.add_argument(
        "--fresh", type=int, help="the first fresh seed (default: drawn, and printed)"
    )
    parser.add_argument("--processes", type=int, default=min(2, os.cpu_count() or 1))
    parser.add_argument("--no-real", action="store_true", help="leave the real pictures out")
    parser.add_argument("--json", metavar="FILE", help="write everything there, too")
    return parser.parse_args(line)


def print_boards(name: str, seeds: range, outcomes: Sequence[Outcome]) -> None:
    """Print the table of a range of random boards, and its worst cases."""
    print(f"\n## Random boards, {name} seeds {seeds[0]} to {seeds[-1]}\n")
    heads = ["", "boards", *VERDICTS, "Δλ/λ: median", "95 %", "centre, px: median", "95 %"]
    heads += ["z of λ, cx, cy", "good, but > 2 % off", "s a board"]
    print(row(heads), row(["---"] * len(heads)), sep="\n")
    groups = {
        "all": outcomes,
        "chessboards": [o for o in outcomes if o.pattern == "chessboard"],
        "parallel lines": [o for o in outcomes if o.pattern == "lines"],
        "called good": [o for o in outcomes if o.verdict == "good"],
    }
    for title, group in groups.items():
        if group:
            s = synthetic_boards.summarise(group)
            z = "–" if s.z is None else ", ".join(f"{v:.2f}" for v in s.z)
            verdicts = [str(s.verdicts.get(v, 0)) for v in VERDICTS]
            errors = [f"{s.lam_median:.3%}", f"{s.lam_p95:.2%}"]
            errors += [f"{s.center_median:.3f}", f"{s.center_p95:.2f}"]
            silent = " ".join(str(seed) for seed in s.silent) or "none"
            print(row([title, str(s.boards), *verdicts, *errors, z, silent, f"{s.seconds:.2f}"]))
    print("\nThe worst in λ, then in the centre:\n")
    heads = ["seed", "size", "pattern", "λR²", "λ off by", "centre off by", "verdict"]
    print(row(heads), row(["---"] * len(heads)), sep="\n")
    for o in synthetic_boards.worst(outcomes, WORST):
        verdict = words(o.verdict, o.reasons)
        size = f"{o.size[0]}x{o.size[1]}"
        off = [f"{o.lam_error:.2%}", f"{o.center_error:.2f} px"]
        print(row([str(o.seed), size, o.pattern, f"{o.strength:.2f}", *off, verdict]))


def print_fisheyes(seeds: range, outcomes: Sequence[fisheye_boards.Outcome]) -> None:
    """Print the table of the fisheyes' boards, and those that are far from the least straightness."""
    print(f"\n## Boards through fisheyes, seeds {seeds[0]} to {seeds[-1]}\n")
    heads = ["", "boards", "s/f: median", "90 %", "worst", "beyond 2 f and f + 0.2 px"]
    print(row(heads), row(["---"] * len(heads)), sep="\n")
    for model in real_boards.MODELS:
        own = [o for o in outcomes if o.model == model]
        groups = {
            model: own,
            "f is a lens": [o for o in own if not o.degenerate],
            "f is none: a corner at the pole": [o for o in own if o.degenerate],
        }
        for title, group in groups.items():
            if group:
                s = fisheye_boards.summarise(group)
                figures = [number(v, 2) for v in (s.median, s.p90, s.worst)]
                far = " ".join(str(seed) for seed in s.far) or "none"
                print(row([title, str(s.boards), *figures, far]))
    print("\nThose beyond:\n")
    heads = ["seed", "lens", "farthest corner", "model", "s", "f", "sends a corner out", "verdict"]
    print(row(heads), row(["---"] * len(heads)), sep="\n")
    for o in outcomes:
        if not o.near:
            cells = [str(o.seed), o.lens, f"{o.angle:.0f}°", o.model, number(o.s), number(o.floor)]
            print(row([*cells, f"{o.far_out:.0f} times", o.verdict]))


def print_pictures(pictures: tuple[real_boards.Picture, ...]) -> None:
    """Print the table of the real pictures, and the medians of each lens."""
    print("\n## Real pictures: straightness of the corners, px\n")
    heads = ["picture", "as it is"]
    for model in real_boards.MODELS:
        heads += [f"{model}: s", "f", "s/f", "verdict"]
    print(row(heads), row(["---"] * len(heads)), sep="\n")
    for p in pictures:
        cells = [f"{p.lens}/{p.file}", number(p.uncorrected)]
        for score in p.scores.values():
            cells += [number(score.s), number(score.floor), number(score.ratio, 2)]
            cells.append(words(score.verdict, score.reasons))
        print(row(cells))
    print("\nMedian s/f of each lens:\n")
    print(row(["lens", *real_boards.MODELS]), row(["---"] * 3), sep="\n")
    for lens in sorted({p.lens for p in pictures}):
        medians = [real_boards.median_ratio(pictures, lens, m) for m in real_boards.MODELS]
        if any(m is not None for m in medians):
            print(row([lens, *(number(m, 2) for m in medians)]))


def row(cells: Sequence[str]) -> str:
    """Return a row of a Markdown table."""
    return f"| {' | '.join(cells)} |"


def words(verdict: str, reasons: Sequence[str]) -> str:
    """Return a verdict with the first reason for it, as a table's cell."""
    return ": ".join([verdict, *reasons[:1]]).replace("|", "/")


def number(value: float | None, digits: int = 3) -> str:
    """Return a number, or a dash for none."""
    return "–" if value is None else f"{value:.{digits}f}"


def tell(message: str) -> None:
    """Tell on stderr how it goes."""
    print(message, file=sys.stderr, flush=True)


def tick(outcome: Outcome | fisheye_boards.Outcome) -> None:
    """Show on stderr which board is done."""
    print(f"\r{outcome.seed}", end="", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
