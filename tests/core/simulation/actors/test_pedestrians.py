"""People in the simulated room: what they wear, what they do, and that they walk without touching the robot."""

import math
from typing import Any

import numpy as np
import pytest

from core.errors import BadInput
from core.geometry import Pose
from core.robots.requests import PlacedThing, PlaceThing, ReadPlan, ReadTruth
from core.simulation.rendering.person import CLOTHES, figure
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import SimulationSettings
from core.simulation.world import COLOURS, GESTURES, Thing


def robot(**changes: Any) -> SimulatedRobot:
    return SimulatedRobot("lab", seed=3, settings=SimulationSettings(microphones="none", **changes))


def place(one: SimulatedRobot, **wish: Any) -> PlacedThing:
    return one.ask(PlaceThing(**({"what": "person", "id": "Ann", "x_m": 1.0, "y_m": 1.0} | wish)))


def person(one: SimulatedRobot) -> PlacedThing:
    things = one.ask(ReadPlan()).things
    return next(thing for thing in things if isinstance(thing, PlacedThing) and thing.id == "Ann")


def room_after(one: SimulatedRobot) -> float:
    """Room [m] between the body and what is nearest after one frame: who stands feels no bumper."""
    one.read()
    return one.ask(ReadTruth()).clearance_m


def test_every_colour_and_gesture_can_be_drawn() -> None:
    assert set(CLOTHES) == set(COLOURS)
    shapes = {gesture: figure(0, "", gesture)[:, :, 3] for gesture in GESTURES}
    assert all((shapes[one] != shapes[other]).any() for one in GESTURES for other in GESTURES if one < other)
    assert figure(0, "green/black")[:, :, 3].tolist() == figure(0)[:, :, 3].tolist()
    assert (figure(0, "green/black") != figure(0)).any()
    assert (figure(4, stride=math.pi / 2)[:, :, 3] != figure(4)[:, :, 3]).any()


def test_a_person_walks_the_path_at_that_speed_and_stays_at_its_end() -> None:
    one = robot(camera=False)
    told = place(one, x_m=1.0, y_m=1.0, heading_rad=0.0, path_m=((2.0, 1.0), (2.0, 2.0)), speed_m_s=0.5)
    assert told.path_m == ((2.0, 1.0), (2.0, 2.0))
    for _ in range(40):
        one.read()
    assert person(one).x_m == pytest.approx(1.5, abs=0.02)
    assert person(one).y_m == pytest.approx(1.0, abs=0.01)
    for _ in range(200):
        one.read()
    assert (person(one).x_m, person(one).y_m) == (pytest.approx(2.0, abs=0.01), pytest.approx(2.0, abs=0.01))
    assert person(one).heading_rad == pytest.approx(math.pi / 2, abs=0.05)
    place(one, x_m=3.0, y_m=1.5)
    one.read()
    assert person(one).x_m == 3.0


def test_a_walker_goes_around_a_robot_in_the_way() -> None:
    one = robot(camera=False)
    place(one, x_m=1.5, y_m=0.0, path_m=[[-1.0, 0.0]], speed_m_s=1.0)
    assert min(room_after(one) for _ in range(200)) > 0.02
    assert person(one).x_m == pytest.approx(-1.0, abs=0.01)
    place(one, x_m=1.5, y_m=0.0, path_m=[[0.2, 0.0]], speed_m_s=1.0)  # to where the robot itself leaves no room
    assert min(room_after(one) for _ in range(200)) > 0.02
    assert 0.2 < person(one).x_m < 0.4


@pytest.mark.parametrize(
    ("speed", "begin", "end"),
    [(0.21, -0.08, -0.25), (0.44, -0.05, -0.28), (0.65, -0.14, -0.15), (0.75, -0.07, -0.22), (1.0, -0.11, -0.19)],
)
def test_no_foot_of_a_walker_comes_to_a_robot_that_stands(speed: float, begin: float, end: float) -> None:
    one = robot(camera=False)
    place(one, x_m=1.2, y_m=begin, path_m=[[-1.0, end]], speed_m_s=speed)
    assert min(room_after(one) for _ in range(round(60 / speed))) > 0.025


def test_the_laser_sees_two_legs_that_swing_with_the_step() -> None:
    def legs(stride: float) -> list[float]:
        pose = Pose(2.0, 0.0, 0.0)
        thing = Thing(id="p", what="person", pose=pose, length=0.4, depth=0.4, height=1.75, stride=stride)
        return [float(solid.centre[0]) for solid in thing.solids]

    assert legs(0.0) == [2.0, 2.0]
    assert legs(math.pi / 2) == pytest.approx([2.15, 1.85])
    one = robot(camera=False, laser_noise="none", dropout=0.0)
    place(one, x_m=1.0, y_m=0.0, heading_rad=math.pi)
    scan = next(frame.scan for frame in iter(one.read, None) if frame.scan is not None)
    near = scan.ranges < 1.0
    angles = scan.angles[near & (np.abs(scan.angles) < 0.3)]
    assert np.diff(angles).max() > 0.05  # free sight between the legs


@pytest.mark.parametrize(
    ("wish", "complaint"),
    [
        ({"clothes": "red"}, "clothes must be"),
        ({"clothes": "red/pink"}, "clothes must be"),
        ({"gesture": "dance"}, "gesture must be"),
        ({"what": "box", "id": "b", "gesture": "wave"}, "Only a person has"),
        ({"what": "box", "id": "b", "path_m": [[2, 1]]}, "Only a person can walk"),
        ({"path_m": []}, "path_m must be a list"),
        ({"path_m": [[1, math.nan]]}, "finite"),
        ({"path_m": [[2, 1]], "speed_m_s": 9}, "speed_m_s must lie"),
        ({"path_m": [[9, 1]]}, "Nobody can walk past"),
        ({"x_m": 3.1, "y_m": -1.35}, "does not fit there"),  # under the bench
        ({"x_m": 3.1, "y_m": 0.0, "path_m": [[3.1, -2.1]]}, "Nobody can walk past"),
    ],
)
def test_what_no_person_can_do_is_refused_with_a_reason(wish: dict[str, Any], complaint: str) -> None:
    one = robot(camera=False)
    with pytest.raises(BadInput, match=complaint):
        place(one, **wish)
