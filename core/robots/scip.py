"""Hokuyo lasers that speak SCIP 2.0, such as the URG-04LX-UG01: `scip:///dev/ttyACM0`, `scip://192.168.0.10:10940`.

Options: `skip` scans left out after each, `cluster` steps joined into one beam, `baud` of a unit on RS-232.
Source: the communication protocol specification SCIP 2.0 (C-42-03320B).
"""

import contextlib
import math
import time
from collections import deque
from collections.abc import Sequence

import numpy as np

from core.errors import Unavailable
from core.message import Array, message
from core.robots.byte_link import ByteLink, LinkAddress, NoLink, drain, link_address, open_link
from core.robots.device import ClockOffset, Device, Equipment, Findings
from core.robots.device_clock import DeviceClock
from core.robots.readings import Readings
from core.sensors import Laser, Scan

EXAMPLE = "scip:///dev/ttyACM0 or scip://192.168.0.10:10940"
TCP_PORT = 10940
BAUD_RATES = (19200, 38400, 115200)  # of RS-232 units, in the order in which they are tried; USB takes any
ANSWER_TIMEOUT_S = 0.3  # until the answer to a short command
DRAIN_QUIET_S = 0.15  # of silence after which nothing more is on its way
MAX_DRAIN_S = 1.5  # at most until a stream that ran is over
MAX_TRIES, SILENT_TRIES = 5, 2  # at each baud rate; the latter where nothing at all comes back
LARGEST_REPLY = 65536  # bytes without an empty line after which they are garbage
LOST_AFTER_S = 3.0  # without a good scan; at least 16 periods
CLOCK_ROUNDS = 8  # questions for the sensor's time
SETTLING_SCANS = 10  # scans from which the delay of a scan is learnt
COUNTER_WRAP_MS = 1 << 24  # at which the sensor's counter starts over
JUMP_MS = 5000  # a timestamp that differs more from the last is no timestamp of the next scan
NO_ECHO_BELOW = 20  # values below are error codes: too weak, too strong, inconsistent


class BadReply(ValueError):
    """A reply that the sensor did not send like this: its sum, its length or its echo is wrong."""


@message
class ScipParameters:
    """The sensor's own description (`PP`)."""

    model: str
    range_min: int  # DMIN [mm]
    range_max: int  # DMAX [mm]
    steps_per_turn: int  # ARES
    first: int  # AMIN, step of the first beam
    last: int  # AMAX
    front: int  # AFRT, step of the beam straight ahead
    rpm: int  # SCAN, turns of the mirror per minute


def checksum(line: bytes) -> int:
    """The character that ends a line."""
    return (sum(line) & 0x3F) + 0x30


def decode(characters: bytes, width: int) -> Array:
    """Characters of 6 bits each, most significant first, `width` a number → (N,) int64. Raises BadReply."""
    bits = np.frombuffer(characters, np.uint8).astype(np.int64) - 0x30
    if len(bits) % width or ((bits < 0) | (bits > 0x3F)).any():
        raise BadReply("no numbers")
    return bits.reshape(-1, width) @ (64 ** np.arange(width - 1, -1, -1))


def checked(line: bytes) -> bytes:
    """A line without its sum. Raises BadReply."""
    if len(line) < 2 or line[-1] != checksum(line[:-1]):
        raise BadReply("wrong sum")
    return line[:-1]


def status_of(lines: Sequence[bytes], command: bytes) -> bytes:
    """The two characters of a reply's status. Raises BadReply where it is no reply to `command`."""
    if len(lines) < 2 or lines[0] != command or len(lines[1]) != 3:
        raise BadReply("no reply to this command")
    return checked(lines[1])


def parse_parameters(lines: Sequence[bytes]) -> ScipParameters:
    """The lines of a `PP` reply. Raises BadReply."""
    status = status_of(lines, b"PP")
    if status != b"00":
        raise BadReply("refused")
    fields: dict[str, str] = {}
    for line in lines[2:]:
        body, semicolon, total = line.rpartition(b";")
        if not semicolon or len(total) != 1 or total[0] not in (checksum(body), checksum(body + b";")):
            raise BadReply("wrong sum")
        key, _, value = body.decode("ascii", "replace").partition(":")
        fields[key] = value
    try:
        found = ScipParameters(
            model=fields["MODL"].partition("(")[0].strip(),
            range_min=int(fields["DMIN"]),
            range_max=int(fields["DMAX"]),
            steps_per_turn=int(fields["ARES"]),
            first=int(fields["AMIN"]),
            last=int(fields["AMAX"]),
            front=int(fields["AFRT"]),
            rpm=int(fields["SCAN"]),
        )
    except (KeyError, ValueError):
        raise BadReply("incomplete") from None
    sound = 0 <= found.first < found.last <= 9999 and 16 <= found.steps_per_turn <= 65536 and 1 <= found.rpm <= 60000
    if not sound or not 0 <= found.range_min < found.range_max < COUNTER_WRAP_MS:
        raise BadReply("impossible geometry")
    return found


def parse_scan(lines: Sequence[bytes], beams: int) -> tuple[int, Array]:
    """The lines of a scan behind its echo and status → the sensor's time [ms] and (beams,) [mm]. Raises BadReply."""
    if len(lines) < 2 or len(lines[0]) != 5:
        raise BadReply("no time")
    stamp = int(decode(checked(lines[0]), 4)[0])
    if any(len(line) != 65 for line in lines[1:-1]):
        raise BadReply("a line is too short or too long")
    ranges = decode(b"".join(checked(line) for line in lines[1:]), 3)
    if len(ranges) != beams:
        raise BadReply("not all beams")
    return stamp, ranges


def in_metres(ranges: Array, parameters: ScipParameters) -> Array:
    """Values of the sensor (N,) [mm] → (N,) [m], NaN for its error codes and what lies beyond its range."""
    low = max(NO_ECHO_BELOW, parameters.range_min)
    good = (ranges >= low) & (ranges <= parameters.range_max)
    return np.where(good, ranges / 1000, np.nan)


def laser_of(parameters: ScipParameters, skip: int, cluster: int) -> Laser:
    """The sensor as Beckon describes lasers; a cluster is one beam in its middle."""
    step = math.tau / parameters.steps_per_turn
    period = 60 / parameters.rpm
    return Laser(
        beams=math.ceil((parameters.last - parameters.first + 1) / cluster),
        angle_min=(parameters.first - parameters.front + (cluster - 1) / 2) * step,
        angle_step=cluster * step,
        range_min=parameters.range_min / 1000,
        range_max=parameters.range_max / 1000,
        rate=1 / (period * (skip + 1)),
        time_step=cluster * period / parameters.steps_per_turn,
    )


class SensorTime:
    """The sensor's counter of milliseconds, put on the robot's clock.

    A question for the time (`TM`) says how far the clocks are apart; a scan arrives late by a turn of the mirror and
    its way through the cable, by how much is learnt from the first ones.
    """

    def __init__(self, apart: float | None, late: float) -> None:
        """`apart` [s]: robot's clock minus the sensor's, as asked; None: not known. `late` [s]: a scan at least."""
        self._apart, self._late = apart, late
        self._clock = DeviceClock()
        self._last: int | None = None
        self._turns = 0
        self._scans = 0

    @property
    def offset(self) -> float | None:
        """Robot's clock minus the sensor's [s]; None before the first scan."""
        return self._clock.offset if self._apart is None else self._apart

    def plausible(self, counter: int) -> bool:
        """Return whether `counter` [ms] may follow the last one."""
        return self._last is None or 0 < (counter - self._last) % COUNTER_WRAP_MS < JUMP_MS

    def stamp(self, counter: int, received: float) -> float:
        """The time [s] of a scan's step 0 on the robot's clock."""
        if self._last is None and self._apart is not None:
            self._turns = round((received - self._apart - counter * 1e-3) / (COUNTER_WRAP_MS * 1e-3))
        elif self._last is not None and counter < self._last:
            self._turns += 1
        self._last = counter
        device = (self._turns * COUNTER_WRAP_MS + counter) * 1e-3
        stamp = self._clock.stamp(device, received)
        self._scans += 1
        if self._apart is None:
            return stamp - self._late
        if self._scans <= SETTLING_SCANS:
            self._late = stamp - device - self._apart
            return device + self._apart
        return stamp - self._late


class ScipLaser(Device):
    """A Hokuyo laser on a serial port or on Ethernet."""

    def __init__(self, address: LinkAddress) -> None:
        self.rejected = 0  # replies that the sensor did not send like this
        self._address = address
        self._skip = address.whole("skip", 0, 0, 9)
        self._cluster = address.whole("cluster", 1, 1, 99)
        self._baud = address.whole("baud", 0, 0, 4_000_000)
        self._link: ByteLink = NoLink()
        self._buffer = bytearray()
        self._received: deque[list[bytes]] = deque()
        self._parameters: ScipParameters | None = None
        self._clock: SensorTime | None = None  # of the present stream

    def open(self) -> Equipment:
        """Make the sensor wait for commands, whatever it is doing, and read its geometry."""
        for baud in self._bauds():
            self._connect(baud)
            if self._ready():
                break
            self._link.close()
        else:
            raise Unavailable(
                f"At {self._address.name} no laser answers SCIP 2.0; is it switched on, and is this its port?"
            )
        if self._address.port_path and self._baud:
            self._change_baud(self._baud)
        parameters = self._parameters = self._ask_parameters()
        return Equipment(name=parameters.model, lasers=(laser_of(parameters, self._skip, self._cluster),))

    def run(self, readings: Readings) -> None:
        """Start the stream and hand on its scans."""
        parameters = self._parameters
        if parameters is None:
            return
        laser = laser_of(parameters, self._skip, self._cluster)
        late = (parameters.last / parameters.steps_per_turn) * 60 / parameters.rpm
        clock = self._clock = SensorTime(self._ask_time(readings), late)
        command = f"MD{parameters.first:04}{parameters.last:04}{self._cluster:02}{self._skip}00".encode()
        self._link.write(command + b"\n")
        patience = max(LOST_AFTER_S, 16 * (self._skip + 1) * 60 / parameters.rpm)
        good = time.monotonic()
        while time.monotonic() - good < patience:
            for lines in self._replies(readings, patience / 8):
                try:
                    scan = self._scan(lines, command, laser, clock, readings)
                except BadReply:
                    self.rejected += 1
                    readings.arrived("the laser", unreadable=1)
                    continue
                readings.arrived("the laser", readable=1)
                good = time.monotonic()
                if scan is not None:
                    readings.scan(scan)
        raise OSError("no scans come")

    def findings(self) -> Findings:
        """The laser's clock."""
        offset = self._clock.offset if self._clock else None
        return Findings(clocks=() if offset is None else (ClockOffset(clock="laser", offset_s=round(offset, 4)),))

    def close(self) -> None:
        """Switch the laser off and let go."""
        with contextlib.suppress(OSError):
            self._link.write(b"QT\n")
        self._link.close()

    def _bauds(self) -> tuple[int, ...]:
        if not self._address.port_path:
            return (0,)
        return tuple(dict.fromkeys((self._baud, *BAUD_RATES))) if self._baud else BAUD_RATES

    def _connect(self, baud: int) -> None:
        self._link.close()
        self._link = open_link(self._address, baud)
        self._forget()

    def _forget(self) -> None:
        self._buffer.clear()
        self._received.clear()

    def _ready(self) -> bool:
        """End whatever the sensor is doing → whether it waits for commands now."""
        silent = 0
        for _ in range(MAX_TRIES):
            lines = self._answer(b"QT")
            try:
                status = status_of(lines, b"QT") if lines else b""
            except BadReply:
                status = b"?"
            if status == b"00":
                return True
            silent += not lines and not self._buffer
            if silent == SILENT_TRIES:
                return False
            self._recover(lines, status)
        return False

    def _recover(self, lines: Sequence[bytes], status: bytes) -> None:
        if status == b"0E":
            self._link.write(b"TM2\n")
        elif len(lines) > 1 and lines[1].startswith(b"E"):
            self._link.write(b"SCIP2.0\n")
        drain(self._link, DRAIN_QUIET_S, MAX_DRAIN_S)
        self._forget()

    def _answer(self, command: bytes, patience: float = ANSWER_TIMEOUT_S) -> list[bytes]:
        self._forget()
        self._link.write(command + b"\n")
        end = time.monotonic() + patience
        while (left := end - time.monotonic()) > 0:
            self._read(left)
            if self._received:
                return self._received.popleft()
        return []

    def _ask_parameters(self) -> ScipParameters:
        for _ in range(MAX_TRIES):
            try:
                return parse_parameters(self._answer(b"PP", 4 * ANSWER_TIMEOUT_S))
            except BadReply:
                self.rejected += 1
        raise Unavailable(f"The laser at {self._address.name} does not say what it is; switch it off and on.")

    def _change_baud(self, baud: int) -> None:
        """Make a unit on RS-232 faster; others do not mind."""
        lines = self._answer(f"SS{baud:06}".encode())
        if len(lines) > 1 and lines[1][:2] in (b"00", b"03", b"04"):
            self._connect(baud)
            if not self._ready():
                raise Unavailable(f"The laser at {self._address.name} does not answer at {baud} bit/s.")

    def _ask_time(self, readings: Readings) -> float | None:
        """The robot's clock minus the sensor's [s], by the quickest of some questions; None: it does not say."""
        best: tuple[float, float] | None = None  # how long it took, difference
        self._answer(b"TM0")
        for _ in range(CLOCK_ROUNDS):
            asked = readings.now()
            lines = self._answer(b"TM1")
            answered = readings.now()
            with contextlib.suppress(BadReply):
                if status_of(lines, b"TM1") == b"00" and len(lines) > 2 and len(lines[2]) == 5:
                    sensor = int(decode(checked(lines[2]), 4)[0]) * 1e-3
                    found = (answered - asked, (asked + answered) / 2 - sensor)
                    best = found if best is None else min(best, found)
        self._answer(b"TM2")
        if not self._ready():
            raise OSError("the laser does not leave its time mode")
        return best[1] if best else None

    def _read(self, timeout: float) -> None:
        self._buffer += self._link.read(timeout)
        *replies, rest = bytes(self._buffer).split(b"\n\n")
        self._buffer = bytearray(rest if len(rest) < LARGEST_REPLY else b"")
        for reply in replies:
            lines = reply.strip(b"\n").split(b"\n")
            if lines != [b""]:
                self._received.append(lines)

    def _replies(self, readings: Readings, timeout: float) -> list[list[bytes]]:
        self._read(timeout)
        replies = list(self._received)
        self._received.clear()
        return replies

    def _scan(
        self, lines: list[bytes], command: bytes, laser: Laser, clock: SensorTime, readings: Readings
    ) -> Scan | None:
        """A reply of the stream → its scan; None: it carries none. Raises BadReply, and OSError at the end."""
        received = readings.now()
        status = status_of(lines, command)
        if status == b"00" and len(lines) == 2:
            return None
        if status != b"99":
            return self._no_scan(status, readings)
        counter, ranges = parse_scan(lines[2:], laser.beams)
        if not clock.plausible(counter) or self._parameters is None:
            raise BadReply("a time that cannot be")
        stamp = clock.stamp(counter, received)
        return Scan(
            stamp=stamp + self._parameters.first * laser.time_step / self._cluster,
            ranges=in_metres(ranges, self._parameters),
            angle_min=laser.angle_min,
            angle_step=laser.angle_step,
            range_min=laser.range_min,
            range_max=laser.range_max,
            time_step=laser.time_step,
        )

    def _no_scan(self, status: bytes, readings: Readings) -> None:
        code = status.decode("ascii", "replace")
        if code.isdigit() and 50 <= int(code) <= 97:
            readings.note(f"The laser reports a fault of its hardware (status {code}); it is started again.")
        if not (code.isdigit() and (21 <= int(code) <= 49 or code == "98")):
            raise OSError(f"the stream ended with status {code}")


def open_device(rest: str) -> ScipLaser:
    """`scip:<rest>` → the laser. Raises BadInput."""
    return ScipLaser(link_address(rest, EXAMPLE, ("skip", "cluster", "baud"), tcp_port=TCP_PORT))
