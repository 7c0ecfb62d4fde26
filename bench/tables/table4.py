"""Table IV: how long calibration and correction take. The one section whose figures differ from run to run."""

from __future__ import annotations

from endocal.benchmarks import calibrate, table4
from endocal.errors import EndocalError
from endocal.jobs.devices import find_devices

from .page import table

# Timed so many times; NumPy, the slow reference, once.
REPEATS = 3


def section() -> str:
    report = calibrate.run(REPEATS)
    rows = [
        [
            str(row.article.points),
            f"{row.article.one_core:.3f}",
            f"{row.article.four_cores:.3f}",
            f"{row.endocal.processor:.2f}",
            f"{row.times_article:.1f}",
            f"{row.times_plain:.0f}",
        ]
        for row in report.rows
    ]
    heads = [
        "edge points",
        "article, 1 core, s",
        "4 cores, s",
        "endocal, 1 core, s",
        "times the article",
        "times a plain loop, same run",
    ]
    return f"""## Table IV: speed

Timings differ with the machine and from run to run; all else on this page does not. The article's are of an
i7-860 and a Tesla C2050; ours, of one core, are seconds of the processor, so that other work counts little.

### Calibration

Algorithm 1 with HEwG, S = {report.samples}, ε = {report.epsilon:g} px⁻², on the edge points of a synthetic board:

{table(heads, rows)}
### Correction

Frames per second, bilinear, colour frames from host memory to host memory, median:

{_correction()}"""


def _correction() -> str:
    devices = [d.address for d in find_devices().devices if d.resampling is not None]
    reports = []
    for device in [*devices, "numpy"]:
        try:
            reports.append(table4.run(device, 1 if device == "numpy" else REPEATS))
        except EndocalError:  # listed, but it cannot do it
            continue
    heads = ["size", "article: 1 core", "4 cores", "GPU", *(r.device for r in reports)]
    rows = []
    for i, (size, article) in enumerate(table4.ARTICLE.items()):
        ours = [f"{r.rows[i].frames_per_second:.1f}" for r in reports]
        rows.append([f"{size[0]}x{size[1]}", *(f"{rate:g}" for rate in article), *ours])
    return table(heads, rows)
