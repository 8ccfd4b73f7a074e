"""A toy robot on TCP: the emulator, and in the same file its driver, `py:tests/emulators/toy_robot.py:HOST:PORT`.

Lines of text. To the robot: `V v w`, speeds [m/s], [rad/s] that hold until the next line; there is no failsafe. From
the robot: `O x y heading v w` fifty times a second, `L range range …` ten times a second.
"""

import contextlib
import math
import select
import socket
import threading
import time

import numpy as np

from core.robots.driver import ZERO, Base, Device, Equipment, Laser, Pose, Readings, Scan, Twist, arc

PERIOD = 0.02  # [s] between readings of the wheels
LASER = Laser(name="front", beams=36, angle_min=-math.pi, angle_step=math.radians(10), rate=10.0)
LONGEST = 4096  # bytes of a line


class ToyRobot:
    """The emulator. It goes on with the speeds of the last line, also while nobody is connected."""

    def __init__(self, port: int = 0) -> None:
        self.heard: list[tuple[float, float, float]] = []  # time.monotonic(), v, w of every line
        self._port = port
        self._twist, self._place = ZERO, Pose()
        self._over = threading.Event()
        self._garbage = b""
        self._thread: threading.Thread | None = None

    @property
    def url(self) -> str:
        return f"py:{__file__}:127.0.0.1:{self._port}"

    @property
    def connected(self) -> bool:
        return self._connected.is_set()

    def start(self) -> None:
        self._over.clear()
        self._connected = threading.Event()
        self._twist = ZERO
        server = socket.create_server(("127.0.0.1", self._port))
        self._port = server.getsockname()[1]
        self._thread = threading.Thread(target=self._run, args=(server,), name="toy-robot", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Be gone, as a robot that was switched off."""
        self._over.set()
        if self._thread is not None:
            self._thread.join(5.0)

    def inject(self, data: bytes) -> bool:
        """Send bytes as they are → whether a driver is there."""
        self._garbage += data
        return self.connected

    def _run(self, server: socket.socket) -> None:
        with server:
            while not self._over.is_set():
                if select.select([server], [], [], PERIOD)[0]:
                    connection, _ = server.accept()
                    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                    with connection, contextlib.suppress(OSError):
                        self._connected.set()
                        self._serve(connection)
                    self._connected.clear()

    def _serve(self, connection: socket.socket) -> None:
        waiting, due, count = b"", time.monotonic(), 0
        while not self._over.is_set():
            if select.select([connection], [], [], max(0.0, due - time.monotonic()))[0]:
                data = connection.recv(4096)
                if not data:
                    return
                *lines, waiting = (waiting + data).split(b"\n")
                for line in lines:
                    self._obey(line)
            if time.monotonic() >= due:
                due += PERIOD
                count += 1
                garbage, self._garbage = self._garbage, b""
                connection.sendall(garbage + self._report(with_scan=count % 5 == 0))

    def _obey(self, line: bytes) -> None:
        _, v, w = line.split()
        self._twist = Twist(float(v), float(w))
        self.heard.append((time.monotonic(), self._twist.v, self._twist.w))

    def _report(self, *, with_scan: bool) -> bytes:
        here = self._place = self._place @ arc(self._twist.v * PERIOD, self._twist.w * PERIOD)
        text = f"O {here.x} {here.y} {here.heading} {self._twist.v} {self._twist.w}\n"
        if with_scan:
            text += "L " + " ".join(["2.0"] * LASER.beams) + "\n"
        return text.encode()


class ToyDriver(Device):
    def __init__(self, arguments: str = "") -> None:
        host, _, port = arguments.rpartition(":")
        self._address = host, int(port)
        self._link: socket.socket | None = None

    def open(self) -> Equipment:
        self._link = socket.create_connection(self._address, timeout=2.0)
        self._link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return Equipment(name="Toy", base=Base(wheelbase=0.16, max_speed=0.3), lasers=(LASER,))

    def run(self, readings: Readings) -> None:
        link, waiting = self._link, b""
        while link is not None and (data := link.recv(4096)):
            *lines, waiting = (waiting + data)[-LONGEST:].split(b"\n")
            for line in lines:
                with contextlib.suppress(ValueError):
                    self._take(line, readings)

    def drive(self, twist: Twist) -> None:
        if self._link is not None:
            self._link.sendall(f"V {twist.v} {twist.w}\n".encode())

    def close(self) -> None:
        if self._link is not None:
            with contextlib.suppress(OSError):
                self._link.shutdown(socket.SHUT_RDWR)
            self._link.close()

    def _take(self, line: bytes, readings: Readings) -> None:
        kind, *words = line.split(b" ")
        numbers = [float(word) for word in words]
        if kind == b"O" and len(numbers) == 5:
            readings.wheels(Pose(*numbers[:3]), *numbers[3:])
        if kind == b"L" and len(numbers) == LASER.beams:
            scan = Scan(
                stamp=readings.now(), ranges=np.array(numbers), angle_min=LASER.angle_min, angle_step=LASER.angle_step
            )
            readings.scan(scan)
