"""Other programs watch live: the topics of a recording, to look at only."""

import json
import socket
import struct
from collections.abc import Iterator
from typing import Any

import pytest
from websockets.sync.client import ClientConnection, connect

from console.options import Options, check
from core.errors import BadInput, Unavailable
from core.recording import foxglove_server
from core.recording.ros import typestore
from core.recording.ros_writing import RosEncoder
from tests.console.live import Live

PATIENCE_S = 60.0


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        return int(listener.getsockname()[1])


@pytest.fixture(scope="module")
def live(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Live]:
    port = free_port()
    with Live(tmp_path_factory.mktemp("foxglove"), no_auth=True, foxglove_port=port) as live:
        live.foxglove_port = port  # type: ignore[attr-defined]

        def listens() -> bool:
            with socket.socket() as trial:
                return trial.connect_ex(("127.0.0.1", port)) == 0

        live.until(listens, seconds=PATIENCE_S)
        yield live


@pytest.fixture
def client(live: Live) -> Iterator[ClientConnection]:
    url = f"ws://127.0.0.1:{live.foxglove_port}"  # type: ignore[attr-defined]
    with connect(url, subprotocols=["foxglove.sdk.v1"], max_size=None) as client:  # type: ignore[list-item]
        yield client


def channels_of(client: ClientConnection, wanted: set[str]) -> dict[str, dict[str, Any]]:
    """Everything that is advertised until all of these topics are, by topic."""
    found: dict[str, dict[str, Any]] = {}
    while not wanted <= found.keys():
        said = json.loads(client.recv(timeout=PATIENCE_S))
        found |= {one["topic"]: one for one in said.get("channels", ())}
    return found


def first_of(client: ClientConnection, channel: dict[str, Any]) -> Any:
    """Subscribe to a channel → its first message, decoded."""
    subscribed = {"op": "subscribe", "subscriptions": [{"id": channel["id"], "channelId": channel["id"]}]}
    client.send(json.dumps(subscribed))
    while True:
        raw = client.recv(timeout=PATIENCE_S)
        if isinstance(raw, bytes) and raw[0] == 1 and struct.unpack_from("<I", raw, 1)[0] == channel["id"]:
            return typestore().deserialize_cdr(raw[13:], channel["schemaName"])


def test_the_topics_of_a_recording_are_served_with_their_types(live: Live, client: ClientConnection) -> None:
    channels = channels_of(client, {"/scan", "/odom", "/tf", "/pose", "/cmd_vel", "/map", "/camera/image/compressed"})
    assert {one["encoding"] for one in channels.values()} == {"cdr"}
    assert {one["schemaEncoding"] for one in channels.values()} == {"ros2msg"}
    scan = first_of(client, channels["/scan"])
    laser = live.robot.profile.laser
    assert laser is not None and len(scan.ranges) == laser.beams and (scan.ranges > 0).mean() > 0.5
    picture = first_of(client, channels["/camera/image/compressed"])
    assert picture.format == "jpeg" and bytes(picture.data[:2]) == b"\xff\xd8"


def test_what_a_robot_sends_is_announced_before_a_client_can_ask_for_it(live: Live, client: ClientConnection) -> None:
    encoder = RosEncoder(live.robot.profile.lasers, live.robot.profile.cameras)
    assert json.loads(client.recv(timeout=PATIENCE_S))["op"] == "serverInfo"
    first = json.loads(client.recv(timeout=PATIENCE_S))["channels"]
    assert encoder.topics().items() <= {one["topic"]: one["schemaName"] for one in first}.items()


def test_who_comes_late_gets_the_map_and_the_mounting_at_once(live: Live, client: ClientConnection) -> None:
    channels = channels_of(client, {"/map", "/tf_static", "/camera/camera_info"})
    fixed = first_of(client, channels["/tf_static"])
    assert {one.child_frame_id for one in fixed.transforms} >= {"camera"}
    while not len((grid := first_of(client, channels["/map"])).data):  # the robot may just wake up
        pass
    assert grid.info.width * grid.info.height == len(grid.data) > 0


PUBLISHED = struct.pack("<BI", 1, 77) + b"{}"
CALLED = struct.pack("<BIII", 2, 1, 1, 4) + b"json{}"


@pytest.mark.parametrize(
    "asked",
    [
        {"op": "advertise", "channels": [{"id": 77, "topic": "/cmd_vel", "encoding": "json", "schemaName": "any"}]},
        PUBLISHED,
        {"op": "setParameters", "parameters": [{"name": "limits.v", "value": 9}]},
        {"op": "getParameters", "parameterNames": ["limits.v"], "id": "1"},
        CALLED,
        {"op": "subscribeConnectionGraph"},
        {"op": "fetchAsset", "uri": "package://a/b.dae", "requestId": 1},
    ],
)
def test_whatever_a_client_publishes_sets_or_calls_is_refused(
    live: Live, client: ClientConnection, asked: Any
) -> None:
    hello = json.loads(client.recv(timeout=PATIENCE_S))
    assert hello["op"] == "serverInfo" and hello["capabilities"] == []
    client.send(asked if isinstance(asked, bytes) else json.dumps(asked))
    while True:
        said = json.loads(client.recv(timeout=PATIENCE_S))
        if said["op"] != "advertise":
            break
    assert said["op"] in ("status", "serviceCallFailure", "fetchAssetResponse"), said
    assert said.get("level", 2) == 2 and "parameters" not in said
    assert not any(one.v or one.w for one in live.robot.orders)


def test_without_the_package_the_sentence_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(foxglove_server.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(Unavailable, match="extra foxglove"):
        check(Options(foxglove=8765))


def test_a_port_that_is_taken_or_is_none_is_refused_before_anything_starts() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken, pytest.raises(BadInput, match="Take another port"):
        check(Options(foxglove=taken.getsockname()[1]))
    for port in (0, -1, 70_000):
        with pytest.raises(BadInput, match="1 to 65535"):
            check(Options(foxglove=port))
