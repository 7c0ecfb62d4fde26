"""Pictures as NumPy arrays through Remapper."""

from __future__ import annotations

import numpy as np
import pytest

from endocal import DivisionModel, Remapper
from endocal.errors import InputError, UsageError

SIZE = (123, 45)
MODEL = DivisionModel(-9e-5, (60.2, 20.7), SIZE)


def picture(*channels, dtype=np.uint8):
    rng = np.random.default_rng(1)
    return rng.integers(0, np.iinfo(dtype).max + 1, (45, 123, *channels)).astype(dtype)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("channels", [(), (3,), (4,)])
def test_pictures_keep_their_kind_and_engines_agree(dtype, channels):
    image = picture(*channels, dtype=dtype)
    exact = Remapper(MODEL, device="numpy").apply(image)
    quick = Remapper(MODEL).apply(image)
    assert (exact.dtype, exact.shape) == (image.dtype, image.shape)
    level = 1 if dtype == np.uint8 else 256
    assert np.abs(exact.astype(int) - quick.astype(int)).max() <= level


def test_channels_are_corrected_alike():
    image = picture(3)
    whole = Remapper(MODEL, interpolation="lanczos").apply(image)
    single = Remapper(MODEL, interpolation="lanczos")
    for channel in range(3):
        plane = np.ascontiguousarray(image[..., channel])
        np.testing.assert_array_equal(single.apply(plane), whole[..., channel])


@pytest.mark.parametrize("device", ["auto", "numpy"])
def test_views_of_other_arrays_and_given_outputs(device):
    image = picture(3)
    remapper = Remapper(MODEL, device)
    plain = remapper.apply(image)
    wide = np.zeros((45, 200, 3), np.uint8)
    wide[:, 11:134] = image
    np.testing.assert_array_equal(remapper.apply(wide[:, 11:134]), plain)
    np.testing.assert_array_equal(remapper.apply(image[::-1].copy()[::-1]), plain)
    # BGR to RGB and back by a view, as OpenCV users write it.
    np.testing.assert_array_equal(remapper.apply(image[..., ::-1].copy()[..., ::-1]), plain)
    out = np.zeros((60, 150, 3), np.uint8)
    target = out[5:50, 7:130]
    assert remapper.apply(image, target) is target
    np.testing.assert_array_equal(out[5:50, 7:130], plain)
    assert out[:5].max() == out[50:].max() == out[:, :7].max() == out[:, 130:].max() == 0


def test_sizes_and_views_are_those_of_the_geometry():
    remapper = Remapper(MODEL, "numpy", view="crop", size=(246, 90))
    assert remapper.apply(picture()).shape == (90, 246)
    assert remapper.geometry.size == (246, 90)
    assert Remapper(MODEL, "numpy", scale=2).apply(picture(3)).shape == (90, 246, 3)


def test_what_is_no_picture_is_refused():
    remapper = Remapper(MODEL, "numpy")
    for bad in (picture().astype(np.float32), picture(2), picture()[0], picture(3)[None]):
        with pytest.raises(InputError, match="uint8 or uint16"):
            remapper.apply(bad)
    with pytest.raises(InputError, match="rescale it"):
        remapper.apply(picture()[:40])
    with pytest.raises(InputError, match="out is"):
        remapper.apply(picture(), np.empty((45, 123), np.uint16))
    with pytest.raises(UsageError, match="interpolation"):
        Remapper(MODEL, "numpy", interpolation="cubic").apply(picture())
    with pytest.raises(UsageError, match="no OpenCL device matches 'voodoo'"):
        Remapper(MODEL, "voodoo").apply(picture())
