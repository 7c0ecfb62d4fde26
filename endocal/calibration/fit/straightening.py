"""The last fit for a lens that departs from the model: by its board's corners, from all looks at them."""

from __future__ import annotations

from collections.abc import Sequence

from ..board.crossings import corners_of
from ..board.union import united
from ..straightness import Floats, Labels, root_mean_square
from .corner_fit import fit_corners, fit_corners_from_one, tell_apart
from .measured import Refined, magnified, told_by_corners
from .plumb_line import Fit, Prior

# A two-parameter fit that is found by way of the one-parameter one is taken where the other is so many times
# less straight: it may lie nearer to the pole, and farther from the lens.
MUCH_STRAIGHTER = 1.5


def straightened(
    looks: Sequence[Refined],
    reach: float,
    prior: Prior,
    content: float,
    single: Floats | None = None,
) -> Refined:
    """Fit the first of ``looks`` again, by how straight the board's corners are in the corrected picture.

    The others are the same pictures measured under other models. A two-parameter model, kept from folding
    within ``content`` px, is sought from the one-parameter model ``single`` (lam, cx, cy), too.
    """
    refined = looks[0]
    params = refined.fit.params
    boards = [
        united([corners_of(look.measured.take(look.view == view)) for look in looks], params[1:3])
        for view in range(int(refined.view.max()) + 1)
    ]
    corners = fit_corners(boards, params, prior, content)
    if corners is None:
        return magnified(refined, reach, prior, content)
    if single is not None:
        other = fit_corners_from_one(boards, single, prior, content)
        if other is not None and _rms(corners) > MUCH_STRAIGHTER * _rms(other):
            corners = other
    if not tell_apart(boards, corners, params):
        return refined
    return told_by_corners(refined, corners, reach, prior, content)


def _rms(corners: tuple[Fit, Labels]) -> float:
    return root_mean_square(corners[0].residuals)
