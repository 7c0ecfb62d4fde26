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
# QuickTime's list knows some languages by the other of their two codes of ISO 639-2 alone.
_QUICKTIME_LANGUAGES = {
    "deu": "ger",
    "nld": "dut",
    "ell": "gre",
    "isl": "ice",
    "zho": "chi",
    "swe": "sve",
    "sqi": "alb",
    "hye": "arm",
    "kat": "geo",
}


def container_tags(tags: Mapping[str, str]) -> dict[str, str]:
    """Return the container's tags that describe the recording."""
    return {k: v for k, v in tags.items() if k.lower() not in _OF_THE_FILE}


def stream_tags(tags: Mapping[str, str], container: str) -> dict[str, str]:
    """Return a stream's tags that describe the recording, not the bytes that it was coded in.

    ``container`` is FFmpeg's name of the container that they go to.
    """
    kept = {
        k: v
        for k, v in tags.items()
        if k.lower() not in _OF_THE_FILE and not k.lower().startswith(_OF_THE_FILE_PREFIXES)
    }
    if container == "mov" and "language" in kept:
        kept["language"] = _QUICKTIME_LANGUAGES.get(kept["language"], kept["language"])
    return kept
