"""The pilot's doors to the map: keep it, enter it, say where the robot is, take a closure back."""

from pathlib import Path

import pytest

from core.errors import Refused
from core.gate import ZERO, Twist
from core.pilot import Pilot
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import SimulationSettings
from core.slam.map.map_file import SavedMap
from tests.core.pilot.test_pilot import command


def lab() -> SimulatedRobot:
    return SimulatedRobot("lab", seed=4, settings=SimulationSettings(camera=False))


def test_before_the_first_scan_there_is_no_map_to_keep() -> None:
    with pytest.raises(Refused, match="no map yet"):
        Pilot(lab().profile).keep_map()


def test_one_room_is_one_submap_at_the_origin_and_nothing_is_closed() -> None:
    robot = lab()
    pilot = Pilot(robot.profile)
    snapshot = pilot.step(robot.read())
    for _ in range(120):
        snapshot = pilot.step(robot.read())
    assert [room.id for room in snapshot.floor.submaps] == [0]
    assert snapshot.floor.submaps[0].active
    assert snapshot.floor.closures == ()
    assert snapshot.floor.lost is None
    assert snapshot.floor.match_score is None or snapshot.floor.match_score > 0.5
    pilot.believe_closure(7, believed=False)
    pilot.believe_closure(7, believed=True)
    assert pilot.step(robot.read()).floor.graph_revision == 0
    assert pilot.where(pilot.anchored_pose).vector == pytest.approx(
        pilot.step(robot.read()).estimate.pose.vector, abs=1e-9
    )


def test_in_a_map_of_the_drive_that_is_under_way_the_robot_is_where_it_was(tmp_path: Path) -> None:
    robot = lab()
    pilot = Pilot(robot.profile)
    for number in range(200):
        robot.drive(Twist(0.1, 0.3) if 80 < number < 160 else ZERO)
        before = pilot.step(robot.read())
    pilot.keep_map().to_files(tmp_path)
    pilot.enter_map(SavedMap.from_files(tmp_path))
    for number in range(120):
        found = pilot.step(robot.read())
        if number > 2 and found.floor.lost is None:
            break
    assert found.floor.lost is None and number < 60
    assert found.estimate.pose.distance_to(before.estimate.pose.x, before.estimate.pose.y) < 0.03


def test_a_map_is_kept_and_entered_and_the_robot_finds_its_place_in_it(tmp_path: Path) -> None:
    robot = lab()
    first = Pilot(robot.profile)
    for _ in range(120):
        before = first.step(robot.read())
    first.keep_map().to_files(tmp_path)
    second = Pilot(robot.profile)
    second.step(robot.read())
    second.enter_map(SavedMap.from_files(tmp_path))
    entered = second.step(robot.read())
    assert entered.floor.lost is not None
    assert "this map was just loaded" in entered.floor.lost.words
    assert [one.level for one in entered.notices if one.cause == "place"] == ["info"], "no incident is kept of it"
    with pytest.raises(Refused, match="Not now"):
        second.tell(1, command("continue 1 meters"), "typed", "anna")
    second.step(robot.read())
    second.place_at(0.1, -0.1, 0.1)
    for _ in range(200):
        found = second.step(robot.read())
        if found.floor.lost is None:
            break
    assert found.floor.lost is None
    assert found.estimate.pose.distance_to(before.estimate.pose.x, before.estimate.pose.y) < 0.05
    assert [mark.id for mark in found.landmarks] == [mark.id for mark in before.landmarks]
