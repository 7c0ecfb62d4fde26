"""The OpenCL devices that there are, and which one ``auto`` takes."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from ..errors import DeviceError

# Levels of 8 bits that an engine may be off float64: one of rounding, and one that 8 bits of a place allow.
MOST_DEVIATION = 1.0


@dataclass(frozen=True)
class StrategyReport:
    """How a device resamples, and what was measured (None where it was not).

    ``strategy``: ``baked`` maps or ``direct``, coordinates on the fly. ``milliseconds``: a 1920x1080 yuv420p
    frame, bilinear, by strategy. ``first_seconds``: its first two frames, by strategy. ``deviation``: the
    most that the strategy was off the NumPy engine, in levels of 8 bits.
    """

    strategy: str
    measured: bool
    milliseconds: dict[str, float] | None = None
    first_seconds: dict[str, float] | None = None
    deviation: float | None = None

    @property
    def is_wrong(self) -> bool:
        """Whether the device computed what it should not: its driver is at fault."""
        return self.deviation is not None and self.deviation > MOST_DEVIATION


@dataclass(frozen=True)
class DeviceReport:
    """One OpenCL device. ``memory`` is in bytes; ``images`` and ``shares_memory`` say what it can."""

    address: str
    name: str
    kind: str
    platform: str
    platform_version: str
    version: str
    driver: str
    compute_units: int
    memory: int
    images: bool
    shares_memory: bool
    auto: bool
    resampling: StrategyReport | None


@dataclass(frozen=True)
class DevicesReport:
    """All devices, and why ``auto`` takes the one it does, or cannot take any."""

    devices: tuple[DeviceReport, ...]
    reason: str

    @property
    def auto(self) -> str | None:
        """The number of the device that ``auto`` takes; None where it takes none."""
        return next((d.address for d in self.devices if d.auto), None)

    def data(self) -> dict[str, Any]:
        """Return the report as plain data."""
        return {
            "auto": self.auto,
            "reason": self.reason,
            "devices": [asdict(d) for d in self.devices],
        }


def find_devices(measure: bool = False) -> DevicesReport:
    """List the OpenCL devices; with ``measure`` time and check each, and remember its faster strategy."""
    from ..remap.engine import prepare_device

    prepare_device("auto")
    from ..remap.opencl_device import choose_device, list_devices

    try:
        chosen, reason = choose_device("auto")
        auto = chosen.address
    except DeviceError as error:
        auto, reason = None, str(error)
    return DevicesReport(
        tuple(_report(entry, entry.address == auto, measure) for entry in list_devices()), reason
    )


def _report(entry: Any, auto: bool, measure: bool) -> DeviceReport:
    device = entry.device
    return DeviceReport(
        address=entry.address,
        name=entry.name,
        kind=entry.kind,
        platform=str(device.platform.name).strip(),
        platform_version=str(device.platform.version).strip(),
        version=str(device.version).strip(),
        driver=str(device.driver_version).strip(),
        compute_units=int(device.max_compute_units),
        memory=int(device.global_mem_size),
        images=bool(device.image_support),
        shares_memory=bool(device.host_unified_memory),
        auto=auto,
        resampling=_resampling(entry, measure),
    )


def _resampling(entry: Any, measure: bool) -> StrategyReport | None:
    """How the device resamples; None where it cannot be used."""
    from ..remap.opencl_choice import choose_strategy, is_remembered, remember
    from ..remap.opencl_device import session
    from ..remap.opencl_measure import deviation
    from ..remap.opencl_measure import measure as time_strategies

    try:
        opened = session(entry)
        if not measure:
            return StrategyReport(choose_strategy(opened), is_remembered(opened))
        found = time_strategies(entry.address)
        off = deviation(entry.address, found.best)
    except DeviceError:
        return None
    remember(opened, found.best)
    return StrategyReport(found.best, True, found.milliseconds, found.first_seconds, off)
