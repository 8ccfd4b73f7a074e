"""The driver's process between gate and console: each of its own watchdogs, with a robot that has none."""

import os
import socket
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from core.gate import ZERO, Twist
from core.gate.packets import packet_pair, send_packet, take_packets
from core.robots import Profile, driver
from core.robots.frame_sender import FrameReceiver, FrameSender
from core.robots.process import MAX_SLOWDOWN_FACTOR, TWIST_TIMEOUT_S, DriverLoop
from core.robots.requests import AnswerT, RobotRequest, not_taken
from core.sensors import Laser, Scan, SensorFrame

LASER = Laser(beams=100, angle_step=0.04, angle_min=-2.0)


class Obedient:
    """A base that goes on for ever with what it was told last."""

    def __init__(self) -> None:
        self.profile = Profile(name="obedient", url="obedient:", lasers=(LASER,))
        self.twist = ZERO
        self.told: list[tuple[float, Twist]] = []
        self.scanning = False
        self.ranges = np.full(LASER.beams, 3.0)
        self._frames = 0

    def drive(self, twist: Twist) -> None:
        self.twist = twist
        self.told.append((time.monotonic(), twist))

    @property
    def stamp(self) -> float:
        return self._frames / self.profile.rate

    def read(self) -> SensorFrame:
        self._frames += 1
        stamp = self.stamp
        scan = None
        if self.scanning and self._frames % 4 == 0:
            scan = Scan(
                stamp=stamp, ranges=self.ranges.copy(), angle_min=LASER.angle_min, angle_step=LASER.angle_step
            )
        return SensorFrame(stamp=stamp, scan=scan)

    requests = ()

    def ask(self, request: RobotRequest[AnswerT]) -> AnswerT:
        raise not_taken(self.requests)

    def close(self) -> None: ...


class Running:
    """A driver that runs in a thread, with gate and console played by the test."""

    def __init__(self) -> None:
        self.robot = Obedient()
        (self.control, their_control), (self.gate, their_gate) = packet_pair(), packet_pair()
        self.stream, their_stream = socket.socketpair()
        self.frame_sender = FrameSender(their_stream)
        self.driver = DriverLoop(self.robot, their_control, their_gate, self.frame_sender)
        self.thread = threading.Thread(target=self.driver.run)
        self.thread.start()

    def until(self, happens: Callable[[], bool], seconds: float = 60.0) -> None:
        ends = time.monotonic() + seconds
        while not happens():
            assert time.monotonic() < ends
            time.sleep(0.002)

    def start_driving(self) -> None:
        self.until(lambda: bool(take_packets(self.gate)[0]))  # it runs
        send_packet(self.gate, {"v": 0.2, "w": 0.0, "nonce": 1})
        self.until(lambda: self.robot.twist.moves)

    def end(self) -> None:
        send_packet(self.control, {"kind": "leave"})
        self.thread.join(5.0)
        assert not self.thread.is_alive() and self.robot.twist == ZERO
        self.frame_sender.close()
        for end in (self.control, self.gate, self.stream):
            end.close()


@pytest.fixture
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """What stops the base is not the silence of the gate."""
    monkeypatch.setattr("core.robots.process.TWIST_TIMEOUT_S", 1e9)  # beyond every wait here


@pytest.fixture
def running() -> Iterator[Running]:
    running = Running()
    yield running
    running.end()


def test_without_twists_the_base_is_told_to_stand(running: Running) -> None:
    running.start_driving()
    begun = running.robot.told[-1][0]
    running.until(lambda: not running.robot.twist.moves)
    assert running.robot.told[-1][0] - begun >= TWIST_TIMEOUT_S
    send_packet(running.gate, {"v": 0.2, "w": 0.0, "nonce": 2})
    running.until(lambda: running.robot.twist.moves)


def test_a_gate_that_is_gone_means_zero(patient: None, running: Running) -> None:
    running.start_driving()
    running.gate.close()
    running.until(lambda: not running.robot.twist.moves)


def test_another_gate_begins_at_zero(patient: None, running: Running) -> None:
    running.start_driving()
    other, theirs = packet_pair()
    with theirs:
        socket.send_fds(running.control, [b'{"kind":"gate"}'], [theirs.fileno()])
    running.until(lambda: not running.robot.twist.moves)
    running.gate.close()
    running.gate = other
    send_packet(running.gate, {"v": 0.1, "w": 0.0, "nonce": 5})
    running.until(lambda: running.robot.twist.moves)


@pytest.mark.parametrize("nonsense", [{}, {"v": "fast", "w": 0.0}, {"v": True, "w": 0.0}, {"v": 0.1}], ids=str)
def test_a_twist_that_is_none_is_zero(patient: None, running: Running, nonsense: dict[str, Any]) -> None:
    running.start_driving()
    send_packet(running.gate, nonsense)
    running.until(lambda: not running.robot.twist.moves)


def test_with_console_and_gate_gone_it_ends_at_zero() -> None:
    running = Running()
    running.start_driving()
    running.stream.close()
    running.control.close()
    running.gate.close()
    running.thread.join(5.0)
    assert not running.thread.is_alive() and running.robot.twist == ZERO
    running.frame_sender.close()


def test_a_console_that_is_no_longer_its_parent_is_gone(running: Running, monkeypatch: pytest.MonkeyPatch) -> None:
    running.start_driving()
    monkeypatch.setattr(os, "getppid", lambda: 1)
    running.gate.close()
    running.thread.join(5.0)
    assert not running.thread.is_alive()


def test_a_laser_that_repeats_one_scan_on_the_move_is_not_told_to_the_gate(running: Running) -> None:
    def points() -> int:
        return sum("points" in packet for packet in take_packets(running.gate)[0])

    running.robot.scanning = True
    standing = 0
    ends = time.monotonic() + 5.0
    while standing < 3:
        assert time.monotonic() < ends
        standing += points()
        time.sleep(0.01)
    ends, moving = time.monotonic() + 0.6, 0
    while time.monotonic() < ends:
        send_packet(running.gate, {"v": 0.2, "w": 0.0, "nonce": 1})
        moving += points()
        time.sleep(0.02)
    assert moving <= 2


def test_a_frame_tells_when_it_was_sensed_however_late_it_is_read(running: Running) -> None:
    begun = time.monotonic()
    time.sleep(0.3)
    now, inbox, frames = time.monotonic(), FrameReceiver(), list[SensorFrame]()
    while not frames:
        frames += inbox.feed(running.stream.recv(65536))
    assert begun - 1.0 < frames[0].sensed < now - 0.1


def test_a_simulated_robot_lives_no_further_than_its_gate_lets_it_but_very_slowly(running: Running) -> None:
    running.start_driving()
    until = running.robot.stamp + 0.2
    send_packet(running.gate, {"v": 0.0, "w": 0.0, "nonce": 2, "until": until})
    running.until(lambda: running.robot.stamp > until - 0.03)
    begun = time.monotonic()
    time.sleep(0.2)
    stamp, passed = running.robot.stamp, time.monotonic() - begun
    assert stamp <= until + (1 + passed / (MAX_SLOWDOWN_FACTOR / 40)) / 40
    send_packet(running.gate, {"v": 0.0, "w": 0.0, "nonce": 3})  # a gate of a real robot says no time
    running.until(lambda: running.robot.stamp > until + 0.2)


def test_the_names_of_the_import_line_stay() -> None:
    """Drivers of other people import them: a name may come, and none may go."""
    promised = [
        "ZERO",
        "BadInput",
        "Base",
        "Camera",
        "CameraModel",
        "Device",
        "Equipment",
        "Findings",
        "Image",
        "Laser",
        "MicrophoneArray",
        "Pose",
        "Readings",
        "Refused",
        "Scan",
        "Sound",
        "Transform",
        "Twist",
        "Unavailable",
        "arc",
        "check_robot",
    ]
    assert set(promised) <= set(driver.__all__) and all(hasattr(driver, name) for name in promised)
