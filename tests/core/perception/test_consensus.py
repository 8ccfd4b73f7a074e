"""Who called: voices, pictures and legs agree on a place; echoes and other talkers stand alone."""

import math

import numpy as np
import pytest

from core.geometry import Pose, Ray
from core.perception.people.consensus import Coordinate, GatheredCoordinates, consensus
from core.perception.people.fusion import Sense
from core.perception.people.voice_bearing import VoiceBearing, likeliest

CALLER, OTHER = (2.0, 1.0), (1.0, -1.5)
POSES = (Pose(0.0, 0.0, 0.3), Pose(0.3, -0.1, 0.6), Pose(0.6, 0.1, 0.9))


def seen(sense: Sense, pose: Pose, place: tuple[float, float], rng: np.random.Generator, **more: float) -> Coordinate:
    """A place as one sense perceives it from there."""
    sd = {"sound": 0.06, "camera": 0.03, "laser": 0.03}[sense]
    azimuth = math.atan2(place[1] - pose.y, place[0] - pose.x) + float(rng.normal(0, sd))
    far = math.dist(place, (pose.x, pose.y))
    ray = Ray(x=pose.x, y=pose.y, azimuth=azimuth, sd=sd)
    if sense == "sound":
        return Coordinate(sense=sense, stamp=more.get("stamp", 0.0), ray=ray, weight=more.get("weight", 0.8))
    share = {"camera": 0.15, "laser": 0.02}[sense]
    measured = far * (1 + float(rng.normal(0, share)))
    return Coordinate(sense=sense, stamp=0.0, ray=ray, distance=measured, distance_sd=share * far, weight=0.8)


def scene(rng: np.random.Generator) -> list[Coordinate]:
    """Two people whom the robot sees from three poses, a wall's echo, and chairs."""
    senses: tuple[Sense, ...] = ("camera", "laser")
    found = [seen(sense, pose, place, rng) for sense in senses for pose in POSES for place in (CALLER, OTHER)]
    chairs = [tuple(rng.uniform(-3, 3, 2).tolist()) for _ in range(6)]
    found += [seen("laser", pose, (x, y), rng) for pose in POSES for x, y in chairs]
    moments = (0.0, 1.0, 2.0)
    found += [seen("sound", POSES[0], CALLER, rng, stamp=stamp, weight=0.7) for stamp in moments]
    found += [seen("sound", POSES[0], (-3.0, 4.0), rng, stamp=stamp, weight=0.9) for stamp in moments]  # the echo
    return [*found, seen("sound", POSES[0], OTHER, rng, stamp=2.0, weight=0.9)]  # talks into the last of the words


def test_the_place_on_which_the_senses_agree_is_the_callers_among_an_echo_another_talker_and_chairs() -> None:
    missed = []
    for seed in range(60):
        agreed = consensus(scene(np.random.default_rng(seed)))
        missed.append(math.inf if agreed is None else math.dist(agreed.position.tolist(), CALLER))
    assert np.mean(np.array(missed) < 0.15) >= 0.95, missed


def test_bearings_of_pictures_from_several_poses_cross_where_no_distance_is_known() -> None:
    rng = np.random.default_rng(1)
    rays = [seen("camera", pose, CALLER, rng) for pose in (*POSES, Pose(1.0, -0.8, 1.0))]
    alone = [Coordinate(sense="camera", stamp=0.0, ray=one.ray, weight=0.8) for one in rays]
    agreed = consensus([*alone, seen("sound", POSES[0], CALLER, rng)])
    assert agreed is not None
    assert math.dist(agreed.position.tolist(), CALLER) < 0.25


def test_without_a_voice_or_without_anybody_to_see_there_is_no_place() -> None:
    rng = np.random.default_rng(2)
    assert consensus([]) is None
    assert consensus([seen("camera", POSES[0], CALLER, rng)]) is None
    assert consensus([seen("sound", POSES[0], CALLER, rng), seen("laser", POSES[0], OTHER, rng)]) is None
    assert GatheredCoordinates([]).agreed() is None


def test_coordinates_are_gathered_once_from_every_pose() -> None:
    gathered = GatheredCoordinates([])
    assert [gathered.is_new(pose) for pose in (POSES[0], POSES[0], POSES[1], POSES[1])] == [True, False, True, False]


def bearing(degrees: float, stamp: float, strength: float = 0.8) -> VoiceBearing:
    return VoiceBearing(stamp=stamp, azimuth=math.radians(degrees), sd=0.06, x=0.0, y=0.0, strength=strength)


def test_the_likeliest_direction_was_heard_in_every_moment_of_the_words() -> None:
    heard = [bearing(1, 1.0, 0.7), bearing(0, 2.0, 0.7), bearing(-2, 3.0, 0.7), bearing(60, 3.0, 0.95)]
    found = likeliest(heard)
    assert [round(math.degrees(one.azimuth)) for one in found] in ([0, 60], [1, 60], [-2, 60])
    assert found[0].strength > 2 * found[1].strength == pytest.approx(2 * 0.95 / 3)
    assert {one.stamp for one in found} == {3.0}
