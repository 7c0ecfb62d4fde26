"""The page of a calibration: can it be trusted, and what does that rest on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from ..boundary.content import content_radius
from ..calibration.fit.plumb_line import robust_sigma
from ..calibration.outcome import Workings
from ..calibration.quality import ROUGH
from ..calibration.result import Calibration
from ..calibration.spec import CalibrationSpec
from ..calibration.straightness import Floats, Labels
from . import calibration_plots as plots
from . import page as p
from . import pictures
from .checks import checks
from .numbers import scientific
from .search import found_by

# Where the colours of lines change, px of a 540-line frame; the last is what a good calibration may have.
STEPS = (0.1, 0.25, ROUGH)
# Of so many neighbours along a line the middle one counts: a bend shows, the noise of one point does not.
NEIGHBOURS = 11

HEADLINES = {
    "good": "Good: this calibration can be trusted",
    "doubtful": "Doubtful: it can be used, but weigh these points first",
    "failed": "Failed: do not correct with this calibration",
    None: "No verdict: the file does not say how good it is",
}
# More pictures than this are not shown, for the page's weight.
MOST_PICTURES = 4


@dataclass(frozen=True)
class Study:
    """A calibration made now: its pictures by name, as its workings count them, and its options."""

    pictures: Sequence[tuple[str, NDArray[Any]]]
    workings: Workings
    spec: CalibrationSpec


def calibration_page(
    name: str,
    calibration: Calibration,
    study: Study | None,
    notes: Sequence[str] = (),
    doubts: Sequence[str] = (),
) -> p.Html:
    """Return the page of a calibration that goes by ``name``.

    ``notes`` are said at the top; without a ``study`` only what the calibration itself holds is shown. With
    ``doubts``, reasons found while the page was made, no calibration is called good.
    """
    model = calibration.model
    parts = [
        _verdict(calibration, doubts),
        *(p.paragraph(p.Html(f"<b>Note:</b> {p.escape(n)}")) for n in notes),
    ]
    reach = _usable_reach(calibration)
    sure = None
    if study is not None and study.workings.evidence is not None:
        lines = min(reach, study.workings.evidence.reach)
        sure = plots.placing(study.workings, model, lines, reach)
    parts.append(p.tiles(_tiles(calibration, reach, None if sure is None else sure[1])))
    if study is not None:
        parts.append(_pictures(calibration, study))
        if study.workings.evidence is not None:
            parts.append(_checks(study.workings))
        if sure is not None:
            parts += [_residuals(study.workings), _sureness(calibration, study.workings, sure[0])]
        parts += found_by(study.workings, study.spec, model)
    parts.append(_origin(calibration))
    w, h = model.size
    return p.page(
        f"Calibration: {name}", *parts, subtitle=f"One lens at one zoom setting, {w}x{h} px"
    )


def _verdict(calibration: Calibration, doubts: Sequence[str]) -> p.Html:
    quality = calibration.quality
    if quality is None:
        return p.verdict("doubtful", HEADLINES[None], doubts)
    verdict = "doubtful" if doubts and quality.verdict == "good" else quality.verdict
    return p.verdict(verdict, HEADLINES[verdict], (*doubts, *quality.reasons))


def _usable_reach(calibration: Calibration) -> float:
    """The distance in px from the centre to the farthest content that the model has a place for."""
    model = calibration.model
    reach = content_radius(model.center, model.size, calibration.boundary, model.pixel_aspect)
    return min(reach, calibration.usable_radius or reach)


def _tiles(
    calibration: Calibration, reach: float, sigma_there: float | None
) -> list[tuple[str, str, str]]:
    model, u, quality = calibration.model, calibration.uncertainty, calibration.quality
    strength = model.lam * reach**2 + model.lam2 * reach**4
    tiles = []
    if quality is not None and quality.rms is not None and quality.rms_before is not None:
        share = quality.outlying_told
        without = f", without {share:.0%} of their points" if share else ""
        before = f"{quality.rms_before:.3g} px before{without}"
        tiles.append(("Lines off straight", f"{quality.rms:.3g} px", before))
    tiles.append(
        (
            "What correction does",
            f"{reach:.0f} → {reach / (1 + strength):.0f} px",
            "the farthest content's distance from the centre",
        )
    )
    if sigma_there is not None:
        tiles.append(("Surely placed to", f"± {sigma_there:.2g} px", "at the outermost lines"))
    tiles.append(("λ, px⁻²", *scientific(model.lam, u.lam if u else None)))
    if model.lam2:
        tiles.append(("λ₂, px⁻⁴", *scientific(model.lam2, u.lam2 if u else None)))
    center = f"{model.center[0]:.2f}, {model.center[1]:.2f}"
    sigma = f"± {u.center[0]:.2g}, {u.center[1]:.2g}" if u else ""
    if u is not None and u.center_given:
        sigma = "given"
    tiles.append(("Distortion centre, px", center, sigma))
    b = calibration.boundary
    circle = "none" if b is None else f"{b.diameter:.1f} px wide"
    tiles.append(
        ("Visible circle", circle, "" if b is None else f"{b.visible:.0%} of its rim seen")
    )
    return tiles


def smoothed(residuals: Floats, labels: Labels) -> Floats:
    """Return the running median of residuals (n,) px along each line."""
    out = np.empty_like(residuals)
    for line in range(int(labels.max()) + 1):
        own = labels == line
        out[own] = median_filter(residuals[own], NEIGHBOURS, mode="mirror")
    return out


def _pictures(calibration: Calibration, study: Study) -> p.Html:
    """Each picture with its lines coloured by residual, and corrected."""
    model, scene, refined = calibration.model, study.workings.scene, study.workings.refined
    used = sorted({view.picture for view in scene.views})
    unit = max(1.0, min(scene.square_size) / 540)
    steps = unit * np.array(STEPS)
    smooth = None if refined is None else smoothed(refined.fit.residuals, refined.measured.labels)
    parts = []
    for number in used[:MOST_PICTURES]:
        name, picture = study.pictures[number]
        shown, scale = pictures.to_show(picture, model.pixel_aspect)
        after = pictures.corrected(shown, model)
        aspect = model.pixel_aspect
        x, y = pictures.places(np.array(model.center) * (aspect, 1.0), aspect)
        caption = f"{name} as it was taken. The cross is the distortion centre."
        if refined is not None:
            views = [i for i, view in enumerate(scene.views) if view.picture == number]
            own = np.isin(refined.view, views)
            assert smooth is not None
            classes = np.searchsorted(steps, np.abs(smooth[own]))
            m = refined.measured
            points = pictures.places(m.points[own], aspect)
            shown = pictures.with_lines(shown, scale, points, m.labels[own], classes)
            caption = (
                f"{name}: the lines that were found, coloured by how far they stay from straight after"
                " correction. The cross is the distortion centre."
            )
        before = pictures.as_image(
            pictures.with_mark(shown, (x, y), scale), f"{name} with the lines that were found."
        )
        corrected = pictures.as_image(after, f"{name} after correction.")
        parts.append(
            p.figures(
                p.figure(before, caption),
                p.figure(corrected, "Corrected: what was straight is straight again."),
            )
        )
    if refined is not None:
        words = [
            *(f"straight to {step:.2g} px" for step in steps),
            f"bent by more than {steps[-1]:.2g} px",
        ]
        parts.insert(0, p.key(zip(pictures.LINE_COLOURS, words, strict=True)))
    if len(used) > MOST_PICTURES:
        parts.append(p.paragraph(f"{len(used) - MOST_PICTURES} more pictures are not shown.", True))
    return p.section("Before and after", *parts)


def _checks(workings: Workings) -> p.Html:
    assert workings.evidence is not None
    rows = [
        (
            c.what,
            c.found,
            c.wanted,
            p.Html('<b class="yes">✓ met</b>' if c.met else '<b class="no">✗ not met</b>'),
        )
        for c in checks(workings.evidence)
    ]
    return p.section(
        "What the verdict rests on", p.table(("looked at", "found", "wanted", "outcome"), rows)
    )


def _residuals(workings: Workings) -> p.Html:
    assert workings.refined is not None
    fit, m = workings.refined.fit, workings.refined.measured
    sigma = max(robust_sigma(fit.residuals), 1e-4)
    beyond = float(np.mean(np.abs(fit.residuals) > 5 * sigma))
    svg = plots.residual_map(m.points, fit.residuals, workings.scene.square_size)
    return p.section(
        "What is left",
        p.paragraph(
            "How far the points stay from straight lines after correction. Where the model fits the lens,"
            " this is noise: a bell about zero, and no part of the frame that stands out."
        ),
        p.figures(
            p.figure(
                plots.histogram(fit.residuals, sigma),
                f"Residuals of {len(fit.residuals)} points. {beyond:.1%} lie beyond five standard"
                " deviations: they hardly count, and are not shown.",
            ),
            p.figure(
                svg, "Their usual size over the frame. Where there is no colour there is no point."
            ),
        ),
    )


def _sureness(calibration: Calibration, workings: Workings, placing: p.Html) -> p.Html:
    model = calibration.model
    shown = [
        p.figure(
            placing,
            "How surely a point is placed, worst and best direction (one standard deviation)."
            " Beyond the outermost lines nothing but the model says where it goes.",
        )
    ]
    if workings.scene.prior.fixed:
        words = "The centre was given, not sought: its uncertainty is not known."
    else:
        words = (
            "Both come from the lines themselves: how far what is left of them, as noisy and as alike from"
            " one point to the next and from one line to the next as it is, moves the result."
        )
        ellipses = plots.ellipse(workings, model)
        shown.insert(
            0, p.figure(ellipses, "Where the centre may lie: 1, 2 and 3 standard deviations.")
        )
    return p.section("How sure it is", p.paragraph(words), p.figures(*shown))


def _origin(calibration: Calibration) -> p.Html:
    source, model = calibration.source, calibration.model
    kind = "two parameters (division2)" if model.lam2 else "one parameter (division)"
    rows: list[tuple[str, p.Text]] = [("model", kind)]
    if model.pixel_aspect != 1:
        rows.append(("pixel aspect", f"{model.pixel_aspect:.5g}"))
    if calibration.usable_radius is not None:
        rows.append(("usable up to", f"{calibration.usable_radius:.1f} px from the centre"))
    if source is not None:
        rows.append(("method", source.method + ("" if source.refined else ", not refined")))
        if source.options:
            rows.append(("options", ", ".join(f"{k} = {v}" for k, v in source.options.items())))
        if source.endocal:
            rows.append(("made by", f"endocal {source.endocal}"))
        for image in source.images:
            digest = p.Html(f"<code>{p.escape(image.sha256)}</code>")
            rms = "" if image.rms is None else f", its lines straight to {image.rms:.3f} px"
            rows.append(("picture", p.Html(f"{p.escape(image.file)}{rms}<br>SHA-256 {digest}")))
    return p.section("What it was made from", p.facts(rows))
