"""Which metadata travels, and which only describes the file that it was in."""

from __future__ import annotations

from collections.abc import Mapping

# Written by a muxer about its own file. Copied, they would be false.
_OF_THE_FILE = frozenset(
    (
        "encoder",
        "major_brand",
        "minor_version",
        "compatible_brands",
        "vendor_id",
        "_statistics_tags",
    )
)
_OF_THE_FILE_PREFIXES = ("duration", "bps", "number_of_", "_statistics")


def container_tags(tags: Mapping[str, str]) -> dict[str, str]:
    """Return the container's tags that describe the recording."""
    return {k: v for k, v in tags.items() if k.lower() not in _OF_THE_FILE}


def stream_tags(tags: Mapping[str, str]) -> dict[str, str]:
    """Return a stream's tags that describe the recording, not the bytes that it was coded in."""
    return {
        k: v
        for k, v in tags.items()
        if k.lower() not in _OF_THE_FILE and not k.lower().startswith(_OF_THE_FILE_PREFIXES)
    }
