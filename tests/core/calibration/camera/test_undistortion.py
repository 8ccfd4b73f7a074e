import cv2
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from core.calibration.camera.undistortion import (
    all_pixels,
    apply_inverse,
    errors,
    exact_map,
    inverse_parameters,
    straighten,
    table_1_map,
    tie_points,
)
from core.message import Array
from core.optics import TABLE_3, CameraModel

STRONG = CameraModel(width=640, height=480, fx=519, fy=519, cx=331, cy=229, k1=0.114, k2=0.193, k3=-1.095)


@settings(deadline=None, max_examples=60)
@given(
    k1=st.floats(-0.4, 0.4),
    k2=st.floats(-0.2, 0.2),
    p1=st.floats(-0.004, 0.004),
    p2=st.floats(-0.004, 0.004),
    x=st.floats(-0.5, 0.5),
    y=st.floats(-0.4, 0.4),
)
def test_undistorting_undoes_distorting(k1: float, k2: float, p1: float, p2: float, x: float, y: float) -> None:
    model = CameraModel(width=320, height=256, fx=300, fy=300, cx=160, cy=128, k1=k1, k2=k2, p1=p1, p2=p2)
    place = np.array([[x, y]])
    if np.hypot(x, y) < 0.95 * model.turning_radius:
        assert np.allclose(model.undistort(model.distort(place)), place, atol=1e-9)


def test_the_exact_path_is_exact_and_table_1_keeps_its_bound() -> None:
    table_1, exact = errors(TABLE_3)
    assert exact["max_px"] < 1e-9
    assert table_1["max_px"] < 0.35 and table_1["rms_px"] < 0.04


def test_the_refinement_betters_the_linear_start_of_table_1() -> None:
    linear = np.linalg.lstsq(*as_printed_rows(corrected=True), rcond=None)[0]
    assert errors(TABLE_3, linear)[0]["max_px"] > errors(TABLE_3)[0]["max_px"]


def test_the_printed_denominator_with_a3_does_not_fit() -> None:
    """Eq. 10 prints a3 where Heikkila has a5: with the print, the best fit is an order of magnitude worse."""
    rows, right = as_printed_rows(corrected=False)
    a = np.linalg.lstsq(rows, right, rcond=None)[0]
    distorted = all_pixels(TABLE_3)
    r2 = np.sum(distorted**2, axis=1)
    u, v = distorted.T
    below = 1 + r2 * (a[2] * r2 + a[4] * u + a[5] * v + a[6])
    across = u * (1 + a[0] * r2 + a[1] * r2**2) + 2 * a[2] * u * v + a[3] * (r2 + 2 * u * u)
    off = np.abs(across / below - TABLE_3.undistort(distorted)[:, 0]) * TABLE_3.fx
    assert off.max() > 5 * errors(TABLE_3)[0]["max_px"]


def as_printed_rows(corrected: bool) -> tuple[Array, Array]:
    """Eq. 10 times its denominator, with a5 (8 unknowns) or as printed with a3 (7 unknowns)."""
    grid = tie_points(TABLE_3)
    (u, v), (x, y) = grid.distorted.T, grid.ideal.T
    r2 = u * u + v * v
    one = [u * r2, u * r2**2, 2 * u * v, r2 + 2 * u * u, -x * r2**2, -x * u * r2, -x * v * r2, -x * r2]
    two = [v * r2, v * r2**2, r2 + 2 * v * v, 2 * u * v, -y * r2**2, -y * u * r2, -y * v * r2, -y * r2]
    if not corrected:
        one, two = ([*rows[:2], rows[2] + rows[4], rows[3], *rows[5:]] for rows in (one, two))
    return np.concatenate((np.column_stack(one), np.column_stack(two))), np.concatenate((x - u, y - v))


def test_both_maps_agree_and_straighten_lines() -> None:
    exact, table_1 = exact_map(TABLE_3), table_1_map(TABLE_3)
    seen = table_1[..., 0] > -1e3
    assert seen.mean() > 0.99
    assert np.linalg.norm(exact - table_1, axis=2)[seen].max() < 0.15


def test_the_exact_map_is_opencvs() -> None:
    theirs = cv2.initUndistortRectifyMap(
        TABLE_3.matrix, TABLE_3.distortion, None, TABLE_3.matrix, (320, 256), cv2.CV_32FC1
    )
    assert np.allclose(exact_map(TABLE_3), np.stack(theirs, axis=-1), atol=1e-3)


def test_a_bent_line_becomes_straight() -> None:
    places = np.column_stack((np.linspace(-0.4, 0.4, 200), np.full(200, -0.3)))
    seen = TABLE_3.distort(places) * (TABLE_3.fx, TABLE_3.fy) + (TABLE_3.cx, TABLE_3.cy)
    picture = np.zeros((256, 320), np.uint8)
    whole = np.rint(seen * 16).astype(np.int32)
    cv2.polylines(picture, [whole], isClosed=False, color=255, thickness=3, lineType=cv2.LINE_AA, shift=4)
    straight = straighten(picture, exact_map(TABLE_3))[:, 50:260].astype(float)
    rows = (np.arange(256) @ straight) / straight.sum(axis=0)
    assert np.ptp(seen[:, 1]) > 4 and np.ptp(rows) < 0.3


def test_pixels_that_no_ray_reaches_are_left_out() -> None:
    assert STRONG.turning_radius < 1
    ideal = STRONG.undistort(all_pixels(STRONG))
    unreached = np.isnan(ideal).any(axis=1)
    assert 0 < unreached.mean() < 0.05
    assert np.all(np.linalg.norm(ideal[~unreached], axis=1) < STRONG.turning_radius)
    assert errors(STRONG)[1]["max_px"] < 1e-9


def test_a_distortion_that_never_folds_has_no_turning_radius() -> None:
    assert TABLE_3.turning_radius == float("inf")
    assert CameraModel(width=320, height=256, fx=300, fy=300, cx=160, cy=128).turning_radius == float("inf")
    barrel = CameraModel(width=320, height=256, fx=300, fy=300, cx=160, cy=128, k1=-0.3)
    assert np.isclose(barrel.turning_radius, np.sqrt(1 / 0.9))


def test_an_undistorted_camera_needs_no_correction() -> None:
    plain = CameraModel(width=320, height=256, fx=300, fy=300, cx=160, cy=128)
    grid = tie_points(plain)
    assert np.allclose(apply_inverse(inverse_parameters(plain), grid.distorted), grid.distorted, atol=1e-9)
