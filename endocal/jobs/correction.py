"""What a correction can be told, how far it has come, and what it did."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from ..errors import UsageError
from ..files.names import shown
from ..remap.geometry import VIEWS
from ..remap.interpolation import TAPS
from ..video.encoder import EncoderChoice
from ..video.live import redacted
from ..zoom.table import LOOKUPS
from .live_feed import Latency
from .pipe import PIPE

# With far more the libraries give up, and take the process with them.
MAX_THREADS = 256
STEREO = ("sbs", "tb")
CENTERS = ("auto", "follow", "fixed")
DEINTERLACE = ("auto", "off", "frame", "field")
# Containers under the names that people give them.
_CONTAINERS = {"y4m": "yuv4mpegpipe", "mkv": "matroska", "ts": "mpegts"}


@dataclass(frozen=True)
class CorrectionSpec:
    """All that a correction can be told.

    ``input`` and ``output`` are paths, or ``-`` for standard input and output; ``calibration`` is the path
    of a calibration or a zoom table. ``size`` is the output's (width, height) in px and ``scale`` its
    magnification; ``container_format`` the output's container (y4m, matroska, mpegts, or another of FFmpeg's
    names) where its suffix does not tell.
    ``stereo`` says that a frame holds two eyes side by side (sbs) or one below the other (tb), and
    ``right_calibration`` is then the second one's, where it has another than the first. ``lookup`` is how a
    zoom table is read (auto, diameter, area); with ``center`` follow the distortion centre goes with the
    visible circle's shift, with fixed it does not, with auto it does with a table. ``assume_diameter``, px,
    of the visible circle, holds until one is seen. ``zoom_log`` is written, and ``zoom_from`` read instead
    of measuring the zoom (CSV or JSON lines). ``allow_protocols`` names the protocols that an input may open
    besides its own file.
    ``live`` takes the input as an address (RTSP, UDP and the like) or a camera, and leaves frames out rather
    than fall behind.
    ``threads`` may decode, and as many encode; 0: as many as there are cores.
    """

    input: str
    output: str
    calibration: str
    view: str = "same"
    size: tuple[int, int] | None = None
    scale: float | None = None
    interpolation: str = "bilinear"
    device: str = "auto"
    keep_sar: bool = False
    side_by_side: bool = False
    stereo: str | None = None
    right_calibration: str | None = None
    deinterlace: str = "auto"
    encoder: EncoderChoice = field(default_factory=EncoderChoice)
    container_format: str | None = None
    lookup: str = "auto"
    center: str = "auto"
    assume_diameter: float | None = None
    zoom_log: str | None = None
    zoom_from: str | None = None
    overwrite: bool = False
    strict: bool = False
    live: bool = False
    strip_metadata: bool = False
    allow_protocols: tuple[str, ...] = ()
    threads: int = 0

    def __post_init__(self) -> None:
        if self.deinterlace not in DEINTERLACE:
            raise UsageError(
                f"--deinterlace {self.deinterlace}: it is one of {', '.join(DEINTERLACE)}"
            )
        if self.view not in VIEWS:
            raise UsageError(f"--view {self.view}: it is one of {', '.join(VIEWS)}")
        if self.interpolation not in TAPS:
            raise UsageError(
                f"--interpolation {self.interpolation}: it is one of {', '.join(TAPS)}"
            )
        name = self.container_format
        object.__setattr__(self, "container_format", _CONTAINERS.get(name or "", name))
        if self.lookup not in LOOKUPS:
            raise UsageError(f"--lookup {self.lookup}: it is one of {', '.join(LOOKUPS)}")
        if self.center not in CENTERS:
            raise UsageError(f"--center {self.center}: it is one of {', '.join(CENTERS)}")
        if self.stereo not in (None, *STEREO):
            raise UsageError(f"--stereo {self.stereo}: it is one of {', '.join(STEREO)}")
        if self.right_calibration is not None and self.stereo is None:
            raise UsageError("a second calibration is for the second eye of --stereo")
        if self.stereo is not None and (self.side_by_side or self.zoom_log or self.zoom_from):
            raise UsageError("--stereo excludes --side-by-side, --zoom-log and --zoom-from")
        diameter = self.assume_diameter
        if diameter is not None and not (math.isfinite(diameter) and diameter > 0):
            raise UsageError(f"--assume-diameter {diameter:g}: it is a number of px above 0")
        if diameter is not None and self.zoom_from is not None:
            raise UsageError("--assume-diameter and --zoom-from exclude each other")
        if not 0 <= self.threads <= MAX_THREADS:
            raise UsageError(
                f"--threads {self.threads}: it is 1 to {MAX_THREADS}, or 0 for by cores"
            )
        if self.size is not None and self.scale is not None:
            raise UsageError("--size and --scale exclude each other")
        if self.input == PIPE and self.calibration == PIPE:
            raise UsageError("the input and the calibration cannot both come from stdin")


@dataclass(frozen=True)
class Progress:
    """How far a correction has come: frames written, frames expected (None: unknown), and seconds so far."""

    frames: int
    total: int | None
    seconds: float


@dataclass(frozen=True)
class CorrectionReport:
    """What a correction did.

    ``seconds`` is wall-clock time with start-up; ``size_in`` and ``size_out`` are (width, height) in px;
    ``notes`` say what was decided or left out, ``warnings`` what was wrong with the input. ``damaged``
    counts packets that could not be decoded and ``corrupt`` frames decoded with errors. ``zoom`` counts the
    frames by where their zoom came from (rim, tracked, held, given); empty for a fixed calibration.
    ``diameters`` are the least and the greatest diameter of the visible circle that the zoom was taken from,
    px; None for a fixed calibration.
    ``latency`` is that of a live input.
    """

    input: str
    output: str
    frames: int
    seconds: float
    size_in: tuple[int, int]
    size_out: tuple[int, int]
    device: str
    codec: str | None = None
    duration: float | None = None
    damaged: int = 0
    corrupt: int = 0
    zoom: dict[str, int] = field(default_factory=dict)
    diameters: tuple[float, float] | None = None
    latency: Latency | None = None
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()


def input_name(spec: CorrectionSpec) -> str:
    """Return what messages call the input."""
    return "stdin" if spec.input == PIPE else redacted(shown(spec.input))


def output_name(spec: CorrectionSpec) -> str:
    """Return what messages call the output."""
    return "stdout" if spec.output == PIPE else shown(spec.output)
