"""A zoom log as arrays, for its page."""

from __future__ import annotations

import numpy as np

from ..files.names import shown
from ..report.run import SOURCES, ZoomHistory
from .zoom_log import places_of, recorded_rows


def zoom_history(path: str) -> ZoomHistory:
    """Read a zoom log (.csv, .jsonl); InputError where it is none, UsageError for another suffix."""
    rows = list(recorded_rows(path))
    in_seconds, places = places_of(rows, shown(path))
    order = np.argsort(places, kind="stable")
    sources = [row.source if row.source in SOURCES else "" for row in rows]
    return ZoomHistory(
        places[order],
        in_seconds,
        np.array([row.diameter for row in rows])[order],
        np.array([row.lam for row in rows])[order],
        np.array([row.uncertainty for row in rows])[order],
        np.array(sources, np.str_)[order],
    )
