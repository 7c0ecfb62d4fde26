"""Whether a calibration can be trusted: the thresholds, in one place, and the reasons in plain words."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from .fit.uncertainty import NEAR_FOLD
from .result import Quality

# Fewer lines than FAILED_LINES fit anything; fewer than FEW_LINES leave no check.
FAILED_LINES = 4
FEW_LINES = 8
# How far out the lines reach, as a share of the content's radius.
POOR_COVERAGE = 0.45
# One standard deviation of the centre, as a share of the frame's short side, and of lambda, of itself.
WEAK_CENTER = 0.003
# That of the centre as a share of the one that was believed beforehand: what was seen tells next to nothing.
UNKNOWN_CENTER = 0.6
# How far the centre lies from where it is believed to be, in standard deviations of that belief.
ASTRAY, FAILED_ASTRAY = 3.0, 6.0
WEAK_LAMBDA = 0.01
# Lambda at least this many standard deviations from zero; one of them moves the farthest points by no less
# than so many px: a drawing without any noise leaves no residuals to tell it by.
SIGNIFICANT = 3.0
FINEST = 0.001
# Straightness, px of a 540-line frame, that noise and blur do not explain.
ROUGH = 0.6
FAILED_ROUGH = 2.5
# The share of points that do not follow their lines, and have hardly a say. Of 197 random boards that are
# good none has more than 0.11, of good real pictures none more than 0.04; folded sheets and two boards that
# meet have 0.20 to 0.42 where one half alone told the model.
MANY_OUTLYING = 0.15
# How far, px of a 540-line frame, lines stay bent that the model cannot straighten.
BENT = 0.15
# Without a chessboard nothing but straightness says that the lines are lines: it must be good. Bars that are
# told well enough for "good" are straight to 0.13 px; the diagonals into which blur turns small squares, and
# the wavy edges of their sheet, to 0.2 px or more.
FAILED_WITHOUT_BOARD = 0.35
ROUGH_WITHOUT_BOARD = 0.15
# The part of the edge points that the lines explain. Less than the first is chance: a page of text.
FAILED_EXPLAINED = 0.03
LITTLE_EXPLAINED = 0.08
LITTLE_WITHOUT_BOARD = 0.3
# Several pictures: the model that one of them tells alone lies so many stated standard deviations, in the
# median, from those of the others, if it is surely of another lens or zoom, and if it may be. In five sets of
# pictures of real lenses, none quite of the model, it is 7.1 at most, and 9.6 in any three of a set or more;
# where one of them is enlarged by a quarter, that one's is 5.4 to 26, 14 in the median. Of 32 pairs from
# such sets one lies beyond 8, nine beyond 6.
OTHER_LENS, DOUBTED_LENS = 10.0, 8.0


@dataclass(frozen=True)
class Seen:
    """What tells a pattern from what is none; ``rms`` and ``short_side`` in px."""

    rms: float
    short_side: float
    explained: float  # share of edge points on lines
    board: bool  # whether a chessboard was seen

    @property
    def rough(self) -> float:
        """How far points are from straight lines, px of a 540-line frame."""
        return self._scaled(self.rms)

    def _scaled(self, length: float) -> float:
        # In a smaller frame a px is a px.
        return length / max(1.0, self.short_side / 540)


@dataclass(frozen=True)
class Evidence(Seen):
    """What a verdict rests on; lengths in px, shares from 0 to 1."""

    lines: int
    points: int
    rms_before: float
    entropy: float
    lam: float
    lam_sigma: float | None
    center_sigma: float | None  # None where it was given
    center_belief: float  # the same, before any line was seen
    reach: float  # of the measured points, from the distortion centre
    content_radius: float
    fold_radius: float  # of the model
    outlying: float = 0.0  # share of points that do not follow their lines
    bend: float = 0.0  # px that the lines stay bent by, beyond noise
    second: bool = False  # whether the model has two parameters
    second_lost: bool = False  # whether it was to have two, and too few lines held under them
    astray: float = 0.0  # of the centre from the frame's middle, in the prior's standard deviations
    pictures: int = 1
    differing: int = 0  # the picture, from 1, that goes with the others least; 0 if all do

    @property
    def bent(self) -> float:
        """``bend`` in px of a 540-line frame."""
        return self._scaled(self.bend)


@dataclass(frozen=True)
class Objection:
    """A reason against "good", and whether it makes the verdict "failed" rather than "doubtful"."""

    reason: str
    fails: bool = False


def judge(e: Evidence) -> Quality:
    """Return the verdict, with every reason against "good"."""
    kinds = (_of_pictures, _of_lines, _of_bend, _of_pattern, _of_lambda, _of_center, _of_fold)
    objections = [objection for kind in kinds for objection in kind(e)]
    failed = [objection.reason for objection in objections if objection.fails]
    doubts = [objection.reason for objection in objections if not objection.fails]
    verdict = "failed" if failed else "doubtful" if doubts else "good"
    return Quality(
        verdict=verdict,
        reasons=tuple(failed + doubts),
        lines=e.lines,
        points=e.points,
        rms_before=e.rms_before,
        rms=e.rms,
        entropy=e.entropy,
        outlying=e.outlying,
    )


def shows_no_pattern(seen: Seen) -> bool:
    """Whether what look like a picture's lines are surely those of no pattern."""
    return not seen.board and any(objection.fails for objection in _of_pattern(seen))


def _of_pictures(e: Evidence) -> Iterator[Objection]:
    """Whether the pictures are of one lens."""
    if e.differing:
        which = "the two pictures" if e.pictures == 2 else f"the {e.pictures} pictures"
        least = "" if e.pictures == 2 else f", number {e.differing} least"
        yield Objection(
            f"{which} do not go together{least}: of one lens at one zoom? calibrate from each alone"
        )


def _of_lines(e: Evidence) -> Iterator[Objection]:
    """Whether there are enough of them, and far enough out."""
    if e.lines < FAILED_LINES:
        yield Objection(
            f"only {e.lines} straight lines found: show the pattern larger or sharper", fails=True
        )
    elif e.lines < FEW_LINES:
        yield Objection(f"few lines ({e.lines}): show more of the pattern")
    if e.second_lost:
        yield Objection("too few lines hold under two parameters: this is the one-parameter model")
    if e.reach < POOR_COVERAGE * e.content_radius:
        yield Objection(
            f"poor coverage: the lines reach {e.reach / e.content_radius:.0%} of the way to the rim;"
            " fill the view with the pattern"
        )


def _of_bend(e: Evidence) -> Iterator[Objection]:
    """Whether the model makes the lines straight, and all of their points follow them."""
    or_center = ", or the centre that was given is wrong" if e.center_sigma is None else ""
    if e.rough > FAILED_ROUGH:
        yield Objection(
            f"the lines stay {e.rms:.2f} px from straight: the model does not fit them{or_center}",
            fails=True,
        )
    elif e.bent > BENT:
        yield Objection(
            f"residuals above noise: lines stay bent by {e.bend:.2f} px, as this model cannot straighten them"
            + ("" if e.second else "; --model division2 may")
            + or_center
        )
    elif e.rough > (ROUGH if e.board else ROUGH_WITHOUT_BOARD):
        yield Objection(
            f"the edges are noisy: they lie {e.rms:.2f} px from straight lines; a sharper picture tells more"
        )
    if e.outlying > MANY_OUTLYING and not e.differing:
        yield Objection(
            f"{e.outlying:.0%} of the points do not follow their lines, and have hardly a say: is the pattern"
            " flat, and the only one?"
        )


def _of_pattern(e: Seen) -> Iterator[Objection]:
    """Whether the lines are those of a pattern at all."""
    if not e.board and e.rough > FAILED_WITHOUT_BOARD:
        yield Objection(
            f"no chessboard seen, and what look like lines stay {e.rms:.2f} px from straight:"
            " show a chessboard or parallel lines",
            fails=True,
        )
    elif not e.board and e.rough > ROUGH_WITHOUT_BOARD and e.explained < LITTLE_WITHOUT_BOARD:
        yield Objection(
            f"no chessboard seen, and what look like lines are {e.explained:.0%} of the edges and"
            f" {e.rms:.2f} px from straight: show a chessboard or parallel lines",
            fails=True,
        )
    if e.explained < FAILED_EXPLAINED:
        yield Objection(
            f"only {e.explained:.0%} of the edges lie on straight lines: show a chessboard or parallel lines",
            fails=True,
        )
    elif e.explained < (LITTLE_EXPLAINED if e.board else LITTLE_WITHOUT_BOARD):
        yield Objection(
            f"only {e.explained:.0%} of the edges lie on straight lines: is this a pattern?"
        )


def _of_lambda(e: Evidence) -> Iterator[Objection]:
    """Whether lambda is told, and differs from zero."""
    if e.lam_sigma is None:
        return
    relative = e.lam_sigma / abs(e.lam) if e.lam else float("inf")
    if abs(e.lam) < SIGNIFICANT * max(e.lam_sigma, FINEST / max(e.reach, 1.0) ** 3):
        yield Objection("the distortion is within its uncertainty of zero")
        if not e.board and (e.lines < FEW_LINES or e.explained < LITTLE_WITHOUT_BOARD):
            yield Objection(
                "no pattern seen that could tell: show a chessboard or parallel lines", fails=True
            )
    elif relative > WEAK_LAMBDA:
        yield Objection(f"lambda is weakly determined (one standard deviation: {relative:.1%})")


def _of_center(e: Evidence) -> Iterator[Objection]:
    """Whether the centre is told, and lies where one may."""
    if e.center_sigma is not None and e.center_sigma > WEAK_CENTER * e.short_side:
        spread = f"one standard deviation: {e.center_sigma:.1f} px"
        if e.center_sigma > UNKNOWN_CENTER * e.center_belief:
            spread = "it may be anywhere near the middle"
        hint = "tilt the pattern, or show lines in two directions"
        if e.board and e.bend:
            # Which no other pose would mend: what bends the lines together looks like another centre.
            hint = f"a lens or sheet that departs from the model, by {e.bend:.2g} px here, leaves it open"
        yield Objection(f"the centre is weakly determined ({spread}); {hint}")
    if e.astray > FAILED_ASTRAY:
        yield Objection(
            "the centre came out far from the middle of the picture: the lines do not tell it",
            fails=True,
        )
    elif e.astray > ASTRAY:
        yield Objection("the centre lies far from the middle of the picture: was it cropped?")


def _of_fold(e: Evidence) -> Iterator[Objection]:
    """Whether the model folds where something is seen."""
    if e.fold_radius < NEAR_FOLD * e.reach:
        yield Objection(
            f"lambda is at its bound: the model folds at {e.fold_radius:.0f} px, where the lines reach"
            f" {e.reach:.0f} px"
        )
    elif e.fold_radius <= e.content_radius:
        yield Objection(
            f"the model folds at {e.fold_radius:.0f} px, inside the visible content: what lies beyond is"
            " lost" + ("" if e.second else "; try --model division2")
        )
