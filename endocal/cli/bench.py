"""``endocal bench``: how fast it is, beside its peers in the same run."""

from __future__ import annotations

from typing import Annotated

import typer

from .options import Device, Json, note, parse_size, print_json

EXAMPLES = (
    "endocal bench remap --size 3840x2160",
    "endocal bench table4 --device numpy --repeats 1",
    "endocal bench calibrate",
    "endocal bench boundary",
    "endocal bench correct --frames 300",
)

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


@group.command("table4")
def table4(
    device: Device = "auto",
    repeats: Annotated[int, typer.Option(min=1, help="How often each size is done.")] = 20,
    json: Json = False,
) -> None:
    """Colour frames at the sizes of the article's Table IV, beside its rates."""
    from ..benchmarks.table4 import run

    report = run(device, repeats)
    if json:
        print_json(report.data())
        return
    typer.echo(f"Frames per second on {report.device}, bilinear, median of {repeats}")
    typer.echo(
        "size        with transfers  kernel alone  of the copy rate  article: 1 core, 4, GPU"
    )
    for row in report.rows:
        size = f"{row.size[0]}x{row.size[1]}"
        alone = "-" if row.kernel_per_second is None else f"{row.kernel_per_second:.1f}"
        share = "-" if row.copy_share is None else f"{row.copy_share:.0%}"
        article = ", ".join(f"{rate:g}" for rate in row.article)
        typer.echo(f"{size:<12}{row.frames_per_second:14.1f}  {alone:>12}  {share:>16}  {article}")


@group.command("calibrate")
def calibrate(
    repeats: Annotated[int, typer.Option(min=1, help="How often each work is done.")] = 5,
    json: Json = False,
) -> None:
    """Algorithm 1 with HEwG, beside the article's times and a plain NumPy loop; the whole command."""
    from ..benchmarks.calibrate import run

    report = run(repeats, progress=note)
    if json:
        print_json(report.data())
        return
    typer.echo(
        f"Algorithm 1 with HEwG, S = {report.samples}, epsilon = {report.epsilon:g} px^-2, seconds;"
        f" endocal {repeats} times: median / least on the clock / of the processor"
    )
    typer.echo(f"{'edge points':>11}  {'endocal':<23}{'article, 1 and 4 cores':<32}plain loop")
    for row in report.rows:
        ours, article = row.endocal, row.article
        typer.echo(
            f"{article.points:>11}  {ours.median:.3f} / {ours.least:.3f} / {ours.processor:.3f}"
            f"  {article.one_core:.3f} ({row.times_article:4.1f}x)  {article.four_cores:.3f}"
            f"       {row.plain.median:6.2f} / {row.plain.processor:5.2f} ({row.times_plain:4.1f}x)"
            f"  {'the same minimum' if row.same_minimum else 'ANOTHER MINIMUM'}"
        )
    whole = report.command
    typer.echo(
        f"endocal calibrate on a {whole.size[0]}x{whole.size[1]} board, all of it:"
        f" {whole.time.median:.2f} / {whole.time.least:.2f} / {whole.time.processor:.2f}"
    )


@group.command("boundary")
def boundary(
    rounds: Annotated[int, typer.Option(min=1, help="How often the frames are gone through.")] = 12,
    json: Json = False,
) -> None:
    """Finding the visible circle, on one core, beside a bare prototype and the article's contour."""
    from ..benchmarks.boundary import ARTICLE_RATE, ARTICLE_SIZE, run

    report = run(rounds=rounds)
    if json:
        print_json(report.data())
        return
    typer.echo("frames per second of one core, median (best) of the rounds:")
    typer.echo(
        f"{'size':<11}{'in a video':>18}{'each frame anew':>18}{'prototype':>18}{'contour':>18}"
        "  article"
    )
    for row in report.rows:
        pairs = (
            (row.warm, row.warm_best),
            (row.cold, row.cold_best),
            (row.prototype, row.prototype_best),
            (row.contour, row.contour_best),
        )
        figures = "".join(f"{f'{m:.0f} ({b:.0f})':>18}" for m, b in pairs)
        article = f"{ARTICLE_RATE:>9}" if row.size == ARTICLE_SIZE else ""
        typer.echo(f"{f'{row.size[0]}x{row.size[1]}':<11}{figures}{article}")
    typer.echo("error of diameter or centre, median and 95 %, px:")
    for name, (middle, most) in (
        ("ours", report.error),
        ("prototype", report.prototype_error),
        ("contour", report.contour_error),
    ):
        typer.echo(f"  {name:<11}{middle:8.2f}{most:8.2f}")


@group.command("correct")
def correct(
    size: Annotated[str, typer.Option(metavar="WxH", help="Frame size.")] = "1920x1080",
    frames: Annotated[int, typer.Option(min=10, help="Length of the clip.")] = 600,
    rounds: Annotated[int, typer.Option(min=1, help="How often each contender runs.")] = 3,
    device: Device = "auto",
    json: Json = False,
) -> None:
    """Whole corrections beside ffmpeg's plain transcode and lenscorrection, and a cv2 script."""
    from ..benchmarks.correct import run

    shape = parse_size(size)
    assert shape is not None
    report = run(shape, frames, rounds, device, progress=note)
    if json:
        print_json(report.data())
        return
    typer.echo(
        f"{frames} frames of {size}, H.264 to libx264 ultrafast crf 18, start-up included, {rounds} rounds"
    )
    typer.echo(f"{'':<58}{'seconds':>9}{'least':>9}{'processor':>11}{'peak MiB':>10}")
    for row in report.rows:
        cost = row.cost
        typer.echo(
            f"{row.name:<58}{cost.seconds:9.2f}{row.least:9.2f}{cost.processor:11.2f}{cost.memory:10.0f}"
        )
    for name in report.missing:
        typer.echo(f"{name:<58}not installed")
    if report.added is not None:
        typer.echo(
            f"time added to the plain transcode, over what lenscorrection adds: {report.added:.2f}"
            f" (processor {report.added_processor:.2f}); of the plain transcode: {report.times_plain:.2f}x"
        )
    typer.echo(f"endocal's peak on a tenth of the frames: {report.short_memory:.0f} MiB")
