"""``endocal bench``: how fast it is, beside its peers in the same run."""

from __future__ import annotations

from typing import Annotated

import typer

from .options import Device, Json, parse_size, print_json

EXAMPLES = ("endocal bench remap --size 3840x2160",)

group = typer.Typer(help="Time endocal beside its peers, in the same run.", no_args_is_help=True)


@group.command("remap")
def remap(
    size: Annotated[str, typer.Option(metavar="WxH", help="Frame size.")] = "1920x1080",
    device: Device = "auto",
    repeats: Annotated[int, typer.Option(min=1, help="How often each work is done.")] = 60,
    json: Json = False,
) -> None:
    """Resampling: planes by endocal and by cv2.remap, a zoom that changes and one that stays."""
    from ..benchmarks.remap import run

    shape = parse_size(size)
    assert shape is not None
    report = run(shape, device, repeats)
    if json:
        print_json(report.data())
        return
    typer.echo(f"{shape[0]}x{shape[1]} on {report.device}, {repeats} times in turn; milliseconds:")
    typer.echo("median / least on the clock / of all processors; times the peer's rate (processor)")
    for row in report.rows:
        ours, peers = (
            f"{t.median:7.2f} /{t.least:6.2f} /{t.processor:6.2f}" for t in (row.endocal, row.peers)
        )
        ratio = f"{row.ratio:5.2f}x ({row.processor_ratio:.2f}x)"
        typer.echo(f"{row.work:<50}{ours}   {row.peer:<34}{peers}  {ratio}")
