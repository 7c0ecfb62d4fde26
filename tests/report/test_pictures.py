"""Pictures of a page: what is drawn lies where it is seen."""

from __future__ import annotations

import numpy as np
import pytest

from endocal.model import DivisionModel
from endocal.report.pictures import corrected, places, to_show

SPOT = (30.0, 12.0)


def middle_of(shown: np.ndarray) -> np.ndarray:
    """The (x, y) about which the light of a picture lies, px."""
    light = shown[..., 0].astype(float)
    y, x = np.indices(light.shape)
    return np.array([(light * x).sum(), (light * y).sum()]) / light.sum()


@pytest.mark.parametrize("aspect", [0.5, 1.0, 2.0])
def test_a_place_is_drawn_on_what_is_there(aspect: float) -> None:
    x, y = np.meshgrid(np.arange(80), np.arange(40))
    picture = np.uint8(220 * np.exp(-((x - SPOT[0]) ** 2 + (y - SPOT[1]) ** 2) / 8))
    shown, scale = to_show(picture, aspect)
    drawn = (places(np.array(SPOT) * (aspect, 1.0), aspect) + 0.5) * scale - 0.5
    assert middle_of(shown) == pytest.approx(drawn, abs=0.05)
    # Correction leaves the distortion centre where it is.
    after = corrected(shown, DivisionModel(-1e-6, SPOT, (80, 40), aspect))
    assert middle_of(after) == pytest.approx(drawn, abs=0.05)
