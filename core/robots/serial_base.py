"""A differential drive on a serial port, in a line protocol of Beckon's own: `serial:///dev/ttyUSB0?baud=115200`.

Every line is ASCII text, `*`, two hexadecimal digits of its CRC-8 (polynomial 0x07, from 0, over the text before the
`*`) and a line feed; at most 120 characters. Lines with a wrong sum are dropped on both sides.

To the robot:
    ?                      describe yourself
    V 0.100 -0.500         speed [m/s] and turn rate [rad/s], counter-clockwise; they hold until the next V, and no
                           longer than the failsafe says

From the robot:
    I name=rover wheelbase=0.160 radius=0.11 max_speed=0.30 max_turn_rate=1.5 failsafe=0.5
                           the answer to `?`; metres, m/s, rad/s, seconds. wheelbase must be there
    O 123456 1.2345 1.2360 its milliseconds (unsigned, 32 bit), how far the left and the right wheel have rolled since
                           it was switched on [m]; 20 to 100 times a second
    B 1                    the bumper is pressed; B 0: it is free again
    P 0.87                 charge of the battery, 0..1

The same over TCP, for a robot behind a Wi-Fi bridge: `serial://192.168.4.1:2000`.
"""

import contextlib
import math
import time
from collections import deque

from core.errors import Unavailable
from core.gate.twist import ZERO, Twist
from core.geometry import Pose, arc
from core.robots.byte_link import ByteLink, LinkAddress, NoLink, link_address, open_link
from core.robots.device import Base, ClockOffset, Device, Equipment, Findings
from core.robots.device_clock import RESONATOR_DRIFT, DeviceClock
from core.robots.readings import Readings
from core.sensors.wheels import MAX_SPEED_M_S

EXAMPLE = "serial:///dev/ttyUSB0?baud=115200"
TCP_PORT = 2000
BAUD_RATE = 115200
LONGEST_LINE = 120  # bytes
QUESTION_PERIOD_S = 0.3  # between questions what the robot is
RESET_TIME_S = 5.0  # that it may take to answer: opening the port resets many boards
LOST_AFTER_S = 1.0  # without odometry
SPEED_SPAN_S = 0.06  # over which speeds are taken from the wheels
COUNTER_WRAP_MS = 1 << 32  # at which the robot's counter starts over
MAX_GAP_S = 2.0  # between readings; more is a robot that was started again
CRUISE_SPEED_M_S = 0.1
MAX_ROLLED_M = 0.5  # of a wheel between two readings, beyond MAX_SPEED_M_S
BOUNDS = {
    "wheelbase": (0.01, 5.0),
    "radius": (0.01, 5.0),
    "max_speed": (0.01, 5.0),
    "max_turn_rate": (0.01, 20.0),
    "failsafe": (0.01, 60.0),
}


class BadLine(ValueError):
    """A line that the robot did not send like this."""


def crc8(text: bytes) -> int:
    """CRC-8 with the polynomial 0x07, from 0."""
    crc = 0
    for byte in text:
        crc ^= byte
        for _ in range(8):
            crc = (crc << 1) ^ 0x07 if crc & 0x80 else crc << 1
    return crc & 0xFF


def frame_line(text: str) -> bytes:
    """Text → the line that goes over the wire."""
    body = text.encode("ascii")
    return body + b"*%02X\n" % crc8(body)


def parse_line(line: bytes) -> list[str]:
    """A line without its line feed → its words. Raises BadLine."""
    text, star, total = line.rstrip(b"\r").rpartition(b"*")
    if not star or len(line) > LONGEST_LINE or total.upper() != b"%02X" % crc8(text):
        raise BadLine("wrong sum")
    try:
        return text.decode("ascii").split()
    except UnicodeDecodeError:
        raise BadLine("no text") from None


def parse_numbers(words: list[str], count: int) -> list[float]:
    """`count` finite numbers. Raises BadLine."""
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        raise BadLine("no number") from None
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        raise BadLine("not these numbers")
    return numbers


def parse_description(words: list[str]) -> Equipment:
    """`name=… wheelbase=… …` → what the robot is. Raises BadLine."""
    fields: dict[str, str] = {}
    for word in words:
        key, _, fields[key] = word.partition("=")
    numbers: dict[str, float] = {}
    for key, (low, high) in BOUNDS.items():
        if key in fields:
            numbers[key] = parse_numbers([fields[key]], 1)[0]
            if not low <= numbers[key] <= high:
                raise BadLine(f"impossible {key}")
    if "wheelbase" not in numbers:
        raise BadLine("no wheelbase")
    name = "".join(letter for letter in fields.get("name", "") if letter.isprintable()).replace("_", " ")
    max_speed = numbers.get("max_speed")
    base = Base(
        radius=numbers.get("radius"),
        wheelbase=numbers["wheelbase"],
        cruise=None if max_speed is None else min(CRUISE_SPEED_M_S, max_speed),
        max_speed=max_speed,
        max_turn_rate=numbers.get("max_turn_rate"),
        failsafe=numbers.get("failsafe"),
    )
    return Equipment(name=f"{name[:1].upper()}{name[1:]}" or "Serial robot", base=base)


class WheelOdometry:
    """How far both wheels have rolled → where the robot believes to be, and how fast it moves."""

    def __init__(self, wheelbase: float) -> None:
        self._wheelbase = wheelbase  # [m]
        self._pose = Pose()
        self._past: deque[tuple[float, float, float]] = deque()  # [s] of the robot, left, right [m]
        self._strange: int | None = None  # [ms]: the last reading's counter, where that did not follow
        self.stamp = 0.0  # [s] of the robot's counter, without its turning over

    def move(self, counter: int, left: float, right: float) -> tuple[Pose, float, float]:
        """A reading at `counter` [ms] of wheels [m] → pose, [m/s], [rad/s].

        Raises BadLine where the counter does not follow the last one, or wheels have rolled farther than any: they go
        on from there. OSError where the next follows that one: the
        robot was started again.
        """
        if not self._past:
            self.stamp = counter * 1e-3
            self._past.append((self.stamp, left, right))
            return self._pose, 0.0, 0.0
        elapsed = (counter - round(self._past[-1][0] * 1e3)) % COUNTER_WRAP_MS * 1e-3
        if elapsed > MAX_GAP_S:
            again = self._strange is not None and 0 < counter - self._strange < MAX_GAP_S * 1e3
            self._strange = counter
            if again:
                raise OSError("the robot was started again")
            raise BadLine("a counter that does not follow")
        self._strange = None
        self.stamp += elapsed
        farthest = MAX_ROLLED_M + MAX_SPEED_M_S * elapsed
        if max(abs(left - self._past[-1][1]), abs(right - self._past[-1][2])) > farthest:
            self._past.clear()
            self._past.append((self.stamp, left, right))
            raise BadLine("wheels that cannot have rolled so far")
        forward, turn = self._rolled(self._past[-1], left, right)
        self._pose = self._pose @ arc(forward, turn)
        self._past.append((self.stamp, left, right))
        while len(self._past) > 2 and self._past[1][0] <= self.stamp - SPEED_SPAN_S:
            self._past.popleft()
        forward, turn = self._rolled(self._past[0], left, right)
        span = max(self.stamp - self._past[0][0], 1e-3)
        return self._pose, forward / span, turn / span

    def _rolled(self, since: tuple[float, float, float], left: float, right: float) -> tuple[float, float]:
        """Distance [m] and turn [rad] since a reading."""
        rolled_left, rolled_right = left - since[1], right - since[2]
        return (rolled_left + rolled_right) / 2, (rolled_right - rolled_left) / self._wheelbase


class SerialBase(Device):
    """A robot that speaks the protocol above."""

    def __init__(self, address: LinkAddress) -> None:
        self.rejected = 0  # lines with a wrong sum or without sense
        self._address = address
        self._baud = address.whole("baud", BAUD_RATE, 1200, 4_000_000)
        self._link: ByteLink = NoLink()
        self._buffer = b""
        self._equipment: Equipment | None = None
        self._clock = DeviceClock(RESONATOR_DRIFT)  # a base that was switched off counts from 0: it steps

    def open(self) -> Equipment:
        """Open the port and ask the robot what it is."""
        self._buffer, self._equipment = b"", None
        self._link = open_link(self._address, self._baud)
        asked, end = 0.0, time.monotonic() + RESET_TIME_S
        while time.monotonic() < end:
            if time.monotonic() - asked > QUESTION_PERIOD_S:
                self.drive(ZERO)
                self._link.write(frame_line("?"))
                asked = time.monotonic()
            for words in self._lines(0.05):
                with contextlib.suppress(BadLine):
                    if words[:1] == ["I"]:
                        self._equipment = parse_description(words[1:])
                        return self._equipment
        raise Unavailable(
            f"At {self._address.name} no robot answers the question what it is; is this its port, "
            f"and {self._baud} its baud rate?"
        )

    def run(self, readings: Readings) -> None:
        """Hand on odometry, bumper and battery."""
        if self._equipment is None or self._equipment.base is None:
            return
        odometry = WheelOdometry(self._equipment.base.wheelbase or 0.1)
        heard = time.monotonic()
        while time.monotonic() - heard < LOST_AFTER_S:
            rejected, lines = self.rejected, self._lines(LOST_AFTER_S / 10)
            for words in lines:
                try:
                    self._hand_on(words, odometry, readings)
                except BadLine:
                    self.rejected += 1
                    continue
                if words[:1] == ["O"]:
                    heard = time.monotonic()
            readings.arrived("the base", readable=len(lines), unreadable=self.rejected - rejected)
        raise OSError("no odometry comes")

    def findings(self) -> Findings:
        """The base's clock."""
        offset = self._clock.offset
        return Findings(clocks=() if offset is None else (ClockOffset(clock="base", offset_s=round(offset, 4)),))

    def drive(self, twist: Twist) -> None:
        """Send the speeds."""
        v, w = (twist.v, twist.w) if twist.is_finite() else (0.0, 0.0)
        self._link.write(frame_line(f"V {v:.3f} {w:.3f}"))

    def close(self) -> None:
        """Stop and let go."""
        with contextlib.suppress(OSError):
            self.drive(ZERO)
        self._link.close()

    def _lines(self, timeout: float) -> list[list[str]]:
        """The words of all lines that came within `timeout` [s]; those with a wrong sum are dropped."""
        *lines, rest = (self._buffer + self._link.read(timeout)).split(b"\n")
        self._buffer = rest if len(rest) <= LONGEST_LINE else b""
        found: list[list[str]] = []
        for line in lines:
            try:
                found.append(parse_line(line))
            except BadLine:
                self.rejected += 1
        return found

    def _hand_on(self, words: list[str], odometry: WheelOdometry, readings: Readings) -> None:
        match words:
            case ["O", counter, *wheels] if counter.isdecimal() and int(counter) < COUNTER_WRAP_MS:
                left, right = parse_numbers(wheels, 2)
                pose, speed, turn_rate = odometry.move(int(counter), left, right)
                readings.wheels(pose, speed, turn_rate, self._clock.stamp(odometry.stamp, readings.now()))
            case ["B", ("0" | "1") as pressed]:
                readings.contact(pressed == "1")
            case ["P", charge]:
                readings.battery(min(max(parse_numbers([charge], 1)[0], 0.0), 1.0))
            case ["I", *_]:
                pass
            case _:
                raise BadLine("no such line")


def open_device(rest: str) -> SerialBase:
    """`serial:<rest>` → the robot. Raises BadInput."""
    return SerialBase(link_address(rest, EXAMPLE, ("baud",), tcp_port=TCP_PORT))
