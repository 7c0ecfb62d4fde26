"""What is to be concluded from a picture that tells zoom and approach only so well."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Late(NamedTuple):
    """What the last steps say together of zoom and approach, per s, as a ``ScaleStep`` has it.

    It is as good as ``steps`` of them with errors of their own; ``lasting`` is which part is shared by all.
    """

    information: NDArray[np.float64]
    target: NDArray[np.float64]
    steps: float
    lasting: float


class Weighed(NamedTuple):
    """A hypothesis: whether the zoom moves, its evidence, and what it says of zoom and hand."""

    moves: bool
    evidence: float
    zoom: float
    hand: float
    variance: float


def explain(
    information: NDArray[np.float64], target: NDArray[np.float64], expected: NDArray[np.float64]
) -> tuple[tuple[NDArray[np.float64], NDArray[np.float64]], float]:
    """Return the posterior mean and covariance before ``expected`` deviations (n,), and the log evidence.

    The picture says ``information`` (n, n) @ what is sought = ``target`` (n,).
    """
    covariance = np.asarray(np.linalg.inv(information + np.diag(expected**-2.0)), np.float64)
    found = covariance @ target
    shrunk = float(np.linalg.slogdet(covariance)[1]) - 2 * float(np.log(expected).sum())
    return (found, covariance), (shrunk + float(target @ found)) / 2


def mixed(information: NDArray[np.float64], mistake: float) -> NDArray[np.float64]:
    """Add to what is known that zoom may pass for approach, and the reverse, by a ``mistake`` per s."""
    along = information @ np.array([1.0, -1.0])
    loss = np.outer(along, along) / (mistake**-2.0 + along[0] - along[1])
    return np.asarray(information - loss)
