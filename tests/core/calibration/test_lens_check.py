"""Numbers that no lens has are refused before anything looks through them."""

import contextlib
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.calibration.files.camera_files import check_lens
from core.errors import BadInput
from core.geometry import OPTICAL, Transform
from core.optics import TABLE_3, CameraModel
from core.perception.landmarks.level_view import LevelView, level_bounds
from core.sensors import Camera

NO_LENS = [
    {"k1": -1.0},
    {"k1": 1e9, "k2": 0.0},
    {"k1": -1e9},
    {"k1": 1e300},
    {"k3": 1e308},
    {"k3": -5.0},
    {"p1": 3.0},
    {"fx": 1e-6, "fy": 1e-6},
    {"fx": 1.0, "fy": 1.0, "k1": 0.0, "k2": 0.0},
    {"fx": 1.0},
    {"fx": 1e7, "fy": 1e7},
    {"fx": 1e300, "fy": 1e300},
]
WIDE = CameraModel(width=320, height=256, fx=160.0, fy=160.0, cx=160.0, cy=128.0, k1=-0.3, k2=0.1)


@pytest.mark.parametrize("change", NO_LENS, ids=str)
def test_a_camera_that_no_lens_makes_is_refused_in_a_sentence(change: dict[str, float]) -> None:
    with pytest.raises(BadInput, match=r"^[A-Z].*(calibrate|check|Check).*\.$"):
        check_lens(replace(TABLE_3, **change))


@pytest.mark.parametrize("model", [TABLE_3, WIDE, replace(WIDE, fx=2000.0, fy=2000.0)])
def test_real_lenses_pass(model: CameraModel) -> None:
    check_lens(model)


@settings(deadline=None, max_examples=60)
@given(
    fx=st.floats(0.1, 1e5), k1=st.floats(-10, 10), k2=st.floats(-10, 10), k3=st.floats(-10, 10), p1=st.floats(-1, 1)
)
def test_whatever_passes_is_levelled_or_refused(fx: float, k1: float, k2: float, k3: float, p1: float) -> None:
    model = replace(TABLE_3, fx=fx, fy=fx, k1=k1, k2=k2, k3=k3, p1=p1)
    with contextlib.suppress(BadInput):
        check_lens(model)
        assert np.isfinite(model.widest_ray)
        assert np.isfinite(level_bounds(Camera(model=model))).all()


def test_a_strong_distortion_is_inverted_exactly_over_the_whole_picture() -> None:
    pixels = np.array([[0.0, 0.0], [320.0, 256.0], [0.0, 256.0], [10.0, 128.0]])
    back = WIDE.distort(WIDE.unproject(pixels)) * (WIDE.fx, WIDE.fy) + (WIDE.cx, WIDE.cy)
    assert np.abs(back - pixels).max() < 1e-6


def test_a_camera_whose_picture_would_be_levelled_into_billions_of_pixels_is_refused() -> None:
    up = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    tilted = Transform(rotation=up @ OPTICAL, translation=np.zeros(3))
    far = replace(TABLE_3, fx=7200.0, fy=7200.0, k1=0.0, k2=0.0)
    check_lens(far)
    with pytest.raises(BadInput, match="looks across the floor"):
        LevelView(Camera(model=far, mounting=tilted))
