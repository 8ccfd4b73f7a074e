"""A ROS 1 or ROS 2 robot behind rosbridge_server with rosapi, as far as a console uses them.

`python -m tests.emulators.rosbridge --port 9090`, then `beckon run --robot rosbridge://127.0.0.1:9090`.
"""

import argparse
import base64
import contextlib
import dataclasses
import json
import math
import os
import threading
import time
from collections.abc import Sequence
from typing import Any

import cbor2
import numpy as np
from websockets.exceptions import ConnectionClosed
from websockets.sync.server import Server, ServerConnection, serve

from core.geometry import Pose
from core.robots.ros.typestore import GOAL, STRING, TWIST, TWIST_STAMPED, usual_types
from core.sensors import Wheels
from tests.emulators.by_hand import serve as serve_by_hand
from tests.emulators.foxglove import CLOCK, PERIOD, TOPICS
from tests.emulators.own_navigation import EmulatedNavigation
from tests.emulators.ros_messages import DESCRIPTION, PROFILE, SIMULATED_START_S, URDF, RosMessageMaker
from tests.emulators.wires import serving
from tests.emulators.world import World

TYPES = "/rosapi/topics"  # begins the services that list topics
SERVICES = (
    "/rosapi/topics_and_raw_types",
    "/rosapi/topics",
    "/rosapi/nodes",
    "/rosapi/subscribers",
    "/rosapi/get_param",
    "/rosapi/get_param_names",
)
LATCHED = (DESCRIPTION, "/map", "/tf_static", "/camera/camera_info", "/battery_state")


class RosbridgeEmulator:
    """One robot, its rosbridge and its rosapi, which can be stopped and started again on the same port."""

    def __init__(
        self,
        world: World,
        port: int = 0,
        *,
        ros1: bool = False,
        cmd_vel_type: str = TWIST,
        services: Sequence[str] = SERVICES,
        tells: bool = True,
    ) -> None:
        """`services`: what this version of rosapi has; it `tells` the type of the speeds, or not."""
        self.tells = tells
        self.world, self.port, self.ros1 = world, port, ros1
        self.cmd_vel_type, self.services = cmd_vel_type, services
        self.locks: list[tuple[float, bool]] = []
        self.received: list[tuple[float, float, float]] = []  # time.monotonic(), v, w of every message on the wire
        self.commands: list[dict[str, Any]] = []  # as they came
        self.subscribed: dict[str, dict[str, Any]] = {}  # topic → the request
        self.maker = RosMessageMaker(SIMULATED_START_S)
        self.navigation: EmulatedNavigation | None = None  # set it before `start`, and
        self.urdf = ""  # on /robot_description, in ROS 1 a parameter
        self.simulates = True  # it has a simulator's clock, which a slow computer holds up
        self.parameters: dict[str, Any] = {}  # of ROS 1 "/controller/cmd_vel_timeout", ROS 2 "/node:cmd_vel_timeout"
        self.clients: list[ServerConnection] = []
        self._stamp = 0.0
        self._server: Server | None = None
        self._thread: threading.Thread | None = None
        world.on_scan.append(lambda scan: self.log("/scan", self.maker.scan(scan)))
        world.on_image.append(lambda image: self.log("/camera/image/compressed", self.maker.image(image)))
        world.on_sound.append(lambda sound: self.log("/microphones", self.maker.sound(sound)))
        world.on_wheels.append(self._wheels)

    @property
    def url(self) -> str:
        return f"rosbridge://127.0.0.1:{self.port}"

    @property
    def topics(self) -> dict[str, str]:
        described = {DESCRIPTION: STRING} if self.urdf and not self.ros1 else {}
        clock = CLOCK if self.simulates else {}
        return TOPICS | clock | described | (self.navigation.topics if self.navigation else {})

    def start(self) -> None:
        self._server = serve(self._serve, "127.0.0.1", self.port, compression=None, max_size=None)
        self.port = int(self._server.socket.getsockname()[1])
        self._thread = serving(self._server)

    def stop(self) -> None:
        """The bridge ends; the robot does not."""
        if self._server is not None and self._thread is not None:
            for client in list(self.clients):
                client.close()
            self._server.shutdown()
            self._thread.join()
            for end in (self._server.shutdown_watcher, self._server.shutdown_notifier):
                os.close(end)  # the library leaves them open
            self._server = None

    def status(self, sentence: str, level: str = "warning") -> None:
        self.say(json.dumps({"op": "status", "level": level, "msg": sentence}))

    def say(self, raw: str | bytes) -> None:
        for client in list(self.clients):
            with contextlib.suppress(ConnectionClosed):
                client.send(raw)

    def log(self, topic: str, cdr: bytes) -> None:
        request = self.subscribed.get(topic)
        if request is None or not self.clients:
            return
        payload = bytes(self.maker.store.cdr_to_ros1(cdr, self.topics[topic])) if self.ros1 else cdr
        if request.get("compression") == "cbor-raw":
            content = {"secs": 0, "nsecs": 0, "bytes": payload}
            self.say(cbor2.dumps({"op": "publish", "topic": topic, "msg": content}))
        else:
            content = self._json(self.maker.store.deserialize_cdr(cdr, self.topics[topic]))
            self.say(json.dumps({"op": "publish", "topic": topic, "msg": content}))

    def describe(self) -> None:
        """What rosbridge repeats to whom comes late: mountings and calibration."""
        self.log("/tf_static", self.maker.frames())
        self.log("/camera/camera_info", self.maker.camera_info(self._stamp))
        self.log("/battery_state", self.maker.battery(0.8))
        self.log(DESCRIPTION, self.maker.description(self.urdf))
        if self.navigation is not None:
            self.log("/map", self.navigation.grid())

    def _json(self, value: Any) -> Any:
        """As rosbridge writes messages: bytes in base 64, no number is null, ROS 1 with names of its own."""
        if dataclasses.is_dataclass(value):
            fields = {one.name: self._json(getattr(value, one.name)) for one in dataclasses.fields(value)}
            fields.pop("__msgtype__", None)
            if self.ros1 and set(fields) == {"sec", "nanosec"}:
                return {"secs": fields["sec"], "nsecs": fields["nanosec"]}
            return {name.upper() if self.ros1 and name in "dkrp" else name: one for name, one in fields.items()}
        if isinstance(value, np.ndarray):
            if value.dtype == np.uint8:
                return base64.b64encode(value.tobytes()).decode()
            return [self._json(one) for one in value.tolist()]
        if isinstance(value, list):
            return [self._json(one) for one in value]
        return None if isinstance(value, float) and not math.isfinite(value) else value

    def _name(self, kind: str) -> str:
        return kind.replace("/msg/", "/") if self.ros1 else kind

    def _wheels(self, wheels: Wheels) -> None:
        count = round(self._stamp * PROFILE.rate) + 1
        self._stamp = count / PROFILE.rate
        self.log("/odom", self.maker.odometry(wheels, self._stamp))
        for topic, payload in self.navigation.step(wheels, self._stamp) if self.navigation else ():
            self.log(topic, payload)
        if count % round(PERIOD * PROFILE.rate) == 0:
            self.describe()

    def _serve(self, client: ServerConnection) -> None:
        self.subscribed = {}
        self.clients.append(client)
        advertised: dict[str, str] = {}
        with contextlib.suppress(ConnectionClosed):
            for raw in client:
                self._hear(client, json.loads(raw), advertised)
        self.clients.remove(client)

    def _hear(self, client: ServerConnection, fields: dict[str, Any], advertised: dict[str, str]) -> None:
        match fields["op"]:
            case "subscribe":
                self.subscribed[fields["topic"]] = fields
                if fields["topic"] in LATCHED:
                    self.describe()
            case "advertise":
                advertised[fields["topic"]] = fields["type"]
            case "unadvertise":
                advertised.pop(fields["topic"], None)
            case "publish" if fields["topic"] in advertised:
                self._take(fields["topic"], advertised[fields["topic"]], fields["msg"])
            case "call_service":
                client.send(json.dumps(self._answer(fields)))

    def _take(self, topic: str, kind: str, content: dict[str, Any]) -> None:
        if topic == "/cmd_vel" and kind == self._name(self.cmd_vel_type):
            self.commands.append(content)
            twist = content["twist"] if self.cmd_vel_type == TWIST_STAMPED else content
            speeds = float(twist["linear"]["x"]), float(twist["angular"]["z"])
            self.received.append((time.monotonic(), *speeds))
            self.world.drive(*speeds)
        elif kind == self._name("std_msgs/msg/Bool"):
            self.locks.append((time.monotonic(), content["data"]))
            if self.navigation is not None:
                self.navigation.locked = self.locks[-1]
        elif kind == self._name(GOAL) and self.navigation is not None:
            stamp, place, q = content["header"]["stamp"], content["pose"]["position"], content["pose"]["orientation"]
            assert not any(stamp.values())
            heading = 2 * math.atan2(q["z"], q["w"])
            self.navigation.take_goal(content["header"]["frame_id"], Pose(place["x"], place["y"], heading))

    def _answer(self, fields: dict[str, Any]) -> dict[str, Any]:
        service = fields["service"]
        answer = {"op": "service_response", "service": service, "id": fields.get("id")}
        if service not in self.services:
            return answer | {"result": False, "values": f"Service {service} does not exist"}
        if not service.startswith(TYPES):
            return answer | {"result": True, "values": self._told(service, fields.get("args") or {})}
        topics = self.topics | ({"/cmd_vel": self.cmd_vel_type} if self.tells else {})
        values: dict[str, Any] = {"topics": list(topics), "types": [self._name(kind) for kind in topics.values()]}
        if service == "/rosapi/topics_and_raw_types":
            version, store = (1, usual_types("ros1")) if self.ros1 else (2, self.maker.store)
            texts = [store.generate_msgdef(kind, ros_version=version)[0] for kind in topics.values()]
            values["typedefs_full_text"] = texts
        return answer | {"result": True, "values": values}

    def _told(self, service: str, asked: dict[str, str]) -> dict[str, Any]:
        """What rosapi says of nodes and parameters."""
        known = self.parameters | ({DESCRIPTION: self.urdf} if self.urdf and self.ros1 else {})
        match service:
            case "/rosapi/get_param":
                return {"value": json.dumps(known[asked["name"]]) if asked["name"] in known else ""}
            case "/rosapi/get_param_names":
                return {"names": list(known)}
            case "/rosapi/subscribers":
                return {"subscribers": ["/twist_mux"] if asked["topic"] == "/cmd_vel" else []}
            case _:
                return {"nodes": ["/rosapi", "/camera", *(name.partition(":")[0] for name in known)]}


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.emulators.rosbridge", description=__doc__)
    parser.add_argument("--port", type=int, default=9090)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--ros1", action="store_true", help="a robot with ROS 1")
    given = parser.parse_args()
    world = World(seed=given.seed)
    emulator = RosbridgeEmulator(world, given.port, ros1=given.ros1)
    separator = "/" if given.ros1 else ":"
    emulator.parameters = {f"/diff_drive_controller{separator}cmd_vel_timeout": 0.5}
    emulator.urdf = URDF
    serve_by_hand(emulator, world)


if __name__ == "__main__":
    main()
