"""Several robots behind one bridge, on the wire: nothing is said to any before one was named."""

import json
import math
from collections.abc import Callable, Collection, Generator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest
from websockets.sync.server import ServerConnection

from core.gate import Twist
from core.geometry import Pose, Transform
from core.robots.device import Device
from core.robots.foxglove import open_device as open_foxglove
from core.robots.ros.topics import LASER_SCAN, ODOMETRY
from core.robots.ros.typestore import TF, TWIST
from core.robots.rosbridge import open_device as open_rosbridge
from core.sensors import Scan, Wheels
from tests.core.robots.links import frames, live, until
from tests.emulators.ros_messages import RosMessageMaker
from tests.emulators.rosbridge import RosbridgeEmulator
from tests.emulators.small_foxglove import SmallFoxglove
from tests.emulators.world import World

MAKER = RosMessageMaker(1000.0)
KINDS = {"scan": LASER_SCAN, "odom": ODOMETRY, "cmd_vel": TWIST, "tf": TF}
ROBOTS = ("/robot1", "/robot2")
Topics = dict[str, str]


def definition(kind: str) -> tuple[str, str, str]:
    return kind, str(MAKER.store.generate_msgdef(kind, ros_version=2)[0]), "ros2msg"


class ListeningFoxglove(SmallFoxglove):
    """Tells who listens, and keeps the topics that a client says it will write to."""

    def __init__(self, topics: Topics, listeners: Collection[str]) -> None:
        channels = [(topic, *definition(kind)) for topic, kind in topics.items()]
        super().__init__(channels, capabilities=("clientPublish", "connectionGraph"))
        self.listeners = listeners

    @property
    def written(self) -> set[str]:
        return {one["topic"] for one in self.advertised.values()} | {topic for topic, _ in self.published}

    def _hear(self, raw: str | bytes) -> None:
        if isinstance(raw, str) and json.loads(raw)["op"] == "subscribeConnectionGraph":
            heard = [{"name": one, "subscriberIds": ["/base"]} for one in self.listeners]
            graph = {"subscribedTopics": heard, "publishedTopics": [], "advertisedServices": [], "removedTopics": []}
            self.say({"op": "connectionGraphUpdate", **graph})
        super()._hear(raw)


class SeveralRosbridge(RosbridgeEmulator):
    """Lists the topics of a test, and keeps those that a client says it will write to."""

    def __init__(self, topics: Topics, listeners: Collection[str]) -> None:
        super().__init__(World())
        self.listed, self.written = topics, set[str]()

    def _hear(self, client: ServerConnection, fields: dict[str, Any], advertised: dict[str, str]) -> None:
        if fields["op"] in ("advertise", "publish"):
            self.written.add(fields["topic"])
        super()._hear(client, fields, advertised)

    def _answer(self, fields: dict[str, Any]) -> dict[str, Any]:
        answer = super()._answer(fields)
        if "topics" in (values := answer["values"]):
            texts = [definition(kind)[1] for kind in self.listed.values()]
            values |= {"topics": list(self.listed), "types": list(self.listed.values())}
            values |= {"typedefs_full_text": texts}
        return answer


WIRES: dict[str, tuple[Callable[..., Any], Callable[[str], Device]]] = {
    "foxglove": (ListeningFoxglove, open_foxglove),
    "rosbridge": (SeveralRosbridge, open_rosbridge),
}


@contextmanager
def served(wire: str, topics: Topics, listeners: Collection[str]) -> Generator[tuple[Any, Callable[[str], Device]]]:
    make, open_device = WIRES[wire]
    emulator = make(topics, listeners)
    emulator.start()
    try:
        yield emulator, lambda options: open_device(f"//127.0.0.1:{emulator.port}{options}")
    finally:
        emulator.stop()


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("LEARNING_TIMEOUT_S", "DESCRIBING_TIMEOUT_S"):
        monkeypatch.setattr(f"core.robots.ros.socket_link.{name}", 0.05)


@pytest.mark.parametrize("wire", WIRES)
@pytest.mark.parametrize(
    ("leaves", "listeners"),
    [
        (("scan", "odom", "cmd_vel"), [f"{one}/cmd_vel" for one in ROBOTS]),
        (("scan", "odom", "cmd_vel"), ["/robot2/cmd_vel"]),
        (("scan", "odom", "tf"), []),
    ],
    ids=["both listen", "one listens", "trees alone"],
)
def test_nothing_is_written_to_one_of_several_robots_before_it_is_named(
    wire: str, leaves: tuple[str, ...], listeners: list[str]
) -> None:
    topics = {f"{robot}/{leaf}": KINDS[leaf] for robot in ROBOTS for leaf in leaves}
    with served(wire, topics, listeners) as (emulator, open_device):
        with live(open_device("")) as robot:
            frames(robot, 0.15, Twist(0.1, 0.5))
        assert emulator.written == set()
        with live(open_device("?namespace=/robot2")) as robot:
            robot.drive(Twist(0.1, 0.5))
            until(lambda: emulator.written)
            frames(robot, 0.1, Twist(0.1, 0.5))
        assert emulator.written == {"/robot2/cmd_vel"}


def test_a_mounting_that_comes_on_tf_alone_and_stays_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    """As of a laser that is mounted a quarter turn to the left."""
    monkeypatch.setattr("core.robots.ros.socket_link.LEARNING_TIMEOUT_S", 10.0)
    turned = Transform.of_pose(Pose(-0.04, 0.0, math.pi / 2), 0.2)
    tree = MAKER.encode(TF, transforms=[MAKER.transform("base_footprint", "laser", turned)])
    scan = Scan(stamp=1.0, ranges=np.ones(90, np.float32), angle_min=-0.5, angle_step=0.01)
    messages = {
        "/scan": MAKER.scan(scan),
        "/odom": MAKER.odometry(Wheels(odometry=Pose(), speed=0.0, turn_rate=0.0), 1.0),
        "/tf": tree,
    }
    kinds = {"/scan": LASER_SCAN, "/odom": ODOMETRY, "/tf": TF, "/cmd_vel": TWIST}
    with served("foxglove", kinds, ["/cmd_vel"]) as (emulator, open_device):
        emulator.on_subscribed = lambda one: [
            one.log(number, messages[topic]) for number, topic in enumerate(kinds, 1) if topic in messages
        ]
        with live(open_device("")) as robot:
            laser = robot.profile.laser
    assert laser is not None and laser.mounting.heading == pytest.approx(math.pi / 2)
    assert (laser.mounting.x, laser.mounting.y) == pytest.approx((-0.04, 0.0))
