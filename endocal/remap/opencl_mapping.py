"""A plane's mapping as the kernels read it: ``struct mapping`` of kernels/mapping.cl."""

from __future__ import annotations

import math

import numpy as np

from ..model import DivisionModel
from .grid import PlaneGrid

# Field by field as the struct; all are 4 bytes wide, so that no compiler pads them.
MAPPING = np.dtype(
    [
        ("source_size", "i4", 2),
        ("output_size", "i4", 2),
        ("origin", "f4", 2),
        ("step", "f4", 2),
        ("shift", "f4", 2),
        ("stretch", "f4", 2),
        ("center", "f4", 2),
        ("metric", "f4", 2),
        ("lam", "f4"),
        ("lam2", "f4"),
        ("limit", "f4"),
        ("reach", "f4"),
        ("maximum", "f4"),
        ("fill", "f4", 4),
    ]
)

_LARGEST = float(np.finfo(np.float32).max)


def pack_mapping(grid: PlaneGrid, model: DivisionModel) -> np.ndarray:
    """Return a plane's mapping through a model, shape (1,) of dtype MAPPING."""
    mapping = np.zeros(1, MAPPING)
    mapping["source_size"] = grid.source.size
    mapping["output_size"] = grid.output.size
    mapping["origin"] = grid.source.origin
    mapping["step"] = grid.source.step
    mapping["shift"] = grid.shift
    mapping["stretch"] = grid.stretch
    mapping["center"] = grid.center(model)
    mapping["metric"] = grid.metric(model)
    mapping["lam"] = model.lam
    mapping["lam2"] = model.lam2
    # What single precision cannot hold is everywhere.
    mapping["limit"] = min(model.valid_radius, _LARGEST)
    mapping["reach"] = squared_reach(model)
    mapping["maximum"] = grid.source.maximum
    mapping["fill"][0, : len(grid.source.fill)] = grid.source.fill
    return mapping


def squared_reach(model: DivisionModel) -> float:
    """Return the squared undistorted radius, px^2, that the model reaches; inf where it reaches all."""
    limit = model.valid_radius
    if not math.isfinite(limit):
        return math.inf
    q = limit * limit
    denominator = 1 + q * (model.lam + q * model.lam2)
    # At the pole of a barrel distortion the denominator is 0 but for rounding, and every radius is reached.
    reach = q / denominator**2 if denominator > 1e-9 else math.inf
    return reach if reach < _LARGEST else math.inf  # as good as everywhere
