"""The floor in the camera's picture."""

import math
from dataclasses import replace

import numpy as np
import pytest

from core.errors import BadInput
from core.geometry import Transform, rotation_of_rpy
from core.perception.picture_floor import (
    ABOVE,
    ASSUMED,
    FAR,
    HIDDEN,
    MAX_PARTS,
    MAX_POINTS,
    floor_at,
    ring_in_picture,
    way_in_picture,
)
from core.sensors import Camera

CAMERA = Camera()
TURNED = Transform(rotation=rotation_of_rpy(0.03, 0.1, 0.2), translation=np.array([0.0, 0.0, 0.3]))
NOTHING = np.zeros((0, 2))


def pixel_of(point: tuple[float, float], camera: Camera) -> tuple[float, float]:
    """Where the picture shows a point of the floor: the middle of a small ring around it."""
    u, v = ring_in_picture(np.array(point), 1e-4, camera).mean(axis=0).tolist()
    return u, v


@pytest.mark.parametrize(
    "camera", [CAMERA, replace(CAMERA, mounting=TURNED @ CAMERA.mounting)], ids=["level", "tilted"]
)
@pytest.mark.parametrize("point", [(0.9, 0.1), (1.0, -0.3), (2.0, 0.0), (2.0, 0.7)], ids=str)
def test_a_point_of_the_floor_that_is_drawn_and_pressed_comes_back(
    camera: Camera, point: tuple[float, float]
) -> None:
    found = floor_at(*pixel_of(point, camera), camera, NOTHING)
    assert math.dist(found, point) < 1e-3


def test_a_pixel_beside_moves_a_point_two_metres_away_by_less_than_its_error_says() -> None:
    u, v = pixel_of((2.0, 0.0), CAMERA)
    assert math.dist(floor_at(round(u), round(v), CAMERA, NOTHING), (2.0, 0.0)) < 0.05


@pytest.mark.parametrize(
    ("camera", "row", "scan", "why"),
    [
        (CAMERA, 20, NOTHING, ABOVE),
        (CAMERA, 146, NOTHING, FAR(centimetres="30")),
        (CAMERA, 200, np.array([[0.5, 0.0]]), HIDDEN),
        (replace(CAMERA, optics_known=False), 200, NOTHING, ASSUMED),
        (replace(CAMERA, mounting_known=False), 200, NOTHING, ASSUMED),
    ],
    ids=["horizon", "far", "hidden", "optics", "mounting"],
)
def test_a_pixel_that_tells_no_point_of_the_floor_is_refused(
    camera: Camera, row: float, scan: np.ndarray, why: str
) -> None:
    with pytest.raises(BadInput) as refusal:
        floor_at(160, row, camera, scan)
    assert str(refusal.value) == why


def test_what_stands_beside_a_point_or_behind_it_hides_nothing() -> None:
    scan = np.array([[0.5, 0.3], [3.0, 0.0], [-0.5, 0.0]])
    assert floor_at(*pixel_of((1.0, 0.0), CAMERA), CAMERA, scan) == pytest.approx((1.0, 0.0), abs=1e-3)


@pytest.mark.parametrize(
    "camera", [CAMERA, replace(CAMERA, mounting=TURNED @ CAMERA.mounting)], ids=["level", "tilted"]
)
def test_every_point_of_a_way_in_the_picture_is_on_the_way(camera: Camera) -> None:
    angle = np.linspace(0, 1.2, 50)
    way = np.column_stack((1.5 * np.sin(angle), 1.5 * (1 - np.cos(angle))))  # to the left, from under the robot
    (part,) = way_in_picture(way, camera)
    assert 5 < len(part) <= MAX_POINTS + 2
    for u, v, distance in part.tolist():
        x, y = floor_at(u, v, camera, NOTHING)
        assert math.hypot(x, y - 1.5) == pytest.approx(1.5, abs=0.02)
        assert math.hypot(x - camera.mounting.translation[0], y - camera.mounting.translation[1]) == pytest.approx(
            distance, abs=0.02
        )
    edge = camera.model.height - 0.5
    assert edge - part[:, 1].max() < 4, "it begins at the picture's lower border"


def test_a_way_that_leaves_the_picture_and_comes_back_is_two_parts_and_one_behind_none() -> None:
    way = np.array([[1.0, 0.0], [1.0, 3.0], [3.0, 3.0], [3.0, 0.0]])
    first, second = way_in_picture(way, CAMERA)
    assert first[:, 2].max() < 1.5 and second[:, 2].min() > 2.5
    assert len(first) + len(second) <= MAX_POINTS + 2 * MAX_PARTS
    assert way_in_picture(np.array([[-1.0, 0.0], [-3.0, 0.5]]), CAMERA) == []
    assert way_in_picture(np.array([[1.0, 0.0], [1.0, 0.0]]), CAMERA)[0].shape[1] == 3, "a way of no length"


def test_a_ring_is_drawn_where_it_is_seen() -> None:
    assert len(ring_in_picture(np.array([2.0, 0.0]), 0.1, CAMERA)) > 8
    for place in ((-2.0, 0.0), (0.05, 0.0), (1.0, 5.0)):
        assert len(ring_in_picture(np.array(place), 0.1, CAMERA)) == 0
