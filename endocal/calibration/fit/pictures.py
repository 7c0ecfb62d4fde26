"""How far apart pictures of one lens put it: each by its own lines alone.

A real lens departs from any model, and pictures that show other parts of it, or a sheet that is not quite
flat, tell models that differ. By how much they may is stated with each (see ``uncertainty``): pictures of one
lens at one zoom lie within a few of those standard deviations of each other, whatever the lens.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..straightness import Floats, Labels, root_mean_square
from .measured import Refined, fit_alone
from .plumb_line import Prior, inlying, robust_sigma
from .uncertainty import covariance

# A picture with fewer lines than these tells no model of its own.
FEWEST_LINES = 4


def distances(
    refined: Refined, pictures: Labels, reach: float, prior: Prior, content: float
) -> Floats:
    """How far apart, (p, p) in stated standard deviations, the models are that each picture tells alone.

    ``pictures`` (n,): the picture, from 0 to p - 1, that each measured point is from. A picture that tells no
    model is at a distance of 0 from all.
    """
    count = int(pictures.max()) + 1
    models: list[tuple[Floats, Floats] | None] = []
    for picture in range(count):
        chosen = pictures == picture
        if len(np.unique(refined.measured.labels[chosen])) < FEWEST_LINES:
            models.append(None)
            continue
        fit, lines = fit_alone(refined, chosen, reach, prior, content)
        models.append((fit.params[fit.free], covariance(fit, lines.labels)))
    apart = np.zeros((count, count))
    for i, one in enumerate(models):
        for j, other in enumerate(models[:i]):
            if one is not None and other is not None:
                apart[i, j] = apart[j, i] = _apart(one[0] - other[0], one[1] + other[1])
    return apart


def straightness_alone(
    refined: Refined, chosen: NDArray[np.bool_], reach: float, prior: Prior, content: float
) -> float:
    """How far, px, the ``chosen`` points, those of one picture, are from straight under the model they tell.

    Of lines too few to tell one, under that of all pictures.
    """
    own = refined.fit.residuals[chosen]
    if len(np.unique(refined.measured.labels[chosen])) >= FEWEST_LINES:
        own = fit_alone(refined, chosen, reach, prior, content)[0].residuals
    return root_mean_square(own[inlying(own, robust_sigma(own))])


def strangers(apart: Floats, most: float) -> list[int]:
    """The pictures that lie more than ``most`` from the others, in the median, the strangest first.

    Of two pictures that differ nothing tells which is the stranger: then it is both.
    """
    near = list(range(len(apart)))
    strange: list[int] = []
    while len(near) > 1:
        medians = _medians(apart[np.ix_(near, near)])
        if medians.max() <= most:
            return strange
        strange.append(near.pop(int(medians.argmax())))
    return strange + near if strange else []


def _medians(apart: Floats) -> Floats:
    """Of the distances (p, p), each picture's to the others in the median, (p,)."""
    count = len(apart)
    return np.asarray(np.median(apart[~np.eye(count, dtype=bool)].reshape(count, -1), axis=1))


def _apart(difference: Floats, covariances: Floats) -> float:
    """Mahalanobis's distance."""
    if len(difference) == 0:
        return 0.0
    unit = np.sqrt(np.maximum(np.diag(covariances), 1e-300))
    inverse = np.linalg.pinv(covariances / np.outer(unit, unit), hermitian=True)
    scaled = difference / unit
    return float(np.sqrt(max(float(scaled @ inverse @ scaled), 0.0)))
