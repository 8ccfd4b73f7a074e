"""A Hokuyo URG-04LX-UG01 that speaks SCIP 2.0, on a pseudo-terminal or a TCP port."""

import argparse
import math
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from core.message import Array
from core.sensors import Scan
from tests.emulators.by_hand import serve
from tests.emulators.wires import Port, SerialPort, TcpPort, Wire
from tests.emulators.world import World

FIRST, LAST, FRONT, STEPS, LONGEST_MM = 44, 725, 384, 1024, 5600
PERIOD = 0.1  # [s]


def with_sum(line: bytes) -> bytes:
    return line + bytes([(sum(line) & 0x3F) + 0x30]) + b"\n"


def encode(values: Array, width: int) -> bytes:
    """Whole numbers → 6 bits a character, most significant first."""
    digits = (np.asarray(values, np.int64)[:, None] >> (6 * np.arange(width - 1, -1, -1))) & 0x3F
    return (digits + 0x30).astype(np.uint8).tobytes()


class ScipEmulator:
    """The sensor. `show` gives it a turn of its mirror."""

    def __init__(
        self,
        *,
        path: Path | None = None,
        port: int = 0,
        rate: int = 0,
        last: int = LAST,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """`path`: a pseudo-terminal of that name instead of TCP. `rate` [bit/s] of the line. `clock` [s]: its own."""
        self.old = False  # it speaks SCIP 1.1 until it hears SCIP2.0
        self.streaming: tuple[bytes, int, int, int] | None = None  # command, first, last, cluster
        self.in_time_mode = False
        self.half_heard = b""  # of a command, before the driver's first byte
        self.sent: list[tuple[float, Array]] = []  # what went out: time of step 0 by time.monotonic(), [mm]
        self._skip = self._left_out = 0
        self._last, self._clock = last, clock
        self._port: Port = (
            TcpPort(self._serve, port=port, rate=rate) if path is None else SerialPort(self._serve, path, rate=rate)
        )

    @property
    def url(self) -> str:
        return f"scip:{self._port.url}"

    @property
    def port(self) -> Port:
        return self._port

    def start(self) -> None:
        self.streaming, self.in_time_mode = None, False
        self._port.start()

    def stop(self) -> None:
        self._port.stop()

    def inject(self, data: bytes) -> bool:
        """Send bytes as they are → whether a driver was there."""
        return self._port.inject(data)

    def show_scan(self, scan: Scan, instant: float | None = None) -> None:
        """What the simulated laser measured in one turn; `instant`: time.monotonic() of its first beam."""
        steps = np.arange(FIRST, self._last + 1) - FRONT
        beams = np.round((steps * math.tau / STEPS - scan.angle_min) / scan.angle_step).astype(int)
        there = (beams >= 0) & (beams < len(scan.ranges))
        ranges = scan.ranges[np.where(there, beams, 0)]
        begin = None if instant is None else instant - PERIOD * FIRST / STEPS
        self.show(np.where(there & np.isfinite(ranges), np.nan_to_num(ranges, posinf=0.0) * 1e3, 0.0).round(), begin)

    def show(self, millimetres: Array, begin: float | None = None) -> None:
        """One turn: (beams,) [mm] from FIRST on; `begin`: time.monotonic() of step 0, else it has just ended."""
        if self.streaming is None or self._port.wire is None:
            return
        if self._left_out < self._skip:
            self._left_out += 1
            return
        self._left_out = 0
        command, first, last, cluster = self.streaming
        late = time.monotonic() - begin if begin is not None else PERIOD * self._last / STEPS
        try:
            self._port.wire.write(self.reply(command, first, last, cluster, millimetres, late))
        except OSError:
            self.streaming = None
            return
        self.sent.append((time.monotonic() - late, np.asarray(millimetres)))

    def reply(
        self,
        command: bytes,
        first: int,
        last: int,
        cluster: int,
        millimetres: Array,
        late: float = PERIOD * LAST / STEPS,
    ) -> bytes:
        """A scan of the stream, `late` [s] after its step 0."""
        chosen = np.asarray(millimetres, np.int64)[first - FIRST : last - FIRST + 1]
        pad = -len(chosen) % cluster
        groups = np.pad(chosen, (0, pad), constant_values=1 << 17).reshape(-1, cluster)
        counter = int((self._clock() - late) * 1e3) & 0xFFFFFF
        data = encode(groups.min(axis=1), 3)
        lines = [data[begin : begin + 64] for begin in range(0, len(data), 64)]
        head = command + b"\n" + with_sum(b"99") + with_sum(encode(np.array([counter]), 4))
        return head + b"".join(map(with_sum, lines)) + b"\n"

    def _serve(self, wire: Wire) -> None:
        waiting, self.half_heard = self.half_heard, b""
        while True:
            waiting += wire.read(1.0)
            *lines, waiting = waiting.replace(b"\r", b"\n").split(b"\n")
            for line in lines:
                if line:
                    wire.write(self.answer(line))

    def answer(self, line: bytes) -> bytes:
        if self.old and line != b"SCIP2.0":
            return line + b"\nE\n\n"
        head, command = line + b"\n", line[:2]
        if line == b"SCIP2.0":
            ok, self.old = self.old, False
            return head + with_sum(b"00" if ok else b"0E") + b"\n"
        if self.in_time_mode and command != b"TM":
            return head + with_sum(b"0E") + b"\n"
        match command:
            case b"QT" if len(line) == 2:
                self.streaming = None
                return head + with_sum(b"00") + b"\n"
            case b"PP" if len(line) == 2:
                return head + with_sum(b"00") + self._parameters() + b"\n"
            case b"TM" if len(line) == 3:
                return head + self._time_mode(line[2:]) + b"\n"
            case b"MD" if len(line) == 15 and line[2:].isdigit():
                return head + with_sum(self._begin(line)) + b"\n"
            case b"SS":
                return head + with_sum(b"00") + b"\n"
            case _:
                return head + with_sum(b"0E") + b"\n"

    def _parameters(self) -> bytes:
        fields = ("MODL:URG-04LX-UG01(Simple-URG)", "DMIN:20", "DMAX:5600", "ARES:1024", f"AMIN:{FIRST}")
        fields = (*fields, f"AMAX:{self._last}", "AFRT:384", "SCAN:600")
        lines = (field.encode() for field in fields)
        return b"".join(line + b";" + bytes([(sum(line) & 0x3F) + 0x30]) + b"\n" for line in lines)

    def _time_mode(self, what: bytes) -> bytes:
        if what == b"1" and self.in_time_mode:
            counter = int(self._clock() * 1e3) & 0xFFFFFF
            return with_sum(b"00") + with_sum(encode(np.array([counter]), 4))
        if what in b"02":
            self.in_time_mode, self.streaming = what == b"0", None
            return with_sum(b"00")
        return with_sum(b"0E")

    def _begin(self, line: bytes) -> bytes:
        first, last, cluster, skip = int(line[2:6]), int(line[6:10]), int(line[10:12]), int(line[12:13])
        if last > self._last or first < FIRST:
            return b"04"
        if last < first:
            return b"05"
        self._skip = self._left_out = skip
        self.streaming = (line, first, last, max(cluster, 1))
        return b"00"


def main() -> None:
    """Serve `sim:lab` by hand."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--path", type=Path, help="name of a pseudo-terminal instead of TCP")
    parser.add_argument("--port", type=int, default=10940)
    given = parser.parse_args()
    world, sensor = World(), ScipEmulator(path=given.path, port=given.port)
    world.on_scan.append(lambda scan: sensor.show_scan(scan, world.instant(scan.stamp)))
    serve(sensor, world)


if __name__ == "__main__":
    main()
