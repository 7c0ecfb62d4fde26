"""The errors that a user can meet. Each message says what, where, and what to do, in one line."""


class EndocalError(Exception):
    """Something failed for a reason that a user can act on; the command line exits 1."""


class InputError(EndocalError):
    """A file or a frame is missing, unreadable, damaged, or not what it should be."""


class CalibrationError(EndocalError):
    """No trustworthy model follows from the picture."""


class DeviceError(EndocalError):
    """No OpenCL device, or the one that was named cannot be used."""


class OutputError(EndocalError):
    """An output exists, cannot be written, or did not come out complete."""


class UsageError(EndocalError):
    """Options that contradict each other or make no sense; the command line exits 2."""
