"""Calibrate a lens from one picture of straight lines, or from several at one setting."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import InputError
from .fit.measured import Refined
from .fit.pictures import distances, straightness_alone, strangers
from .fit.plumb_line import inlying, robust_sigma
from .fit.refine import reach_of
from .lens_fit import fit_lens
from .methods.registry import method_named
from .objective import task_of
from .outcome import Workings, bare_outcome, outcome
from .quality import DOUBTED_LENS, OTHER_LENS, Seen, shows_no_pattern
from .result import Calibration
from .scene import Image, Scene, look_at
from .search import Found
from .spec import CalibrationSpec
from .straightness import Floats, root_mean_square


@dataclass(frozen=True)
class Joint:
    """A calibration of several pictures, and its workings.

    ``rms`` px: the straightness of each picture's lines under the common model, None for one left out;
    ``left_out``: the numbers, from 0, of pictures that do not go with the others, and ``silent`` of those in
    which no line was found, or none of a pattern where others show one.
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
            bare = bare_outcome(scene, spec, found)
            return Joint(bare, Workings(scene, found), (None,) * len(images))
        refined, content = fit_lens(scene, spec, found.params)
        pictures = _telling(scene, refined, content)
        if len(pictures) < len(kept):
            # Without them the circle, too, is that of the others.
            silent += [number for i, number in enumerate(kept) if i not in pictures]
            kept = [kept[i] for i in pictures]
            continue
        apart = _apart(scene, refined, content)
        strange = strangers(apart, OTHER_LENS)
        alike = len(kept) - len(strange)
        # Where no more of them are alike than are strange, nothing tells which are wrong.
        if not strange or alike <= len(images) - len(silent) - alike:
            break
        # What the others show is looked at anew: the circle, too, may have been that of these.
        kept = [number for i, number in enumerate(kept) if i not in strange]
    rms_of = {kept[picture]: _rms_of(scene, refined, picture) for picture in pictures}
    rms = tuple(rms_of.get(i) for i in range(len(images)))
    left_out = tuple(i for i in range(len(images)) if i not in (*kept, *silent))
    doubted = strangers(apart, DOUBTED_LENS)
    differing = kept[doubted[0]] + 1 if doubted else 0
    calibration, workings = outcome(scene, spec, found, refined, content, differing)
    return Joint(calibration, workings, rms, left_out, tuple(sorted(silent)))


def _search(scene: Scene, spec: CalibrationSpec) -> Found:
    """What the method finds in the article's region, lambda bounded by the visible content."""
    return method_named(spec.method).solve(task_of(scene, spec))


def _pictures(scene: Scene, refined: Refined) -> list[int]:
    """The numbers of the pictures in which lines were found."""
    return sorted({scene.views[view].picture for view in np.unique(refined.view)})


def _telling(scene: Scene, refined: Refined, content: float) -> list[int]:
    """The numbers of the pictures with lines that may be a pattern's; where none has, of all with lines."""
    pictures = _pictures(scene, refined)
    if len(pictures) == 1:
        return pictures
    telling = [p for p in pictures if not shows_no_pattern(_seen(scene, refined, content, p))]
    return telling or pictures


def _seen(scene: Scene, refined: Refined, content: float, picture: int) -> Seen:
    """What a picture shows by the lines that all pictures' fit measured in it, under the model they tell."""
    views = _views(scene, picture)
    chosen = np.isin(refined.view, views)
    reach = reach_of(scene.views, scene.prior.center)
    return Seen(
        rms=straightness_alone(refined, chosen, reach, scene.prior, content),
        short_side=min(scene.square_size),
        explained=float(chosen.sum()) / max(sum(scene.views[v].edge_length for v in views), 1),
        board=not refined.boards.isdisjoint(views),
    )


def _apart(scene: Scene, refined: Refined, content: float) -> Floats:
    """How far apart, (p, p) in stated standard deviations, the pictures put the lens."""
    pictures = np.array([view.picture for view in scene.views])[refined.view]
    count = int(pictures.max()) + 1
    if count == 1:
        return np.zeros((1, 1))
    return distances(
        refined, pictures, reach_of(scene.views, scene.prior.center), scene.prior, content
    )


def _rms_of(scene: Scene, refined: Refined, picture: int) -> float:
    own = refined.fit.residuals[np.isin(refined.view, _views(scene, picture))]
    # A picture that goes with the others badly is judged by its own points: they are not its outliers.
    return root_mean_square(own[inlying(own, max(refined.fit.sigma, robust_sigma(own)))])


def _views(scene: Scene, picture: int) -> list[int]:
    return [i for i, view in enumerate(scene.views) if view.picture == picture]
