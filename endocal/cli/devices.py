"""``endocal devices``: what can do the work, and which of it does."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from ..errors import DeviceError
from .options import Json, print_json

if TYPE_CHECKING:
    from ..jobs.devices import DeviceReport, DevicesReport

EXAMPLES = ("endocal devices -v", "endocal devices --json | jq -r .auto")


def command(
    verbose: Annotated[
        bool,
        typer.Option(
            "--verbose",
            "-v",
            help="Time and check the ways of resampling on each device; keep the faster.",
        ),
    ] = False,
    json: Json = False,
) -> None:
    """List the OpenCL devices and tell which one --device auto takes, and why."""
    from ..jobs.devices import find_devices

    report = find_devices(measure=verbose)
    if json:
        print_json(report.data())
    else:
        _tell(report)
    wrong = [d.address for d in report.devices if d.resampling and d.resampling.is_wrong]
    if wrong:
        raise DeviceError(
            f"device {', '.join(wrong)} computes wrong pixels: update its driver, or pass another --device"
        )


def _tell(report: DevicesReport) -> None:
    for device in report.devices:
        typer.echo(f"{device.address:<6}{device.name} ({device.kind})")
        for label, text in _facts(device):
            typer.echo(f"      {label:<12}{text}")
    typer.echo("numpy NumPy on one core, in float64: always there, exact, slow")
    typer.echo(f"auto  takes {report.auto or 'none'}: {report.reason}")


def _facts(device: DeviceReport) -> list[tuple[str, str]]:
    facts = [
        ("platform", f"{device.platform}, {device.platform_version}"),
        ("version", f"{device.version}, driver {device.driver}"),
        ("units", f"{device.compute_units} compute units, {device.memory / 2**30:.1f} GiB"),
        ("images", "yes" if device.images else "no"),
        ("memory", "shared with the host" if device.shares_memory else "its own"),
    ]
    how = device.resampling
    if how is None:
        return [*facts, ("resampling", "cannot be used")]
    choice = {"baked": "maps baked once a model", "direct": "coordinates on the fly"}[how.strategy]
    facts.append(("resampling", f"{choice} ({'measured' if how.measured else 'by its kind'})"))
    if how.milliseconds is not None and how.first_seconds is not None:
        for strategy, ms in how.milliseconds.items():
            first = how.first_seconds[strategy]
            text = f"{ms:.2f} ms a 1920x1080 frame, the first two {first:.2f} s"
            facts.append((f"  {strategy}", text))
    if how.deviation is not None:
        verdict = "WRONG, do not use it" if how.is_wrong else "as it should be"
        facts.append(("  checked", f"{how.deviation:.2g} of 255 levels off NumPy: {verdict}"))
    return facts
