"""A differential drive that speaks Beckon's line protocol, on a pseudo-terminal or a TCP port."""

import argparse
import contextlib
import math
import time
from pathlib import Path

from core.geometry import Pose
from core.sensors import Wheels
from tests.emulators.by_hand import serve
from tests.emulators.wires import Port, SerialPort, TcpPort, Wire
from tests.emulators.world import World

WHEELBASE = 0.16  # [m]
DESCRIPTION = f"I name=test_rover wheelbase={WHEELBASE} radius=0.09 max_speed=0.3 max_turn_rate=1.5 failsafe=0.5"
TABLE = [0] * 256
for _byte in range(256):
    _crc = _byte
    for _ in range(8):
        _crc = ((_crc << 1) ^ (0x107 if _crc & 0x80 else 0)) & 0xFF
    TABLE[_byte] = _crc


def line_of(text: str) -> bytes:
    """Text with its sum, by a table instead of bit by bit as the driver does it."""
    crc = 0
    for byte in text.encode():
        crc = TABLE[crc ^ byte]
    return f"{text}*{crc:02X}\n".encode()


class SerialRobot:
    """The firmware: what it hears moves the world, what the world's wheels do it sends."""

    def __init__(self, world: World, *, path: Path | None = None, port: int = 0, rate: int = 0) -> None:
        self.heard: list[tuple[float, float, float]] = []  # time.monotonic(), v, w of every V line
        self.refused = 0  # lines with a wrong sum
        self.silent = False  # it sends no odometry
        self._world = world
        self._left = self._right = 0.0
        self._last: Pose | None = None
        self._milliseconds = 0
        self._left_out = 0.0  # [s] of the world's, that its clock has shown
        self._contact = False
        world.on_wheels.append(self._roll)
        world.on_contact.append(self._touch)
        self._port: Port = (
            TcpPort(self._serve, port=port, rate=rate) if path is None else SerialPort(self._serve, path, rate=rate)
        )

    @property
    def url(self) -> str:
        return f"serial:{self._port.url}"

    @property
    def port(self) -> Port:
        return self._port

    def start(self) -> None:
        """Switch on: it counts from zero."""
        self._left = self._right = 0.0
        self._last, self._milliseconds, self._left_out = None, 0, self._world.left_out
        self._port.start()

    def stop(self) -> None:
        self._port.stop()

    def inject(self, data: bytes) -> bool:
        """Send bytes as they are → whether a driver was there."""
        return self._port.inject(data)

    def send(self, text: str) -> None:
        wire = self._port.wire
        if wire is not None:
            with contextlib.suppress(OSError):
                wire.write(line_of(text))

    def _roll(self, wheels: Wheels) -> None:
        if self._last is not None:
            move = self._last.inverse() @ wheels.odometry
            half = move.heading / 2
            forward = math.hypot(move.x, move.y) * (half / math.sin(half) if abs(half) > 1e-9 else 1.0)
            forward = math.copysign(forward, move.x)
            self._left += forward - move.heading * WHEELBASE / 2
            self._right += forward + move.heading * WHEELBASE / 2
        self._last = wheels.odometry
        self._milliseconds += 25 + round(1e3 * (self._world.left_out - self._left_out))  # no clock is held up
        self._left_out = self._world.left_out
        if not self.silent:
            self.send(f"O {self._milliseconds} {self._left:.4f} {self._right:.4f}")

    def _touch(self, pressed: bool) -> None:
        if pressed != self._contact:
            self._contact = pressed
            self.send(f"B {pressed:d}")

    def _serve(self, wire: Wire) -> None:
        waiting = b""
        while True:
            waiting = (waiting + wire.read(1.0))[-4096:]
            *lines, waiting = waiting.split(b"\n")
            for line in lines:
                self._obey(line)

    def _obey(self, line: bytes) -> None:
        text = line.partition(b"*")[0].decode("ascii", "replace")
        if line_of(text).rstrip(b"\n") != line:
            self.refused += 1
            return
        words = text.split()
        if words == ["?"]:
            self.send(DESCRIPTION)
            self.send("P 0.87")
        elif len(words) == 3 and words[0] == "V":
            v, w = float(words[1]), float(words[2])
            self.heard.append((time.monotonic(), v, w))
            self._world.drive(v, w)


def main() -> None:
    """Serve `sim:lab` by hand."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--path", type=Path, help="name of a pseudo-terminal instead of TCP")
    parser.add_argument("--port", type=int, default=2000)
    given = parser.parse_args()
    world = World()
    serve(SerialRobot(world, path=given.path, port=given.port), world)


if __name__ == "__main__":
    main()
