"""The same over zenoh: `python -m tests.benchmarks.many_zenoh_robots [--robots 50] [--seconds 20]`.

As `tests.benchmarks.many_robots`, but every robot is a router of its own with a node on rmw_zenoh, and the time of
sending stands in the message's stamp. Of pictures only the newest is handed on, so with a busy process some are left
out before the driver has them; these are counted by themselves.
"""

import struct
import time
from multiprocessing.connection import Connection
from typing import Any

from core.robots.ros.bridge import RosSensors
from core.robots.ros.zenoh_session import ZenohConnection
from core.robots.zenoh_link import ZenohRobot, parse_address
from tests.benchmarks.command import run_command
from tests.benchmarks.many_robots import TYPES, measure, samples, transmit
from tests.emulators.ros_messages import RosMessageMaker
from tests.emulators.zenoh_robot import RmwNode, free_port, session

STAMP = struct.Struct("<iI")  # at byte 4, after the encapsulation


def send(robots: int, line: Connection) -> None:
    """The robots, in a process of their own."""
    hash_of = RosMessageMaker(0.0).store.hash_rihs01
    payloads = samples()
    ports: list[int] = []
    nodes: list[Any] = []
    for number in range(robots):
        port = free_port()
        router = session("router", listen__endpoints=[f"tcp/127.0.0.1:{port}"], transport__link__tx__lease=2000)
        node = RmwNode(router, hash_of, name=f"bot{number}")
        nodes.append((node, {topic: node.publisher(topic, kind) for topic, kind in TYPES.items()}))
        ports.append(port)

    def put(number: int, topic: str, now: int) -> None:
        payload = payloads[topic]
        nodes[number][1][topic](payload[:4] + STAMP.pack(now // 10**9, now % 10**9) + payload[12:])

    line.send(ports)
    transmit(robots, line, put)


class MeasuredRobot(ZenohRobot):
    """Writes down when what was sent at which time arrived."""

    def __init__(self, port: int) -> None:
        super().__init__(parse_address(f"//127.0.0.1:{port}"))
        self.arrivals: list[tuple[int, int]] = []  # sent, arrived [ns]

    def connection(self) -> ZenohConnection | None:
        return self._link

    def _hand_on(self, sensors: RosSensors, topic: str, payload: bytes, publisher: str) -> None:
        seconds, nanoseconds = STAMP.unpack_from(payload, 4)
        self.arrivals.append((seconds * 10**9 + nanoseconds, time.time_ns()))
        super()._hand_on(sensors, topic, payload, publisher)


def main(
    *,
    robots: int = 50,
    seconds: float = 20.0,
    watched: int = 1,  # of how many frames are read
) -> object:
    devices: list[MeasuredRobot] = []

    def connect(port: int) -> MeasuredRobot:
        devices.append(MeasuredRobot(port))
        return devices[-1]

    def left_out() -> int:
        links = [device.connection() for device in devices]
        return sum(link.waiting.dropped for link in links if link is not None)

    return measure(robots, seconds, watched, send, connect, left_out)


if __name__ == "__main__":
    run_command(main)
