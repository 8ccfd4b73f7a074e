"""Voices as every viewer gets them: where they lie in the picture."""

import math

import numpy as np
import pytest

from console.messages.hearing import columns
from core.sensors import Camera

CAMERA = Camera()


def test_a_voice_to_the_left_lies_left_in_the_picture_and_doubt_makes_the_band_wide() -> None:
    ahead, left = columns(0.0, 0.05, CAMERA), columns(0.2, 0.05, CAMERA)
    assert ahead is not None and left is not None
    assert left[1] < ahead[1] and abs(ahead[1] - CAMERA.model.cx) < 3
    wide = columns(0.0, 0.1, CAMERA)
    assert wide is not None and wide[2] - wide[0] == pytest.approx(2 * (ahead[2] - ahead[0]), rel=0.05)


@pytest.mark.parametrize("azimuth", [math.pi, -math.pi / 2, 1.0])
def test_a_voice_outside_the_picture_has_no_columns(azimuth: float) -> None:
    assert columns(azimuth, 0.05, CAMERA) is None


def test_the_columns_are_those_of_the_bearing() -> None:
    for azimuth in np.linspace(-0.3, 0.3, 7):
        found = columns(float(azimuth), 0.01, CAMERA)
        assert found is not None
        ray = CAMERA.model.unproject(np.array([[found[1], CAMERA.model.cy]]))[0]
        assert -math.atan(ray[0]) == pytest.approx(azimuth, abs=0.02)
