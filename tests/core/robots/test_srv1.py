"""The SRV-1's driver against the firmware's manners, on TCP, in the simulated lab."""

import socket
import struct
import time
from collections.abc import Iterator

import numpy as np
import pytest

from core.errors import BadInput, Unavailable
from core.gate import ZERO, Twist
from core.robots.srv1 import MotorSide, Srv1, decode_picture, motor_command, motor_percents, open_device
from tests.core.robots.links import frames, is_up, live, loopback, memory, no_leak, percentile, until
from tests.emulators.srv1 import Srv1Emulator, jpeg_of
from tests.emulators.wires import malformed
from tests.emulators.world import World


@pytest.fixture
def robot_there() -> Iterator[Srv1Emulator]:
    yield from emulated(rate=0)


@pytest.fixture
def slow_robot() -> Iterator[Srv1Emulator]:
    """With the serial line of a real one."""
    yield from emulated(rate=921_600)


def emulated(rate: int) -> Iterator[Srv1Emulator]:
    world = World(failsafe=None)
    emulator = Srv1Emulator(world, rate=rate)
    emulator.start()
    world.start()
    yield emulator
    world.stop()
    emulator.stop()


def device_of(emulator: Srv1Emulator, options: str = "") -> Srv1:
    return open_device(emulator.url.removeprefix("srv1:") + options)


@pytest.mark.parametrize(
    ("percents", "hexadecimal"),
    [((50, 50), "4D323200"), ((30, 70), "4D1E4600"), ((0, 0), "4D000000"), ((-64, 64), "4DC04000")],
)
def test_motor_commands_are_those_of_the_manual(percents: tuple[int, int], hexadecimal: str) -> None:
    assert motor_command(percents).hex().upper() == hexadecimal


def test_speeds_become_percents_of_each_side() -> None:
    assert motor_percents(Twist(0.2, 0.0), 0.1, 0.4, 0.4) == pytest.approx((50, 50))
    assert motor_percents(Twist(0.2, 0.0), 0.1, 0.4, 0.5) == pytest.approx((50, 40))
    assert motor_percents(Twist(0.0, 2.0), 0.1, 0.4, 0.4) == pytest.approx((-25, 25))
    assert motor_percents(Twist(0.8, 4.0), 0.1, 0.4, 0.4) == pytest.approx((60, 100))
    assert motor_percents(Twist(float("nan"), 0.0), 0.1, 0.4, 0.4) == (0, 0)


@pytest.mark.parametrize("wanted", [-1.7, -0.3, 0.05, 0.5, 1.2, 1.9, 2.6, 3.4])
def test_what_is_slower_than_the_motors_turn_comes_in_pulses(wanted: float) -> None:
    side = MotorSide()
    sent = [side.next(wanted, 0.025 * number) for number in range(4000)]
    assert np.mean(sent) == pytest.approx(wanted, abs=0.01) and not {1, -1} & set(sent)
    assert side.next(0.0, 100.1) == 0  # a stop is one at once


def test_usual_speeds_are_whole_percents_without_pulses() -> None:
    side = MotorSide()
    assert {side.next(25.3, 0.025 * number) for number in range(100)} == {25}


def test_the_robot_moves_in_its_world_and_shows_pictures(robot_there: Srv1Emulator) -> None:
    with live(device_of(robot_there)) as robot:
        frames(robot, 0.1, ZERO)
        read = frames(robot, 1.5, Twist(0.2, 0.0))
    images = [frame.image for frame in read if frame.image is not None]
    stamps = np.array([image.stamp for image in images])
    assert robot_there._world.truth.x == pytest.approx(0.3, abs=0.08)
    assert len(images) >= 9 and (np.diff(stamps) > 0).all()
    assert images[-1].pixels.shape == (240, 320, 3) and images[-1].pixels.std() > 10
    assert all(frame.wheels is None for frame in read)  # it has no odometry


def test_the_firmwares_failsafe_is_switched_on_and_stated(robot_there: Srv1Emulator) -> None:
    device = device_of(robot_there)
    base = device.open().base
    assert robot_there.failsafe == (0, 0)
    assert base is not None and base.failsafe == 2.0 and "any byte" in base.failsafe_words and not base.odometry
    device._link.write(motor_command((40, 40)))
    until(lambda: robot_there.motors == (40, 40))
    device.close()
    began = time.monotonic()
    until(lambda: robot_there.motors == (1, 1))
    assert time.monotonic() - began > 1.5


def test_a_driver_that_is_not_called_any_more_stops_the_motors_itself(robot_there: Srv1Emulator) -> None:
    """Pictures would keep the firmware's failsafe from ever stopping them."""
    with live(device_of(robot_there)) as robot:
        robot.drive(ZERO)
        frames(robot, 0.3, Twist(0.2, 0.0))
        assert robot_there.motors == (50, 50)
        until(lambda: robot_there.motors == (1, 1))
        frames(robot, 0.5)
        assert robot_there.motors == (1, 1) and robot_there.pictures > 5


def test_closing_stops_the_motors_at_once(slow_robot: Srv1Emulator) -> None:
    for _ in range(2):
        with live(device_of(slow_robot)) as robot:
            robot.drive(ZERO)
            until(lambda: robot.drive(Twist(0.1, 0.0)) or slow_robot.motors == (25, 25))
        assert slow_robot.motors == (1, 1)


def stop_delays(emulator: Srv1Emulator, count: int, options: str = "") -> list[float]:
    """[s] from the request to zero on the wire."""
    delays: list[float] = []
    chance = np.random.default_rng(2)
    with live(device_of(emulator, options)) as robot:
        robot.drive(ZERO)
        for _ in range(count):
            until(lambda: robot.drive(Twist(0.1, 0.0)) or emulator.heard[-1][1] > 0)
            time.sleep(float(chance.uniform(0.0, 0.1)))
            asked = time.monotonic()
            robot.drive(ZERO)
            until(lambda: emulator.heard[-1][1:] == (0, 0))
            delays.append(max(emulator.heard[-1][0] - asked, 0.0))
    return delays


def test_without_pictures_a_stop_is_on_the_wire_within_30_ms(robot_there: Srv1Emulator) -> None:
    with loopback() as machine:
        for _ in range(3):  # a machine that others use may be late itself, though not every time
            late = percentile(stop_delays(robot_there, 20, "?camera=0"), 0.9)
            own = max(machine.delay() for _ in range(20))
            if late < 0.030 + own:
                break
    assert late < 0.030 + own


def test_a_stop_waits_for_the_picture_under_way_and_no_longer(slow_robot: Srv1Emulator) -> None:
    delays = stop_delays(slow_robot, 10)
    picture = 10 * len(slow_robot._jpeg) / 921_600
    assert 0.005 < max(delays) < picture + 0.1


def test_after_the_robot_was_switched_off_and_on_nothing_moves_before_zero(robot_there: Srv1Emulator) -> None:
    moving = Twist(0.1, 0.0)
    with no_leak(), live(device_of(robot_there, "?camera=0")) as robot:
        robot.drive(ZERO)
        frames(robot, 0.3, moving)
        assert robot_there.motors == (25, 25)
        robot_there.stop()
        until(lambda: not is_up(robot))
        robot_there.heard.clear()
        robot_there.start()
        until(lambda: robot.drive(moving) or is_up(robot), 20.0)
        frames(robot, 0.5, moving)
        assert {percents for _, *percents in robot_there.heard for percents in [tuple(percents)]} == {(0, 0)}
        robot.drive(ZERO)
        until(lambda: robot.drive(moving) or robot_there.motors == (25, 25))


@pytest.mark.parametrize("half", [b"M", b"M\x20\x20", b"F\x01"])
def test_a_command_that_was_half_received_is_completed_with_zeros(robot_there: Srv1Emulator, half: bytes) -> None:
    robot_there.half_heard = half
    with live(device_of(robot_there, "?camera=0")) as robot:
        frames(robot, 0.3, ZERO)
        assert robot_there.motors == (1, 1) and robot_there.failsafe == (0, 0)


def test_a_camera_that_is_busy_or_fails_half_way_is_asked_again(robot_there: Srv1Emulator) -> None:
    device = device_of(robot_there)
    with live(device) as robot:
        until(lambda: robot.read().image is not None)
        robot_there.busy = 2
        robot_there.cut_short = 1
        until(lambda: not robot_there.busy and not robot_there.cut_short)
        assert device.rejected >= 2
        until(lambda: robot.read().image is not None)
        assert is_up(robot)


@pytest.mark.parametrize("frozen", [0.7, 1.3, 2.4])
def test_a_speed_that_waited_in_a_frozen_robot_is_followed_by_a_stop(
    robot_there: Srv1Emulator, frozen: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    obey, thawed = robot_there._obey, list[float]()

    def obey_later(command: bytes) -> bytes:
        if command == motor_command((30, 30)) and not thawed:
            time.sleep(frozen)
            thawed.append(time.monotonic())
        return obey(command)

    monkeypatch.setattr(robot_there, "_obey", obey_later)
    with live(device_of(robot_there, "?camera=0")) as robot:
        robot.drive(ZERO)
        until(lambda: robot.drive(Twist(0.12, 0.0)) or thawed)
        until(lambda: robot_there.motors == (1, 1))
        assert time.monotonic() - thawed[0] < 0.35
        frames(robot, 0.5)
        assert robot_there.motors == (1, 1)


def test_what_is_no_picture_is_not_shown() -> None:
    good = jpeg_of(np.zeros((256, 320, 3), np.uint8))
    assert decode_picture(good) is not None and decode_picture(good + b"\0\0") is not None
    large = jpeg_of(np.zeros((480, 640, 3), np.uint8))
    bad = [b"", b"\xff\xd8\xff\xd9", good[:-2], good[2:], large, b"\xff\xd8" + bytes(500) + b"\xff\xd9"]
    assert [decode_picture(one) for one in bad] == [None] * len(bad)


def fuzz(emulator: Srv1Emulator, count: int) -> tuple[set[tuple[int, int]], float]:
    """Malformed messages while standing → motor commands heard, memory's growth in the second half [MB]."""
    rng, before = np.random.default_rng(4), 0.0
    frame = b"##IMJ5" + struct.pack("<I", len(emulator._jpeg)) + emulator._jpeg
    samples = [b"#M", b"##IMJ5", b"##IMJ5\xff\xff\xff\xff", frame, b"#f##Version - x\r\n", b"#?"]
    with live(device_of(emulator)) as robot:
        for number in range(count):
            if number == count // 2:
                before = memory()
            until(lambda: emulator.inject(malformed(rng, samples[int(rng.integers(len(samples)))])), 30.0)
            if number % 20 == 0:
                robot.drive(ZERO)
                robot.read()
        growth = memory() - before
        until(lambda: (frame := robot.read()).image is not None and not frame.trouble, 30.0)
    return {(left, right) for _, left, right in emulator.heard}, growth


def test_malformed_bytes_neither_end_the_driver_nor_move_the_robot(robot_there: Srv1Emulator) -> None:
    heard, growth = fuzz(robot_there, 500)
    assert heard == {(0, 0)} and growth < 20
    assert robot_there._world.truth.distance_to(0.0, 0.0) == 0


@pytest.mark.campaign
def test_a_hundred_thousand_malformed_messages(robot_there: Srv1Emulator) -> None:
    heard, growth = fuzz(robot_there, 100_000)
    assert heard == {(0, 0)} and growth < 20


@pytest.mark.parametrize(
    "rest", ["", "///dev/ttyUSB0", "//h?wheelbase=0", "//h?left=a", "//h?camera=2", "//h?colour=1", "//h?pictures=0"]
)
def test_an_address_that_cannot_be_is_a_sentence(rest: str) -> None:
    with pytest.raises(BadInput, match=r"\.$"):
        open_device(rest)


def test_something_that_does_not_answer_is_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("core.robots.srv1.OPENING_TIMEOUT_S", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        device = open_device(f"//127.0.0.1:{silent.getsockname()[1]}")
        with pytest.raises(Unavailable, match="no SRV-1 answers"):
            device.open()
        device.close()
