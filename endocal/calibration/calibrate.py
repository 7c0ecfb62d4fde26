"""Calibrate a lens from one picture of straight lines, or from several at one setting."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from .._version import __version__
from ..boundary.circle import Boundary
from ..boundary.content import content_radius
from ..boundary.detect import find_boundary
from ..errors import CalibrationError, InputError
from ..model import DivisionModel
from .content import content_mask
from .edges import EdgePoints, find_edges, sobel_gradients
from .fit import Prior, covariance
from .hough import Voters
from .measures import measure_named
from .picture import Grey, Mask, Picture, fields, to_grey
from .quality import Evidence, judge
from .refine import Refined, View, best_start, reach_of, refine
from .result import Calibration, Quality, Source, Uncertainty
from .search import Found, Region, search
from .spec import CalibrationSpec
from .straightness import Floats, residuals

Image = NDArray[np.uint8] | NDArray[np.uint16]

# Edges are sought on a picture of at most so many pixels; they are measured on the full one.
MOST_PIXELS = 2_500_000
# Algorithm 1 votes with at most so many points, drawn evenly; fewer where it only finds a start.
MOST_VOTERS = 16_000
MOST_VOTERS_FOR_START = 5_000
# The search ends where lambda is as good as zero, px^-2 (METHOD: [-1 / r_max^2, -1e-7]).
SMALLEST_LAMBDA = -1e-7
# A model is used up to this share of the radius at which it folds.
SHORT_OF_FOLD = 0.98
# A fit's share of residuals within which straightness is told, in robust standard deviations.
OUTLYING = 5.0


@dataclass(frozen=True)
class _Scene:
    """Everything that is known of the pictures before a model is sought, in square pixels."""

    views: list[View]
    boundary: Boundary | None
    size: tuple[int, int]  # of the frame, in its own pixels
    square_size: tuple[float, float]
    prior: Prior
    content: Mask  # of all pictures together

    def content_radius(self, center: Floats) -> float:
        """The distance from ``center`` to the farthest pixel where edges were looked for, px."""
        y, x = np.nonzero(self.content[::4, ::4])
        aspect = self.square_size[0] / self.size[0]
        return float(np.hypot(4 * x * aspect - center[0], 4 * y - center[1]).max())


def calibrate(
    image: Image | Sequence[Image], spec: CalibrationSpec = CalibrationSpec()
) -> Calibration:
    """Calibrate from a picture, or jointly from several of one lens at one zoom setting.

    ``image``: uint8 or uint16 array, (h, w) grey or (h, w, 3) BGR, or a sequence of such of one size.
    The quality's verdict may be "failed": then the model is the best there is and not to be trusted.
    Raises InputError for pictures that cannot be used and CalibrationError where no line is found.
    """
    images = [image] if isinstance(image, np.ndarray) else list(image)
    scene = _look_at(images, spec)
    found = _search(scene, spec)
    if not spec.refine:
        return _bare(scene, spec, found)
    return _refined(scene, spec, found)


def _look_at(images: Sequence[Image], spec: CalibrationSpec) -> _Scene:
    if not images:
        raise InputError("no picture to calibrate from")
    if len({image.shape[:2] for image in images}) > 1:
        raise InputError("the pictures differ in size: all must be of one lens at one setting")
    h, w = images[0].shape[:2]
    views, boundaries = [], []
    everywhere = np.zeros((h, w), bool)
    for number, image in enumerate(images):
        grey = to_grey(image)
        boundary = find_boundary(np.rint(grey).astype(np.uint8), spec.pixel_aspect)
        boundaries.append(boundary)
        content = content_mask(grey, boundary, spec.pixel_aspect, spec.roi)
        everywhere |= content
        for field in fields(grey):
            edges = _edges(Picture(field, content), spec.pixel_aspect)
            views.append(View(_square(field, spec.pixel_aspect), edges, number))
    if sum(len(view.edges) for view in views) < 50:
        raise CalibrationError(
            "no edges found: a sharp, evenly lit picture of a chessboard or of straight lines is needed"
        )
    views = [view for view in views if len(view.edges) > 0]
    square = (w * spec.pixel_aspect, float(h))
    return _Scene(views, _widest(boundaries), (w, h), square, _prior(spec, square), everywhere)


def _edges(picture: Picture, pixel_aspect: float) -> EdgePoints:
    """Edge points in square pixels, sought on a smaller picture where this one is very large."""
    h, w = picture.grey.shape
    step = int(np.ceil(np.sqrt(h * w / MOST_PIXELS)))
    if step > 1:
        size = (w // step, h // step)
        grey = cv2.resize(
            picture.grey[: size[1] * step, : size[0] * step], size, interpolation=cv2.INTER_AREA
        )
        picture = Picture(
            np.asarray(grey, np.float32),
            picture.content[: size[1] * step : step, : size[0] * step : step],
        )
    edges = find_edges(picture)
    points = (edges.points + 0.5) * step - 0.5
    gradients = edges.gradients / (pixel_aspect, 1.0)
    gradients /= np.maximum(np.linalg.norm(gradients, axis=1), 1e-12)[:, None]
    return EdgePoints(points * (pixel_aspect, 1.0), gradients)


def _square(grey: Grey, pixel_aspect: float) -> Grey:
    """Stretch a picture so that its pixels are square; the first pixel's centre stays in place."""
    if pixel_aspect == 1:
        return grey
    h, w = grey.shape
    size = (round((w - 1) * pixel_aspect) + 1, h)
    stretch = np.array([[pixel_aspect, 0, 0], [0, 1, 0]], np.float64)
    return np.asarray(
        cv2.warpAffine(grey, stretch, size, flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE),
        np.float32,
    )


def _widest(boundaries: Sequence[Boundary | None]) -> Boundary | None:
    """The boundary seen best; the pictures share one."""
    seen = [b for b in boundaries if b is not None]
    return max(seen, key=lambda b: b.visible) if seen else None


def _prior(spec: CalibrationSpec, square: tuple[float, float]) -> Prior:
    """The article's region for the centre, 0.1 W x 0.1 H, as two standard deviations either way."""
    middle = ((square[0] - 1) / 2, (square[1] - 1) / 2)
    spread = (square[0] * spec.center_region / 2, square[1] * spec.center_region / 2)
    if spec.center == "free":
        return Prior(middle, spread)
    if isinstance(spec.center, tuple):
        return Prior((spec.center[0] * spec.pixel_aspect, spec.center[1]), (0.0, 0.0))
    return Prior(middle, (0.0, 0.0))


def _search(scene: _Scene, spec: CalibrationSpec) -> Found:
    """Algorithm 1 over the article's region, lambda bounded by the visible content."""
    reach = reach_of(scene.views, scene.prior.center)
    measure = measure_named(spec.method)
    voters = [_voters(view, spec, scene.square_size[1]) for view in scene.views]
    x, y = scene.prior.center
    dx, dy = scene.prior.spread
    region = Region((-1 / reach**2, SMALLEST_LAMBDA), (x - dx, x + dx), (y - dy, y + dy))

    def cost(lams: Floats, xs: Floats, ys: Floats) -> Floats:
        return np.mean([measure(v, lams, xs, ys) for v in voters], axis=0)

    return search(cost, region, spec.samples, spec.epsilon, spec.max_rounds)


def _voters(view: View, spec: CalibrationSpec, frame_height: float) -> Voters:
    edges = view.edges
    gradients = sobel_gradients(view.grey, edges.points, spec.sobel)
    most = MOST_VOTERS_FOR_START if spec.refine else MOST_VOTERS
    if len(edges) > most:
        chosen = np.random.default_rng(0).permutation(len(edges))[:most]
        edges, gradients = edges.take(chosen), gradients[chosen]
    return Voters.of(edges.points, gradients, frame_height)


def _bare(scene: _Scene, spec: CalibrationSpec, found: Found) -> Calibration:
    """The search's answer as it is, for comparisons with the article."""
    model = _model(scene, spec, found.params)
    quality = Quality(
        "doubtful",
        ("not refined: the search alone cannot tell how good its answer is",),
        points=sum(len(view.edges) for view in scene.views),
        entropy=found.cost,
    )
    return _with_usable_radius(Calibration(model, None, scene.boundary, quality, _source(spec)))


def _refined(scene: _Scene, spec: CalibrationSpec, found: Found) -> Calibration:
    prior, views = scene.prior, scene.views
    reach = reach_of(views, prior.center)
    start = best_start(views, found.params, reach, prior)
    refined = None
    if start is not None:
        refined = refine(views, start, reach, prior, second=spec.model == "division2")
    if refined is None:
        raise CalibrationError(
            "no straight lines found: a sharp picture of a chessboard or of straight lines that fills"
            " the view is needed"
        )
    fit = refined.fit
    sigmas = np.zeros(len(fit.params))
    sigmas[fit.free] = np.sqrt(np.maximum(np.diag(covariance(fit, refined.measured.labels)), 0))
    model = _model(scene, spec, fit.params)
    uncertainty = Uncertainty(
        float(sigmas[0]),
        (float(sigmas[1]) / spec.pixel_aspect, float(sigmas[2])),
        float(sigmas[3]) if len(sigmas) > 3 else None,
    )
    evidence = _evidence(scene, spec, refined, model, sigmas, found.cost)
    return _with_usable_radius(
        Calibration(model, uncertainty, scene.boundary, judge(evidence), _source(spec))
    )


def _evidence(
    scene: _Scene,
    spec: CalibrationSpec,
    refined: Refined,
    model: DivisionModel,
    sigmas: Floats,
    entropy: float,
) -> Evidence:
    fit, m = refined.fit, refined.measured
    inlying = np.abs(fit.residuals) < OUTLYING * max(fit.sigma, 0.02)
    before = residuals(m.points, m.labels, np.array([0.0, *fit.params[1:3]]), sides=m.sides)
    return Evidence(
        lines=int(m.labels.max()) + 1,
        points=len(m.points),
        rms_before=_rms(before[inlying]),
        rms=_rms(fit.residuals[inlying]),
        entropy=entropy,
        lam=fit.params[0],
        lam_sigma=float(sigmas[0]),
        center_sigma=float(np.hypot(sigmas[1], sigmas[2])),
        reach=float(np.linalg.norm(m.points - fit.params[1:3], axis=1).max()),
        content_radius=scene.content_radius(fit.params[1:3]),
        fold_radius=model.valid_radius,
        short_side=min(scene.square_size),
        explained=len(m.points) / max(sum(len(view.edges) for view in scene.views), 1),
        board=refined.board,
    )


def _with_usable_radius(calibration: Calibration) -> Calibration:
    """Say how far the model holds where its fold lies inside the frame's or the circle's content."""
    model = calibration.model
    reach = content_radius(model.center, model.size, calibration.boundary, model.pixel_aspect)
    if model.valid_radius > reach:
        return calibration
    return replace(calibration, usable_radius=SHORT_OF_FOLD * model.valid_radius)


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2))) if len(values) else 0.0


def _model(scene: _Scene, spec: CalibrationSpec, params: Floats) -> DivisionModel:
    return DivisionModel(
        params[0],
        (params[1] / spec.pixel_aspect, params[2]),
        scene.size,
        spec.pixel_aspect,
        params[3] if len(params) > 3 else 0.0,
    )


def _source(spec: CalibrationSpec) -> Source:
    return Source(method=spec.method, refined=spec.refine, endocal=__version__)
