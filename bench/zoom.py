"""Print how well the zoom is found, tabulated and followed: ``make bench-zoom``.

On a fixed seed and a fresh one: the visible circle on frames with known truth, trouble by trouble, with
what else may be about it, and on frames without one; the zoom table's look-ups on settings held out; and
the zoom of rendered clips, frame by frame. Then how fast the circle is found, and what a changing zoom costs
the resampling. The worst cases are named by their seeds. ``--json FILE`` writes all of it.
"""

from __future__ import annotations

import argparse
import json
import secrets
import sys
from pathlib import Path

import numpy as np

from endocal.benchmarks import boundary, looks, remap, rims, zoom
from endocal.benchmarks.rim_frames import TROUBLES
from endocal.zoom.follow import FollowSpec

FIXED = 0


def main() -> None:
    args = parse(sys.argv[1:])
    fresh = secrets.randbelow(10**6) + 10**4 if args.fresh is None else args.fresh
    report: dict[str, object] = {}
    for name, seed in (("fixed", FIXED), ("fresh", fresh)):
        tell(f"\n{name} seed {seed}")
        report[name] = {
            "seed": seed,
            "rims": print_rims(seed, args.frames),
            "looks": print_looks(seed, args.frames),
            "plain": print_plain(seed, args.plain),
            "lookups": print_lookups(seed),
            "clips": print_clips(seed, args.seconds),
        }
    report["speed"] = print_speed()
    report["remap"] = print_remap()
    if args.json:
        Path(args.json).write_text(json.dumps(report, indent=1, allow_nan=False) + "\n")
        tell(f"{args.json} written")


def parse(words: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0] if __doc__ else None)
    parser.add_argument("--fresh", type=int, help="the fresh seed; drawn at random without")
    parser.add_argument("--frames", type=int, default=100, help="frames per trouble")
    parser.add_argument("--plain", type=int, default=1000, help="frames without a circle")
    parser.add_argument("--seconds", type=float, default=20.0, help="length of the zooming clips")
    parser.add_argument("--json", metavar="FILE", help="write all figures here")
    return parser.parse_args(words)


def print_rims(seed: int, frames: int) -> list[object]:
    tell("the circle, errors in px:  diameter median, 95 %   centre median, 95 %   none   worst")
    scores = [rims.score_rims(t, range(seed, seed + frames)) for t in TROUBLES]
    for s in scores:
        tell(
            f"  {s.trouble:<16}{s.diameter[0]:18.2f}{s.diameter[1]:7.2f}"
            f"{s.center[0]:16.2f}{s.center[1]:7.2f}{s.missed:9d}   {s.worst_error:.2f} (seed {s.worst})"
        )
    return [s.data() for s in scores]


def print_looks(seed: int, frames: int) -> list[object]:
    tell("what else is about the circle:  right   none   wrong")
    scores = [looks.score_look(kind, range(seed, seed + frames)) for kind in looks.LOOKS]
    for s in scores:
        named = f"   (seeds {', '.join(map(str, s.wrong))})" if s.wrong else ""
        tell(f"  {s.kind:<18}{s.found:17d}{s.none:7d}{len(s.wrong):8d}{named}")
    return [s.data() for s in scores]


def print_plain(seed: int, frames: int) -> object:
    score = rims.score_plain(range(seed, seed + frames))
    named = "".join(f", {kind} (seed {n})" for n, kind in score.false)
    tell(f"frames without a circle: one found in {len(score.false)} of {score.frames}{named}")
    return {"frames": score.frames, "false": list(score.false)}


def print_lookups(seed: int) -> list[object]:
    tell("look-ups on settings held out, lambda's relative error:  rms   worst")
    scores = zoom.score_lookups(seed)
    for s in scores:
        tell(f"  {s.lookup:<50}{s.rms:8.2%}{s.worst:8.2%}")
    return [vars(s) for s in scores]


def print_clips(seed: int, seconds: float) -> list[object]:
    tell(
        "clips, lambda's relative error:  circle in sight: median, 95 %   out of sight: median, 95 %"
    )
    found: list[object] = []
    for name, scene in (
        ("zoom to 2.5x and back", zoom.zooming_clip(seed, seconds)),
        ("the same, coming nearer", zoom.zooming_clip(seed, seconds, approach=0.25)),
        ("a camera that roams before organs", zoom.rough_clip(seed)),
    ):
        score, _ = zoom.follow_clip(name, scene)
        hidden = score.hidden_error or (float("nan"), float("nan"))
        doubts = score.hidden_doubts or (float("nan"), float("nan"))
        tell(
            f"  {name:<40}{score.visible_error[0]:9.2%}{score.visible_error[1]:8.2%}"
            f"{hidden[0]:20.2%}{hidden[1]:8.2%}   worst {score.worst_error:+.2%} (frame {score.worst}),"
            f" {score.hidden} of {score.frames} out of sight ({score.sources.get('held', 0)} held), there"
            f" {doubts[0]:.1f}, {doubts[1]:.1f} times the doubt, {score.milliseconds:.2f} ms a frame"
        )
        found.append(score.data())
    for center, follows in (("follow", True), ("fixed", False)):
        score, _ = zoom.follow_clip(
            f"a loose coupler, --center {center}",
            zoom.loose_clip(seed),
            spec=FollowSpec(follows_shift=follows),
        )
        tell(
            f"  {score.name:<40}the distortion centre's error in px: median {score.visible_center[0]:.2f},"
            f" 95 % {score.visible_center[1]:.2f}"
        )
        found.append(score.data())
    score, error = zoom.follow_clip("still", zoom.still_clip(seed))
    tell(f"  still, with noise: lambda's standard deviation {np.std(error):.3%}")
    found.append({**score.data(), "deviation": float(np.std(error))})
    score, error = zoom.follow_clip("steady zoom", zoom.steady_clip(seed))
    # lambda falls by this much a frame; an estimate that is late by one frame is too strong by as much.
    per_frame = 2 * np.log(1.6) / (len(error) - 1)
    lag = error[5:] / per_frame
    tell(f"  steady zoom: lag in frames {np.mean(lag):+.2f} on average, {np.max(lag):+.2f} at most")
    found.append({**score.data(), "lag": float(np.mean(lag)), "most_lag": float(np.max(lag))})
    return found


def print_speed() -> object:
    report = boundary.run()
    tell("\nthe circle, frames per second of one core, median and best of the rounds:")
    tell("  in a video          each frame anew     prototype           contour alone")
    for r in report.rows:
        ways = (
            (r.warm, r.warm_best),
            (r.cold, r.cold_best),
            (r.prototype, r.prototype_best),
            (r.contour, r.contour_best),
        )
        figures = "".join(f"{f'{middle:.0f}, {best:.0f}':<20}" for middle, best in ways)
        tell(f"  {figures}{r.size[0]}x{r.size[1]}")
    return report.data()


def print_remap() -> object:
    report = remap.run_zoom()
    tell(f"\nresampling {report.size[0]}x{report.size[1]} frames on {report.device}")
    for row in report.rows:
        tell(
            f"  {row.work}: {row.ratio:.0%} of the frame rate of a fixed zoom"
            f" ({row.processor_ratio:.0%} by the processors' time)"
        )
    return report.data()


def tell(line: str) -> None:
    print(line, flush=True)


if __name__ == "__main__":
    main()
