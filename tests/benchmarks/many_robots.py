"""How many robots one process can listen to: `python -m tests.benchmarks.many_robots [--robots 50] [--seconds 20]`.

Every robot sends a laser's scans at 10 Hz, pictures of 12 kB at 15 Hz and odometry at 40 Hz, each over a connection
of its own to a process that only sends. Delay is counted from the instant of sending to the instant at which the
driver has the message; lost is what was sent in the time and never came. Of so many robots as `--watched` says frames
are read 40 times a second, as the console does with the robot that it drives: only their pictures are decoded. The
figures are printed as JSON.
"""

import multiprocessing
import time
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

import cv2
import numpy as np
import psutil

from core.geometry import Pose
from core.robots.foxglove import MESSAGE_HEAD, FoxgloveRobot
from core.robots.live import DeviceLink
from core.robots.readings import Readings
from core.robots.ros.socket_link import parse_address
from core.robots.ros.topics import COMPRESSED, LASER_SCAN, ODOMETRY
from core.sensors import Scan, Wheels
from tests.benchmarks.command import run_command
from tests.emulators.ros_messages import RosMessageMaker

RATES = {"/scan": 10, "/image/compressed": 15, "/odom": 40}  # [Hz]
TYPES = {"/scan": LASER_SCAN, "/image/compressed": COMPRESSED, "/odom": ODOMETRY}
PICTURE = 12_000  # [bytes]
STEP = 1 / 120  # [s], of which all periods are multiples
SETTLING = 3.0  # [s] after all are connected


def picture(maker: RosMessageMaker) -> bytes:
    """A JPEG of about the size that small robots' cameras send."""
    rng = np.random.default_rng(0)
    noise = cv2.resize(rng.integers(0, 256, (60, 80, 3), np.uint8), (320, 240))
    sizes = {
        quality: cv2.imencode(".jpg", noise, [cv2.IMWRITE_JPEG_QUALITY, quality])[1] for quality in range(40, 96)
    }
    jpeg = min(sizes.values(), key=lambda one: abs(len(one) - PICTURE))
    return maker.encode(COMPRESSED, header=maker.header(0.0, "camera"), format="jpeg", data=jpeg.ravel())


def send(robots: int, line: Connection) -> None:
    """The robots, in a process of their own: say the ports, send until told to end, say how much was sent since."""
    import foxglove
    from foxglove.websocket import Capability

    maker, payloads = RosMessageMaker(time.time()), samples()
    servers: list[tuple[Any, Any, dict[str, Any]]] = []
    for _ in range(robots):
        context = foxglove.Context()
        server = foxglove.start_server(
            host="127.0.0.1",
            port=0,
            context=context,
            capabilities=[Capability.ClientPublish],
            supported_encodings=["cdr"],
        )
        channels: dict[str, Any] = {}
        for topic, kind in TYPES.items():
            text = maker.store.generate_msgdef(kind, ros_version=2)[0].encode()
            schema = foxglove.Schema(name=kind, encoding="ros2msg", data=text)
            channels[topic] = foxglove.Channel(topic, schema=schema, message_encoding="cdr", context=context)
        servers.append((server, context, channels))
    line.send([server.port for server, _, _ in servers])
    transmit(robots, line, lambda number, topic, now: servers[number][2][topic].log(payloads[topic], log_time=now))


def samples() -> dict[str, bytes]:
    """A message of every topic."""
    maker = RosMessageMaker(time.time())
    return {
        "/scan": maker.scan(Scan(stamp=0.0, ranges=np.ones(682, np.float32), angle_min=-2.09, angle_step=0.0061)),
        "/image/compressed": picture(maker),
        "/odom": maker.odometry(Wheels(odometry=Pose(), speed=0.0, turn_rate=0.0), 0.0),
    }


def transmit(robots: int, line: Connection, put: Callable[[int, str, int], None]) -> None:
    """Send at the robots' rates until told to end, say how much was sent since, and wait for leave."""
    window = (0, 0)  # [ns] in which messages count
    sent, step, due = 0, 0, time.monotonic()
    while True:
        if line.poll():
            window = line.recv()
        if window[1] and time.time_ns() > window[1]:
            break
        for topic, rate in RATES.items():
            every = 120 // rate
            for number in range(robots):
                if (step + number) % every == 0:
                    now = time.time_ns()
                    sent += window[0] <= now < window[1]
                    put(number, topic, now)
        step, due = step + 1, due + STEP
        time.sleep(max(0.0, due - time.monotonic()))
    line.send((sent, psutil.Process().cpu_times().user))
    line.recv()


class MeasuredRobot(FoxgloveRobot):
    """Writes down when what was sent at which time arrived."""

    def __init__(self, rest: str) -> None:
        super().__init__(parse_address(rest, 0))
        self.arrivals: list[tuple[int, int]] = []  # sent, arrived [ns]

    def _read(self, raw: str | bytes) -> tuple[str, Any] | None:
        if isinstance(raw, bytes) and raw[0] == 1:
            self.arrivals.append((MESSAGE_HEAD.unpack_from(raw)[2], time.time_ns()))
        return super()._read(raw)


def measure(
    robots: int,
    seconds: float,
    watched: int,
    send: Callable[[int, Connection], None],
    connect: Callable[[int], Any],
    left_out: Callable[[], int] = lambda: 0,
) -> dict[str, Any]:
    """Connect to so many robots, listen for so long → the figures.

    `send` is the process of the robots; `connect` makes a device with `arrivals` for one of the ports that it says;
    `left_out` counts the pictures so far that gave way to newer ones, which are not lost.
    """
    context = multiprocessing.get_context("spawn")
    line, far = context.Pipe()
    sender = context.Process(target=send, args=(robots, far), daemon=True)
    sender.start()
    ports: list[int] = line.recv()
    began = time.monotonic()
    devices: list[Any] = [connect(port) for port in ports]
    readings = [Readings() for _ in devices]
    links = [DeviceLink(f"robot-{number}", device, readings[number]) for number, device in enumerate(devices)]
    for link in links:
        link.start()
    waited_for(lambda: all(link.up for link in links), 60.0)
    for link in links:
        link.named_apart(set())
    connected = time.monotonic() - began
    time.sleep(SETTLING)
    process = psutil.Process()
    before, start = process.cpu_times(), time.time_ns()
    end = start + int(seconds * 1e9)
    line.send((start, end))
    passed_over = -left_out()
    pictures = watch(readings[:watched], seconds)
    cpu = process.cpu_times()
    sent, _ = line.recv()
    time.sleep(1.0)
    passed_over += left_out()
    memory, threads = process.memory_info().rss / 1e6, process.num_threads()
    delays = sorted(
        (arrived - at) / 1e6 for device in devices for at, arrived in device.arrivals if start <= at < end
    )
    for link in links:
        link.close()
    line.send("end")
    return {
        "robots": robots,
        "watched": watched,
        "pictures_decoded_per_s": round(pictures / seconds, 1),
        "connected_s": round(connected, 1),
        "messages_per_s": round(len(delays) / seconds),
        "sent": sent,
        "pictures_left_out": passed_over,
        "lost": sent - len(delays) - passed_over,
        "errors": sum(sum(device.types.errors.values()) for device in devices),
        "delay_ms_p50": round(delays[len(delays) // 2], 2),
        "delay_ms_p99": round(delays[int(0.99 * len(delays))], 2),
        "cpu_share_of_a_core": round((cpu.user + cpu.system - before.user - before.system) / seconds, 3),
        "memory_mb": round(memory),
        "threads": threads,
    }


def watch(readings: list[Readings], seconds: float) -> int:
    """Read the robots' frames for so long, 40 a second of each → how many pictures were in them."""
    pictures, due = 0, time.monotonic()
    end = due + seconds
    while due < end:
        pictures += sum(one.frame().image is not None for one in readings)
        due += 1 / 40
        time.sleep(max(0.0, due - time.monotonic()))
    return pictures


def waited_for(true: Callable[[], bool], seconds: float) -> None:
    """Wait until it is true. Raises TimeoutError."""
    end = time.monotonic() + seconds
    while not true():
        if time.monotonic() > end:
            raise TimeoutError("not all robots could be reached")
        time.sleep(0.02)


def main(
    *,
    robots: int = 50,
    seconds: float = 20.0,
    watched: int = 1,  # of how many frames are read
) -> object:
    return measure(robots, seconds, watched, send, lambda port: MeasuredRobot(f"//127.0.0.1:{port}"))


if __name__ == "__main__":
    run_command(main)
