"""What a driver hands on: the form of every reading is checked where all of them pass."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.geometry import Pose, arc
from core.pilot import Pilot
from core.robots import Profile
from core.robots.nearness import NearField
from core.robots.readings import FAULT_AGAIN_S, Readings
from core.sensors import Image, Laser, Scan, SensorFrame, Sound

NAN, INF = float("nan"), float("inf")
LASER = Laser(beams=360, angle_min=-np.pi, angle_step=np.pi / 180)
GOOD = Scan(stamp=0.0, ranges=np.linspace(1.6, 2.4, 360), angle_min=-np.pi, angle_step=np.pi / 180)
PICTURE = Image(stamp=0.0, pixels=np.zeros((4, 6, 3), np.uint8))

MALFORMED: list[tuple[str, Callable[[Readings], object]]] = [
    *(
        ("scan.malformed", lambda readings, odd=odd: readings.scan(replace(GOOD, **odd)))
        for odd in (
            {"ranges": np.zeros(0)},
            {"ranges": np.ones(1)},
            {"ranges": np.ones(1_000_000)},
            {"ranges": np.ones((4, 90))},
            {"ranges": [1.0, 2.0]},
            {"ranges": np.array(["1", "2"])},
            {"stamp": NAN},
            {"stamp": INF},
            {"stamp": None},
            {"angle_step": 0.0},
            {"angle_step": NAN},
            {"angle_min": INF},
            {"time_step": NAN},
            {"time_step": 1.0},
            {"range_max": NAN},
            {"range_min": 6.0},
            {"range_max": None},
        )
    ),
    *(
        ("odometry.malformed", lambda readings, odd=odd: readings.wheels(Pose(odd, 0.0, 0.0), 0.0, 0.0))
        for odd in (NAN, INF)
    ),
    ("odometry.malformed", lambda readings: readings.wheels(Pose(), 0.0, 0.0, stamp=NAN)),
    *(
        ("picture.malformed", lambda readings, odd=odd: readings.image(replace(PICTURE, **odd)))
        for odd in (
            {"pixels": PICTURE.pixels[:, :, 0]},
            {"pixels": PICTURE.pixels[:0]},
            {"pixels": PICTURE.pixels.astype(float)},
            {"stamp": NAN},
        )
    ),
    (
        "sound.malformed",
        lambda readings: readings.sound(Sound(stamp=0.0, rate=16_000, samples=np.array([["a", "b"]]))),
    ),
    ("battery.malformed", lambda readings: readings.battery(NAN)),
    ("battery.malformed", lambda readings: readings.battery(120)),
]


@pytest.mark.parametrize(("code", "hand_on"), MALFORMED)
def test_a_malformed_reading_is_left_out_with_a_fault(code: str, hand_on: Callable[[Readings], object]) -> None:
    readings = Readings()
    hand_on(readings)
    frame = readings.frame()
    assert (frame.scan, frame.wheels, frame.image, frame.sound, frame.battery) == (None,) * 5
    assert [one.code for one in frame.faults] == [code] and frame.faults == readings.faults


def test_a_fault_that_lasts_is_said_now_and_then() -> None:
    now = 0.0
    readings = Readings(lambda: now)
    said = list[float]()
    for number in range(120):
        now = 0.1 * number
        readings.scan(replace(GOOD, ranges=np.zeros(0)))
        said += [now] * len(readings.frame().faults)
    assert said == pytest.approx([0.0, FAULT_AGAIN_S, 2 * FAULT_AGAIN_S])


def test_a_fault_is_that_of_the_device_that_has_it() -> None:
    base = Readings()
    laser = base.renaming({})
    laser.scan(replace(GOOD, ranges=np.zeros(0)))
    assert laser.faults and not base.faults and base.frame().faults


def test_two_lasers_of_two_devices_are_no_two_robots_though_they_are_called_alike() -> None:
    base = Readings()
    front, back = base.renaming({}), base.renaming({})
    for _ in range(20):
        front.scan(GOOD)
        back.scan(replace(GOOD, ranges=np.full(360, 4.0)))
    assert not base.frame().trouble and base.frame().scan is not None


ODD_NUMBERS = st.one_of(st.floats(), st.integers(-3, 3), st.none(), st.booleans())
RANGES = st.one_of(
    st.integers(0, 400).map(lambda beams: np.full(beams, 1.0)),
    st.lists(st.floats(), max_size=4).map(np.array),
    st.sampled_from([np.ones((2, 2)), np.array(["a"]), np.array([None, 1.0]), None, "far", [1.0, 2.0]]),
)


@settings(max_examples=150, deadline=None)
@given(
    ranges=RANGES,
    stamp=ODD_NUMBERS,
    angles=st.tuples(ODD_NUMBERS, ODD_NUMBERS),
    limits=st.tuples(ODD_NUMBERS, ODD_NUMBERS),
    time_step=ODD_NUMBERS,
)
def test_whatever_a_driver_calls_a_scan_neither_the_gates_points_nor_the_pilot_end(
    ranges: object, stamp: object, angles: tuple[object, object], limits: tuple[object, object], time_step: object
) -> None:
    readings = Readings()
    readings.wheels(Pose(), 0.1, 0.2)
    readings.scan(
        Scan(
            stamp=stamp,  # type: ignore[arg-type]
            ranges=ranges,  # type: ignore[arg-type]
            angle_min=angles[0],  # type: ignore[arg-type]
            angle_step=angles[1],  # type: ignore[arg-type]
            range_min=limits[0],  # type: ignore[arg-type]
            range_max=limits[1],  # type: ignore[arg-type]
            time_step=time_step,  # type: ignore[arg-type]
        )
    )
    frame = readings.frame()
    assert (frame.scan is None) == bool(frame.faults)
    NearField((LASER,)).see(frame, moving=True)
    PILOT.step(frame)


PILOT = Pilot(Profile(name="fuzzed", url="", lasers=(LASER,), capabilities=frozenset({"drive"})))


@pytest.mark.parametrize(("late", "code"), [(0.0, ""), (0.5, "odometry.late"), (-0.5, "odometry.future")])
def test_odometry_that_is_not_of_its_time_is_left_out_and_named(late: float, code: str) -> None:
    clock = [10.0]
    readings = Readings(lambda: clock[0])
    clock[0] = 15.0
    readings.wheels(Pose(1.0), 0.1, 0.0, readings.now() - late)
    frame = readings.frame()
    assert (frame.wheels is None) is bool(code)
    assert [(one.code, one.used) for one in frame.faults] == [(code, False)] * bool(code)


def interleaved(kind: str) -> tuple[list[SensorFrame], Readings]:
    """One robot for 1 s, another one beside it under the same names for 2 s, and one for 6 s; frames at 20 Hz."""
    now = 0.0
    readings = Readings(lambda: now)
    frames = list[SensorFrame]()
    for number in range(180):
        now, two = 0.05 * number, 20 <= number < 60
        if kind == "odometry":
            readings.wheels(Pose(0.5 + 0.01 * number), 0.2, 0.0)
            if two:
                readings.wheels(Pose(9.0), 0.0, 0.0)
        else:
            far = 1.0 if two and number % 2 else 2.0
            readings.scan(replace(GOOD, stamp=now, ranges=GOOD.ranges - 2.0 + far + 0.001 * number))
        frames.append(readings.frame())
    return frames, readings


@pytest.mark.parametrize("kind", ["scan", "odometry"])
def test_of_two_robots_under_one_name_nothing_is_used_and_the_robot_is_not_driven(kind: str) -> None:
    frames, readings = interleaved(kind)
    told = [number for number, frame in enumerate(frames) if frame.trouble]
    assert 20 < told[0] < 30 and told == list(range(told[0], told[-1] + 1)) and 60 < told[-1] < 150
    mixed = frames[told[0] : 60]
    assert all(frame.scan is None and frame.wheels is None for frame in mixed)
    assert [one.code for one in readings.faults] == ["robots.mixed"] and not any(frame.faults for frame in mixed)
    assert frames[told[0]].trouble == readings.faults[0].sentence and "namespace" in frames[told[0]].trouble
    for alone in (frames[:20], frames[150:]):
        assert all(frame.scan is not None or frame.wheels is not None for frame in alone)


def roll(
    readings: Readings, clock: list[float], speed: tuple[float, float], reported: tuple[float, float]
) -> SensorFrame:
    """Twenty seconds of a base that goes and turns, and what it reports of that → the last frame."""
    place, frame = Pose(), readings.frame()
    for _ in range(400):
        clock[0] += 0.05
        place = place @ arc(0.05 * speed[0], 0.05 * speed[1])
        readings.wheels(place, *reported, stamp=clock[0])
        frame = readings.frame()
    return frame


@pytest.mark.parametrize("reported", [(200.0, 0.3), (0.2, 17.2), (-0.2, 0.3), (0.2, -0.3), (1e30, 1e30)])
def test_speeds_that_do_not_fit_the_places_are_taken_from_these_and_said(reported: tuple[float, float]) -> None:
    clock = [0.0]
    readings = Readings(lambda: clock[0])
    frame = roll(readings, clock, (0.2, 0.3), reported)
    assert frame.wheels is not None
    assert (frame.wheels.speed, frame.wheels.turn_rate) == pytest.approx((0.2, 0.3), abs=0.01)
    assert [one.code for one in readings.faults] == ["odometry.speeds"]


@pytest.mark.parametrize("reported", [(0.2, 0.3), (0.26, 0.24), (0.0, 0.0), (0.2, 0.0)])
def test_speeds_that_are_about_right_or_not_reported_are_no_fault(reported: tuple[float, float]) -> None:
    clock = [0.0]
    readings = Readings(lambda: clock[0])
    frame = roll(readings, clock, (0.2, 0.3), reported)
    assert readings.faults == () and frame.wheels is not None
    if reported[1]:
        assert (frame.wheels.speed, frame.wheels.turn_rate) == reported
    else:
        assert (frame.wheels.speed, frame.wheels.turn_rate) == pytest.approx((0.2, 0.3), abs=0.01)


def test_huge_speeds_move_the_robot_nowhere_from_the_first_reading_on() -> None:
    clock = [0.0]
    readings = Readings(lambda: clock[0])
    readings.wheels(Pose(), 1e6, 0.0, stamp=0.0)
    clock[0] = 0.3
    frame = readings.frame()
    assert frame.wheels is not None and abs(frame.wheels.odometry.x) < 1e-6


def test_a_line_on_which_many_messages_are_unreadable_is_said_and_a_lost_one_is_not() -> None:
    readings = Readings()
    for _ in range(99):
        readings.arrived("the base", readable=20, unreadable=1)
    assert readings.faults == ()
    readings.arrived("the base", readable=10, unreadable=9)
    assert [(one.code, one.values["bad"], one.values["all"]) for one in readings.faults] == [
        ("link.unreadable", "13", "100")
    ]
