"""What is told of a lens that was found: the model, how sure it is, the verdict, and what they rest on."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .._version import __version__
from ..boundary.content import content_radius
from ..errors import CalibrationError, InputError
from ..model import DivisionModel
from .fit.measured import MODEL_HOLDS, Refined, departure_from_model
from .fit.plumb_line import inlying
from .fit.refine import reach_of
from .fit.valley import with_valley
from .lens_fit import farthest
from .methods.registry import method_named
from .quality import Evidence, judge
from .result import Calibration, Quality, Source, Uncertainty
from .scene import Scene
from .search import Found
from .spec import CalibrationSpec
from .straightness import Floats, residuals, root_mean_square

# A model is used up to this share of the radius at which it folds.
SHORT_OF_FOLD = 0.98


@dataclass(frozen=True)
class Workings:
    """What a calibration rests on, for those who want to look at it; in square pixels.

    ``scene``: the pictures' edges; ``found``: the search's answer. Without refinement the rest is None:
    ``refined``: the measured points on lines, and their residuals; ``covariance`` (k, k) of the model's
    parameters, with zeros for one that was given; ``evidence``: what the verdict weighs.
    """

    scene: Scene
    found: Found
    refined: Refined | None = None
    covariance: Floats | None = None
    evidence: Evidence | None = None


def bare_outcome(scene: Scene, spec: CalibrationSpec, found: Found) -> Calibration:
    """The search's answer as it is, for comparisons with the article."""
    model = _model(scene, spec, found.params)
    quality = Quality(
        "doubtful",
        ("not refined: the search alone cannot tell how good its answer is",),
        points=sum(len(view.edges) for view in scene.views),
        entropy=_entropy(spec, found),
    )
    return _with_usable_radius(Calibration(model, None, scene.boundary, quality, _source(spec)))


def outcome(
    scene: Scene,
    spec: CalibrationSpec,
    found: Found,
    refined: Refined,
    content: float,
    differing: int,
) -> tuple[Calibration, Workings]:
    """What the refined model is worth: the calibration with its uncertainty and verdict, and the workings.

    ``content``: the radius in px within which a second parameter may not fold the picture; ``differing``: the
    picture, from 1, that goes with the others least; 0 if all do.
    """
    fit = refined.fit
    reach = reach_of(scene.views, scene.prior.center)
    full = with_valley(refined, refined.covariance, reach, scene.prior, content)
    sigmas = np.sqrt(np.maximum(np.diag(full), 0))
    model = _model(scene, spec, fit.params)
    uncertainty = Uncertainty(
        float(sigmas[0]),
        (float(sigmas[1]) / spec.aspect, float(sigmas[2])),
        float(sigmas[3]) if len(sigmas) > 3 else None,
    )
    evidence = replace(
        _evidence(scene, refined, model, full, found.cost),
        differing=differing,
        second_lost=spec.model == "division2" and len(fit.params) == 3,
    )
    quality = replace(judge(evidence), entropy=_entropy(spec, found))
    calibration = _with_usable_radius(
        Calibration(model, uncertainty, scene.boundary, quality, _source(spec))
    )
    return calibration, Workings(scene, found, refined, full, evidence)


def _evidence(
    scene: Scene,
    refined: Refined,
    model: DivisionModel,
    covariances: Floats,
    entropy: float,
) -> Evidence:
    fit, m = refined.fit, refined.measured
    radius = farthest(refined)
    # Two parameters balance each other: what counts is the bending they make together, well outside.
    mix = np.zeros(len(fit.params))
    mix[0] = 1.0
    if len(mix) > 3:
        mix[3] = 0.5 * radius**2
    departure = departure_from_model(fit, m.labels)
    close = inlying(fit.residuals, fit.sigma)
    before = residuals(m.points, m.labels, np.array([0.0, *fit.params[1:3]]), sides=m.sides)
    return Evidence(
        lines=int(m.labels.max()) + 1,
        points=len(m.points),
        rms_before=root_mean_square(before[close]),
        rms=root_mean_square(fit.residuals[close]),
        outlying=1 - float(close.mean()),
        entropy=entropy,
        lam=float(mix @ fit.params),
        lam_sigma=float(np.sqrt(max(float(mix @ covariances @ mix), 0.0))),
        center_sigma=None
        if scene.prior.fixed
        else float(np.sqrt(max(float(covariances[1, 1] + covariances[2, 2]), 0.0))),
        center_belief=float(np.hypot(*scene.prior.spread)),
        reach=radius,
        content_radius=scene.content_radius(fit.params[1:3]),
        fold_radius=model.valid_radius,
        short_side=min(scene.square_size),
        explained=len(m.points) / max(sum(view.edge_length for view in scene.views), 1),
        board=refined.board,
        pictures=len({view.picture for view in scene.views}),
        bend=departure.bend if departure.ratio > MODEL_HOLDS else 0.0,
        second=len(fit.params) > 3,
        astray=_astray(scene, fit.params),
    )


def _entropy(spec: CalibrationSpec, found: Found) -> float | None:
    return found.cost if method_named(spec.method).measure is not None else None


def _with_usable_radius(calibration: Calibration) -> Calibration:
    """Say how far the model holds where its fold lies inside the frame's or the circle's content."""
    model = calibration.model
    reach = content_radius(model.center, model.size, calibration.boundary, model.pixel_aspect)
    if model.valid_radius > reach:
        return calibration
    return replace(calibration, usable_radius=SHORT_OF_FOLD * model.valid_radius)


def _astray(scene: Scene, params: Floats) -> float:
    """How far the centre lies from the middle, in standard deviations of what was believed of it."""
    if scene.prior.fixed:
        return 0.0
    away = (params[1:3] - scene.prior.center) / np.array(scene.prior.spread)
    return float(np.abs(away).max())


def _model(scene: Scene, spec: CalibrationSpec, params: Floats) -> DivisionModel:
    try:
        return DivisionModel(
            params[0],
            (params[1] / spec.aspect, params[2]),
            scene.size,
            spec.aspect,
            params[3] if len(params) > 3 else 0.0,
        )
    except InputError as error:
        raise CalibrationError(
            f"what look like lines tell no lens ({error}): show a chessboard or parallel lines"
        ) from error


def _source(spec: CalibrationSpec) -> Source:
    return Source(method=spec.method, refined=spec.refine, endocal=__version__)
