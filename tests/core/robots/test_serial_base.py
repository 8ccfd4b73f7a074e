"""The line protocol's driver against a robot on a pseudo-terminal and on TCP, in the simulated lab."""

import math
import os
import time
import tty
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from core.errors import BadInput, Unavailable
from core.gate import ZERO, Twist
from core.geometry import Pose
from core.robots.byte_link import WRITE_TIMEOUT_S, SerialLink
from core.robots.live import LiveRobot
from core.robots.readings import Readings
from core.robots.serial_base import (
    BadLine,
    SerialBase,
    WheelOdometry,
    crc8,
    frame_line,
    open_device,
    parse_description,
    parse_line,
)
from tests.core.robots.links import frames, is_up, live, memory, no_leak, percentile, until
from tests.emulators.serial_base import DESCRIPTION, SerialRobot, line_of
from tests.emulators.wires import bit_flips, malformed
from tests.emulators.world import World


@pytest.fixture(params=[pytest.param("tcp", marks=pytest.mark.campaign), "serial"])
def robot_there(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[SerialRobot]:
    world = World()
    emulator = SerialRobot(world, path=tmp_path / "ttyUSB0" if request.param == "serial" else None)
    emulator.start()
    world.start()
    yield emulator
    world.stop()
    emulator.stop()


def device_of(emulator: SerialRobot) -> SerialBase:
    return open_device(emulator.url.removeprefix("serial:"))


def test_the_sum_is_crc_8() -> None:
    assert crc8(b"123456789") == 0xF4  # the check value of CRC-8/SMBUS
    assert frame_line("V 0.100 0.500") == line_of("V 0.100 0.500") == b"V 0.100 0.500*92\n"
    assert parse_line(b"V 0.100 0.500*92\r") == ["V", "0.100", "0.500"]


def test_a_line_that_lost_characters_or_has_flipped_bits_is_refused() -> None:
    line = frame_line("V 0.005 -1.250").rstrip(b"\n")
    damaged = [line[:begin] + line[end:] for begin in range(13) for end in range(begin + 1, 14)]
    damaged += [line[:at] + bytes([line[at] ^ 1 << bit]) + line[at + 1 :] for at in range(14) for bit in range(8)]
    accepted = 0
    for one in damaged:
        try:
            parse_line(one)
        except BadLine:
            continue
        accepted += 1
    assert len(damaged) == 203 and accepted <= 1


def test_the_description_becomes_the_profile(robot_there: SerialRobot) -> None:
    device = device_of(robot_there)
    equipment = device.open()
    base = equipment.base
    device.close()
    assert base is not None and equipment.name == "Test rover"
    assert (base.wheelbase, base.radius, base.max_speed, base.max_turn_rate) == (0.16, 0.09, 0.3, 1.5)
    assert (base.failsafe, base.odometry, base.cruise) == (0.5, True, 0.1)


@pytest.mark.parametrize(
    "words", ["", "wheelbase=0", "wheelbase=x", "wheelbase=nan", "name=rover", "wheelbase=.1 radius=9"]
)
def test_a_description_that_cannot_be_is_refused(words: str) -> None:
    with pytest.raises(BadLine):
        parse_description(words.split())


def test_the_robot_moves_in_its_world_and_says_how_far(robot_there: SerialRobot) -> None:
    with live(device_of(robot_there)) as robot:
        frames(robot, 0.2, ZERO)
        read = frames(robot, 2.0, Twist(0.2, 0.5))
        frames(robot, 0.7, ZERO)
        rested = frames(robot, 0.2)[-1].wheels
    truth = robot_there._world.truth
    moving = read[-1].wheels
    assert moving is not None and rested is not None
    assert moving.speed == pytest.approx(0.2, abs=0.02) and moving.turn_rate == pytest.approx(0.5, abs=0.06)
    assert math.hypot(truth.x, truth.y) > 0.25
    assert rested.odometry.distance_to(truth.x, truth.y) < 0.03
    assert abs(rested.odometry.heading - truth.heading) < 0.05
    assert rested.speed == 0 and all(frame.stamp > 0 for frame in read)


def test_a_stop_is_on_the_wire_within_30_ms(robot_there: SerialRobot) -> None:
    delays = stop_delays(robot_there, 30)
    assert percentile(delays, 0.9) < 0.030


def stop_delays(emulator: SerialRobot, count: int) -> list[float]:
    """[s] from the request to zero on the wire."""
    delays: list[float] = []
    with live(device_of(emulator)) as robot:
        robot.drive(ZERO)
        for _ in range(count):
            robot.drive(Twist(0.1, 0.0))
            until(lambda: emulator.heard[-1][1] > 0)
            asked = time.monotonic()
            robot.drive(ZERO)
            until(lambda: emulator.heard[-1][1:] == (0.0, 0.0))
            delays.append(emulator.heard[-1][0] - asked)
    return delays


def test_without_a_word_the_robot_stops_by_itself(robot_there: SerialRobot) -> None:
    world = robot_there._world
    with live(device_of(robot_there)) as robot:
        robot.drive(ZERO)
        frames(robot, 0.3, Twist(0.2, 0.0))
        last = robot_there.heard[-1][0]
        until(lambda: world.speeds[-1][1] == 0)
        assert world.speeds[-1][0] - last == pytest.approx(0.5, abs=0.1)


def test_after_the_robot_was_started_again_nothing_moves_before_zero_was_asked_for(robot_there: SerialRobot) -> None:
    moving = Twist(0.1, 0.0)
    with no_leak(), live(device_of(robot_there)) as robot:
        robot.drive(ZERO)
        before = frames(robot, 1.0, moving)[-1].wheels
        robot_there.stop()
        until(lambda: not is_up(robot))
        robot_there.heard.clear()
        robot_there.start()
        until(lambda: robot.drive(moving) or is_up(robot), 20.0)
        after = frames(robot, 0.5, moving)[-1].wheels
        assert {(v, w) for _, v, w in robot_there.heard} == {(0.0, 0.0)}
        robot.drive(ZERO)
        robot.drive(moving)
        until(lambda: robot_there.heard[-1][1] == 0.1)
        assert before is not None and after is not None
        assert before.odometry.distance_to(after.odometry.x, after.odometry.y) < 0.05


def test_a_robot_that_falls_silent_is_lost_and_found(robot_there: SerialRobot) -> None:
    with live(device_of(robot_there)) as robot:
        robot_there.silent = True
        until(lambda: not is_up(robot))
        robot_there.silent = False
        until(lambda: is_up(robot))


def test_bumper_and_battery_arrive(robot_there: SerialRobot) -> None:
    with live(device_of(robot_there)) as robot:
        robot_there.send("B 1")
        until(lambda: robot.read().contact)
        robot_there.send("B 0")
        until(lambda: not robot.read().contact)
        robot_there.send("P 0.5")
        until(lambda: robot.read().battery == 0.5)


def test_flipped_bits_neither_move_the_robot_otherwise_nor_its_odometry(robot_there: SerialRobot) -> None:
    device = device_of(robot_there)
    with live(device) as robot:
        robot_there.port.mangle = bit_flips(np.random.default_rng(3), 0.3)
        robot.drive(ZERO)
        read = frames(robot, 1.5, Twist(0.2, 0.0))
        robot_there.port.mangle = None
        robot.drive(ZERO)
    places = [frame.wheels.odometry.x for frame in read if frame.wheels is not None]
    assert len(places) > 30 and max(np.abs(np.diff(places))) < 0.05 and device.rejected > 10


def fuzz(emulator: SerialRobot, count: int) -> tuple[set[tuple[float, float]], float, float]:
    """Malformed messages while standing → speeds heard, distance moved [m], memory's growth in the second half."""
    rng, before = np.random.default_rng(4), 0.0
    samples = [line_of(text) for text in ("O 1000 0.1000 0.1000", "B 1", "P 0.5", DESCRIPTION, "V 1.0 1.0")]
    with live(device_of(emulator)) as robot:
        for number in range(count):
            if number == count // 2:
                before = memory()
            until(lambda: emulator.inject(malformed(rng, samples[int(rng.integers(len(samples)))])), 30.0)
            if number % 20 == 0:
                robot.drive(ZERO)
                robot.read()
        growth = memory() - before
        until(lambda: is_up(robot) and robot.read().wheels is not None, 20.0)
        place = emulator._world.truth
    return {(v, w) for _, v, w in emulator.heard}, math.hypot(place.x, place.y), growth


def test_malformed_bytes_neither_end_the_driver_nor_move_the_robot(robot_there: SerialRobot) -> None:
    heard, moved, growth = fuzz(robot_there, 500)
    assert heard == {(0.0, 0.0)} and moved == 0 and growth < 20


@pytest.mark.campaign
def test_a_hundred_thousand_malformed_messages() -> None:
    world = World()
    emulator = SerialRobot(world)
    emulator.start()
    world.start()
    heard, moved, growth = fuzz(emulator, 100_000)
    world.stop()
    emulator.stop()
    assert heard == {(0.0, 0.0)} and moved == 0 and growth < 20


@pytest.mark.campaign
def test_stop_latency_over_many_stops() -> None:
    world = World()
    emulator = SerialRobot(world)
    emulator.start()
    world.start()
    delays = stop_delays(emulator, 1000)
    world.stop()
    emulator.stop()
    assert percentile(delays, 0.99) < 0.030, f"{percentile(delays, 0.99) * 1e3:.1f} ms"


def test_odometry_follows_a_circle_and_goes_on_when_the_counter_turns_over() -> None:
    odometry, turn, wheelbase = WheelOdometry(0.2), 2 * math.pi, 0.2
    start, steps = (1 << 32) - 500, 200
    for step in range(steps + 1):
        share = step / steps
        left, right = (1.0 - wheelbase / 2) * turn * share, (1.0 + wheelbase / 2) * turn * share
        pose, speed, turn_rate = odometry.move((start + 20 * step) % (1 << 32), left, right)
    assert pose.distance_to(0.0, 0.0) < 1e-9 and abs(pose.heading) < 1e-9
    assert speed == pytest.approx(turn / 4.0) and turn_rate == pytest.approx(turn / 4.0)


def test_wheels_that_cannot_have_rolled_so_far_move_nothing_and_what_follows_does() -> None:
    odometry, rejected, pose = WheelOdometry(0.2), 0, Pose()
    for step in range(100):
        left = (
            1e300 if step == 20 else 5.0 + 0.01 * step if step > 60 else 0.01 * step
        )  # the encoder began anew at 60
        try:
            pose, speed, _ = odometry.move(20 * step, left, left)
        except BadLine:
            rejected += 1
    assert rejected == 3 and pose.x == pytest.approx(0.96) and speed == pytest.approx(0.5)


def test_a_line_full_of_noise_is_said(robot_there: SerialRobot) -> None:
    with live(device_of(robot_there)) as robot:
        robot_there.inject(b"\xffO 1 2*00\n" * 40)
        until(lambda: any(one.code == "link.unreadable" for one in robot.read().faults))


def test_a_counter_that_went_back_twice_is_a_robot_that_was_started_again() -> None:
    odometry = WheelOdometry(0.2)
    odometry.move(50_000, 1.0, 1.0)
    with pytest.raises(BadLine):
        odometry.move(200, 0.0, 0.0)
    assert odometry.move(50_020, 1.01, 1.01)[0].x == pytest.approx(0.01)
    with pytest.raises(BadLine):
        odometry.move(200, 0.0, 0.0)
    with pytest.raises(OSError, match="started again"):
        odometry.move(220, 0.0, 0.0)


def test_a_lag_stays_known_when_the_link_was_lost_and_a_counter_from_zero_is_a_clock_anew() -> None:
    base, now = open_device("//192.0.2.1"), 0.0
    readings = Readings(lambda: now)
    odometry, late = WheelOdometry(0.2), list[float]()
    for lag, counter in ((0.0, 5000), (3.0, 10000), (0.0, 100)):  # at first, after a loss, after a restart
        odometry = WheelOdometry(0.2)
        for step in range(40):
            now += 0.025
            base._hand_on(["O", str(counter + 25 * step - round(1e3 * lag)), "0", "0"], odometry, readings)
        offset = base.findings().clocks[0].offset_s
        late.append(now - odometry.stamp - offset)
        now += 4.0
    assert late == pytest.approx([0.0, 3.0, 0.0], abs=0.05)


@pytest.mark.parametrize("rest", ["", "//", "///dev/x?bauds=9600", "///dev/x?baud=fast", "//host:70000"])
def test_an_address_that_cannot_be_is_a_sentence(rest: str) -> None:
    with pytest.raises(BadInput, match=r"\.$"):
        open_device(rest)


def test_something_that_does_not_answer_is_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("core.robots.serial_base.RESET_TIME_S", 0.5)
    world = World()
    emulator = SerialRobot(world)
    emulator._obey = lambda line: None  # type: ignore[method-assign]
    emulator.start()
    with no_leak(), pytest.raises(Unavailable, match="no robot answers"):
        LiveRobot([("the base", device_of(emulator))], lambda _: pytest.fail("it has no profile"))
    emulator.stop()


def test_a_busy_processor_is_no_lost_link_and_a_full_port_is(monkeypatch: pytest.MonkeyPatch) -> None:
    device, driver = os.openpty()
    tty.setraw(driver)
    link, real = SerialLink(os.ttyname(driver), 115_200), os.write

    def held_up(port: int, data: bytes) -> int:
        written = real(port, data)
        time.sleep(2 * WRITE_TIMEOUT_S)
        return written

    try:
        with monkeypatch.context() as patched:
            patched.setattr(os, "write", held_up)
            link.write(b"drive\n")
        assert os.read(device, 100) == b"drive\n"
        with pytest.raises(OSError):
            for _ in range(100):
                link.write(bytes(65536))
    finally:
        link.close()
        os.close(device)
        os.close(driver)
