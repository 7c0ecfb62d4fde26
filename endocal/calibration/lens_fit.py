"""The refined model of the lens that a scene's lines were seen through: which fit of several is taken."""

from __future__ import annotations

import numpy as np

from ..errors import CalibrationError
from .fit.measured import Refined, departs, fit_again, fit_to_few, told_by_grid
from .fit.refine import best_start, reach_of, refine
from .fit.straightening import straightened
from .scene import Scene
from .spec import CalibrationSpec
from .straightness import Floats, root_mean_square

# Straightness that a model monotonic over all of the content may cost.
ALMOST_AS_STRAIGHT = 1.15
# A second parameter may not fold the picture within so many times the radius that the lines reach.
SEEN = 1.02


def fit_lens(scene: Scene, spec: CalibrationSpec, params: Floats) -> tuple[Refined, float]:
    """Refine the ``params`` (lam, cx, cy) that the search found, in square pixels, on the scene's own lines.

    Returns also the radius in px within which a second parameter may not fold the picture. Raises
    CalibrationError where there are no lines.
    """
    prior, views = scene.prior, scene.views
    reach = reach_of(views, prior.center)
    start = best_start(views, params, reach, prior)
    looks = [] if start is None else refine(views, start, reach, prior)
    if start is None or not looks:
        raise CalibrationError(
            "no straight lines found: a sharp picture of a chessboard or of straight lines that fills"
            " the view is needed"
        )
    refined = looks[0]
    if spec.model == "division":
        if not departs(refined):
            return told_by_grid(refined, reach, 0.0), 0.0
        # A model that follows the lens more closely finds its lines whole.
        content = SEEN * farthest(refined)
        bent = fit_to_few(refined, np.append(refined.fit.params, 0.0), reach, prior, content)
        two = refine(views, bent.params, reach, prior, True, content)
        if two and len(two[0].measured.points) > len(refined.measured.points):
            looks = [fit_again(two[0], refined.fit.params, reach, prior, 0.0), *two[1:], *looks]
        return straightened(looks, reach, prior, 0.0), 0.0
    # Monotonic over the whole content, if that costs no straightness; a lens that sees more than half a
    # sphere has content that no flat picture holds: then as far as the lines reach.
    radii = (scene.content_radius(refined.fit.params[1:3]), SEEN * farthest(refined))
    ends: list[Refined | None] = []
    for radius in radii:
        two = refine(views, start, reach, prior, True, radius)
        if two and departs(two[0]):
            two = [straightened(two, reach, prior, radius, refined.fit.params)]
        ends.append(two[0] if two else None)
    whole, seen = ends
    if whole is not None and (seen is None or _as_straight(whole, seen)):
        best, radius = whole, radii[0]
    elif seen is not None:
        best, radius = seen, radii[1]
    else:
        best, radius = refined, radii[0]
        if departs(refined):
            best = straightened(looks, reach, prior, radius)
    return told_by_grid(best, reach, radius), radius


def _as_straight(one: Refined, other: Refined) -> bool:
    """Whether the first makes straight what the other does, or almost: corners, if both were told by them."""
    if one.corners is None or other.corners is None:
        return one.fit.sigma <= ALMOST_AS_STRAIGHT * other.fit.sigma
    left, least = (root_mean_square(fit.residuals) for fit, _ in (one.corners, other.corners))
    return left <= ALMOST_AS_STRAIGHT * least


def farthest(refined: Refined) -> float:
    """The distance in px of the farthest measured point from the distortion centre."""
    offsets = refined.measured.points - refined.fit.params[1:3]
    return float(np.linalg.norm(offsets, axis=1).max())
