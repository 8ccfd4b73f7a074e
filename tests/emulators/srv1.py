"""An SRV-1 Blackfin behind its Wi-Fi bridge, on a TCP port."""

import argparse
import struct
import time

import cv2
import numpy as np

from core.sensors import Image, Wheels
from tests.emulators.by_hand import serve
from tests.emulators.wires import Port, TcpPort, Wire
from tests.emulators.world import World

FULL, WHEELBASE = 0.4, 0.10  # [m/s] of a side at 100 percent, [m]
HEIGHT = 240
ARGUMENTS = {b"M": 3, b"F": 2}  # bytes behind a command
FAILSAFE = 2.0  # [s]


class Srv1Emulator:
    """The firmware: one command at a time, without framing; what comes meanwhile is thrown away."""

    def __init__(self, world: World, *, port: int = 0, rate: int = 0) -> None:
        """`world` should have no failsafe of its own. `rate` [bit/s] of the serial line behind the bridge; 0: any."""
        self.heard: list[tuple[float, int, int]] = []  # time.monotonic(), left, right of every M
        self.motors = (0, 0)  # percent
        self.failsafe: tuple[int, int] | None = None
        self.half_heard = b""  # of a command, from a connection before
        self.busy = 0  # pictures that will not come
        self.cut_short = 0  # pictures that will end half-way
        self.pictures = 0
        self._world = world
        self._last_command = time.monotonic()
        self._within = False
        self._jpeg = jpeg_of(np.full((256, 320, 3), 90, np.uint8))
        world.on_image.append(self._see)
        world.on_wheels.append(self._watch)
        self._port: Port = TcpPort(self._serve, port=port, rate=rate)

    @property
    def url(self) -> str:
        return f"srv1:{self._port.url}"

    @property
    def port(self) -> Port:
        return self._port

    def start(self) -> None:
        self.failsafe = None
        self._turn(0, 0)
        self._port.start()

    def stop(self) -> None:
        self._port.stop()

    def inject(self, data: bytes) -> bool:
        """Send bytes as they are → whether a driver was there."""
        return self._port.inject(data)

    def _see(self, image: Image) -> None:
        self._jpeg = jpeg_of(image.pixels)

    def _watch(self, _: Wheels) -> None:
        """The failsafe, which waits while a command is half received."""
        if self.failsafe and not self._within and time.monotonic() - self._last_command > FAILSAFE:
            self._turn(*self.failsafe)

    def _turn(self, left: int, right: int) -> None:
        """Set both sides; what is asked to be 0 becomes 1 percent, which does not move them."""
        left, right = (max(-100, min(100, side)) or 1 for side in (left, right))
        self.motors = (left, right)
        moving = [FULL * side / 100 if abs(side) > 1 else 0.0 for side in (left, right)]
        self._world.drive(sum(moving) / 2, (moving[1] - moving[0]) / WHEELBASE)

    def _serve(self, wire: Wire) -> None:
        received, self.half_heard = self.half_heard, b""
        while True:
            try:
                while len(received) < 1 + ARGUMENTS.get(received[:1], 0):
                    self._within = bool(received)
                    received += wire.read(1.0)
            except OSError:
                self.half_heard = received
                raise
            command = received[: 1 + ARGUMENTS.get(received[:1], 0)]
            answer = self._obey(command)
            self._last_command, self._within = time.monotonic(), False
            wire.write(answer[:-1])
            wire.read(
                0.0
            )  # what came meanwhile is thrown away, before the driver can know that the answer is complete
            wire.write(answer[-1:])
            received = b""

    def _obey(self, command: bytes) -> bytes:
        letter = command[:1]
        if letter == b"M":
            left, right, _ = struct.unpack("<bbB", command[1:])
            self.heard.append((time.monotonic(), left, right))
            self._turn(left, right)
        elif letter == b"F":
            self.failsafe = struct.unpack("<bb", command[1:])
        elif letter == b"I":
            return self._picture()
        elif letter == b"V":
            return b"##Version - emulated SRV-1 Blackfin\r\n"
        elif letter != b"b":
            return b"#?"
        return b"#" + letter

    def _picture(self) -> bytes:
        if self.busy:
            self.busy -= 1
            return b""
        self.pictures += 1
        frame = b"##IMJ5" + struct.pack("<I", len(self._jpeg)) + self._jpeg
        if self.cut_short:
            self.cut_short -= 1
            return frame[: len(frame) // 2]
        return frame


def jpeg_of(pixels: np.ndarray) -> bytes:
    """(256, 320, 3) → the rows that the robot's camera has, as JPEG."""
    margin = (pixels.shape[0] - HEIGHT) // 2
    return cv2.imencode(".jpg", pixels[margin : margin + HEIGHT], [cv2.IMWRITE_JPEG_QUALITY, 75])[1].tobytes()


def main() -> None:
    """Serve `sim:lab` by hand."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--port", type=int, default=10001)
    parser.add_argument(
        "--rate", type=int, default=921_600, help="bit/s of the serial line behind the bridge; 0: any"
    )
    given = parser.parse_args()
    world = World(failsafe=None)
    serve(Srv1Emulator(world, port=given.port, rate=given.rate), world)


if __name__ == "__main__":
    main()
