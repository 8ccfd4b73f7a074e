"""The pilot of a robot that someone carries away."""

import contextlib
import math
from dataclasses import replace

import pytest

from core.commands.command import Command
from core.errors import BadInput, Refused
from core.geometry import Pose, wrap
from core.pilot import Pilot
from core.robots.requests import CarryRobot, PlaceThing, RemoveThing
from core.sensors.checks import fault
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import SimulationSettings
from core.snapshot import ActiveCommandStatus, Snapshot
from core.speech.understanding.grammar import understand

CROWD = (-150, -115, -80, -50, 50, 80, 115, 150)  # [deg] where things stand around the robot


def command(words: str) -> Command:
    heard = understand(words)
    assert isinstance(heard, Command)
    return heard


class Outing:
    """A simulated robot in the lab with its pilot, obeyed as the gate would."""

    def __init__(self, seed: int) -> None:
        self.robot = SimulatedRobot("lab", seed=seed, settings=SimulationSettings(camera=False))
        self.pilot = Pilot(self.robot.profile)
        self.now: Snapshot = self.step()
        self.told = 0

    def step(self, frames: int = 1) -> Snapshot:
        for _ in range(frames):
            self.now = self.pilot.step(self.robot.read())
            self.robot.drive(self.now.setpoint)
        return self.now

    def obey(self, words: str, frames: int = 1200) -> Snapshot:
        """Tell, and wait for the end."""
        self.told += 1
        self.pilot.tell(self.told, command(words), "typed", "anna")
        for _ in range(frames):
            if any(ending.id == self.told for ending in self.step().endings):
                return self.now
        raise AssertionError(f"{words} has no end")

    def look_around(self) -> None:
        """Know the room; while all is well nothing is suspected."""
        self.step(140)
        for words in ("turn left", "turn left"):
            self.obey(words)
            assert self.now.floor.lost is None

    def carry(self, x: float, y: float, heading: float) -> None:
        self.robot.ask(CarryRobot(x_m=x, y_m=y, heading_rad=heading))

    def until_lost(self) -> None:
        for _ in range(120):
            if self.step().floor.lost is not None:
                return
        raise AssertionError("nothing was noticed")

    def error(self) -> tuple[float, float]:
        truth, pose = self.now.truth, self.now.estimate.pose
        assert truth is not None
        return truth.distance_to(pose.x, pose.y), abs(wrap(truth.heading - pose.heading))


@pytest.fixture
def outing() -> Outing:
    made = Outing(seed=4)
    made.look_around()
    return made


@pytest.mark.campaign
def test_a_carried_robot_stands_refuses_freezes_the_map_and_finds_back_by_turning_on_command(outing: Outing) -> None:
    outing.carry(0.6, 0.5, 2.2)
    outing.until_lost()
    lost, cells = outing.now.floor.lost, outing.now.grid.log_odds.copy()
    assert lost is not None and lost.words.startswith("I have lost my place")
    with pytest.raises(Refused, match="Not now: I have lost my place"):
        outing.pilot.tell(90, command("continue 1 meters"), "typed", "anna")
    outing.step(60)
    assert not outing.now.setpoint.moves and outing.now.floor.lost is not None
    assert outing.now.notices[-1].text == outing.now.floor.lost.words  # one notice, in the words of now
    while_lost = outing.now.grid.log_odds
    assert while_lost.shape == cells.shape and (while_lost == cells).all()
    outing.told, before = 100, outing.now.truth
    outing.obey("turn left")
    assert outing.now.floor.lost is None
    assert before is not None and outing.now.truth is not None
    assert abs(wrap(outing.now.truth.heading - before.heading) - math.pi / 2) < math.radians(4)
    assert any(notice.text.startswith("I know where I am again") for notice in outing.now.notices)
    distance, angle = outing.error()
    assert distance < 0.1 and angle < math.radians(3)


@pytest.mark.campaign
def test_carried_under_way_it_turns_by_leave_of_the_command_which_then_ends(outing: Outing) -> None:
    outing.pilot.tell(7, command("continue 1 meters"), "typed", "anna")
    outing.step(20)
    outing.carry(0.6, 0.5, 2.2)
    outing.until_lost()
    endings, turned = [], False
    for _ in range(400):
        snapshot = outing.step()
        if snapshot.floor.lost is not None and snapshot.setpoint.moves:
            turned = True
            assert snapshot.setpoint.v == 0.0 and 0.0 < snapshot.setpoint.w <= 0.6
            assert snapshot.setpoint_command_id == 7
        endings += snapshot.endings
        if endings:
            break
    assert turned
    assert [(e.id, e.state) for e in endings] == [(7, "failed")]
    assert "somewhere else than it believed" in endings[0].remark
    assert outing.now.floor.lost is None
    distance, angle = outing.error()
    assert distance < 0.1 and angle < math.radians(3)


@pytest.mark.campaign
def test_a_click_brings_the_robot_back_without_a_move(outing: Outing) -> None:
    outing.carry(0.6, 0.5, 2.2)
    outing.until_lost()
    outing.pilot.place_at(0.9, 0.3)
    for _ in range(200):
        if outing.step().floor.lost is None:
            break
        assert not outing.now.setpoint.moves
    assert outing.now.floor.lost is None
    distance, angle = outing.error()
    assert distance < 0.1 and angle < math.radians(3)


@pytest.mark.campaign
def test_where_things_hid_the_walls_the_command_waits_and_goes_on(outing: Outing) -> None:
    start = outing.now.truth
    assert start is not None
    outing.pilot.tell(9, command("continue 0.8 meters"), "typed", "anna")
    here = outing.step(60).truth
    assert here is not None
    crowd = {str(angle): here @ Pose(0.0, 0.0, math.radians(angle)) for angle in CROWD}
    for name, towards in crowd.items():
        place = towards @ Pose(0.5, 0.0, 0.0)
        with contextlib.suppress(BadInput):  # in a wall
            outing.robot.ask(PlaceThing(what="box", id=name, x_m=place.x, y_m=place.y))
    outing.until_lost()
    for name in crowd:
        with contextlib.suppress(BadInput):
            outing.robot.ask(RemoveThing(id=name))
    endings: list[ActiveCommandStatus] = []
    for _ in range(1200):
        endings += outing.step().endings
    assert [(ending.id, ending.state) for ending in endings] == [(9, "done")]
    end = outing.now.truth
    assert end is not None and start.distance_to(end.x, end.y) == pytest.approx(0.8, abs=0.05)
    assert any("I know where I am again" in notice.text for notice in outing.now.notices)


@pytest.mark.parametrize("rolled", [0.0, 0.4])
def test_after_a_restart_of_the_base_the_robot_looks_for_its_place(rolled: float) -> None:
    outing = Outing(seed=4)
    outing.step(140)
    place = outing.robot.read().truth
    assert place is not None
    outing.carry(
        place.x + rolled * math.cos(place.heading), place.y + rolled * math.sin(place.heading), place.heading
    )
    restarted = fault("odometry.restarted", "the base", used=True, count=1, at="3.5")
    outing.now = outing.pilot.step(replace(outing.robot.read(), scan=None, faults=(restarted,)))
    assert outing.now.floor.lost is not None
    assert "restarted" in outing.now.floor.lost.words
    now = outing.step(80)
    truth, lost = now.truth, now.floor.lost
    assert truth is not None
    places = [now.estimate.pose.vector] if lost is None else list(lost.candidates)
    assert min(truth.distance_to(x, y) for x, y, _ in places) < 0.1
    assert rolled or lost is None  # one view does not tell places apart


def test_a_robot_that_has_not_moved_yet_turns_left_to_find_itself_on_a_loaded_map(outing: Outing) -> None:
    saved = outing.pilot.keep_map()
    again = Outing(seed=5)
    again.step(140)
    again.pilot.enter_map(saved)
    again.step(40)
    assert again.now.floor.lost is not None and not again.now.slam.looking_around
    again.obey("turn left", frames=400)  # as the robot advises; its still start would wait for ever while it is lost
    assert again.now.floor.lost is None
    distance, angle = again.error()
    assert distance < 0.1 and angle < math.radians(3)
