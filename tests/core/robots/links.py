"""What the tests of devices on a real wire share."""

import os
import queue
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import psutil

from core.gate import Twist
from core.robots import Profile
from core.robots.device import Device, Equipment
from core.robots.live import LiveRobot
from core.sensors import SensorFrame

PERIOD = 1 / 40  # [s] of the driver's frames


def shape(equipment: tuple[Equipment, ...]) -> Profile:
    lasers = tuple(laser for one in equipment for laser in one.lasers)
    cameras = tuple(camera for one in equipment for camera in one.cameras)
    return Profile(name=equipment[0].name, url="", lasers=lasers, cameras=cameras)


@contextmanager
def live(device: Device) -> Iterator[LiveRobot]:
    robot = LiveRobot([("the device", device)], shape)
    try:
        yield robot
    finally:
        robot.close()


def until(true: Callable[[], object], seconds: float = 100.0) -> None:
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.005)


def frames(robot: LiveRobot, seconds: float, twist: Twist | None = None) -> list[SensorFrame]:
    """What the driver's loop reads in that time; `twist` is asked for with every frame."""
    read: list[SensorFrame] = []
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if twist is not None:
            robot.drive(twist)
        read.append(robot.read())
        time.sleep(PERIOD)
    return read


def is_up(robot: LiveRobot) -> bool:
    return not robot.read().trouble


@contextmanager
def no_leak() -> Iterator[None]:
    """Afterwards there are no more threads and open files than before."""

    def held() -> tuple[int, int]:
        return sum(thread.name.startswith("device-") for thread in threading.enumerate()), len(
            os.listdir("/proc/self/fd")
        )

    before = held()
    yield
    until(lambda: all(now <= then for now, then in zip(held(), before, strict=True)))


def memory() -> float:
    """Resident memory of this process [MB]."""
    return psutil.Process().memory_info().rss / 1e6


def percentile(values: list[float], share: float) -> float:
    return sorted(values)[min(int(share * len(values)), len(values) - 1)]


class Loopback:
    """How long this machine itself takes now from one thread's send to another's receipt, without any driver."""

    def __init__(self) -> None:
        self._near, self._far = socket.socketpair()
        self._received: queue.Queue[float] = queue.Queue()
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()

    def _listen(self) -> None:
        while self._far.recv(1):
            self._received.put(time.monotonic())

    def delay(self) -> float:
        """[s] of one byte."""
        began = time.monotonic()
        self._near.send(b"0")
        return self._received.get(timeout=10.0) - began

    def close(self) -> None:
        self._near.close()
        self._thread.join()
        self._far.close()


@contextmanager
def loopback() -> Iterator[Loopback]:
    measured = Loopback()
    try:
        yield measured
    finally:
        measured.close()
