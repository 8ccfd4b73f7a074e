"""Robots behind foxglove_bridge: the protocol, in both dialects, with ROS 1 and 2, and with damaged messages."""

import json
import math
import os
import shutil
import socket
import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from core.errors import BadInput, Unavailable
from core.gate import ZERO, Twist
from core.robots.foxglove import FoxgloveRobot, open_device
from core.robots.ros.topics import CAMERA_INFO, LASER_SCAN, ODOMETRY
from core.robots.ros.typestore import TF, TWIST, TWIST_STAMPED
from core.sensors import Scan
from tests.console.test_tls import certificate
from tests.core.recording.log_writers import ROS1, one
from tests.core.robots.links import frames, is_up, live, memory, no_leak, until
from tests.emulators.foxglove import FoxgloveEmulator
from tests.emulators.ros_messages import RosMessageMaker
from tests.emulators.small_foxglove import SmallFoxglove
from tests.emulators.world import World

FUZZ = int(os.environ.get("BECKON_FUZZ", "400"))  # damaged messages; 100000 by hand
MAKER = RosMessageMaker(1_700_000_000.0)


def definition(kind: str) -> tuple[str, str, str]:
    return kind, str(MAKER.store.generate_msgdef(kind, ros_version=2)[0]), "ros2msg"


SCAN_CHANNEL = ("/scan", *definition(LASER_SCAN))


def scan(stamp: float = 0.0) -> bytes:
    return MAKER.scan(Scan(stamp=stamp, ranges=np.ones(90, np.float32), angle_min=-0.5, angle_step=0.01))


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> Iterator[SmallFoxglove]:
    monkeypatch.setattr("core.robots.ros.socket_link.LEARNING_TIMEOUT_S", 1.0)
    server = SmallFoxglove([SCAN_CHANNEL, ("/cmd_vel", *definition(TWIST))])
    server.on_subscribed = lambda one: one.log(1, scan())
    yield server
    server.stop()


def device_of(url: str, options: str = "") -> FoxgloveRobot:
    device = open_device(url.removeprefix("foxglove:") + options)
    assert isinstance(device, FoxgloveRobot)
    return device


@pytest.mark.parametrize("dialect", ["foxglove.sdk.v1", "foxglove.websocket.v1"])
def test_both_dialects_are_spoken(small: SmallFoxglove, dialect: str) -> None:
    small.dialect = dialect
    small.start()
    with live(device_of(small.url)) as robot:
        frames(robot, 0.1, Twist(0.1, 0.5))
        until(lambda: small.published)
        assert robot.profile.laser is not None and robot.profile.laser.beams == 90
    assert set(small.subscriptions) == {1}  # not to the channel of speeds
    topic, payload = small.published[0]
    vector = bytes.fromhex("00010000 9a9999999999b93f") + bytes(32) + bytes.fromhex("000000000000e03f")
    assert topic == "/cmd_vel" and payload == vector
    own = small.advertised[1]
    assert (own["encoding"], own["schemaName"], own["schemaEncoding"]) == ("cdr", TWIST, "ros2msg")
    assert "Vector3  linear" in own["schema"] or "Vector3 linear" in own["schema"]


def test_a_stamped_type_is_taken_from_the_robot_and_stamped_0(small: SmallFoxglove) -> None:
    small.channels = [SCAN_CHANNEL, ("/cmd_vel", *definition(TWIST_STAMPED))]
    small.start()
    with live(device_of(small.url, "?base_frame=base_link")) as robot:
        frames(robot, 0.1, Twist(0.1, 0.5))
        until(lambda: small.published)
    head = bytes.fromhex("00010000") + bytes(8) + bytes.fromhex("0a000000626173655f6c696e6b000000")
    assert small.published[0][1][: len(head)] == head and len(small.published[0][1]) == 76


def test_a_robot_with_ros_1_gets_its_own_bytes(small: SmallFoxglove) -> None:
    kind = "sensor_msgs/LaserScan"
    text = ROS1.generate_msgdef(LASER_SCAN, ros_version=1)[0]
    small.encoding, small.channels = "ros1", [("/scan", kind, text, "ros1msg")]
    message = one.scan(0.0, np.ones(45))
    small.on_subscribed = lambda server: server.log(1, bytes(ROS1.serialize_ros1(message, LASER_SCAN)))
    small.start()
    with live(device_of(small.url)) as robot:
        frames(robot, 0.1, Twist(0.1, 0.5))
        until(lambda: small.published)
        assert robot.profile.laser is not None and robot.profile.laser.beams == 45
    assert small.advertised[1]["schemaName"] == "geometry_msgs/Twist"
    assert small.published[0][1] == struct.pack("<6d", 0.1, 0, 0, 0, 0, 0.5)


def test_a_type_that_cannot_be_read_is_left_out_with_a_sentence(small: SmallFoxglove) -> None:
    small.channels = [SCAN_CHANNEL, ("/odom", ODOMETRY, "garbage $$", "ros2msg"), ("/x", "a/msg/B", "?", "protobuf")]
    small.start()
    with live(device_of(small.url)) as robot:
        notes: list[str] = []
        words = "nav_msgs/msg/Odometry is not read: its definition cannot be read."
        until(lambda: bool(notes.extend(robot.read().notes)) or words in " ".join(notes))
        assert set(small.subscriptions) == {1}


def test_a_topic_that_comes_back_under_another_number_is_subscribed_to_again(small: SmallFoxglove) -> None:
    small.start()
    with live(device_of(small.url)) as robot:
        small.say({"op": "unadvertise", "channelIds": [1]})
        small.say(small.advertisement({7: SCAN_CHANNEL}))
        until(lambda: 7 in small.subscriptions)
        frames(robot, 0.1)
        small.log(7, scan(5.0))
        until(lambda: robot.read().scan is not None)


def test_what_the_bridge_has_to_say_reaches_the_operator_once(small: SmallFoxglove) -> None:
    small.start()
    with live(device_of(small.url)) as robot:
        for level, sentence in ((0, "hello"), (2, "no camera"), (2, "no camera")):
            small.say({"op": "status", "level": level, "message": sentence})
        notes = " ".join(note for frame in frames(robot, 0.4) for note in frame.notes)
        assert notes.count("The robot's bridge says: no camera") == 1 and "hello" not in notes


def test_a_bridge_that_takes_no_speeds_is_a_robot_that_only_shows(small: SmallFoxglove) -> None:
    small.capabilities = ()
    small.start()
    device = device_of(small.url)
    with live(device) as robot:
        assert device.topics is not None and device.topics.cmd_vel == ""
        read = frames(robot, 0.2, Twist(0.1, 0.0))
        assert "cannot be driven" in " ".join(note for frame in read for note in frame.notes)
    assert small.published == [] and small.advertised == {}


def test_speeds_go_where_the_connection_graph_has_a_listener(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("core.robots.ros.socket_link.LEARNING_TIMEOUT_S", 0.3)
    emulator = FoxgloveEmulator(World(), listens=("/base/cmd_vel",), cmd_vel_type=TWIST_STAMPED)
    emulator.start()
    device = device_of(emulator.url)
    with live(device):
        assert device.topics is not None
        assert (device.topics.cmd_vel, device.topics.cmd_vel_type) == ("/base/cmd_vel", TWIST_STAMPED)
    emulator.stop()


@pytest.mark.parametrize(
    ("rest", "words"),
    [
        ("", "looks like //192.168.0.7:8765"),
        ("host:8765", "looks like"),
        ("//host:badport", "looks like"),
        ("//host/path", "looks like"),
        ("//user@host", "looks like"),
        ("//host?tls=maybe", "tls is 1"),
        ("//host?colour=red", "no setting 'colour'"),
        ("//host?scan", "looks like"),
        ("//host?odometry=a b", "odometry is the name"),
    ],
)
def test_an_address_that_is_none_is_refused_in_words(rest: str, words: str) -> None:
    with pytest.raises(BadInput, match=words):
        open_device(rest)


def test_settings_come_from_the_address() -> None:
    device = open_device("//[::1]?scan=/front/scan&cmd_vel=%2Ftab_vel")
    assert isinstance(device, FoxgloveRobot)
    assert device.address.name == "[::1]:8765"
    assert (device.address.settings.scan, device.address.settings.cmd_vel) == (("/front/scan",), "/tab_vel")


def test_nobody_there_and_someone_else_there_are_sentences(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("core.robots.ros.socket_link.CONNECT_TIMEOUT_S", 1.0)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
        with pytest.raises(Unavailable, match=r"No foxglove bridge at 127\.0\.0\.1.*refused.*ros2 launch"):
            open_device(f"//127.0.0.1:{port}").open()
        free.listen()
        with pytest.raises(Unavailable, match="is no foxglove bridge"), no_leak():
            open_device(f"//127.0.0.1:{port}").open()


def test_a_robot_without_topics_is_a_sentence(small: SmallFoxglove, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("core.robots.ros.socket_link.LISTING_TIMEOUT_S", 1.0)
    small.channels = []
    small.start()
    device = device_of(small.url)
    with pytest.raises(Unavailable, match="are the robot's nodes running"):
        device.open()
    device.close()


@pytest.mark.skipif(shutil.which("openssl") is None, reason="a certificate needs openssl: apt install openssl")
def test_an_encrypted_bridge_is_checked_by_its_certificate(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("core.robots.ros.socket_link.LEARNING_TIMEOUT_S", 0.3)
    made, key = certificate(tmp_path)
    emulator = FoxgloveEmulator(World(), tls=(made.read_bytes(), key.read_bytes()))
    emulator.start()
    with live(device_of(emulator.url, f"?tls=1&ca={made}")) as robot:
        until(lambda: "/scan" in emulator.subscribed)
        assert is_up(robot)
    with pytest.raises(Unavailable, match="cannot be encrypted"):
        device_of(emulator.url, "?tls=1").open()
    with pytest.raises(BadInput, match="no such file"):
        device_of(emulator.url, "?tls=1&ca=nowhere.pem").open()
    emulator.stop()


@pytest.mark.skipif(shutil.which("openssl") is None, reason="a certificate needs openssl: apt install openssl")
def test_an_address_stands_for_a_robot_whose_certificate_bears_the_name_that_was_asked_for(tmp_path: Path) -> None:
    made, key = certificate(tmp_path, "DNS:robot.lan")
    emulator = FoxgloveEmulator(World(), tls=(made.read_bytes(), key.read_bytes()))
    emulator.start()

    def connect(certified: str) -> None:
        device_of(emulator.url, f"?tls=1&ca={made}{certified}")._connected().close()

    connect("&tls_name=robot.lan")
    for certified in ("", "&tls_name=other.lan", "&tls_name=127.0.0.1"):
        with pytest.raises(Unavailable, match="cannot be encrypted"):
            connect(certified)
    emulator.stop()


def damaged(number: int, rng: np.random.Generator) -> str | bytes:
    """A message as a broken or hostile robot may send it."""
    channels = {1: scan(0.1 * number), 2: MAKER.frames(), 3: MAKER.camera_info(0.0)}
    channel = int(rng.integers(1, 4))
    binary = bytearray(struct.pack("<BIQ", 1, channel, 0) + channels[channel])
    text = json.dumps({"op": "advertise", "channels": [{"id": 9, "topic": "/scan", "encoding": "cdr"}]})
    match number % 8:
        case 0:
            return bytes(binary[: rng.integers(len(binary))])
        case 1 | 2:
            for at in rng.integers(0, len(binary), 4):
                binary[at] = rng.integers(256)
            return bytes(binary)
        case 3:
            return rng.bytes(int(rng.integers(200)))
        case 4:
            return text[: rng.integers(len(text))]
        case 5:
            op = ["serverInfo", "advertise", "status", "unadvertise", "connectionGraphUpdate", "?", 3, None][
                int(rng.integers(8))
            ]
            junk = [None, 3, "x", [], {}, [None], [3], [{}], math.inf, {"a": []}][int(rng.integers(10))]
            names = ("channels", "capabilities", "level", "message", "channelIds", "subscribedTopics")
            return json.dumps({"op": op} | dict.fromkeys(names, junk))
        case 6:
            return json.dumps([None, 3, "x", [], [[]] * 3, math.nan][int(rng.integers(6))])
        case _:
            return "[" * int(rng.integers(1, 5000))


def test_damaged_messages_end_nothing_move_nothing_and_take_no_memory(small: SmallFoxglove) -> None:
    small.channels = [
        SCAN_CHANNEL,
        ("/tf_static", *definition(TF)),
        ("/camera_info", *definition(CAMERA_INFO)),
        ("/cmd_vel", *definition(TWIST)),
    ]
    small.start()
    device, rng = device_of(small.url), np.random.default_rng(11)
    with live(device) as robot:
        frames(robot, 0.1, ZERO)
        before = 0.0
        for number in range(FUZZ):
            small.say(damaged(number, rng))
            if number % 50 == 0:
                frames(robot, 0.001, ZERO)
            if number == FUZZ // 4:
                before = memory()
        until(lambda: device.unreadable > FUZZ // 3, 60.0)
        assert memory() - before < 20.0
        assert is_up(robot) and len(small.clients) == 1
        small.say(small.advertisement({1: SCAN_CHANNEL}))
        until(lambda: small.log(1, scan(1e5)) or robot.read().scan is not None)
        assert small.published == []


@pytest.mark.parametrize(("told", "failsafe", "warned"), [(0.3, 0.3, False), (0.0, None, True)])
def test_when_the_base_stops_by_itself_the_robots_own_parameters_say(
    told: float, failsafe: float | None, warned: bool
) -> None:
    world = World()
    emulator = FoxgloveEmulator(world, capabilities=("ClientPublish", "ConnectionGraph", "Parameters"))
    emulator.parameters = {"/camera.exposure": 3.0, "/diff_drive_controller.cmd_vel_timeout": told}
    emulator.start()
    world.start()
    device = device_of(emulator.url)
    try:
        base = device.open().base
        assert base is not None and (base.failsafe, base.failsafe_words) == (failsafe, "")
        assert device.sensors is not None
        assert any("cmd_vel_timeout = 0" in notice for notice in device.sensors.notices) is warned
    finally:
        device.close()
        emulator.stop()
        world.stop()
