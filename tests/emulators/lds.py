"""Turning lidars: LDROBOT LD19, SLAMTEC RPLidar A1 and YDLIDAR X4, on a pseudo-terminal or a TCP port."""

import argparse
import itertools
import math
import struct
import time
from collections import deque
from collections.abc import Callable
from pathlib import Path

import numpy as np

from core.message import Array
from core.sensors import Laser, Wheels
from core.simulation.laser import SimulatedLaser
from core.simulation.world import world_named
from tests.emulators.by_hand import serve
from tests.emulators.wires import Port, SerialPort, TcpPort, Wire
from tests.emulators.world import World

Ranging = Callable[[Array], Array]  # clockwise from the front (N,) [degrees] → (N,) [m], 0: no echo
AROUND = 900  # rays of the simulated room: every second is a point of the LD19
LIMITS = {"ld19": (0.02, 12.0), "rplidar-a1": (0.15, 12.0), "ydlidar-x4": (0.12, 10.0)}  # [m]
SHARE_SD = {"ld19": 0.0, "rplidar-a1": 0.01, "ydlidar-x4": 0.01}  # of a range; the LD19's data sheet: 10 mm anywhere


def ld19_crc(data: bytes) -> int:
    crc = 0
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = ((crc << 1) ^ (0x4D if crc & 0x80 else 0)) & 0xFF
    return crc


def ld19_turn(ranging: Ranging) -> list[bytes]:
    """450 points in packets of 12, at 10 Hz."""
    angles = np.arange(456) * 0.8
    millimetres = np.round(ranging(angles % 360) * 1e3).astype(int)
    packets: list[bytes] = []
    for first in range(0, 444, 12):
        start, end = (round(angle * 100) % 36000 for angle in (angles[first], angles[first + 11]))
        points = b"".join(struct.pack("<HB", value, 200) for value in millimetres[first : first + 12])
        body = struct.pack("<BBHH", 0x54, 0x2C, 3600, start) + points + struct.pack("<HH", end, first)
        packets.append(body + bytes([ld19_crc(body)]))
    return packets


def rplidar_turn(ranging: Ranging) -> list[bytes]:
    """360 nodes, the first of which carries the start flag."""
    angles = np.arange(360) + 0.3
    quarters = np.round(ranging(angles) * 4e3).astype(int)
    nodes = [
        struct.pack(
            "<BHH", (15 << 2 if value else 0) | (1 if first else 2), round(angle * 64) << 1 | 1, min(value, 65535)
        )
        for first, angle, value in zip([True] + [False] * 359, angles, quarters, strict=True)
    ]
    return [b"".join(nodes[begin : begin + 16]) for begin in range(0, 360, 16)]


def ydlidar_correction(metres: Array) -> Array:
    """How far [degrees] the beam's angle is from the head's, by the triangle of laser and lens."""
    distance = np.where(metres > 0, metres * 1e3, 1e9)
    return np.degrees(np.arctan(21.8 * (155.3 - distance) / (155.3 * distance))) * (metres > 0)


def ydlidar_turn(ranging: Ranging) -> list[bytes]:
    """A start packet of one point and packets of 40, at 7 Hz; angles are those of the head."""
    packets: list[bytes] = []
    heads = np.arange(721) * 0.5
    metres = ranging(heads % 360)
    for _ in range(3):
        metres = ranging((heads + ydlidar_correction(metres)) % 360)
    quarters = np.round(metres * 4e3).astype(int)
    for begin, end in ((0, 1), *((first, min(first + 40, 720)) for first in range(1, 720, 40))):
        start, last = (round(heads[index] * 64) << 1 | 1 for index in (begin, end - 1))
        kind, words = (71 if end == 1 else 0), quarters[begin:end].tolist()
        total = 0x55AA ^ start ^ last ^ (kind | len(words) << 8)
        for word in words:
            total ^= word
        packets.append(struct.pack(f"<HBBHHH{len(words)}H", 0x55AA, kind, len(words), start, last, total, *words))
    return packets


TURNS = {"ld19": (ld19_turn, 10.0), "rplidar-a1": (rplidar_turn, 5.5), "ydlidar-x4": (ydlidar_turn, 7.0)}


class LidarEmulator:
    """A lidar in the simulated room, on the robot's place."""

    def __init__(
        self, world: World, model: str, *, place: str = "lab", path: Path | None = None, port: int = 0
    ) -> None:
        self.measuring = model == "ld19"
        self.turning = True
        self.ranges = np.zeros(AROUND)  # counter-clockwise from behind, [m], each as the head saw it last
        self.model = model
        self._turn, self._rate = TURNS[model]
        low, high = LIMITS[model]
        self._laser = SimulatedLaser(
            Laser(
                beams=AROUND,
                angle_min=0.0,
                angle_step=math.tau / AROUND,
                range_min=low,
                range_max=high,
                time_step=-1 / (self._rate * AROUND),
            ),
            np.random.default_rng(0),
            share_sd=SHARE_SD[model],
            dropout=0.0,
        )
        self._room, self._world = world_named(place), world
        self._began = time.monotonic()
        self._seen = 0.0  # share of the turn that the head has swept
        self._sent: int | None = None  # packets of the turn; None: it does not measure
        self._way: deque[tuple[float, float, float, float]] = deque(maxlen=80)  # time.monotonic(), x, y, heading
        world.on_wheels.append(self._go_on)
        self._port: Port = TcpPort(self._serve, port=port) if path is None else SerialPort(self._serve, path)

    @property
    def url(self) -> str:
        return f"lds:{self._port.url}?model={self.model}"

    @property
    def port(self) -> Port:
        return self._port

    def start(self) -> None:
        self.measuring = self.model == "ld19"
        self._port.start()

    def stop(self) -> None:
        self._port.stop()

    def inject(self, data: bytes) -> bool:
        """Send bytes as they are → whether a driver was there."""
        return self._port.inject(data)

    def packets(self) -> list[bytes]:
        """Those of a turn, as the head saw it last."""
        return self._turn(self._ranging)

    def _look(self, share: float) -> None:
        """Measure from where the head looked last to `share` of its turn, and what it has not swept yet besides."""
        way = np.array(self._way)
        way[:, 3] = np.unwrap(way[:, 3])
        scan = self._laser.scan(self._room, self._began + 1 / self._rate, way[:, 0], way[:, 1:])
        beams = np.arange(AROUND - int(self._seen * AROUND))  # the head turns clockwise from the front
        self.ranges[(beams + AROUND // 2) % AROUND] = np.nan_to_num(scan.ranges[beams], nan=0.0)
        self._seen = min(share, 1.0)

    def _ranging(self, clockwise: Array) -> Array:
        beams = np.round((-clockwise + 180) % 360 * AROUND / 360).astype(int) % AROUND
        return self.ranges[beams]

    def _go_on(self, _: Wheels) -> None:
        """Measure and send what the head has swept since the last time."""
        pose, now = self._world.truth, time.monotonic()
        self._way.append((now, pose.x, pose.y, pose.heading))
        wire = self._port.wire
        if wire is None or not self.measuring or not self.turning:
            self._sent = None
            return
        if self._sent is None:
            self._began, self._seen, self._sent = now, 0.0, 0
        try:
            while self._sweep(wire, (now - self._began) * self._rate):
                late = (now - self._began) * self._rate > 2
                self._began = now if late else self._began + 1 / self._rate
        except OSError:
            return

    def _sweep(self, wire: Wire, share: float) -> bool:
        """Measure and send this share of the turn → whether it is whole, and the next one has begun."""
        assert self._sent is not None
        self._look(share)
        packets = self.packets()
        due = min(math.ceil(share * len(packets)), len(packets))
        for packet in packets[self._sent : due]:
            wire.write(packet)
        self._sent = due
        if share >= 1:
            self._seen, self._sent = 0.0, 0
        return share >= 1

    def _serve(self, wire: Wire) -> None:
        """Start at a scan command and stop at a stop command; the LD19 knows neither."""
        scan, stop = {"ld19": (None, None), "rplidar-a1": (0x20, 0x25), "ydlidar-x4": (0x60, 0x65)}[self.model]
        while True:
            data = wire.read(1.0)
            for first, second in itertools.pairwise(data):
                if first != 0xA5 or second not in (scan, stop):
                    continue
                self.measuring = False
                if second == scan:
                    wire.write(b"\xa5\x5a\x05\x00\x00\x40\x81")
                    self._sent, self.measuring = None, True


def main() -> None:
    """Serve `sim:lab` by hand."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("model", choices=sorted(TURNS))
    parser.add_argument("--path", type=Path, help="name of a pseudo-terminal instead of TCP")
    parser.add_argument("--port", type=int, default=2000)
    given = parser.parse_args()
    world = World()
    serve(LidarEmulator(world, given.model, path=given.path, port=given.port), world)


if __name__ == "__main__":
    main()
