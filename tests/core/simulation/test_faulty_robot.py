"""A simulated robot with faults: what it is given falls on what it senses, and the robot stands in time."""

import math

import numpy as np
import pytest

from core.errors import BadInput
from core.gate import TICK_S, Gate, Limits, Twist
from core.pilot import Pilot
from core.robots.connect import connect
from core.robots.injected_faults import INJECTABLE_FAULTS, read_faults
from core.robots.nearness import NearField
from core.settings import Settings
from core.simulation.settings import SimulationSettings
from tests.benchmarks.late_scans import pressed_on, see

BEGIN_S, END_S = 2.0, 3.5
STANDS_S = 0.55  # after the fault began, of the robot's time
BLIND = Settings(simulation=SimulationSettings(camera=False, microphones="none"))


def stood_after(faults: str) -> float:
    """A stubborn hand drives the robot from 1 s on → when it stands for good, from `BEGIN_S` on [s]; inf: never."""
    robot = connect(f"sim:lab?faults={faults},after:{BEGIN_S}", seed=1, settings=BLIND)
    gate, field = Gate(Limits()), NearField(robot.profile.lasers)
    gate.arm(1, "a stubborn hand", 0.0)
    tick, press, stood = 0, 1, math.inf
    while (frame := robot.read()).stamp < END_S:
        see(gate, field, frame, frame.stamp)
        gate.touch(frame.contact, frame.stamp)
        while tick * TICK_S < frame.stamp:
            tick += 1
            if tick * TICK_S > 1.0 and tick % 2 == 0:
                press = pressed_on(gate, tick, press, 0.1, tick * TICK_S)
            gate.tick(tick * TICK_S)
        robot.drive(gate.twist)
        if frame.stamp > BEGIN_S:
            stood = math.inf if gate.twist.moves else min(stood, frame.stamp - BEGIN_S)
    return stood


@pytest.mark.parametrize("fault", ["late_scan", "early_scan", "lost_scan", "frozen_scan", "blind_scan", "bumper"])
def test_a_robot_that_sees_wrongly_or_touches_something_stands_as_its_row_says(fault: str) -> None:
    assert stood_after(fault) < STANDS_S


def test_scans_of_the_future_are_not_used_for_the_pose_and_said_once() -> None:
    robot = connect(f"sim:lab?faults=early_scan:60,after:{BEGIN_S}", seed=1, settings=BLIND)
    pilot, said, used = Pilot(robot.profile, BLIND), dict[int, str](), list[float]()
    while (frame := robot.read()).stamp < BEGIN_S + 4.0:
        shown = pilot.step(frame)
        said |= {one.id: one.text for one in shown.notices if one.cause.startswith("silent laser")}
        used += [frame.stamp] * (pilot.frame.scan is not None)
        assert shown.floor.lost is None
    assert used and max(used) < BEGIN_S + 0.1
    assert len(said) == 1 and "in the future" in said.popitem()[1]


@pytest.mark.parametrize("fault", ["slip", "late_scan:0.1", "lost_scan:0.2", "blind_scan:0.5", "black_picture"])
def test_a_robot_whose_fault_is_small_or_elsewhere_drives_on(fault: str) -> None:
    assert stood_after(fault) == math.inf


@pytest.mark.parametrize("row", INJECTABLE_FAULTS, ids=lambda row: row.name)
def test_a_fault_has_bounds_and_a_sentence_beyond_them(row: object) -> None:
    name, low, high, value = row.name, row.number.low, row.number.high, row.value  # type: ignore[attr-defined]
    assert read_faults(name) == {name: value} and low <= value <= high
    for beyond in (low - 0.1, high + 0.1, math.nan, math.inf):
        with pytest.raises(BadInput, match=f"The fault {name} takes a number from"):
            read_faults(f"{name}:{beyond}")


@pytest.mark.parametrize("url", ["sim:lab?faults=lateness:1", "sim:lab?fault=slip:0.2", "sim:lab?faults=slip:much"])
def test_what_is_no_fault_is_refused_in_a_sentence(url: str) -> None:
    with pytest.raises(BadInput, match=r"no fault 'lateness'.*late_scan, .*after|takes faults=|from 0 to 0.9"):
        connect(url)


def test_readings_are_spoilt_from_the_instant_on_that_was_asked_for() -> None:
    robot, honest = (
        connect(f"sim:lab{faults}", seed=3, settings=BLIND)
        for faults in ("?faults=slip:0.5,odometry_jump:2,battery:0.1,after:1", "")
    )
    for _ in range(300):
        for one in (robot, honest):
            one.drive(Twist(0.1, 0.0))
        frame, true = robot.read(), honest.read()
        assert frame.truth == true.truth and frame.wheels is not None and true.wheels is not None
        if frame.stamp < 1.0:
            assert frame.battery is None and frame.wheels.odometry == true.wheels.odometry
    assert frame.battery == 0.1
    off = frame.wheels.odometry.y - true.wheels.odometry.y
    assert np.isclose(off, 2.0, atol=0.1) and frame.wheels.odometry.x > 1.5 * true.wheels.odometry.x
