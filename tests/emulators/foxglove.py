"""A ROS 2 robot behind foxglove_bridge: the server is foxglove-sdk's, which the bridge is made of.

`python -m tests.emulators.foxglove --port 8765`, then `beckon run --robot foxglove://127.0.0.1:8765`.
"""

import argparse
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any

from core.recording.ros_sound import RAW_AUDIO
from core.robots.ros.topics import BATTERY, CAMERA_INFO, COMPRESSED, LASER_SCAN, ODOMETRY
from core.robots.ros.typestore import BOOL, GOAL, STRING, TF, TWIST, TWIST_STAMPED
from core.sensors import Wheels
from tests.emulators.by_hand import serve
from tests.emulators.own_navigation import EmulatedNavigation
from tests.emulators.ros_messages import DESCRIPTION, PROFILE, SIMULATED_START_S, URDF, RosMessageMaker, speeds_of
from tests.emulators.world import World

TOPICS = {
    "/scan": LASER_SCAN,
    "/odom": ODOMETRY,
    "/camera/image/compressed": COMPRESSED,
    "/camera/camera_info": CAMERA_INFO,
    "/microphones": RAW_AUDIO,
    "/battery_state": BATTERY,
    "/tf_static": TF,
}
CLOCK = {"/clock": "rosgraph_msgs/msg/Clock"}  # that a simulator gives the time is told by its topic
CONTROLLER = "/diff_drive_controller.cmd_vel_timeout"
PERIOD = 1.0  # [s] between repeated descriptions


def retried(start: Callable[[], Any], seconds: float = 5.0) -> Any:
    """Start a server as soon as the one before has left its port."""
    end = time.monotonic() + seconds
    while True:
        try:
            return start()
        except RuntimeError:
            if time.monotonic() > end:
                raise
        time.sleep(0.05)


class FoxgloveEmulator:
    """One robot and its bridge, which can be stopped and started again on the same port."""

    def __init__(
        self,
        world: World,
        port: int = 0,
        *,
        cmd_vel_type: str = TWIST,
        listens: Sequence[str] = ("/cmd_vel",),
        capabilities: Sequence[str] = ("ClientPublish", "ConnectionGraph"),
        tls: tuple[bytes, bytes] | None = None,
        tells: bool = True,
    ) -> None:
        """`tls`: certificate and key (PEM). `listens`: topics that the robot takes speeds from, as it `tells`."""
        self.tells = tells
        self.world, self.port = world, port
        self.cmd_vel_type, self.listens, self.capabilities, self.tls = cmd_vel_type, listens, capabilities, tls
        self.locks: list[tuple[float, bool]] = []
        self.received: list[tuple[float, float, float]] = []  # time.monotonic(), v, w of every message on the wire
        self.subscribed: set[str] = set()
        self.frames: list[bytes] = []  # every command as it came
        self.maker = RosMessageMaker(SIMULATED_START_S)
        self.navigation: EmulatedNavigation | None = None  # set it before `start`, and
        self.urdf = ""  # on /robot_description
        self.simulates = True  # it has a simulator's clock, which a slow computer holds up
        self._client_channels: dict[tuple[int, int], str] = {}
        self._server: Any = None
        self.parameters: dict[str, Any] = {}  # of the robot's nodes; needs the capability Parameters
        self._context: Any = None
        self._channels: dict[str, Any] = {}
        self._stamp = 0.0
        world.on_scan.append(lambda scan: self.log("/scan", self.maker.scan(scan)))
        world.on_image.append(lambda image: self.log("/camera/image/compressed", self.maker.image(image)))
        world.on_sound.append(lambda sound: self.log("/microphones", self.maker.sound(sound)))
        world.on_wheels.append(self._wheels)

    @property
    def url(self) -> str:
        return f"foxglove://127.0.0.1:{self.port}"

    def start(self) -> None:
        import foxglove
        from foxglove.websocket import Capability, ConnectionGraph

        context = self._context = foxglove.Context()  # its channels close when it is gone
        self._server = retried(
            lambda: foxglove.start_server(
                name="emulated robot",
                host="127.0.0.1",
                port=self.port,
                context=context,
                capabilities=[getattr(Capability, name) for name in self.capabilities],
                supported_encodings=["cdr"],
                server_listener=self,  # type: ignore[arg-type]
                tls_cert=self.tls[0] if self.tls else None,
                tls_key=self.tls[1] if self.tls else None,
            )
        )
        self.port = self._server.port
        own = (self.navigation.topics if self.navigation else {}) | ({DESCRIPTION: STRING} if self.urdf else {})
        topics = TOPICS | own | (CLOCK if self.simulates else {})
        topics |= dict.fromkeys(self.listens, self.cmd_vel_type) if self.tells else {}
        self._channels = {topic: self._channel(foxglove, context, topic, kind) for topic, kind in topics.items()}
        if "ConnectionGraph" in self.capabilities:
            graph = ConnectionGraph()
            for topic in self.listens if self.tells else ():
                graph.set_subscribed_topic(topic, ["/base_controller"])
            self._server.publish_connection_graph(graph)

    def stop(self) -> None:
        """The bridge ends; the robot does not."""
        server, self._server = self._server, None
        self._channels, self._client_channels = {}, {}
        if server is not None:
            server.stop()

    def status(self, sentence: str, level: str = "Warning") -> None:
        from foxglove.websocket import StatusLevel

        self._server.publish_status(sentence, getattr(StatusLevel, level))

    def log(self, topic: str, payload: bytes) -> None:
        channel = self._channels.get(topic)
        if channel is not None:
            channel.log(payload, log_time=time.time_ns())

    def describe(self) -> None:
        """What the bridge repeats to whom comes late: mountings and calibration."""
        self.log("/tf_static", self.maker.frames())
        self.log("/camera/camera_info", self.maker.camera_info(self._stamp))
        self.log("/battery_state", self.maker.battery(0.8))
        self.log(DESCRIPTION, self.maker.description(self.urdf))
        if self.navigation is not None:
            self.log("/map", self.navigation.grid())

    def _channel(self, foxglove: Any, context: Any, topic: str, kind: str) -> Any:
        text = self.maker.store.generate_msgdef(kind, ros_version=2)[0].encode()
        schema = foxglove.Schema(name=kind, encoding="ros2msg", data=text)
        return foxglove.Channel(topic, schema=schema, message_encoding="cdr", context=context)

    def _wheels(self, wheels: Wheels) -> None:
        rate = PROFILE.rate
        count = round(self._stamp * rate) + 1
        self._stamp = count / rate
        self.log("/odom", self.maker.odometry(wheels, self._stamp))
        for topic, payload in self.navigation.step(wheels, self._stamp) if self.navigation else ():
            self.log(topic, payload)
        if count % round(PERIOD * rate) == 0:
            self.describe()

    # What foxglove-sdk calls.

    def on_subscribe(self, client: Any, channel: Any) -> None:
        self.subscribed.add(channel.topic)
        threading.Timer(0.02, self.describe).start()

    def on_unsubscribe(self, client: Any, channel: Any) -> None:
        self.subscribed.discard(channel.topic)

    def on_client_advertise(self, client: Any, channel: Any) -> None:
        if channel.encoding == "cdr" and channel.schema_name in (self.cmd_vel_type, BOOL, GOAL):
            self._client_channels[client.id, channel.id] = channel.topic

    def on_client_unadvertise(self, client: Any, client_channel_id: int) -> None:
        self._client_channels.pop((client.id, client_channel_id), None)

    def on_message_data(self, client: Any, client_channel_id: int, data: bytes) -> None:
        topic = self._client_channels.get((client.id, client_channel_id))
        if topic in self.listens and (speeds := speeds_of(data)) is not None:
            self.received.append((time.monotonic(), *speeds))
            self.frames.append(data)
            self.world.drive(*speeds)
        elif topic is not None and len(data) == 5:
            self.locks.append((time.monotonic(), bool(data[4])))
            if self.navigation is not None:
                self.navigation.locked = self.locks[-1]
        elif topic == "/goal_pose" and self.navigation is not None:
            self.navigation.take_cdr(data)

    def on_get_parameters(self, client: Any, names: list[str], request_id: str | None = None) -> list[Any]:
        from foxglove.websocket import Parameter

        return [Parameter(name, value=value) for name, value in self.parameters.items() if not names or name in names]

    def on_connection_graph_subscribe(self) -> None: ...

    def on_connection_graph_unsubscribe(self) -> None: ...


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.emulators.foxglove", description=__doc__)
    parser.add_argument("--port", type=int, default=8765)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--navigates", action="store_true", help="it has a navigation of its own")
    parser.add_argument("--stamped", action="store_true", help="the robot takes TwistStamped")
    given = parser.parse_args()
    world = World(seed=given.seed)
    emulator = FoxgloveEmulator(
        world,
        given.port,
        cmd_vel_type=TWIST_STAMPED if given.stamped else TWIST,
        capabilities=("ClientPublish", "ConnectionGraph", "Parameters"),
    )
    emulator.parameters, emulator.urdf = {CONTROLLER: 0.5}, URDF
    if given.navigates:
        emulator.navigation = EmulatedNavigation(world, emulator.maker)
    serve(emulator, world)


if __name__ == "__main__":
    main()
