"""Two cameras beside each other: the distance of an edge, how sure it is, and what is no view of one edge."""

import math
from dataclasses import replace

import numpy as np
import pytest

from core.geometry import Pose
from core.perception.landmarks.edges import EdgeSettings, ImageEdge
from core.perception.landmarks.stereo import edges_by_pair, second_camera
from core.pilot import Pilot
from core.robots.requests import CarryRobot
from core.sensors import Camera
from core.settings import Settings
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import SimulationSettings

FIRST = Camera()
SETTINGS = EdgeSettings()


def beside(shift: float, name: str = "second", turn: float = 0.0) -> Camera:
    c, s = math.cos(turn), math.sin(turn)
    rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ FIRST.mounting.rotation
    place = FIRST.mounting.translation + np.array([0.0, shift, 0.0])
    return replace(FIRST, name=name, mounting=replace(FIRST.mounting, rotation=rotation, translation=place))


SECOND = beside(-0.12)


def edge(camera: Camera, x: float, y: float, step: float = 40.0, off: float = 0.0) -> ImageEdge:
    """An upright edge at a place [m] in the robot frame, 0 to 1 m high, its bearing off by so much [rad]."""
    ends = camera.model.project(camera.mounting.inverse().apply(np.array([[x, y, 1.0], [x, y, 0.0]])))
    eye_x, eye_y = camera.mounting.translation[:2]
    return ImageEdge(top=ends[0], bottom=ends[1], bearing=math.atan2(y - eye_y, x - eye_x) + off, step=step)


def seen(first: list[ImageEdge], second: list[ImageEdge], eye: Pose | None = None):
    at = eye or Pose(*FIRST.mounting.translation[:2].tolist())
    return edges_by_pair(tuple(first), tuple(second), (FIRST, SECOND), at, 1.5, SETTINGS)


def test_an_edge_in_both_pictures_is_as_far_as_its_rays_cross() -> None:
    places = [(1.2, 0.3), (2.0, -0.4), (3.1, 0.9)]
    (sightings, alone) = seen([edge(FIRST, *place) for place in places], [edge(SECOND, *place) for place in places])
    assert not alone
    assert np.allclose([one.position for one in sightings], places, atol=1e-9)
    assert [(one.kind, one.stamp) for one in sightings] == [("rise", 1.5)] * 3
    turned = Pose(0.5, 0.2, math.pi / 2)
    (moved,), _ = seen([edge(FIRST, *places[0])], [edge(SECOND, *places[0])], turned)
    x, y = places[0][0] - FIRST.mounting.translation[0], places[0][1]
    assert np.allclose(moved.position, turned.apply(np.array([[x, y]]))[0])


def test_its_covariance_is_that_of_bearings_off_by_chance() -> None:
    rng, place = np.random.default_rng(0), (2.0, 0.5)
    (sure,), _ = seen([edge(FIRST, *place)], [edge(SECOND, *place)])
    drawn: list[np.ndarray] = []
    for own, other, both in rng.normal(size=(2000, 3)).tolist():
        mount, pair = both * SETTINGS.bearing_sd, SETTINGS.pair_sd
        edges = [edge(FIRST, *place, off=mount + own * pair)], [edge(SECOND, *place, off=mount + other * pair)]
        drawn += [np.array([one.range, one.bearing]) for one in seen(*edges)[0]]
    assert len(drawn) == 2000
    floor = np.diag([SETTINGS.range_floor**2, SETTINGS.bearing_floor**2])
    assert np.allclose(np.cov(np.array(drawn).T) + floor, sure.covariance, rtol=0.15, atol=1e-5)


@pytest.mark.parametrize(
    "other",
    [
        [],
        [edge(SECOND, 2.0, 0.1, step=-40.0)],  # becomes darker
        [edge(SECOND, 2.0, 0.1, step=15.0)],  # another step
        [edge(SECOND, 2.0, 0.1), edge(SECOND, 2.02, 0.05)],  # either may be it
        [edge(SECOND, 0.9, 0.1)],  # another edge: its ends lie elsewhere
        [edge(SECOND, 2.0, -0.3)],  # behind the cameras
    ],
    ids=["none", "darker", "paler", "two", "nearer", "behind"],
)
def test_what_is_not_surely_a_view_of_the_same_edge_stays_a_bearing(other: list[ImageEdge]) -> None:
    mine = edge(FIRST, 2.0, 0.1)
    assert seen([mine], other) == ((), (mine,))


def test_far_away_the_pictures_do_not_differ_enough() -> None:
    assert len(seen([edge(FIRST, 3.0, 0.0)], [edge(SECOND, 3.0, 0.0)])[0]) == 1
    assert not seen([edge(FIRST, 40.0, 0.0)], [edge(SECOND, 40.0, 0.0)])[0]


def test_a_pair_looks_the_same_way_from_beside_each_other() -> None:
    assert second_camera((FIRST, SECOND)) is SECOND
    behind = beside(-0.12, "behind", math.pi)
    assert second_camera((FIRST, beside(0.001), behind, SECOND)) is SECOND
    assert second_camera((FIRST, behind)) is second_camera((FIRST,)) is second_camera(()) is None


def test_the_simulated_pair_takes_its_pictures_at_the_same_moment() -> None:
    alone, robot = (SimulatedRobot("lab", settings=SimulationSettings(second_camera=one)) for one in (0.0, 0.12))
    assert second_camera(alone.profile.cameras) is None
    assert second_camera(robot.profile.cameras) is robot.profile.cameras[1]
    robot.ask(CarryRobot(x_m=1.0, y_m=0.5, heading_rad=0.3))
    images = [image for _ in range(40) if (image := robot.read().image) is not None]
    pairs = list(zip(images[::2], images[1::2], strict=False))
    assert len(pairs) >= 8
    assert all((one.camera, two.camera, one.stamp) == ("", "second", two.stamp) for one, two in pairs)
    assert all(np.abs(one.pixels.astype(int) - two.pixels).mean() > 5 for one, two in pairs)


@pytest.mark.parametrize("by_pair", [True, False])
def test_the_pilot_of_a_robot_without_a_laser_has_landmarks_on_the_walls_where_it_stands(by_pair: bool) -> None:
    given = Settings()
    simulation = replace(given.simulation, second_camera=0.12)
    given = replace(given, simulation=simulation, edges=replace(given.edges, by_pair=by_pair))
    robot = SimulatedRobot("glass", settings=simulation)
    pilot = Pilot(replace(robot.profile, lasers=(), arrays=()), given)
    for _ in range(80):
        places = np.array(
            [one.position for one in pilot.step(replace(robot.read(), scan=None, sound=None)).landmarks]
        )
    assert (len(places) >= 2) == by_pair
    x, y = places.reshape(-1, 2).T  # of windows in the walls: x from -2 to 6, y from -3 to 3
    assert np.all(np.minimum(np.minimum(abs(x + 2), abs(x - 6)), np.minimum(abs(y + 3), abs(y - 3))) < 0.3)
