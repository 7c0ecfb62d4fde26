"""A camera from the files of OpenCV (YAML, JSON) and ROS (camera_info YAML)."""

from __future__ import annotations

import json
import math
from typing import Any

import cv2

from ..errors import InputError
from .camera import Camera

# No camera's file nests deeper than this, in brackets, or in characters of indentation.
DEEPEST = 200
# The names that OpenCV's samples, ROS and common scripts give to the same thing.
_MATRIX = ("camera_matrix", "cameraMatrix", "K", "mtx")
_COEFFICIENTS = ("distortion_coefficients", "distCoeffs", "dist_coeffs", "D", "dist")
_SIZES = ("image_size", "img_size", "imageSize")
_EQUIDISTANT = ("equidistant", "fisheye")
_KNOWN_MODELS = ("plumb_bob", "rational_polynomial", *_EQUIDISTANT, "")


def read_camera(text: str, size: tuple[int, int] | None = None) -> Camera:
    """Read a camera from a file's text; ``size`` (width, height) px where the file tells none.

    Raises InputError for text that is no such file, or lacks or garbles what a camera needs.
    """
    document = _from_json(text) if text.lstrip()[:1] in ("{", "[") else _from_yaml(text)
    matrix = _matrix(document, _MATRIX)
    if len(matrix) != 9:
        raise InputError(
            f"{_MATRIX[0]} holds {len(matrix)} numbers; it must hold 9: is it OpenCV's or ROS's file?"
        )
    fx, skew, cx, _, fy, cy, *_ = matrix
    if skew != 0:
        raise InputError(f"{_MATRIX[0]} has a skew of {skew:g}, which a lens model has not")
    model = str(document.get("distortion_model", ""))
    if model not in _KNOWN_MODELS:
        known = ", ".join(m for m in _KNOWN_MODELS if m)
        raise InputError(f"distortion_model {model[:40]!r} is none of {known}")
    coefficients = _matrix(document, _COEFFICIENTS) or [0.0] * 5
    return Camera(
        focal=(fx, fy),
        center=(cx, cy),
        coefficients=tuple(coefficients),
        size=_size(document, size),
        fisheye=model in _EQUIDISTANT or bool(document.get("fisheye_model", 0)),
        circle=_circle(document),
    )


def _from_json(text: str) -> dict[str, Any]:
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"not a JSON document: {error}") from None
    return document if isinstance(document, dict) else {}


def _from_yaml(text: str) -> dict[str, Any]:
    """Read YAML with OpenCV's own parser: its files are none that a YAML library reads."""
    # OpenCV's parser goes into what is nested until the stack ends, and the process with it.
    if _nested(text) > DEEPEST:
        raise InputError("is nested too deeply for a camera")
    if not text.lstrip().startswith("%YAML"):
        text = f"%YAML:1.0\n---\n{text}"
    try:
        storage = cv2.FileStorage(text, cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY)
        document = _plain(storage.root())
    except (cv2.error, SystemError, ValueError, RecursionError):
        raise InputError("not a YAML document that OpenCV reads") from None
    return document if isinstance(document, dict) else {}


def _nested(text: str) -> int:
    """An upper bound of how deeply a YAML text is nested: by brackets, or by a line's indents and dashes."""
    depth = deepest = 0
    for character in text:
        depth += (character in "[{") - (character in "]}")
        deepest = max(deepest, depth)
    indents = (len(line) - len(line.lstrip(" -\t")) for line in text.splitlines())
    return max(deepest, *indents, 0)


def _plain(node: Any) -> Any:
    if node.isMap():
        keys: list[str] = list(node.keys())
        return {key: _plain(node.getNode(key)) for key in keys}
    if node.isSeq():
        return [_plain(node.at(i)) for i in range(node.size())]
    if node.isInt() or node.isReal():
        return node.real()
    return node.string() if node.isString() else None


def _matrix(document: dict[str, Any], names: tuple[str, ...]) -> list[float]:
    """The numbers of the first of ``names`` that is there, row by row; none where none is."""
    found: Any = next((document[name] for name in names if name in document), [])
    name = next((name for name in names if name in document), names[0])
    numbers = _flat(found.get("data", []) if isinstance(found, dict) else found)
    if not all(
        isinstance(v, (int, float)) and not isinstance(v, bool) and math.isfinite(v)
        for v in numbers
    ):
        raise InputError(f"{name} holds something else than finite numbers")
    return [float(v) for v in numbers]


def _flat(value: Any) -> list[Any]:
    if isinstance(value, list):
        return [v for item in value for v in _flat(item)]
    return [value]


def _size(document: dict[str, Any], given: tuple[int, int] | None) -> tuple[int, int]:
    told: Any = [document.get("image_width"), document.get("image_height")]
    for name in _SIZES:
        if name in document:
            told = _flat(document[name])
    if len(told) != 2 or not all(isinstance(v, (int, float)) and v == v // 1 > 0 for v in told):
        if given is None:
            raise InputError("tells no image_width and image_height: give --size WIDTHxHEIGHT")
        return given
    size = (int(told[0]), int(told[1]))
    if given not in (None, size):
        raise InputError(f"is for {size[0]}x{size[1]}, another size than the given one")
    return size


def _circle(document: dict[str, Any]) -> tuple[float, float, float] | None:
    numbers = _matrix(document, ("visible_circle",))
    return (numbers[0], numbers[1], numbers[2]) if len(numbers) == 3 else None
