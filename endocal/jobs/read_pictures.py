"""Picture files of one lens, read to be calibrated from: of one size, and each of a view of its own."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from ..calibration.image.picture import to_grey
from ..errors import InputError
from ..files import decode_image, read_picture_bytes
from ..files.images import Picture
from ..files.names import shown

# Pictures are compared when reduced to so many px on the longer side, by what is finer than so many px there;
# all places count alike, but for those that vary by less than a few grey levels: noise.
REDUCED, FINE, NOISE = 256, 6.0, 4.0
# Two show the same from here on, as a correlation: copies in JPEG of a quality of 50 or better and second
# frames of a camera on a stand have 0.99 or more, unless they are small; a view that moved by a px in a
# thousand has 0.99, by two 0.96; different ones 0.67 at most, faint boards in one bright circle included.
SAME_VIEW = 0.985


@dataclass(frozen=True)
class ReadPicture:
    """A picture file: its ``path``, the bytes in it, and what these show."""

    path: str | Path
    data: bytes
    image: Picture

    @classmethod
    def of(cls, path: str | Path) -> ReadPicture:
        """Read a file; InputError, naming it, for one that cannot be used."""
        data = read_picture_bytes(path)
        return cls(path, data, decode_image(data, shown(path)))

    @property
    def name(self) -> str:
        """The path as messages show it."""
        return shown(self.path)

    @property
    def digest(self) -> str:
        """SHA-256 of the file."""
        return hashlib.sha256(self.data).hexdigest()

    @cached_property
    def seen(self) -> NDArray[np.float32]:
        """What is fine in the reduced picture, beside how strong it is around: a unit vector, if much is."""
        grey = np.asarray(to_grey(self.image), np.float32)
        scale = min(1.0, REDUCED / max(grey.shape))
        size = [max(1, round(side * scale)) for side in grey.shape[::-1]]
        small = cv2.resize(grey, size, interpolation=cv2.INTER_AREA)
        fine = small - cv2.GaussianBlur(small, (0, 0), FINE)
        fine = fine / np.sqrt(cv2.GaussianBlur(fine * fine, (0, 0), FINE) + NOISE**2)
        return np.asarray(fine / max(float(np.linalg.norm(fine)), 1.0), np.float32)

    def shows_what(self, other: ReadPicture) -> bool:
        """Whether both show the same view of the same thing."""
        return float((self.seen * other.seen).sum()) > SAME_VIEW


def check_one_size(pictures: Sequence[ReadPicture]) -> None:
    """Refuse pictures of another size than the first one's."""
    first, *others = pictures
    for other in others:
        (h, w), (height, width) = (picture.image.shape[:2] for picture in (other, first))
        if (h, w) != (height, width):
            raise InputError(
                f"{other.name} is {w}x{h}, {first.name} {width}x{height}: give pictures of one lens at one"
                " setting"
            )


def copies_among(pictures: Sequence[ReadPicture]) -> Iterator[tuple[ReadPicture, ReadPicture]]:
    """Yield pictures that show what an earlier one does, with that one.

    Counted as evidence of its own, a copy would make all look surer: most errors of what is measured in it
    are the first one's. Raises InputError for one that is there twice, in whatever kind of file.
    """
    if len(pictures) < 2:
        return
    kept: list[ReadPicture] = []
    for picture in pictures:
        first = next((other for other in kept if picture.shows_what(other)), None)
        if first is None:
            kept.append(picture)
        elif np.array_equal(to_grey(picture.image), to_grey(first.image)):
            raise InputError(f"{picture.name}: the same picture as {first.name}: give it once")
        else:
            yield picture, first
