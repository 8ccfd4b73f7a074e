import math
from typing import Any

import cv2
import numpy as np
import pytest

from core.errors import BadInput
from core.geometry import OPTICAL, Transform
from core.perception.landmarks.edges import EdgeSettings, find_edges
from core.perception.landmarks.level_view import level_view
from core.sensors import Camera, Image
from tests.core.perception.corner_room import picture


def pitched(angle: float, yaw: float = 0.0) -> Camera:
    """A camera that looks `angle` [rad] down and `yaw` to the left."""
    c, s = math.cos(angle), math.sin(angle)
    down = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    c, s = math.cos(yaw), math.sin(yaw)
    left = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])
    return Camera(mounting=Transform(rotation=left @ down @ OPTICAL, translation=np.array([0.04, 0.0, 0.16])))


def bearings_in(camera: Camera, shades: list[float], contrast: float = 25.0, lean: float = 0.0) -> list[float]:
    pixels = picture(camera, shades, np.random.default_rng(1), contrast, lean)
    return [edge.bearing for edge in find_edges(Image(stamp=0.0, pixels=pixels), camera)]


@pytest.mark.parametrize("camera", [Camera(), pitched(0.1), pitched(-0.06, 0.3)], ids=["level", "down", "aside"])
@pytest.mark.parametrize("contrast", [40.0, 15.0])
def test_upright_borders_are_seen_at_their_bearings(camera: Camera, contrast: float) -> None:
    yaw = level_view(camera).yaw
    shades = [yaw + off for off in (-0.4, -0.11, 0.07, 0.35)]
    seen = sorted(bearings_in(camera, shades, contrast))
    assert np.allclose(seen, shades, atol=math.radians(0.1))


def test_the_ends_lie_on_the_edge_in_the_picture_as_delivered() -> None:
    camera = Camera()
    pixels = picture(camera, [-0.38], np.random.default_rng(0))
    (edge,) = find_edges(Image(stamp=0.0, pixels=pixels), camera)
    rays = camera.model.unproject(np.array([edge.top, edge.bottom]))
    assert np.allclose(-np.arctan(rays[:, 0]), -0.38, atol=math.radians(0.15))
    assert edge.bottom[1] - edge.top[1] > 0.2 * camera.model.height


@pytest.mark.campaign
def test_what_leans_is_no_vertical_edge() -> None:
    assert bearings_in(Camera(), [0.1], 40.0, math.radians(3)) != []
    assert bearings_in(Camera(), [0.1], 40.0, math.radians(12)) == []


def test_a_plain_wall_has_no_edge() -> None:
    assert bearings_in(Camera(), []) == []


@pytest.mark.campaign
def test_both_shapes_of_hough_segments_are_understood(monkeypatch: pytest.MonkeyPatch) -> None:
    flat = bearings_in(Camera(), [-0.2, 0.2])
    found = cv2.HoughLinesP

    def nested(*positional: Any, **named: Any) -> Any:
        return np.asarray(found(*positional, **named)).reshape(-1, 1, 4)

    monkeypatch.setattr(cv2, "HoughLinesP", nested)
    assert bearings_in(Camera(), [-0.2, 0.2]) == flat


def test_a_picture_of_another_size_is_refused_with_a_sentence() -> None:
    with pytest.raises(BadInput, match="640x480"):
        find_edges(Image(stamp=0.0, pixels=np.zeros((480, 640, 3), np.uint8)), Camera(), EdgeSettings())


def test_a_level_pixel_and_its_place_in_the_picture_are_the_same_ray() -> None:
    camera = pitched(0.08, -0.2)
    view = level_view(camera)
    pixels = np.array([[120.0, 150.0], [200.0, 90.0], [260.0, 210.0]])
    rays = camera.model.unproject(view.to_picture(pixels))
    ways = np.column_stack((rays, np.ones(3))) @ camera.mounting.rotation.T
    assert np.allclose(np.arctan2(ways[:, 1], ways[:, 0]), [view.bearing(u) for u in pixels[:, 0]], atol=1e-6)
