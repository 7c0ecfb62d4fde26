"""Correct pictures held in NumPy arrays."""

from __future__ import annotations

import numpy as np

from ..boundary.circle import Boundary
from ..errors import InputError
from ..model import DivisionModel
from .engine import FrameRemapper
from .geometry import output_geometry
from .layout import frame_layout

# (components, dtype) -> a pixel format with that memory; black is 0 in each, alpha opaque.
_FORMATS = {
    (1, "uint8"): "gray",
    (1, "uint16"): "gray16le",
    (3, "uint8"): "bgr24",
    (3, "uint16"): "bgr48le",
    (4, "uint8"): "bgra",
    (4, "uint16"): "bgra64le",
}


class Remapper:
    """Corrects pictures through one model: ``Remapper(model).apply(image)``.

    ``device``, ``interpolation``: see FrameRemapper. ``view``, ``size`` (width, height), ``scale`` and
    ``boundary``: see ``output_geometry``.
    """

    def __init__(
        self,
        model: DivisionModel,
        device: str = "auto",
        view: str = "same",
        interpolation: str = "bilinear",
        size: tuple[int, int] | None = None,
        scale: float | None = None,
        boundary: Boundary | None = None,
    ) -> None:
        self.model = model
        self.geometry = output_geometry([model], [boundary], view, size, scale)
        self._interpolation = interpolation
        self._device = device
        self._frames: dict[tuple[int, str], FrameRemapper] = {}

    @property
    def device_name(self) -> str:
        """The device that did the last picture; what was asked for before the first one."""
        names = [remapper.device_name for remapper in self._frames.values()]
        return names[-1] if names else self._device

    def apply(self, image: np.ndarray, out: np.ndarray | None = None) -> np.ndarray:
        """Return the corrected picture.

        ``image`` is uint8 or uint16, (h, w), (h, w, 3) or (h, w, 4), of the model's size; ``out``, where
        given, is written and returned. Raises InputError for any other shape or dtype.
        """
        image = np.asarray(image)
        components = image.shape[2] if image.ndim == 3 else 1
        pix_fmt = _FORMATS.get((components, image.dtype.name))
        if image.ndim not in (2, 3) or pix_fmt is None:
            raise InputError(
                f"a picture of {image.dtype} {image.shape} cannot be remapped;"
                " it must be uint8 or uint16 with 1, 3 or 4 channels"
            )
        h, w = image.shape[:2]
        if (w, h) != self.model.size:
            raise InputError(
                f"a model for {self.model.size[0]}x{self.model.size[1]} does not fit a picture of"
                f" {w}x{h}; rescale it"
            )
        if (components, pix_fmt) not in self._frames:
            layout = frame_layout(pix_fmt, (w, h), full_range=True)
            self._frames[components, pix_fmt] = FrameRemapper(
                layout, self.geometry, self._interpolation, self._device
            )
        remapper = self._frames[components, pix_fmt]
        shape = (*self.geometry.size[::-1], *image.shape[2:])
        result = np.empty(shape, image.dtype) if out is None else out
        if result.shape != shape or result.dtype != image.dtype:
            raise InputError(
                f"out is {result.dtype} {result.shape}; it must be {image.dtype} {shape}"
            )
        target = result if _is_packed(result) else np.empty_like(result, order="C")
        source = image if _is_packed(image) else np.ascontiguousarray(image)
        remapper.apply(self.model, [_rows(source)], [_rows(target)])
        if target is not result:
            np.copyto(result, target)
        return result


def _is_packed(image: np.ndarray) -> bool:
    """Whether the words of a picture's rows lie side by side in memory."""
    n = image.shape[2] if image.ndim == 3 else 1
    return image.ndim == 2 or image.strides[1:] == (n * image.itemsize, image.itemsize)


def _rows(image: np.ndarray) -> np.ndarray:
    """View a packed picture as one plane, (rows, columns * channels)."""
    if image.ndim == 2:
        return image
    h, w, n = image.shape
    return np.lib.stride_tricks.as_strided(image, (h, w * n), (image.strides[0], image.itemsize))
