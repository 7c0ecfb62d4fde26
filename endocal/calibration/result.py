"""What a calibration is: the model, how sure it is, and where it came from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ..boundary.circle import Boundary
from ..model import DivisionModel

VERDICTS = ("good", "doubtful", "failed")
# Less than this share of points that do not follow their lines is as usual: corners, glare, a line missed.
FEW_OUTLYING = 0.05


@dataclass(frozen=True)
class Uncertainty:
    """One standard deviation of each parameter: px^-2, px, and px^-4 for the two-parameter model.

    That of a centre that was given is 0: it is taken as it is.
    """

    lam: float
    center: tuple[float, float]
    lam2: float | None = None

    @property
    def center_given(self) -> bool:
        """Whether the centre was given rather than sought: how sure it is is not known."""
        return max(self.center) == 0


@dataclass(frozen=True)
class Quality:
    """Whether the calibration can be trusted, and the numbers behind that.

    ``verdict`` is one of VERDICTS; ``rms_before`` and ``rms`` are the straightness of the found lines in
    distorted pixels, without and with the model, over the points that follow their lines; ``outlying`` is the
    share, 0 to 1, of those that do not; ``entropy`` is that of the vote map (eq. 6).
    """

    verdict: str
    reasons: tuple[str, ...] = ()
    lines: int = 0
    points: int = 0
    rms_before: float | None = None
    rms: float | None = None
    entropy: float | None = None
    outlying: float = 0.0

    @property
    def outlying_told(self) -> float | None:
        """The share ``outlying`` where it is not as small as usual."""
        return self.outlying if self.outlying >= FEW_OUTLYING else None


@dataclass(frozen=True)
class SourceImage:
    """A picture that went in: its bare file name, the SHA-256 of its bytes, its lines' straightness, px."""

    file: str
    sha256: str
    rms: float | None = None


@dataclass(frozen=True)
class Source:
    """How the calibration was made.

    ``options`` are the fields of CalibrationSpec that were not as by default, other than those that
    ``method``, ``refined`` and the model tell: what it takes to make the same calibration again. A model that
    was asked for and not found is among them.
    """

    method: str = "hewg"
    refined: bool = True
    images: tuple[SourceImage, ...] = ()
    endocal: str = ""
    options: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Calibration:
    """One lens at one zoom setting.

    ``usable_radius``, px from the distortion centre, is given where the model holds for less than the
    visible content: what lies farther out has no place in a corrected picture. None: it holds for all.
    """

    model: DivisionModel
    uncertainty: Uncertainty | None = None
    boundary: Boundary | None = None
    quality: Quality | None = None
    source: Source | None = None
    usable_radius: float | None = None
