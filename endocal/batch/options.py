"""What is wrong with a batch's options for every recording, found before the first one fails for it."""

from __future__ import annotations

from pathlib import PurePath

from ..errors import UsageError
from ..jobs.page_place import check_page_name
from ..jobs.zoom_log import LOG_SUFFIXES
from ..report.figures import require_figures
from ..video.encoder import EncoderChoice, check_names
from ..video.suffix import check_suffix
from .recording import BatchSpec


def check_options(spec: BatchSpec) -> None:
    """Raise UsageError or DeviceError for a value that suits no recording; the disk is not touched."""
    choice = spec.correction.get("encoder", EncoderChoice())
    check_names(choice)
    if spec.suffix is not None and spec.correction.get("container_format") is None:
        check_suffix(spec.suffix, choice)
    for option, suffix in (("--zoom-log", spec.zoom_log), ("--zoom-from", spec.zoom_from)):
        if suffix is not None and PurePath(f"x{suffix}").suffix.lower() not in LOG_SUFFIXES:
            raise UsageError(f"{option} {suffix}: a zoom log is {', '.join(LOG_SUFFIXES)}")
    if spec.report is not None:
        require_figures()
        check_page_name(f"x{spec.report}", f"--report {spec.report}")
    device = spec.correction.get("device", "auto")
    if spec.scheduler is None and device not in ("auto", "numpy"):
        from ..remap.engine import prepare_device

        prepare_device(device)
        from ..remap.opencl_device import choose_device

        choose_device(device)
