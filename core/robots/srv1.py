"""An SRV-1 Blackfin over its Wi-Fi bridge: `srv1://192.168.0.15:10001`.

Options: `left`, `right` [m/s] of each side at 100 percent, `wheelbase` [m], `camera=0` without pictures, `pictures`
[1/s] at most.

The firmware knows no framing: one command, its answer, then the next. So a stop waits for the picture that is on its
way. The robot has no odometry. Sources: SRV_protocol of 24 April 2010 and the behaviour of the firmware of that time.
"""

import contextlib
import math
import struct
import threading
import time
from dataclasses import replace

import cv2
import numpy as np

from core.errors import Unavailable
from core.gate.twist import Twist
from core.message import Array
from core.optics import TABLE_3
from core.robots.byte_link import ByteLink, LinkAddress, NoLink, TcpLink, drain, link_address
from core.robots.device import Base, Device, Equipment
from core.robots.readings import Readings
from core.sensors import Camera, Image

EXAMPLE = "srv1://192.168.0.15:10001"
TCP_PORT = 10001
WIDTH_PX, HEIGHT_PX = 320, 240  # pixels: larger pictures keep a stop waiting for longer
NOMINAL = replace(TABLE_3, width=WIDTH_PX, height=HEIGHT_PX, cy=TABLE_3.cy - (TABLE_3.height - HEIGHT_PX) / 2)
OPENING_TIMEOUT_S = 6.0  # for the boot text and the first answers
ANSWER_TIMEOUT_S = 0.5  # until a short answer
FIRST_BYTE_TIMEOUT_S, NEXT_BYTE_TIMEOUT_S = 0.3, 0.5  # without the first, and without any other byte of a picture
PICTURE_TIMEOUT_S = 3.0  # for a whole picture
REPEAT_PERIOD_S = 0.2  # after which the same speeds are sent again
DEADMAN_S = 0.4  # without `drive` after which the motors are stopped
IDLE_WAIT_S = 0.05
CLOSE_TIMEOUT_S = 0.7  # at most that closing waits for the last command; then the firmware's failsafe has to do it
FAILSAFE_S = 2.0  # [s], the firmware's own
LARGEST_PICTURE = 2_000_000  # bytes
RESYNC_TIMEOUTS_S = (0.1, 0.2, 0.3, 0.4)  # that an answer may take, try by try
MAX_ARGUMENT_BYTES = 3  # bytes behind a command, at most
HEADER_BYTES = 10  # bytes before a picture: `##IMJ`, size, length
STOPPED_PERCENTS = (0, 0)
MIN_MOTOR_PERCENT = 2  # percent below which the motors do not turn
PULSE_S = 0.1  # over which pulses make up for a speed that is slower


class LostStep(OSError):
    """The answer was not the one expected; the robot may be within another command."""


def motor_percents(twist: Twist, wheelbase: float, left: float, right: float) -> tuple[float, float]:
    """Speeds → percent of each side, both lowered alike where one would need more than 100.

    `wheelbase` [m], `left`, `right` [m/s] at 100 percent.
    """
    if not twist.is_finite():
        return STOPPED_PERCENTS
    sides = ((twist.v - twist.w * wheelbase / 2) / left, (twist.v + twist.w * wheelbase / 2) / right)
    scale = 100 / max(1.0, *map(abs, sides))
    return sides[0] * scale, sides[1] * scale


class MotorSide:
    """One side's whole percents. What is slower than the motors turn comes in pulses that are as fast on average."""

    def __init__(self) -> None:
        self._sent, self._at = 0, 0.0
        self._owed = 0.0  # [percent·s] that it rolled less than it was asked for

    def next(self, wanted: float, now: float) -> int:
        """The percent to send at `now` [s]."""
        elapsed = min(now - self._at, PULSE_S)
        self._at = now
        if wanted == 0 or abs(wanted) >= 2 * MIN_MOTOR_PERCENT:
            self._owed, self._sent = 0.0, round(wanted)
            return self._sent
        most = MIN_MOTOR_PERCENT * PULSE_S
        self._owed = max(-most, min(most, self._owed + (wanted - self._sent) * elapsed))
        due = wanted + self._owed / PULSE_S
        if abs(due) >= MIN_MOTOR_PERCENT:
            self._sent = round(due)
        else:
            self._sent = int(math.copysign(MIN_MOTOR_PERCENT, due)) if abs(due) > MIN_MOTOR_PERCENT / 2 else 0
        return self._sent


def motor_command(percents: tuple[int, int]) -> bytes:
    """`M` with the speeds until the next one."""
    return struct.pack("<cbbB", b"M", *percents, 0)


def decode_picture(jpeg: bytes) -> Array | None:
    """JPEG → (HEIGHT, WIDTH, 3) uint8; None where it is none, or of another size."""
    if not (jpeg.startswith(b"\xff\xd8") and jpeg.rstrip(b"\0").endswith(b"\xff\xd9")):
        return None
    with contextlib.suppress(cv2.error):
        pixels = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
        if pixels is not None and pixels.shape == (HEIGHT_PX, WIDTH_PX, 3):
            return pixels
    return None


class Srv1(Device):
    """The robot: motors and camera over one connection, of which the device's thread is the only user."""

    def __init__(self, address: LinkAddress) -> None:
        self.rejected = 0  # answers that could not be used
        self._address = address
        self._left = address.number("left", 0.4, 0.01, 5.0)
        self._right = address.number("right", 0.4, 0.01, 5.0)
        self._wheelbase = address.number("wheelbase", 0.10, 0.02, 2.0)
        self._rate = address.number("pictures", 10.0, 0.1, 40.0) if address.whole("camera", 1, 0, 1) else 0.0
        self._link: ByteLink = NoLink()
        self._buffer = b""
        self._changed, self._closing = threading.Event(), threading.Event()
        self._idle = threading.Event()  # `run` is over, and the motors were stopped as far as that was possible
        self._idle.set()
        self._wanted: tuple[float, float] = STOPPED_PERCENTS
        self._wanted_at = 0.0

    def open(self) -> Equipment:
        """Connect, find the firmware's place between two commands, stop, and switch its failsafe on."""
        self._wanted, self._buffer = STOPPED_PERCENTS, b""
        self._closing.clear()
        self._link = TcpLink(self._address.host, self._address.port)
        end = time.monotonic() + OPENING_TIMEOUT_S
        while True:
            try:
                self._resynchronise()
                self._exchange(b"F\0\0", b"#F", ANSWER_TIMEOUT_S)
                self._exchange(b"b", b"#b", ANSWER_TIMEOUT_S)
                break
            except LostStep:
                if time.monotonic() > end:
                    raise Unavailable(
                        f"At {self._address.name} no SRV-1 answers; is it switched on, and nobody else connected?"
                    ) from None
        slower = min(self._left, self._right)
        base = Base(
            wheelbase=self._wheelbase,
            cruise=min(0.1, slower),
            max_speed=slower,
            max_turn_rate=min(2 * slower / self._wheelbase, 3.0),
            failsafe=FAILSAFE_S,
            failsafe_words="2 s, but any byte counts; a stop waits for the picture under way, 3 s at worst",
            odometry=False,
        )
        camera = Camera(model=NOMINAL, rate=self._rate, optics_known=False, mounting_known=False)
        return Equipment(name="SRV-1 Blackfin", base=base, cameras=(camera,) if self._rate else ())

    def run(self, readings: Readings) -> None:
        """Motors first, then a picture, and again."""
        self._idle.clear()
        try:
            self._work(readings)
            self._exchange(motor_command(STOPPED_PERCENTS), b"#M", ANSWER_TIMEOUT_S)
        finally:
            self._idle.set()

    def _work(self, readings: Readings) -> None:
        """Talk to the robot until the device is closed."""
        sent, sent_at, asked = STOPPED_PERCENTS, 0.0, 0.0
        left, right = MotorSide(), MotorSide()
        while not self._closing.is_set():
            self._changed.clear()
            now = time.monotonic()
            wanted = self._wanted if now - self._wanted_at < DEADMAN_S else STOPPED_PERCENTS
            percents = left.next(wanted[0], now), right.next(wanted[1], now)
            try:
                if percents != sent or now - sent_at > REPEAT_PERIOD_S:
                    self._exchange(motor_command(percents), b"#M", ANSWER_TIMEOUT_S)
                    sent, sent_at = percents, now
                elif self._rate and now - asked >= 1 / self._rate:
                    asked = now
                    self._take_picture(readings)
                else:
                    self._changed.wait(IDLE_WAIT_S)
            except LostStep:
                self.rejected += 1
                self._resynchronise()
                sent = STOPPED_PERCENTS

    def drive(self, twist: Twist) -> None:
        """Set speeds for the device's thread to send."""
        self._wanted = motor_percents(twist, self._wheelbase, self._left, self._right)
        self._wanted_at = time.monotonic()
        self._changed.set()

    def close(self) -> None:
        """Stop, after the picture under way, and let go."""
        self._closing.set()
        self._changed.set()
        self._idle.wait(CLOSE_TIMEOUT_S)
        self._link.close()

    def _fill(self, count: int, stalled: float, end: float) -> None:
        """Read until `count` bytes are there. Raises LostStep after `stalled` [s] of silence, or at `end`."""
        while len(self._buffer) < count:
            left = min(stalled, end - time.monotonic())
            more = self._link.read(left) if left > 0 else b""
            if not more:
                raise LostStep("the robot did not answer")
            self._buffer += more

    def _exchange(self, command: bytes, answer: bytes, timeout: float) -> None:
        """One command of fixed answer. Raises LostStep."""
        self._link.write(command)
        self._fill(len(answer), timeout, time.monotonic() + timeout)
        found, self._buffer = self._buffer, b""
        if found != answer:
            raise LostStep("another answer")

    def _take_picture(self, readings: Readings) -> None:
        """Ask for a picture and wait for all of it; a busy camera may send none. Raises LostStep."""
        stamp, end = readings.now(), time.monotonic() + PICTURE_TIMEOUT_S
        self._link.write(b"I")
        try:
            self._fill(1, FIRST_BYTE_TIMEOUT_S, end)
        except LostStep:
            self.rejected += 1
            return
        self._fill(HEADER_BYTES, NEXT_BYTE_TIMEOUT_S, end)
        length = int.from_bytes(self._buffer[6:HEADER_BYTES], "little")
        if not self._buffer.startswith(b"##IMJ") or not 0 < length <= LARGEST_PICTURE:
            raise LostStep("no picture")
        self._fill(HEADER_BYTES + length, NEXT_BYTE_TIMEOUT_S, end)
        jpeg, extra = self._buffer[HEADER_BYTES : HEADER_BYTES + length], self._buffer[HEADER_BYTES + length :]
        self._buffer = b""
        pixels = decode_picture(jpeg)
        if extra or pixels is None:
            raise LostStep("no picture")
        readings.image(Image(stamp=stamp, pixels=pixels, packed=bytes(jpeg)))

    def _resynchronise(self) -> None:
        """Bring the firmware to where it waits for a command, with the motors stopped. Raises LostStep.

        Zeros are no commands (`#?`), or the arguments that a command under way still waits for. It is stopped twice:
        the first answer may be to a command that waited in a robot which was frozen.
        """
        for patience in RESYNC_TIMEOUTS_S:
            self._link.write(bytes(MAX_ARGUMENT_BYTES))
            if self._link.read(patience):
                drain(self._link, patience / 2, PICTURE_TIMEOUT_S)
            self._buffer = b""
            with contextlib.suppress(LostStep):
                for _ in range(2):
                    self._exchange(motor_command(STOPPED_PERCENTS), b"#M", patience)
                    drain(self._link, patience / 2, PICTURE_TIMEOUT_S)
                return
            self._buffer = b""
        raise LostStep("the robot does not stop")


def open_device(rest: str) -> Srv1:
    """`srv1:<rest>` → the robot. Raises BadInput."""
    keys = ("left", "right", "wheelbase", "camera", "pictures")
    return Srv1(link_address(rest, EXAMPLE, keys, tcp_port=TCP_PORT, serial=False))
