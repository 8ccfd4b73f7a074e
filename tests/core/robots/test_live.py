"""A real robot's devices: connecting again, standing meanwhile, and clocks."""

import queue
import threading
import time
from collections.abc import Callable

import numpy as np
import pytest

from core.errors import BadInput, Unavailable
from core.gate import ZERO, Twist
from core.geometry import Pose
from core.robots import Profile
from core.robots.connection import ReadConnection
from core.robots.device import Base, Device, Equipment
from core.robots.device_clock import MAX_DRIFT, RESONATOR_DRIFT, DeviceClock
from core.robots.live import LiveRobot
from core.robots.readings import Readings
from core.robots.requests import ReadTruth, SetListening
from core.robots.robot_file import LaserTable, RobotFile
from core.sensors import Camera, Image, Laser, Scan, SensorFrame, Sound


class Wire(Device):
    """A device whose link a test cuts."""

    def __init__(self, *, drives: bool = True, opens: Callable[[], None] = lambda: None) -> None:
        self.drives, self.opens = drives, opens
        self.driven: list[Twist] = []
        self.cut = threading.Event()
        self.opened = 0
        self.todo: queue.Queue[Callable[[Readings], None]] = queue.Queue()

    def open(self) -> Equipment:
        self.opens()
        self.opened += 1
        self.cut.clear()
        return Equipment(name="wire", base=Base(failsafe=0.5) if self.drives else None)

    def run(self, readings: Readings) -> None:
        while not self.cut.wait(0.002):
            while not self.todo.empty():
                self.todo.get()(readings)

    def drive(self, twist: Twist) -> None:
        self.driven.append(twist)

    def close(self) -> None:
        self.cut.set()


def shape(equipment: tuple[Equipment, ...]) -> Profile:
    return Profile(name=equipment[0].name, url="")


def until(true: Callable[[], bool], seconds: float = 100.0) -> None:
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end
        time.sleep(0.005)


def test_after_the_link_came_back_nothing_moves_before_zero_was_asked_for() -> None:
    wire = Wire()
    robot = LiveRobot([("the base", wire)], shape)
    robot.drive(Twist(0.1, 0.0))
    assert wire.driven == [Twist(0.1, 0.0)]
    wire.cut.set()
    until(lambda: bool(robot.read().trouble))
    robot.drive(Twist(0.1, 0.0))
    assert len(wire.driven) == 1
    until(lambda: not robot.read().trouble)
    robot.drive(Twist(0.1, 0.0))
    assert wire.driven[1:] == [ZERO]
    robot.drive(ZERO)
    robot.drive(Twist(0.2, 0.0))
    assert wire.driven[-1] == Twist(0.2, 0.0) and wire.opened == 2
    robot.close()
    assert wire.driven[-1] == ZERO


def test_a_link_that_is_lost_and_back_between_two_calls_needs_its_zero_too() -> None:
    wire = Wire()
    robot = LiveRobot([("the base", wire)], shape)
    robot.drive(Twist(0.1, 0.0))
    wire.cut.set()
    until(lambda: wire.opened == 2 and not robot.read().trouble)
    robot.drive(Twist(0.1, 0.0))
    assert wire.driven == [Twist(0.1, 0.0), ZERO]
    robot.close()


def test_a_device_that_is_not_there_at_first_is_a_sentence_and_ends_the_others() -> None:
    def never() -> None:
        raise ConnectionRefusedError(111, "Connection refused")

    before = set(threading.enumerate())
    good, bad = Wire(), Wire(drives=False, opens=never)
    with pytest.raises(Unavailable, match="the laser cannot be reached: Connection refused"):
        LiveRobot([("the base", good), ("the laser", bad)], shape)
    until(lambda: set(threading.enumerate()) <= before)


def test_no_device_runs_before_all_sensors_have_their_names() -> None:
    ran, early = threading.Event(), list[bool]()
    quick = Wire()
    quick.todo.put(lambda _: ran.set())
    late = Wire(drives=False, opens=lambda: early.append(ran.wait(0.2)))
    robot = LiveRobot([("the base", quick), ("the laser", late)], shape)
    until(ran.is_set)
    robot.close()
    assert early == [False]


def test_a_device_that_is_lost_is_told_and_comes_back() -> None:
    laser = Wire(drives=False)
    robot = LiveRobot([("the base", Wire()), ("the laser", laser)], shape)
    laser.cut.set()
    notes: list[str] = []
    until(lambda: bool(notes.extend(robot.read().notes)) or any("is back" in note for note in notes))
    assert "the laser was lost; it is looked for." in " ".join(notes)
    assert robot.read().trouble == ""
    robot.close()


def test_a_robot_that_is_closed_while_it_connects_again_leaves_no_thread() -> None:
    connecting, go_on = threading.Event(), threading.Event()

    def opens() -> None:
        if wire.opened:
            connecting.set()
            go_on.wait(5.0)

    before = set(threading.enumerate())
    wire = Wire(opens=opens)
    robot = LiveRobot([("the base", wire)], shape)
    wire.cut.set()
    assert connecting.wait(5.0)
    threading.Timer(0.2, go_on.set).start()
    robot.close()
    until(lambda: set(threading.enumerate()) <= before)


def test_a_fault_of_a_driver_is_no_end_of_the_console() -> None:
    wire = Wire()
    robot = LiveRobot([("the base", wire)], shape)
    wire.todo.put(lambda _: [][1])
    notes: list[str] = []
    until(lambda: bool(notes.extend(robot.read().notes)) or any("IndexError" in note for note in notes))
    until(lambda: wire.opened == 2)
    robot.close()


def test_a_device_that_opens_while_it_is_closed_does_not_run() -> None:
    opening, go_on = threading.Event(), threading.Event()

    def slow() -> None:
        opening.set()
        go_on.wait(5.0)

    before = set(threading.enumerate())
    slow_device, base = Wire(drives=False), Wire()
    robot = LiveRobot([("the base", base), ("the laser", slow_device)], shape)
    slow_device.opens = slow
    slow_device.cut.set()
    assert opening.wait(5.0)
    threading.Timer(0.1, go_on.set).start()
    robot.close()
    until(lambda: set(threading.enumerate()) <= before)


def test_a_real_robot_listens_always_and_takes_no_requests_of_a_simulator() -> None:
    robot = LiveRobot([("the base", Wire())], shape)
    assert robot.ask(SetListening(on=False)).on  # its microphones cannot be switched off
    with pytest.raises(BadInput, match="understands the requests connection, robot_file and listen"):
        robot.ask(ReadTruth())
    robot.close()


def test_a_robot_of_two_cameras_looks_through_the_first() -> None:
    profile = Profile(name="two eyes", url="", cameras=(Camera(name="front"), Camera(name="back")))
    for name, seen in (("front", True), ("back", False), ("", True)):
        frame = SensorFrame(stamp=1.0, image=Image(stamp=1.0, pixels=np.zeros((2, 2, 3), np.uint8), camera=name))
        assert (profile.first_view(frame).image is not None) is seen


def test_a_frame_carries_one_scan_all_sound_and_the_wheels_as_they_go_on() -> None:
    clock = [10.0]
    readings = Readings(lambda: clock[0])
    for number in (1, 2):
        readings.scan(Scan(stamp=0.0, ranges=number * np.ones(3), angle_min=0.0, angle_step=0.1))
    readings.sound(Sound(stamp=0.0, rate=16000, samples=np.zeros((160, 1))))
    readings.sound(Sound(stamp=0.01, rate=16000, samples=np.zeros((160, 1))))
    readings.wheels(Pose(1.0, 0.0, 0.0), 0.2, 0.0)
    clock[0] += 0.05
    first, second = readings.frame(), readings.frame()
    assert [one.scan is not None and one.scan.ranges[0] for one in (first, second)] == [1.0, 2.0]
    assert first.sound is not None and first.sound.duration == pytest.approx(0.02) and second.sound is None
    assert first.stamp == pytest.approx(0.05)
    assert first.wheels is not None and first.wheels.odometry.x == pytest.approx(0.01)


def test_a_base_that_counts_anew_goes_on_from_where_it_was() -> None:
    clock = [0.0]
    readings = Readings(lambda: clock[0])

    def at(x: float) -> float:
        clock[0] += 0.02
        readings.wheels(Pose(x, 0.0, 0.0), 0.0, 0.0)
        wheels = readings.frame().wheels
        assert wheels is not None
        return wheels.odometry.x

    start = at(7.0)
    assert at(7.1) - start == pytest.approx(0.1)
    assert at(0.0) - start == pytest.approx(0.1)  # it was switched off and on
    assert at(0.2) - start == pytest.approx(0.3)
    readings.forget_wheels()
    assert readings.frame().wheels is None
    assert at(0.1) - start == pytest.approx(0.3)
    readings.wheels(Pose(float("nan"), 0.0, 0.0), 0.0, 0.0)
    assert at(0.2) - start == pytest.approx(0.4)


@pytest.mark.parametrize("drift", [-20e-6, 0.0, 20e-6])
def test_the_quickest_message_tells_a_devices_clock(drift: float) -> None:
    rng, clock, worst = np.random.default_rng(3), DeviceClock(), 0.0
    for number in range(3000):
        true = 0.1 * number
        stamp = clock.stamp(1000.0 + true * (1 + drift), true + float(rng.uniform(0.0, 0.05)))
        if number > 100:
            worst = max(worst, abs(stamp - true))
    assert worst < 0.010


def test_a_clock_that_was_set_back_is_learnt_anew() -> None:
    clock = DeviceClock()
    clock.stamp(100.0, 1.0)
    assert clock.stamp(5.0, 2.0) == pytest.approx(2.0)


@pytest.mark.parametrize("until", [20.5, 22.0, 60.0])  # [s] the link stands still, then all comes late, or bit by bit
@pytest.mark.parametrize(("start", "follows"), [(1.7e9, True), (1.7e9, False), (1000.0, False)])
def test_a_link_that_lags_as_a_whole_is_late_however_long_it_lasts(until: float, start: float, follows: bool) -> None:
    clock, late = DeviceClock(follows=follows), 0.0
    for number in range(1200):
        own = 0.1 * number
        lag = 2.0 * min(max(own - 20.0, 0.0) / (until - 20.0), 1.0)
        for source in ("scan", "odometry"):
            late = own + lag - clock.stamp(start + own, own + lag, source)
    assert late == pytest.approx(2.0, abs=0.06)


@pytest.mark.parametrize("growth", [1.0, 0.1, 0.003])
def test_what_lags_behind_stays_late_however_slowly_it_came_to_it(growth: float) -> None:
    rng, clock, late = np.random.default_rng(3), DeviceClock(), 0.0
    for number in range(12_000):
        received = 0.1 * number
        lag = min(3.0, growth * max(received - 20.0, 0.0)) + float(rng.uniform(0.0, 0.05))
        late = received - clock.stamp(1000.0 + received - lag, received)
    assert 3.0 - 1200 * MAX_DRIFT - 0.05 < late < 3.06


def test_a_simulators_clock_that_was_held_up_is_followed_when_all_that_it_stamps_is_late() -> None:
    clock, late = DeviceClock(follows=True), list[float]()
    for number in range(600):
        received, lag = 0.1 * number, min(max(0.1 * number - 20.0, 0.0), 1.5)
        late += [received - clock.stamp(received - lag, received, source) for source in ("scan", "odometry")]
    assert max(late) > 1.4 and max(late[-400:]) < 0.2


def test_a_clock_that_was_set_back_by_less_than_a_second_is_learnt_anew_at_once() -> None:
    rng, clock = np.random.default_rng(3), DeviceClock()
    for number in range(400):
        received = 0.1 * number
        lag = 1.0 if received > 20 else 0.0
        assert received - clock.stamp(received - lag - float(rng.uniform(0.0, 0.05)), received) < 0.06


@pytest.mark.parametrize("drift", [-0.004, 0.004])
def test_the_clock_of_a_microcontroller_is_followed(drift: float) -> None:
    rng, clock = np.random.default_rng(3), DeviceClock(RESONATOR_DRIFT)
    for number in range(2000):
        true = 0.1 * number
        stamp = clock.stamp(true * (1 + drift), true + float(rng.uniform(0.0, 0.02)))
        assert abs(stamp - true) < 0.03


@pytest.mark.parametrize("frozen", [3.0, 12.0])
def test_messages_that_waited_for_a_frozen_reader_keep_their_times(frozen: float) -> None:
    clock, off = DeviceClock(), list[float]()
    for number in range(400):
        true = 0.1 * number
        received = 20.0 + frozen if 20.0 <= true < 20.0 + frozen else true
        off.append(clock.stamp(1000.0 + true, received) - true)
    assert max(map(abs, off)) < 0.11


def test_a_frame_tells_how_old_its_odometry_is_and_how_often_it_comes() -> None:
    now = 0.0
    readings = Readings(lambda: now)
    for step in range(50):
        now = 0.05 * step
        readings.wheels(Pose(), 0.0, 0.0)
    now += 0.02
    wheels = readings.frame().wheels
    assert wheels is not None and wheels.rate is not None
    assert abs(wheels.age - 0.02) < 1e-9
    assert abs(wheels.rate - 20.0) < 1e-6


def test_a_picture_is_decoded_where_the_one_before_was_taken_and_else_for_the_frame_that_takes_it() -> None:
    readings, decoded = Readings(), list[int]()

    def bring(number: int, broken: bool = False) -> None:
        def decode() -> Image | None:
            decoded.append(number)
            return None if broken else Image(stamp=float(number), pixels=np.zeros((1, 1, 3), np.uint8))

        readings.undecoded(decode)

    for number in (1, 2, 3):
        bring(number)
    assert decoded == [1]
    image = readings.frame().image
    assert image is not None and image.stamp == 3.0
    assert decoded == [1, 3] and readings.frame().image is None
    bring(4)
    bring(5, broken=True)
    image = readings.frame().image
    assert image is not None and image.stamp == 4.0
    assert decoded == [1, 3, 4, 5]


def test_speeds_of_before_a_loss_never_reach_the_connection_after_it() -> None:
    """A caller that is held up between its look at the link and the sending holds the new connection up as well."""
    events: list[str] = []
    held, go_on, lost = threading.Event(), threading.Event(), threading.Event()

    class Slow(Device):
        def open(self) -> Equipment:
            events.append("open")
            return Equipment(name="slow", base=Base(wheelbase=0.2))

        def run(self, readings: Readings) -> None:
            lost.wait(5.0)
            lost.clear()

        def drive(self, twist: Twist) -> None:
            held.set()
            go_on.wait(5.0)
            events.append(f"drive {twist.v}")

        def close(self) -> None:
            lost.set()

    robot = LiveRobot([("slow", Slow())], lambda _: Profile(name="slow", url="slow:"))
    caller = threading.Thread(target=robot.drive, args=(Twist(0.1, 0.0),))
    caller.start()
    assert held.wait(5.0)
    lost.set()  # the link goes while the speeds are on their way
    time.sleep(1.0)
    assert events == ["open"]
    go_on.set()
    caller.join(5.0)
    until(lambda: events.count("open") == 2)
    assert events == ["open", "drive 0.1", "open"]
    robot.close()


def test_the_robot_file_bounds_the_ranges_of_a_laser_for_everyone() -> None:
    wire, laser = Wire(), Laser(name="laser", beams=3, angle_min=-0.02, angle_step=0.02, range_max=8.0)
    file = RobotFile(lasers={"laser": LaserTable(range_min=0.5, range_max=3.0, time_offset=0.6)})
    robot = LiveRobot([("the base", wire)], lambda _: Profile(name="it", url="", lasers=(laser,)), file=file)
    ranges = np.array([0.3, 0.31, 5.0])
    wire.todo.put(
        lambda readings: readings.scan(
            Scan(
                stamp=readings.now() - 0.6,
                laser="laser",
                ranges=ranges,
                angle_min=-0.02,
                angle_step=0.02,
                range_max=8.0,
            )
        )
    )
    frames = list[SensorFrame]()

    def came() -> bool:
        frames.append(robot.read())
        return frames[-1].scan is not None

    until(came)
    robot.close()
    scan = frames[-1].scan
    assert scan is not None and not scan.valid.any() and np.isposinf(scan.ranges[2]) and scan.range_max == 3.0
    assert [one.code for one in robot.ask(ReadConnection()).parts[0].findings.faults] == []


def test_contact_and_battery_are_those_of_a_base_that_is_there() -> None:
    wire = Wire()
    robot = LiveRobot([("the base", wire)], shape)

    def touched(readings: Readings) -> None:
        readings.contact(True)
        readings.battery(0.5)

    wire.todo.put(touched)
    until(lambda: robot.read().contact and robot.read().battery == 0.5)
    wire.cut.set()
    until(lambda: wire.opened == 2 and not robot.read().trouble)
    robot.read()
    frame = robot.read()
    robot.close()
    assert not frame.contact and frame.battery is None


def test_a_robot_file_that_does_not_fit_leaves_no_device_open() -> None:
    wire, before = Wire(), set(threading.enumerate())

    def unfit(_: tuple[Equipment, ...]) -> Profile:
        raise BadInput("there is no laser x")

    with pytest.raises(BadInput, match="no laser x"):
        LiveRobot([("the base", wire)], unfit)
    until(lambda: set(threading.enumerate()) <= before)
    assert wire.cut.is_set()
