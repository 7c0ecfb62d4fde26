"""What a calibration's page shows of the search: its entropies, and the votes that they are those of."""

from __future__ import annotations

from ..calibration.methods.registry import method_named
from ..calibration.outcome import Workings
from ..calibration.spec import CalibrationSpec
from ..model import DivisionModel
from . import calibration_plots as plots
from . import page as p


def found_by(workings: Workings, spec: CalibrationSpec, model: DivisionModel) -> list[p.Html]:
    """Return the sections about the search that led to the ``model``, and about its votes."""
    return [_search(workings, spec, model), _votes(workings, spec, model)]


def _search(workings: Workings, spec: CalibrationSpec, model: DivisionModel) -> p.Html:
    method = method_named(spec.method)
    words = (
        f"The search minimises the entropy of the edge points' votes ({spec.method}): the fewer places"
        " they agree on, the straighter the lines. "
    )
    if method.measure is None:
        words = (
            f"The method {spec.method} ({method.title}) takes the place of the search; what is drawn is the"
            " entropy of the edge points' votes (hewg) all the same. "
        )
    words += (
        "That is a start; the refinement on the lines themselves gives the result."
        if workings.refined is not None
        else "Its answer was not refined."
    )
    shown = [
        p.figure(
            plots.entropy_over_lambda(workings, spec, model),
            "Entropy over λ, with the centre of the result.",
        )
    ]
    if not workings.scene.prior.fixed:
        shown.append(
            p.figure(
                plots.entropy_over_center(workings, spec, model),
                "Entropy over the centre, with the λ of the result: the stronger the colour, the lower.",
            )
        )
    return p.section("The search", p.paragraph(words), p.figures(*shown))


def _votes(workings: Workings, spec: CalibrationSpec, model: DivisionModel) -> p.Html:
    h1_before, h1_after, h2_before, h2_after = plots.vote_plots(workings, spec, model)
    return p.section(
        "The votes",
        p.paragraph(
            "H1: each edge point votes for the line through it, by its direction and distance. A bent line"
            " smears its votes; a straight one gathers them in one place. H2: each line votes for the points"
            " where it may meet others, along a curve. The curves of lines that are parallel on the board"
            " cross in one place, their vanishing point; that they all pass one more place, where ω points"
            " from the picture's corner to its middle, means nothing."
        ),
        p.figures(
            p.figure(h1_before, "H1 before correction."),
            p.figure(h1_after, "H1 after correction."),
            p.figure(h2_before, "H2 before correction."),
            p.figure(h2_after, "H2 after correction."),
        ),
    )
