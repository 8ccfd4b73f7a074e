"""Every link to a ROS robot against its emulator, with the simulated robot behind it, on a real wire."""

import functools
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from core.gate import ZERO, Twist
from core.robots.device import Device
from core.robots.foxglove import open_device as open_foxglove
from core.robots.requests import SwitchSpeeds
from core.robots.ros.typestore import TWIST_STAMPED
from core.robots.rosbridge import open_device as open_rosbridge
from core.robots.zenoh_link import open_device as open_zenoh
from core.sensors import Image, Scan
from tests.core.robots.links import PERIOD, frames, is_up, live, loopback, no_leak, percentile, until
from tests.emulators.foxglove import FoxgloveEmulator
from tests.emulators.rosbridge import RosbridgeEmulator
from tests.emulators.world import World
from tests.emulators.zenoh_robot import ZenohEmulator

Opened = tuple[Any, Callable[..., Device]]

LINKS: dict[str, tuple[Callable[[World], Any], Callable[[str], Device], str]] = {
    "foxglove": (FoxgloveEmulator, open_foxglove, ""),
    "rosbridge": (RosbridgeEmulator, open_rosbridge, ""),
    "rosbridge ROS 1": (functools.partial(RosbridgeEmulator, ros1=True), open_rosbridge, ""),
    "rosbridge JSON": (RosbridgeEmulator, open_rosbridge, "encoding=json"),
    "rosbridge ROS 1 JSON": (functools.partial(RosbridgeEmulator, ros1=True), open_rosbridge, "encoding=json"),
    "zenoh rmw": (ZenohEmulator, open_zenoh, ""),
    "zenoh rmw Humble": (functools.partial(ZenohEmulator, humble=True), open_zenoh, ""),
    "zenoh bridge": (functools.partial(ZenohEmulator, bridge=True), open_zenoh, ""),
}


DIALECTS = ("rosbridge JSON", "rosbridge ROS 1 JSON", "zenoh rmw Humble", "zenoh bridge")  # in the campaign


@pytest.fixture(
    scope="module",
    params=[pytest.param(name, marks=[pytest.mark.campaign] if name in DIALECTS else []) for name in LINKS],
)
def there(request: pytest.FixtureRequest) -> Iterator[tuple[Any, Callable[..., Device]]]:
    """A running emulator for all tests of a link, and what opens a device with options for it."""
    make, open_device, always = LINKS[request.param]
    world = World()
    emulator = make(world)
    emulator.start()
    world.start()
    place = emulator.url.partition(":")[2]
    yield emulator, lambda *options: open_device(f"{place}?{'&'.join(filter(None, (always, *options)))}")
    emulator.stop()
    world.stop()


@pytest.fixture
def opened(there: Opened) -> Opened:
    """The same, nothing heard yet."""
    emulator, _ = there
    for heard in (emulator.received, emulator.locks):
        heard.clear()
    return there


class Made:
    """What an emulator's world makes: the driver is to hand on all of it, at whatever rate the machine simulates."""

    def __init__(self, world: World) -> None:
        self.late: list[float] = []  # [s] from the first beam of every scan to when it was made
        self.images = 0
        self._world = world
        world.on_scan.append(self._scan)
        world.on_image.append(self._image)

    def clear(self) -> None:
        self.late, self.images = [], 0

    def _scan(self, scan: Scan) -> None:
        self.late.append(time.monotonic() - self._world.instant(scan.stamp))

    def _image(self, _: Image) -> None:
        self.images += 1


def test_all_streams_come_at_their_rates_and_stamps_never_go_back(opened: Opened) -> None:
    emulator, device = opened
    made, late = Made(emulator.world), list[float]()
    with live(device()) as robot:
        frames(robot, 0.8)  # until the clocks are compared
        made.clear()
        read = frames(robot, 1.5)
        late, images, took = list(made.late), made.images, len(made.late)
        laser, camera = robot.profile.laser, robot.profile.camera
    scans = [frame.scan for frame in read if frame.scan]
    assert took >= 3 and abs(len(scans) - took) <= 3
    assert 3 <= sum(frame.image is not None for frame in read) <= images + 3  # only the newest is handed on
    assert all(frame.wheels is not None for frame in read)
    for stamps in ([frame.stamp for frame in read], [scan.stamp for scan in scans]):
        assert (np.diff(stamps) > 0).all()
    assert np.median(np.diff([scan.stamp for scan in scans])) == pytest.approx(0.1, abs=0.005)
    ages = [frame.stamp - frame.scan.stamp for frame in read if frame.scan]
    assert 0.06 < percentile(ages, 0.5) < percentile(late, 0.5) + 0.1  # late: since the first beam, when it was made
    assert laser is not None and laser.beams == 682 and laser.height == pytest.approx(0.12)
    assert camera is not None and camera.model.k1 == pytest.approx(-0.43039)
    assert camera.mounting.translation == pytest.approx([0.04, 0.0, 0.16])


def test_speeds_move_the_robot_and_its_wheels_say_so(opened: Opened) -> None:
    emulator, device = opened
    for _ in range(3):  # on a busy machine the base's watchdog may stand in for speeds that come late
        with live(device()) as robot:
            frames(robot, 0.3, ZERO)
            until(lambda: robot.read().wheels is not None)
            first = robot.read().wheels
            start, left_out = emulator.world.truth, emulator.world.left_out
            frames(robot, 1.0, Twist(0.2, 0.5))
            frames(robot, 0.6, ZERO)
            until(lambda: robot.read().wheels is not None)
            last = robot.read().wheels
        assert first is not None and last is not None
        moved, said = start.inverse() @ emulator.world.truth, first.odometry.inverse() @ last.odometry
        assert said.heading == pytest.approx(moved.heading, abs=0.03) and said.x == pytest.approx(moved.x, abs=0.02)
        (began, *_), (ended, *_) = emulator.world.speeds[-2:]
        seconds = ended - began  # as the robot heard it; what the machine did not simulate is missing
        assert moved.heading < 0.5 * seconds + 0.1
        if moved.heading > 0.5 * (seconds - (emulator.world.left_out - left_out)) - 0.1:
            return
    pytest.fail(f"It turned by {moved.heading:.2f} rad in {seconds:.2f} s.")


def test_nothing_is_on_the_wire_while_nothing_is_asked_for_and_five_zeros_end_a_motion(opened: Opened) -> None:
    emulator, device = opened
    with live(device()) as robot:
        frames(robot, 0.5, ZERO)
        assert emulator.received == []
        frames(robot, 0.3, Twist(0.1, 0.0))
        robot.drive(ZERO)  # nobody calls any more
        until(lambda: len(emulator.received) > 5 and not any(any(one[1:]) for one in emulator.received[-5:]))
        time.sleep(0.1)
        speeds = [pair[1:] for pair in emulator.received]
        assert speeds[-5:] == [(0.0, 0.0)] * 5 and speeds[-6] == (0.1, 0.0)
        frames(robot, 0.5, ZERO)
        assert len(emulator.received) == len(speeds)


@pytest.mark.campaign  # the conformance suite has a shorter one
def test_a_stop_is_on_the_wire_within_30_ms(opened: Opened) -> None:
    emulator, device = opened
    waits, machine = list[float](), list[float]()
    with live(device()) as robot, loopback() as measured:
        frames(robot, 0.2, ZERO)
        for _ in range(60):
            frames(robot, 2 * PERIOD, Twist(0.05, 0.0))
            count = len(emulator.received)
            asked = time.monotonic()
            robot.drive(ZERO)
            until(lambda count=count: any(not any(one[1:]) for one in emulator.received[count:]))
            waits.append(next(one[0] for one in emulator.received[count:] if not any(one[1:])) - asked)
            machine.append(measured.delay())
    assert percentile(waits, 0.99) < 0.030 + max(machine), waits


def test_the_lock_is_a_heartbeat_that_closes_when_nothing_is_asked_for(opened: Opened) -> None:
    emulator, device = opened
    with live(device("lock=/stop_lock")) as robot:
        frames(robot, 0.5, ZERO)
        assert len(emulator.locks) >= 3 and all(closed for _, closed in emulator.locks)
        frames(robot, 0.5, Twist(0.1, 0.0))
        assert emulator.locks[-1][1] is False
        frames(robot, 0.5, ZERO)
        assert emulator.locks[-1][1] is True


@pytest.mark.campaign  # as the conformance suite has it, for every dialect
def test_after_the_bridge_was_gone_nothing_moves_before_zero_was_asked_for(opened: Opened) -> None:
    emulator, device = opened
    with live(device()) as robot:
        frames(robot, 0.3, ZERO)
        frames(robot, 0.3, Twist(0.1, 0.0))
        emulator.stop()
        until(lambda: not is_up(robot))
        count = len(emulator.received)
        emulator.start()
        until(lambda: robot.drive(Twist(0.1, 0.0)) or is_up(robot), 15.0)
        frames(robot, 0.5, Twist(0.1, 0.0))
        assert not any(any(one[1:]) for one in emulator.received[count:])
        robot.drive(ZERO)
        frames(robot, 0.2, Twist(0.1, 0.0))
        assert emulator.received[-1][1:] == (0.1, 0.0)
        until(lambda: robot.read().scan is not None)
        said = " ".join(note for frame in frames(robot, 0.1) for note in frame.notes)
        assert "microphones" not in said  # that was said at first


def test_closing_stops_the_robot_and_leaks_nothing(opened: Opened) -> None:
    emulator, device = opened
    with live(device()) as robot:  # what a first connection keeps for good
        frames(robot, 0.1)
    with no_leak():
        with live(device()) as robot:
            frames(robot, 0.2, ZERO)
            until(lambda: robot.drive(Twist(0.1, 0.0)) or emulator.received)
        until(lambda: emulator.received[-1][1:] == (0.0, 0.0))


def test_the_robot_stops_by_itself_when_the_console_is_silent(opened: Opened) -> None:
    emulator, device = opened
    with live(device()) as robot:
        frames(robot, 0.2, ZERO)
        frames(robot, 0.2, Twist(0.1, 0.0))
        until(lambda: emulator.world.speeds[-1][1:] == (0.0, 0.0), 3.0)


@pytest.mark.parametrize("make", [FoxgloveEmulator, RosbridgeEmulator])
def test_a_guessed_type_of_speeds_that_moves_nothing_is_named_and_the_other_one_moves_it(
    monkeypatch: pytest.MonkeyPatch, make: Callable[..., Any]
) -> None:
    monkeypatch.setattr("core.robots.ros.socket_link.LEARNING_TIMEOUT_S", 0.3)
    world = World()
    emulator = make(world, cmd_vel_type=TWIST_STAMPED, tells=False)
    world.on_image.clear()  # nobody looks
    if isinstance(emulator, FoxgloveEmulator):
        emulator.capabilities = ("ClientPublish",)
    emulator.start()
    world.start()
    slow, device = Twist(0.05, 0.0), LINKS[emulator.url.partition(":")[0]][1](emulator.url.partition(":")[2])
    with live(device) as robot:
        until(lambda: is_up(robot) and robot.read().wheels)
        frames(robot, 0.1, ZERO)
        found: list[str] = []

        def named() -> bool:
            found.extend(one.sentence for one in frames(robot, 0.1, slow)[-1].faults)
            return bool(device.findings().faults) and bool(found or frames(robot, 2.0, slow))

        until(named)
        (said,) = device.findings().faults
        assert said.code == "speeds.type_guessed"
        assert "sent as Twist; this base may take TwistStamped" in said.sentence
        assert emulator.received == []

        assert robot.ask(SwitchSpeeds(type="TwistStamped")).type == "TwistStamped"
        frames(robot, 0.2, slow)
        assert emulator.received == []  # before zero was asked for
        frames(robot, 0.1, ZERO)
        start = world.truth
        until(lambda: frames(robot, 0.1, slow) and (start.inverse() @ world.truth).x > 0.02)
        until(lambda: frames(robot, 0.1, slow) and not device.findings().faults)
        speeds = next(role for role in device.findings().roles if role.role == "cmd_vel")
        assert speeds.used[0].guessed and speeds.used[0].type == TWIST_STAMPED
    world.stop()
    emulator.stop()
