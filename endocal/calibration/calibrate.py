"""Calibrate a lens from one picture of straight lines, or from several at one setting."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .._version import __version__
from ..boundary.content import content_radius
from ..errors import CalibrationError, InputError
from ..model import DivisionModel
from .fit.measured import (
    MODEL_HOLDS,
    Refined,
    departs,
    departure_from_model,
    fit_again,
    misfit_of_views,
)
from .fit.refine import best_start, reach_of, refine
from .fit.straightening import straightened
from .methods.registry import method_named
from .objective import task_of
from .quality import ALIKE, OTHER_LENS, OUTLYING_PICTURE, Evidence, judge
from .result import Calibration, Quality, Source, Uncertainty
from .scene import Image, Scene, look_at
from .search import Found
from .spec import CalibrationSpec
from .straightness import Floats, residuals, root_mean_square

# A model is used up to this share of the radius at which it folds.
SHORT_OF_FOLD = 0.98
# A fit's share of residuals within which straightness is told, in robust standard deviations.
OUTLYING = 5.0
# Straightness that a model monotonic over all of the content may cost.
ALMOST_AS_STRAIGHT = 1.15
# A second parameter may not fold the picture within so many times the radius that the lines reach.
SEEN = 1.02


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


@dataclass(frozen=True)
class Joint:
    """A calibration of several pictures, and its workings.

    ``rms`` px: the straightness of each picture's lines under the common model, None for one left out;
    ``left_out``: the numbers, from 0, of pictures that do not go with the others, and ``silent`` of those in
    which no line was found.
    """

    calibration: Calibration
    workings: Workings
    rms: tuple[float | None, ...] = ()
    left_out: tuple[int, ...] = ()
    silent: tuple[int, ...] = ()


def calibrate(
    image: Image | Sequence[Image], spec: CalibrationSpec = CalibrationSpec()
) -> Calibration:
    """Calibrate from a picture, or jointly from several of one lens at one zoom setting.

    ``image``: uint8 or uint16 array, (h, w) grey or (h, w, 3) BGR, or a sequence of such of one size.
    The quality's verdict may be "failed": then the model is the best there is and not to be trusted.
    Raises InputError for pictures that cannot be used and CalibrationError where no line is found.
    """
    images = [image] if isinstance(image, np.ndarray) else image
    if not isinstance(images, Sequence) or not all(isinstance(i, np.ndarray) for i in images):
        kind = type(image).__name__
        raise InputError(f"calibrate needs a picture as an array, or several; this is {kind}")
    return calibrate_jointly(images, spec).calibration


def calibrate_jointly(images: Sequence[Image], spec: CalibrationSpec = CalibrationSpec()) -> Joint:
    """Calibrate as ``calibrate`` does, and tell how each picture went with the others."""
    kept = list(range(len(images)))
    silent: list[int] = []
    while True:
        scene = look_at([images[i] for i in kept], spec)
        found = _search(scene, spec)
        if not spec.refine:
            bare = _bare(scene, spec, found)
            return Joint(bare, Workings(scene, found), (None,) * len(images))
        refined, content = _refine(scene, spec, found)
        pictures = _pictures(scene, refined)
        if len(pictures) < len(kept):
            # Without them the circle, too, is that of the others.
            silent += [number for i, number in enumerate(kept) if i not in pictures]
            kept = [kept[i] for i in pictures]
            continue
        fits = _common_and_own(scene, refined, content) if len(pictures) > 1 else []
        worst, misfit = _worst_picture(scene, fits, OTHER_LENS)
        # Of two that differ nothing tells which is wrong.
        if len(pictures) < 3 or misfit <= OUTLYING_PICTURE:
            break
        # What the others show is looked at anew: the circle, too, may have been this one's.
        del kept[worst]
    rms_of = {kept[picture]: _rms_of(scene, refined, picture) for picture in pictures}
    rms = tuple(rms_of.get(i) for i in range(len(images)))
    left_out = tuple(i for i in range(len(images)) if i not in (*kept, *silent))
    stray, misfit = _worst_picture(scene, fits, ALIKE)
    differing = kept[stray] + 1 if misfit > OUTLYING_PICTURE else 0
    calibration, workings = _calibration(scene, spec, found, refined, differing)
    return Joint(calibration, workings, rms, left_out, tuple(sorted(silent)))


def _pictures(scene: Scene, refined: Refined) -> list[int]:
    """The numbers of the pictures in which lines were found."""
    return sorted({scene.views[view].picture for view in np.unique(refined.view)})


def _common_and_own(scene: Scene, refined: Refined, content: float) -> list[tuple[float, float]]:
    """For each view, its residual in px under the common model, and under one of its own."""
    reach = reach_of(scene.views, scene.prior.center)
    return misfit_of_views(refined, reach, scene.prior, content)


def _worst_picture(
    scene: Scene, fits: Sequence[tuple[float, float]], floor: float
) -> tuple[int, float]:
    """The picture that fits the common model worst, and how many times worse than one of its own.

    Residuals of less than ``floor`` px count as that. With no ``fits``, of a single picture, once.
    """
    misfits = [max(common, floor) / max(own, floor) for common, own in fits] or [1.0]
    worst = int(np.argmax(misfits))
    return scene.views[worst].picture, misfits[worst]


def _rms_of(scene: Scene, refined: Refined, picture: int) -> float:
    views = [i for i, view in enumerate(scene.views) if view.picture == picture]
    own = refined.fit.residuals[np.isin(refined.view, views)]
    return root_mean_square(own[np.abs(own) < OUTLYING * max(refined.fit.sigma, 0.02)])


def _search(scene: Scene, spec: CalibrationSpec) -> Found:
    """What the method finds in the article's region, lambda bounded by the visible content."""
    return method_named(spec.method).solve(task_of(scene, spec))


def _entropy(spec: CalibrationSpec, found: Found) -> float | None:
    return found.cost if method_named(spec.method).measure is not None else None


def _bare(scene: Scene, spec: CalibrationSpec, found: Found) -> Calibration:
    """The search's answer as it is, for comparisons with the article."""
    model = _model(scene, spec, found.params)
    quality = Quality(
        "doubtful",
        ("not refined: the search alone cannot tell how good its answer is",),
        points=sum(len(view.edges) for view in scene.views),
        entropy=_entropy(spec, found),
    )
    return _with_usable_radius(Calibration(model, None, scene.boundary, quality, _source(spec)))


def _refine(scene: Scene, spec: CalibrationSpec, found: Found) -> tuple[Refined, float]:
    """The refined model, and the radius in px within which a second parameter may not fold it."""
    prior, views = scene.prior, scene.views
    reach = reach_of(views, prior.center)
    start = best_start(views, found.params, reach, prior)
    looks = [] if start is None else refine(views, start, reach, prior)
    if start is None or not looks:
        raise CalibrationError(
            "no straight lines found: a sharp picture of a chessboard or of straight lines that fills"
            " the view is needed"
        )
    refined = looks[0]
    if spec.model == "division":
        if not departs(refined):
            return refined, 0.0
        # A model that follows the lens more closely finds its lines whole.
        two = refine(views, start, reach, prior, True, SEEN * _farthest(refined))
        if two and len(two[0].measured.points) > len(refined.measured.points):
            looks = [fit_again(two[0], refined.fit.params, reach, prior, 0.0), *two[1:]]
        return straightened(looks, reach, prior, 0.0), 0.0
    # Monotonic over the whole content, if that costs no straightness; a lens that sees more than half a
    # sphere has content that no flat picture holds: then as far as the lines reach.
    radii = (scene.content_radius(start[1:3]), SEEN * _farthest(refined))
    whole, seen = (refine(views, start, reach, prior, True, radius) for radius in radii)
    if not seen or (whole and whole[0].fit.sigma <= ALMOST_AS_STRAIGHT * seen[0].fit.sigma):
        chosen, radius = whole or looks, radii[0]
    else:
        chosen, radius = seen, radii[1]
    if not departs(chosen[0]):
        return chosen[0], radius
    single = None if chosen is looks else refined.fit.params
    return straightened(chosen, reach, prior, radius, single), radius


def _farthest(refined: Refined) -> float:
    """The distance in px of the farthest measured point from the distortion centre."""
    offsets = refined.measured.points - refined.fit.params[1:3]
    return float(np.linalg.norm(offsets, axis=1).max())


def _calibration(
    scene: Scene, spec: CalibrationSpec, found: Found, refined: Refined, differing: int
) -> tuple[Calibration, Workings]:
    fit = refined.fit
    full = refined.covariance
    sigmas = np.sqrt(np.maximum(np.diag(full), 0))
    model = _model(scene, spec, fit.params)
    uncertainty = Uncertainty(
        float(sigmas[0]),
        (float(sigmas[1]) / spec.pixel_aspect, float(sigmas[2])),
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
    radius = _farthest(refined)
    # Two parameters balance each other: what counts is the bending they make together, well outside.
    mix = np.zeros(len(fit.params))
    mix[0] = 1.0
    if len(mix) > 3:
        mix[3] = 0.5 * radius**2
    departure = departure_from_model(fit, m.labels)
    inlying = np.abs(fit.residuals) < OUTLYING * max(fit.sigma, 0.02)
    before = residuals(m.points, m.labels, np.array([0.0, *fit.params[1:3]]), sides=m.sides)
    return Evidence(
        lines=int(m.labels.max()) + 1,
        points=len(m.points),
        rms_before=root_mean_square(before[inlying]),
        rms=root_mean_square(fit.residuals[inlying]),
        entropy=entropy,
        lam=float(mix @ fit.params),
        lam_sigma=float(np.sqrt(max(float(mix @ covariances @ mix), 0.0))),
        center_sigma=float(np.sqrt(max(float(covariances[1, 1] + covariances[2, 2]), 0.0))),
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
            (params[1] / spec.pixel_aspect, params[2]),
            scene.size,
            spec.pixel_aspect,
            params[3] if len(params) > 3 else 0.0,
        )
    except InputError as error:
        raise CalibrationError(
            f"what look like lines tell no lens ({error}): show a chessboard or parallel lines"
        ) from error


def _source(spec: CalibrationSpec) -> Source:
    return Source(method=spec.method, refined=spec.refine, endocal=__version__)
