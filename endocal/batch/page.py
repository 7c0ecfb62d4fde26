"""The report of a batch as a page for people."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from ..files.names import shown
from ..report import page as p
from ..report.numbers import duration
from .ledger import DONE, FAILED
from .report import LEFT, OPEN, BatchReport, Line

_HEADS = ("recording", "calibration", "frames", "video", "work", "speed")
_ZOOM_HEADS = ("zoom", "rim", "tracked", "held", "given")
# So many recordings are named with a note that they share.
_NAMED = 5


def report_page(report: BatchReport) -> str:
    """Return the page."""
    parts = [_verdict(report), _tiles(report)]
    failed = [line for line in report.lines if line.status == FAILED]
    if failed or report.missing:
        reasons = [line.reason or "" for line in failed] + list(report.missing)
        parts.append(p.section("Failed", p.bullets(_plain(reason) for reason in reasons)))
    left = [line for line in report.lines if line.status == LEFT]
    if left:
        words = "Their outputs are not of this batch. --overwrite makes them anew."
        names = (f"{shown(line.place)}: {line.reason}" for line in left)
        parts.append(p.section("Left alone", p.paragraph(words), p.bullets(map(_plain, names))))
    done = [line for line in report.lines if line.status == DONE]
    for heading, said in (
        ("Warnings", _grouped(done, "warnings")),
        ("Notes", [*report.notes, *_grouped(done, "notes")]),
    ):
        if said:
            parts.append(p.section(heading, p.bullets(map(_plain, said))))
    if done:
        parts.append(_table(done))
    if any(line.calibrations for line in report.lines):
        parts.append(_calibrations(report.lines))
    return p.page(
        "Batch report", *parts, subtitle=_plain(f"{shown(report.out)}, begun {report.began}")
    )


def _table(done: list[Line]) -> p.Html:
    zooms = any(line.facts.get("zoom") for line in done)
    rows = [[*_row(line), *(_zoom_row(line) if zooms else ())] for line in done]
    heads = (*_HEADS, *(_ZOOM_HEADS if zooms else ()))
    words = (
        "Work is the time of one recording, and speed its frames over that; several go on at once."
    )
    if zooms:
        words += (
            " Zoom is the range of the visible circle's diameter; then come the shares of the frames whose"
            " zoom was seen at the circle's rim, tracked in the picture, held from before, or given."
        )
    return p.section("Recordings", p.table(heads, rows), p.paragraph(words, soft=True))


def _grouped(done: list[Line], key: str) -> list[str]:
    """Return what is said of recordings, once for all of which the same is said."""
    places: dict[str, list[str]] = {}
    for line in done:
        for text in line.facts.get(key, ()):
            places.setdefault(text, []).append(shown(line.place))
    said = []
    for text, names in places.items():
        more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
        said.append(f"{', '.join(names[:_NAMED])}{more}: {text}")
    return said


def _verdict(report: BatchReport) -> p.Html:
    total = len(report.lines) + len(report.missing)
    done, still = report.count(DONE), report.count(OPEN)
    reasons = []
    if report.failures:
        reasons.append(f"{report.failures} failed")
    if report.count(LEFT):
        reasons.append(
            f"{report.count(LEFT)} left alone, since their outputs are not of this batch"
        )
    if still:
        reasons.append(f"{still} not done yet: the same command goes on with them")
    if report.interrupted:
        reasons.append("the run was interrupted")
    if report.stopped is not None:
        reasons.append(f"the run was stopped: {report.stopped}")
    level = "failed" if report.failures else "doubtful" if reasons else "good"
    return p.verdict(level, f"{done} of {total} recordings are done", reasons)


def _tiles(report: BatchReport) -> p.Html:
    done = [line.facts for line in report.lines if line.status == DONE]
    frames = sum(f["frames"] for f in done)
    now = [line.facts for line in report.lines if line.now and line.status == DONE]
    rate = sum(f["frames"] for f in now) / report.seconds if now and report.seconds else None
    return p.tiles(
        [
            ("done", str(len(done)), f"{report.done_now} by this run"),
            ("failed", str(report.failures), ""),
            ("frames", f"{frames:,}".replace(",", "\u202f"), ""),
            ("video", duration(sum(f.get("duration") or 0 for f in done)), ""),
            ("this run took", duration(report.seconds), _plain(report.workers)),
            ("this run's speed", "–" if rate is None else f"{rate:.0f} fps", "over all recordings"),
        ]
    )


def _row(line: Line) -> list[p.Cell]:
    facts = line.facts
    length = facts.get("duration")
    speed = "" if line.speed is None else f"{line.speed:.0f} fps"
    return [
        _plain(shown(line.place)),
        _lens(line),
        facts["frames"],
        "" if length is None else duration(length),
        duration(facts["seconds"]),
        speed,
    ]


def _lens(line: Line) -> str:
    """Name the calibrations of a recording, and the scope's serial number where one led there."""
    names = ", ".join(shown(path) for path, _ in line.calibrations)
    return _plain(names if line.serial is None else f"{names} (serial {line.serial})")


def _calibrations(lines: Sequence[Line]) -> p.Html:
    """List the calibrations of all recordings, whatever became of those."""
    counts = Counter(lens for line in lines for lens in line.calibrations)
    rows: list[list[p.Cell]] = [
        [_plain(shown(path)), digest, count] for (path, digest), count in sorted(counts.items())
    ]
    return p.section("Calibrations", p.table(("calibration", "SHA-256", "recordings"), rows))


def _zoom_row(line: Line) -> list[p.Cell]:
    shares = line.shares()
    parts = (f"{shares[s]:.0%}" if s in shares else "" for s in _ZOOM_HEADS[1:])
    return [_zoom(line.facts.get("diameters")), *parts]


def _zoom(diameters: tuple[float, float] | None) -> str:
    if diameters is None:
        return ""
    least, most = (f"{d:.0f}" for d in diameters)
    return f"{least} px" if least == most else f"{least}–{most} px"


def _plain(text: str) -> str:
    """Return text that is Unicode: bytes of file names that are none are escaped."""
    return text.encode(errors="backslashreplace").decode()
