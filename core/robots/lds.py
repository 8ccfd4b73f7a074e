"""Turning lidars on a serial port, through the package lds2d: `lds:///dev/ttyUSB0?model=rplidar-a1`.

One turn of the head is one scan. These lidars turn clockwise: the last of a scan's beams, which run counter-clockwise
from behind the robot, was measured first.
"""

import contextlib
import math
import struct
import time
from collections import deque
from collections.abc import Iterator
from importlib import import_module
from typing import Any

import numpy as np

from core.errors import BadInput, Unavailable
from core.install import install_extra, install_packages
from core.message import message
from core.robots.byte_link import ByteLink, LinkAddress, drain, link_address, open_link
from core.robots.device import Device, Equipment
from core.robots.readings import Readings
from core.sensors import Laser, Scan

EXAMPLE = "lds:///dev/ttyUSB0?model=rplidar-a1"
TCP_PORT = 2000
MISSING = f"Lidars on a serial port need the package lds2d of the extra hardware: {install_extra('hardware')}"
READ_TIMEOUT_S = 0.2  # for which bytes are waited for at a time
LOST_AFTER_S = 3.0  # without a whole turn
OPENING_TIMEOUT_S = 5.0  # until the first point: the motor has to start
WHOLE_TURN_RAD = 1.5 * math.pi  # that must have been swept for a turn to count
MEDIAN_TURNS = 5  # turns whose median duration is that of a turn
RPLIDAR_PWM = b"\xa5\xf0\x02\x94\x02\xc1"  # the motor of an A2 at 660 of 1023


@message
class LidarModel:
    """One kind of lidar."""

    driver: str  # its name in lds2d
    beams: int  # of a scan, somewhat fewer than the points of a turn
    rate: float  # [Hz]
    range_min: float  # [m]
    range_max: float  # [m]
    started: bool = True  # it measures only after a command
    dtr: bool = True  # level of the line DTR at which its motor turns
    motor: bytes = b""  # starts its motor


def _ldrobot(driver: str) -> LidarModel:
    return LidarModel(driver=driver, beams=450, rate=10.0, range_min=0.02, range_max=12.0, started=False)


MODELS = {
    "rplidar-a1": LidarModel(driver="RPLIDAR-A1", beams=360, rate=5.5, range_min=0.15, range_max=12.0, dtr=False),
    "rplidar-a2": LidarModel(
        driver="RPLIDAR-A1", beams=360, rate=10.0, range_min=0.15, range_max=12.0, dtr=False, motor=RPLIDAR_PWM
    ),
    "rplidar-c1": LidarModel(driver="RPLIDAR-C1", beams=450, rate=10.0, range_min=0.05, range_max=12.0, dtr=False),
    "ydlidar-x2": LidarModel(driver="YDLIDAR-X2", beams=400, rate=7.0, range_min=0.10, range_max=8.0, started=False),
    "ydlidar-x4": LidarModel(driver="YDLIDAR-X4", beams=600, rate=7.0, range_min=0.12, range_max=10.0),
    "ld06": _ldrobot("LDROBOT-LD06"),
    "ld19": _ldrobot("LDROBOT-LD19"),
    "stl19p": _ldrobot("LDROBOT-STL19P"),
    "ld14p": LidarModel(driver="LDROBOT-LD14P", beams=600, rate=6.0, range_min=0.10, range_max=8.0),
    "lds-01": LidarModel(driver="HLS-LFCD2", beams=360, rate=5.0, range_min=0.12, range_max=3.5),
}


def laser_of(model: LidarModel) -> Laser:
    """The lidar as Beckon describes lasers: all around, counter-clockwise from straight behind."""
    return Laser(
        beams=model.beams,
        angle_min=-math.pi,
        angle_step=math.tau / model.beams,
        range_min=model.range_min,
        range_max=model.range_max,
        rate=model.rate,
        time_step=-1 / (model.rate * model.beams),
    )


class TurnCollector:
    """Points of a head that turns clockwise → scans."""

    def __init__(self, laser: Laser) -> None:
        self._laser = laser
        self._ranges = np.full(laser.beams, np.nan)
        self._last = 0.0  # [rad]
        self._swept = 0.0  # [rad] since the head looked behind
        self._durations: deque[float] = deque(maxlen=MEDIAN_TURNS)
        self._ended: float | None = None  # [s] when the last turn ended; None: no turn was seen from its begin yet

    def add(self, clockwise: float, distance: float, now: float) -> Scan | None:
        """A point at an angle [rad] from the front, at a distance [m] (0: no echo) → the turn that it ends."""
        angle = math.remainder(-clockwise, math.tau)
        step = math.remainder(self._last - angle, math.tau)
        scan = None
        if angle - self._last > math.pi and (self._swept + step >= WHOLE_TURN_RAD or self._ended is None):
            scan = self._finish(now)
        self._swept += step
        self._last = angle
        beam = round((angle - self._laser.angle_min) / self._laser.angle_step) % self._laser.beams
        if self._laser.range_min <= distance <= self._laser.range_max and not self._ranges[beam] <= distance:
            self._ranges[beam] = distance
        return scan

    def _finish(self, now: float) -> Scan | None:
        """Begin the next turn → the one that has just ended; None: its begin was missed."""
        ranges, ended = self._ranges, self._ended
        self._ranges = np.full(self._laser.beams, np.nan)
        self._swept, self._ended = 0.0, now
        if ended is None:
            return None
        self._durations.append(now - ended)
        duration = float(np.median(self._durations))
        return Scan(
            stamp=now,
            ranges=ranges,
            angle_min=self._laser.angle_min,
            angle_step=self._laser.angle_step,
            range_min=self._laser.range_min,
            range_max=self._laser.range_max,
            time_step=-duration / self._laser.beams,
        )


class LidarTransport:
    """The bytes as lds2d asks for them. Silence, or bytes that make no turn, end it."""

    def __init__(self, link: ByteLink) -> None:
        self.deadline = time.monotonic() + OPENING_TIMEOUT_S
        self._link = link

    def read(self, size: int) -> bytes:
        """Bytes that came, however much `size` is; b"" when nothing did. Raises OSError after the deadline."""
        if time.monotonic() > self.deadline:
            raise OSError("no whole turn comes")
        return self._link.read(READ_TIMEOUT_S)

    def write(self, data: bytes) -> int:
        """Send all."""
        self._link.write(data)
        return len(data)

    def close(self) -> None:
        """Let go."""
        self._link.close()


class LidarDevice(Device):
    """A lidar of MODELS."""

    def __init__(self, address: LinkAddress) -> None:
        model = MODELS.get(address.options.get("model", "").lower())
        if model is None:
            raise BadInput(f"A lidar needs its model, as in {EXAMPLE}; known are {', '.join(MODELS)}.")
        self._address, self._model = address, model
        self._baud = address.whole("baud", 0, 0, 4_000_000)
        self._transport: LidarTransport | None = None
        self._driver: Any = None
        self._points: Iterator[Any] = iter(())

    def open(self) -> Equipment:
        """Open the port, start the head, and wait for the first point."""
        create, baud = _driver_class(self._model.driver)
        link = open_link(self._address, self._baud or baud, dtr=self._model.dtr)
        self._transport = LidarTransport(link)
        self._driver = create(self._transport)
        self._start(link)
        self._points = self._driver.points()
        if self._next_point() is None:
            raise Unavailable(
                f"At {self._address.name} no {self._address.options['model']} measures; is this its port, "
                "and does its head turn?"
            )
        return Equipment(name=self._driver.MODEL_NAME, lasers=(laser_of(self._model),))

    def run(self, readings: Readings) -> None:
        """Hand on turn by turn."""
        transport, turns = self._transport, TurnCollector(laser_of(self._model))
        if transport is None:
            return
        transport.deadline = time.monotonic() + LOST_AFTER_S
        while (point := self._next_point()) is not None:
            scan = turns.add(math.radians(point.angle_deg), point.dist_mm / 1000, readings.now())
            if scan is not None:
                transport.deadline = time.monotonic() + LOST_AFTER_S
                readings.scan(scan)

    def close(self) -> None:
        """Stop the measurement and let go."""
        transport = self._transport
        if transport is not None:
            if self._model.started:
                with contextlib.suppress(OSError):
                    self._driver.stop()
            transport.close()

    def _start(self, link: ByteLink) -> None:
        """Bring the head to where it begins to measure, whatever it was doing."""
        if not self._model.started:
            return
        self._driver.stop()
        drain(link, 0.05, 0.5)
        if self._model.motor:
            link.write(self._model.motor)
        self._driver.start()

    def _next_point(self) -> Any:
        try:
            return next(self._points, None)
        except (OSError, ValueError, LookupError, ArithmeticError, struct.error):
            return None


def _driver_class(name: str) -> tuple[Any, int]:
    """The driver of lds2d and its baud rate [bit/s]. Raises Unavailable."""
    try:
        import_module("lds2d.drivers")  # fills the register
        core = import_module("lds2d.core")
    except ModuleNotFoundError:
        raise Unavailable(f"{MISSING}.") from None
    found: Any = core.driver_for(name)
    if found is None:
        raise Unavailable(f"This version of lds2d does not know the {name}: {install_packages('-U', 'lds2d')}")
    return found, int(found.DEFAULT_BAUD)


def open_device(rest: str) -> LidarDevice:
    """`lds:<rest>` → the lidar. Raises BadInput."""
    return LidarDevice(link_address(rest, EXAMPLE, ("model", "baud"), tcp_port=TCP_PORT))
