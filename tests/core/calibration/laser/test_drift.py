"""Whether the camera's mount has moved: told soon, told in words, and not told for nothing."""

import math
from collections.abc import Iterator

import numpy as np
import pytest

from core.calibration.laser.drift import DriftSettings, Gathered, MountWatch, fit
from core.gate import Twist
from core.geometry import Pose, Transform
from core.perception.landmarks.corners import Corner
from core.perception.landmarks.edge_pairs import WINDOW_RAD, EdgePair, edge_pairs
from core.perception.landmarks.edges import EdgeSettings, ImageEdge
from core.pilot import Pilot
from core.sensors import Camera
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import SimulationSettings

SETTINGS = EdgeSettings()


def turned(camera: Camera, angle: float, left: float = 0.0) -> Camera:
    """The camera as it sits after it was turned [rad] and shifted [m] on its mount."""
    turn = Transform.of_pose(Pose(0, 0, angle)).rotation
    return Camera(
        mounting=Transform(
            rotation=turn @ camera.mounting.rotation,
            translation=camera.mounting.translation + np.array([0.0, left, 0.0]),
        )
    )


def corner(x: float, y: float) -> Corner:
    return Corner(position=np.array([x, y]), covariance=np.eye(2) * 1e-6, kind="convex", opening=0.0, sector=1.0)


def edge_of(at: Corner, really: Camera, believed: Camera) -> ImageEdge:
    """What the edge finder tells of a corner's edge, when it takes the believed mount for the real one."""
    pixel = really.model.project(
        really.mounting.inverse().apply(np.array([[*at.position, really.mounting.translation[2]]]))
    )
    (ray,) = really.model.unproject(pixel)
    way = believed.mounting.rotation @ np.array([ray[0], ray[1], 1.0])
    return ImageEdge(top=np.zeros(2), bottom=np.ones(2), bearing=math.atan2(way[1], way[0]))


@pytest.mark.parametrize(("x", "y"), [(1.0, 0.2), (2.5, -0.9), (0.8, 0.0)])
def test_a_pair_tells_the_turn_and_the_shift_of_the_mount_with_their_signs(x: float, y: float) -> None:
    believed, there = Camera(), corner(x, y)
    turn, shift = math.radians(0.4), 0.003
    for told in ((turn, 0.0), (0.0, shift)):
        edges = (edge_of(there, turned(believed, *told), believed),)
        (pair,) = edge_pairs((there,), edges, Pose(), believed, SETTINGS)
        assert pair.off == pytest.approx(-told[0] - told[1] * pair.lever, abs=2e-5)


def test_every_edge_in_the_window_is_a_pair_not_only_the_nearest() -> None:
    camera, there = Camera(), corner(2.0, 0.3)
    true = edge_of(there, camera, camera)
    edges = tuple(
        ImageEdge(top=true.top, bottom=true.bottom, bearing=true.bearing + off)
        for off in (-0.07, 0.03, 0.0, WINDOW_RAD + 0.01)
    )
    offs = sorted(pair.off for pair in edge_pairs((there,), edges, Pose(), camera, SETTINGS))
    assert offs == pytest.approx([-0.07, 0.0, 0.03], abs=1e-6)


def drawn(rng: np.random.Generator, turn: float, shift: float, corners: int = 14, each: int = 10) -> Gathered:
    """Pairs as they come: each corner has an error of its own, and every true pair brings two of chance."""
    own = np.repeat(np.arange(corners), each)
    lever = np.repeat(1 / rng.uniform(0.8, 3.5, corners), each) * rng.uniform(0.9, 1.1, len(own))
    sd = np.full(len(own), math.radians(0.3))
    own_error = np.repeat(rng.normal(0, math.radians(0.12), corners), each)
    true = -turn - shift * lever + own_error + rng.normal(0, sd)
    chance = rng.uniform(-WINDOW_RAD, WINDOW_RAD, 2 * len(own))
    return Gathered(
        off=np.concatenate((true, chance)),
        sd=np.tile(sd, 3),
        lever=np.tile(lever, 3),
        weight=np.ones(3 * len(own)),
        corner=np.tile(own, 3),
    )


@pytest.mark.parametrize(("turn", "shift"), [(0.0, 0.0), (0.5, 0.0), (-4.0, 0.0), (0.3, 0.02)])
def test_turn_and_shift_are_found_among_chance_pairs_and_the_standard_deviations_hold(
    turn: float, shift: float
) -> None:
    rng, scores = np.random.default_rng(5), list[tuple[float, float]]()
    for _ in range(40):
        found = fit(drawn(rng, math.radians(turn), shift))
        assert found is not None
        usual = 1 / 1.8
        apparent = math.radians(turn) + shift * usual
        scores.append(((found.turn - math.radians(turn)) / found.turn_sd, (found.shift - shift) / found.shift_sd))
        assert found.apparent == pytest.approx(apparent, abs=math.radians(0.35))
        assert found.apparent_sd < math.radians(0.12)
    spread = np.sqrt(np.mean(np.square(scores), axis=0))
    assert (spread > 0.3).all()
    assert (spread < 1.3).all()


def test_too_few_corners_tell_nothing() -> None:
    assert fit(drawn(np.random.default_rng(0), 0.0, 0.0, corners=2)) is None


Met = Iterator[tuple[float, Pose, tuple[EdgePair, ...]]]


def met(rng: np.random.Generator, turn: float, seconds: float, start: float = 0.0) -> Met:
    """A drive past twelve corners: two of them are seen at a time."""
    places = np.column_stack((np.arange(12) * 0.8, np.tile((1.0, -1.2), 6)))
    own = rng.normal(0, math.radians(0.12), len(places))
    for number in range(int(10 * seconds)):
        stamp = start + 0.1 * number
        pose = Pose(0.12 * stamp % 9.0, 0.0, 0.0)
        ahead = np.flatnonzero((places[:, 0] > pose.x + 0.5) & (places[:, 0] < pose.x + 2.5))[:2]
        pairs = [
            EdgePair(position=pose.inverse().apply(places[k][None])[0], off=float(off), sd=0.005, lever=0.6)
            for k in ahead.tolist()
            for off in (-turn + own[k] + rng.normal(0, 0.005), rng.uniform(-WINDOW_RAD, WINDOW_RAD))
        ]
        yield stamp, pose, tuple(pairs)


def test_an_alarm_begins_once_says_by_how_much_and_ends_with_a_new_calibration() -> None:
    watch, camera = MountWatch(), Camera()
    told: list[tuple[float, str]] = []
    for stamp, pose, pairs in met(np.random.default_rng(0), math.radians(-0.8), 60):
        watch.watch(stamp, pose, pairs, camera)
        if watch.alarm and (not told or told[-1][1] != watch.alarm):
            told.append((stamp, watch.alarm))
    ((begun, words),) = told
    assert begun < 40
    assert words.startswith("The camera seems to have turned by 0.")
    assert words.endswith("° to the right on its mount; calibrate the laser again.")
    assert watch.drift is not None
    assert watch.drift.alarm
    assert watch.drift.apparent == pytest.approx(math.radians(-0.8), abs=math.radians(0.15))
    watch.watch(61.0, Pose(), (), Camera())
    assert watch.alarm == ""
    assert watch.drift is None


def test_a_mount_that_is_put_right_ends_the_alarm() -> None:
    watch, camera, rng = MountWatch(), Camera(), np.random.default_rng(1)
    for stamp, pose, pairs in met(rng, math.radians(1.0), 60):
        watch.watch(stamp, pose, pairs, camera)
    assert watch.alarm
    for stamp, pose, pairs in met(rng, 0.0, 120, start=60.0):
        watch.watch(stamp, pose, pairs, camera)
    assert not watch.alarm


def test_a_robot_that_stands_still_learns_nothing_new() -> None:
    watch, camera = MountWatch(DriftSettings(corners=1)), Camera()
    pairs = tuple(EdgePair(position=np.array([1.0 + k, 0.0]), off=0.02, sd=0.005, lever=0.5) for k in range(4))
    for number in range(200):
        watch.watch(0.1 * number, Pose(), pairs, camera)
    assert watch.drift is None


def test_chance_alone_is_no_alarm() -> None:
    camera = Camera()
    for seed in range(6):
        watch, rng = MountWatch(), np.random.default_rng(seed)
        for stamp, pose, pairs in met(rng, 0.0, 90):
            watch.watch(stamp, pose, pairs, camera)
            assert not watch.alarm


@pytest.mark.campaign
def test_a_robot_whose_camera_was_turned_notices_while_it_drives() -> None:
    robot = SimulatedRobot("lab", seed=3, settings=SimulationSettings(camera_rate=2.5))
    camera = robot.profile.camera
    assert camera is not None
    pilot = Pilot(robot.profile.with_camera(turned(camera, math.radians(-0.8))))
    told: list[str] = []
    stamp = 0.0
    while not told and stamp < 40:
        phase = stamp / 12
        robot.drive(Twist(0.1 * math.cos(math.tau * phase), 0.45 * math.copysign(1, math.sin(0.5 * phase))))
        snapshot = pilot.step(robot.read())
        stamp = snapshot.stamp
        told = [notice.text for notice in snapshot.notices if "mount" in notice.text]
    assert told
    assert told[0].startswith("The camera seems to have turned by 0.")
    assert "to the left" in told[0]
