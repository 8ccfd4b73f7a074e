import math

import numpy as np
import pytest

from core.geometry import Pose, arc
from core.perception.landmarks.corners import Corner
from core.perception.landmarks.edges import EdgeSettings, ImageEdge
from core.perception.landmarks.landmarks import laser_in_picture, sight
from core.sensors import Camera, Laser, Wheels

CAMERA = Camera()
EYE = CAMERA.mounting.translation[:2]


def corner_at(x: float, y: float, sd: float = 0.02) -> Corner:
    return Corner(
        position=np.array([x, y]), covariance=sd**2 * np.eye(2), kind="concave", opening=math.pi, sector=0.7
    )


def edge_at(bearing: float) -> ImageEdge:
    return ImageEdge(top=np.array([10.0, 10.0]), bottom=np.array([10.0, 200.0]), bearing=bearing)


def bearing_from_eye(x: float, y: float) -> float:
    return math.atan2(y - EYE[1], x - EYE[0])


def test_range_and_bearing_carry_the_corner_s_covariance() -> None:
    spread = np.array([[4e-4, 1e-4], [1e-4, 2e-4]])
    corner = Corner(position=np.array([1.2, 0.7]), covariance=spread, kind="convex", opening=0.3, sector=0.7)
    plain = EdgeSettings(inflation=1.0, range_floor=0.0, bearing_floor=0.0)
    ((sighting,), _) = sight((corner,), settings=plain)
    draws = np.random.default_rng(0).multivariate_normal(corner.position, spread, 40000)
    polar = np.column_stack((np.hypot(*draws.T), np.arctan2(draws[:, 1], draws[:, 0])))
    assert np.allclose(sighting.covariance, np.cov(polar.T), rtol=0.05, atol=2e-6)
    assert np.allclose(sighting.position, corner.position)


def test_an_edge_confirms_a_corner_and_sharpens_its_bearing() -> None:
    true = bearing_from_eye(2.0, 0.3)
    off = corner_at(2.0, 0.33)
    ((plain,), _) = sight((off,))
    ((sharp,), (edge,)) = sight((off,), (edge_at(true),), camera=CAMERA)
    assert edge.matched
    assert sharp.confirmed
    assert not plain.confirmed
    assert sharp.covariance[1, 1] < 0.6 * plain.covariance[1, 1]
    assert abs(sharp.bearing - math.atan2(0.3, 2.0)) < abs(plain.bearing - math.atan2(0.3, 2.0))
    assert sharp.covariance[0, 0] == pytest.approx(plain.covariance[0, 0], rel=0.05)


def test_without_edges_every_corner_is_still_a_sighting() -> None:
    corners = (corner_at(2.0, 0.3), corner_at(1.0, -2.0))
    sightings, edges = sight(corners, (edge_at(0.5),), camera=CAMERA)
    assert len(sightings) == 2
    assert not edges[0].matched


def test_the_paper_s_rule_keeps_only_confirmed_corners() -> None:
    corners = (corner_at(2.0, 0.3), corner_at(1.0, -2.0))
    strict = EdgeSettings(edge_required=True)
    sightings, _ = sight(corners, (edge_at(bearing_from_eye(2.0, 0.3)),), camera=CAMERA, settings=strict)
    assert [sighting.confirmed for sighting in sightings] == [True]
    assert sightings[0].range == pytest.approx(math.hypot(2.0, 0.3), abs=0.01)


def test_one_edge_confirms_one_corner() -> None:
    corners = (corner_at(2.0, 0.3), corner_at(2.02, 0.31))
    sightings, _ = sight(corners, (edge_at(bearing_from_eye(2.0, 0.3)),), camera=CAMERA)
    assert sum(sighting.confirmed for sighting in sightings) == 1


@pytest.mark.parametrize(("speed", "turn_rate"), [(0.0, 1.0), (0.3, 0.0), (0.2, -1.2)])
def test_an_edge_seen_earlier_is_shifted_by_the_way_in_between(speed: float, turn_rate: float) -> None:
    corner, earlier = np.array([1.5, 0.2]), -0.08
    then = arc(speed * earlier, turn_rate * earlier)
    seen_then = then.inverse().apply(corner[None])[0]
    edge = edge_at(bearing_from_eye(*seen_then))
    wheels = Wheels(odometry=Pose(), speed=speed, turn_rate=turn_rate)
    ((sighting,), (used,)) = sight(
        (corner_at(1.5, 0.2),), (edge,), stamp=1.0, edges_stamp=1.0 + earlier, wheels=wheels, camera=CAMERA
    )
    assert used.matched
    assert sighting.bearing == pytest.approx(math.atan2(0.2, 1.5), abs=1e-9)


def test_the_faster_the_turn_the_less_an_old_edge_sharpens() -> None:
    def spread(turn_rate: float) -> float:
        then = arc(0.0, -0.1 * turn_rate)
        edge = edge_at(bearing_from_eye(*then.inverse().apply(np.array([[1.5, 0.2]]))[0]))
        wheels = Wheels(odometry=Pose(), speed=0.0, turn_rate=turn_rate)
        ((sighting,), _) = sight(
            (corner_at(1.5, 0.2),), (edge,), stamp=1.0, edges_stamp=0.9, wheels=wheels, camera=CAMERA
        )
        return float(sighting.covariance[1, 1])

    assert spread(0.0) < spread(0.7) < spread(1.4)


def test_laser_points_lie_in_the_picture_where_the_camera_sees_them() -> None:
    laser = Laser()
    points = np.array([[2.0, 0.0], [1.5, 0.4], [-1.0, 0.0], [0.5, 3.0]])
    drawn = laser_in_picture(points, laser, CAMERA)
    assert len(drawn) == 2
    rays = CAMERA.model.unproject(drawn[:, :2])
    for (x, y), ray in zip(points[:2], rays, strict=True):
        assert -math.atan(ray[0]) == pytest.approx(bearing_from_eye(x, y), abs=1e-6)
        assert ray[1] == pytest.approx((0.16 - laser.height) / (x - EYE[0]), abs=1e-6)
    assert np.allclose(drawn[:, 2], np.hypot(*points[:2].T))


def test_no_points_give_no_points() -> None:
    assert laser_in_picture(np.zeros((0, 2)), Laser(), CAMERA).shape == (0, 3)
