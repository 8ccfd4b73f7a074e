"""Robots on zenoh: in both dialects, lost and found again, encrypted, and with damaged messages."""

import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from core.errors import BadInput, Unavailable
from core.gate import ZERO, Twist
from core.install import install_extra
from core.robots.live import LiveRobot
from core.robots.ros.topics import LASER_SCAN
from core.robots.ros.typestore import TWIST, TWIST_STAMPED
from core.robots.ros.zenoh_keys import attachment, parse_token, publisher_of
from core.robots.ros.zenoh_session import MAX_READING_BYTES, MAX_WAITING_MESSAGES, WaitingMessages
from core.robots.zenoh_link import ZenohRobot, open_device
from core.sensors import Scan, SensorFrame
from tests.console.test_tls import certificate
from tests.core.robots.links import frames, is_up, live, memory, no_leak, until
from tests.emulators.world import World
from tests.emulators.zenoh_robot import ZenohEmulator, free_port, session

FUZZ = int(os.environ.get("BECKON_FUZZ", "400"))  # damaged messages; 100000 by hand
VECTOR = bytes.fromhex("00010000 9a9999999999b93f") + bytes(32) + bytes.fromhex("000000000000e03f")


def device_of(emulator: ZenohEmulator, options: str = "") -> ZenohRobot:
    device = open_device(emulator.url.removeprefix("zenoh:") + options)
    assert isinstance(device, ZenohRobot)
    return device


@contextmanager
def running(**settings: object) -> Iterator[ZenohEmulator]:
    world = World()
    emulator = ZenohEmulator(world, **settings)  # type: ignore[arg-type]
    emulator.start()
    world.start()
    yield emulator
    emulator.stop()
    world.stop()


@pytest.fixture
def emulator() -> Iterator[ZenohEmulator]:
    with running() as one:
        yield one


@pytest.fixture
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Topics are waited for less long."""
    monkeypatch.setattr("core.robots.zenoh_link.LISTING_TIMEOUT_S", 1.0)


def notes_of(robot: LiveRobot, seconds: float) -> str:
    return " ".join(note for frame in frames(robot, seconds) for note in frame.notes)


def timed(true: Callable[[], object], seconds: float) -> float:
    began = time.monotonic()
    until(true, seconds)
    return time.monotonic() - began


def test_speeds_carry_what_a_c_node_asks_for(emulator: ZenohEmulator) -> None:
    with live(device_of(emulator)) as robot:
        frames(robot, 0.3, Twist(0.1, 0.5))
        until(lambda: emulator.frames)
    assert emulator.frames[0] == VECTOR
    assert emulator.strangers == 0 and len(emulator.sequences) >= 10
    assert emulator.sequences == list(range(1, len(emulator.sequences) + 1))


def test_the_robot_s_graph_shows_the_console_while_it_is_there(emulator: ZenohEmulator) -> None:
    own = "/%/%/beckon"

    def shown() -> list[str]:
        return [token for token in emulator.tokens if own in token]

    with live(device_of(emulator)):
        until(lambda: len(shown()) == 9)  # a node, seven sensors, the speeds
        endpoints = {(found.topic, found.publishes) for token in shown() if (found := parse_token(token))}
        assert {("/scan", False), ("/camera/image/compressed", False), ("/cmd_vel", True)} < endpoints
        assert sum("/NN/" in token for token in shown()) == 1
    until(lambda: not shown())


@pytest.mark.parametrize("bridge", [False, True])
def test_a_stamped_type_is_taken_from_the_listener_and_stamped_0(bridge: bool) -> None:
    with running(bridge=bridge, cmd_vel_type=TWIST_STAMPED) as emulator:
        assert emulator.node is not None
        emulator.node.publisher("/cmd_vel", TWIST)  # someone who sends what nobody hears
        with live(device_of(emulator, "?base_frame=base_link")) as robot:
            frames(robot, 0.2, Twist(0.1, 0.5))
            until(lambda: emulator.frames)
    head = bytes.fromhex("00010000") + bytes(8) + bytes.fromhex("0a000000626173655f6c696e6b000000")
    assert emulator.frames[0][: len(head)] == head and len(emulator.frames[0]) == 76


@pytest.mark.parametrize("bridge", [False, pytest.param(True, marks=pytest.mark.campaign)])
def test_one_of_several_robots_is_meant_by_its_namespace(bridge: bool) -> None:
    with running(bridge=bridge, namespace="/robot1") as emulator:
        assert emulator.node is not None
        other: list[object] = []
        emulator.node.listener("/robot2/cmd_vel", TWIST, other.append)
        emulator.node.publisher("/robot2/scan", LASER_SCAN)
        with live(device_of(emulator, "/robot1")) as robot:
            frames(robot, 0.2, Twist(0.1, 0.0))
            until(lambda: emulator.received)
            assert robot.profile.laser is not None and robot.profile.laser.height == pytest.approx(0.12)
        assert other == []
        nowhere = device_of(emulator, "/nowhere")
        with pytest.raises(Unavailable, match="namespace /nowhere; there are: robot1, robot2"):
            nowhere.open()
        nowhere.close()


def test_another_domain_is_another_world(impatient: None) -> None:
    with running(domain=7) as emulator:
        with live(device_of(emulator, "?domain=7")) as robot:
            assert robot.profile.laser is not None
        device = device_of(emulator)
        with pytest.raises(Unavailable, match="knows no topics in domain 0; are the robot's nodes running"):
            device.open()
        device.close()


def test_a_type_of_another_definition_is_left_out_with_a_sentence(
    emulator: ZenohEmulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    emulator.stop()
    usual = emulator.hash_of
    monkeypatch.setattr("core.robots.zenoh_link.LEARNING_TIMEOUT_S", 0.5)
    emulator.hash_of = lambda kind: "RIHS01_" + "0" * 64 if kind == LASER_SCAN else usual(kind)  # type: ignore[method-assign]
    emulator.start()
    with live(device_of(emulator)) as robot:
        notes: list[str] = []
        words = "/scan is not read: the robot's sensor_msgs/msg/LaserScan is not the usual one."
        until(lambda: bool(notes.extend(robot.read().notes)) or words in " ".join(notes))
        assert robot.profile.laser is None and robot.profile.camera is not None


def test_nodes_that_end_are_noticed_while_their_router_stays(emulator: ZenohEmulator) -> None:
    with live(device_of(emulator)) as robot:
        frames(robot, 0.3, ZERO)
        frames(robot, 0.2, Twist(0.1, 0.0))
        emulator.stop_nodes()
        until(lambda: not is_up(robot), 2.0)
        count = len(emulator.received)
        emulator.start_nodes()
        until(lambda: robot.drive(Twist(0.1, 0.0)) or is_up(robot), 15.0)
        frames(robot, 0.3, Twist(0.1, 0.0))
        back = emulator.received[count:]
        assert back and not any(any(one[1:]) for one in back)  # zeros first, and nothing but zeros
        robot.drive(ZERO)
        frames(robot, 0.2, Twist(0.1, 0.0))
        assert emulator.received[-1][1:] == (0.1, 0.0)
        until(lambda: robot.read().scan is not None)


def test_a_base_that_comes_later_is_heard_of(emulator: ZenohEmulator) -> None:
    emulator.stop()
    emulator.puts = {}
    announce, emulator.cmd_vel_type = emulator.cmd_vel_type, TWIST_STAMPED
    emulator.start()
    device = device_of(emulator, "?cmd_vel=/cmd_vel&cmd_vel_type=Twist")
    with live(device) as robot:
        assert "Nothing on the robot listens to /cmd_vel" in notes_of(robot, 0.2)
        frames(robot, 0.2, Twist(0.1, 0.0))
        assert emulator.received == []
        assert emulator.node is not None
        emulator.node.listener("/cmd_vel", announce, emulator._command)  # pyright: ignore[reportPrivateUsage]
        until(lambda: not is_up(robot), 2.0)
        until(lambda: is_up(robot))
        robot.drive(ZERO)
        until(lambda: robot.drive(Twist(0.1, 0.0)) or emulator.received)


def test_a_robot_that_falls_silent_is_lost_although_its_tokens_stay(emulator: ZenohEmulator) -> None:
    with live(device_of(emulator)) as robot:
        frames(robot, 0.5)
        emulator.world.stop()
        read: list[SensorFrame] = []
        assert 1.5 < timed(lambda: read.append(robot.read()) or read[-1].trouble, 5.0) < 3.5
        assert "was lost" in " ".join(note for frame in read for note in frame.notes) + notes_of(robot, 0.3)
        frames(robot, 1.0)
        assert not is_up(robot)  # it answers, but sends nothing
        emulator.world.start()
        until(lambda: is_up(robot), 15.0)
        until(lambda: robot.read().scan is not None)


@contextmanager
def process(port: int) -> Iterator[subprocess.Popen[str]]:
    """The emulated robot as a process of its own, which can be frozen and killed."""
    command = [sys.executable, "-m", "tests.emulators.zenoh_robot", "--port", str(port)]
    child = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert child.stdout is not None and child.stdout.readline().startswith("beckon run --robot zenoh://")
    try:
        yield child
    finally:
        child.kill()
        child.wait()
        child.stdout.close()


def test_a_robot_that_is_frozen_or_killed_is_told_and_comes_back() -> None:
    port = free_port()
    with process(port) as child, live(open_device(f"//127.0.0.1:{port}")) as robot:
        frames(robot, 0.5)
        child.send_signal(signal.SIGSTOP)
        until(lambda: not is_up(robot), 4.0)
        frames(robot, 1.0, Twist(0.1, 0.0))
        child.send_signal(signal.SIGCONT)
        until(lambda: is_up(robot), 15.0)
        frames(robot, 0.5)
        child.kill()
        assert timed(lambda: not is_up(robot), 2.0) < 1.0
        assert robot.read().trouble == "the device does not answer."
        with process(port):
            until(lambda: is_up(robot), 20.0)
            until(lambda: robot.read().scan is not None)


@pytest.mark.parametrize(
    ("rest", "words"),
    [
        ("", "looks like //192.168.0.7:7447/robot1"),
        ("host:7447", "looks like"),
        ("//host:badport", "looks like"),
        ("//user@host", "looks like"),
        ("//host?scan", "looks like"),
        ("//host?tls=maybe", "tls is 1"),
        ("//host?domain=233", "domain is a whole number from 0 to 232"),
        ("//host?domain=-1", "domain is"),
        ("//host?domain=²", "domain is"),
        (f"//host?domain={5000 * '1'}", "domain is"),
        ("//host?colour=red", "no setting 'colour'"),
        ("//host/a b", "namespace is the name"),
        ("//host/**", "namespace is the name"),
        ("//host?ca=nowhere.pem", "ca names a file"),
        (f"//host?cert={__file__}", "cert and key"),
    ],
)
def test_an_address_that_is_none_is_refused_in_words(rest: str, words: str) -> None:
    with pytest.raises(BadInput, match=words):
        open_device(rest)


def test_the_address_says_which_robot_and_which_of_its_topics() -> None:
    device = open_device("//[::1]/fleet/bot1/?scan=/front/scan&domain=3")
    assert isinstance(device, ZenohRobot)
    address = device.address
    assert (address.name, address.domain) == ("[::1]:7447", 3)
    assert (address.settings.scan, address.settings.namespace) == (("/front/scan",), "/fleet/bot1")


def test_nobody_there_and_someone_else_there_are_sentences(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("core.robots.ros.zenoh_session.CONNECT_TIMEOUT_S", 1.0)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        rest = f"//127.0.0.1:{free.getsockname()[1]}"
        with pytest.raises(Unavailable, match=r"No zenoh router at 127.0.0.1.*refused.*rmw_zenohd"):
            open_device(rest).open()
        free.listen()
        began = time.monotonic()
        with pytest.raises(Unavailable, match="does not answer as a zenoh router"):
            open_device(rest).open()
        assert time.monotonic() - began < 5.0


def test_a_router_without_a_robot_is_a_sentence(impatient: None) -> None:
    port = free_port()
    with session("router", listen__endpoints=[f"tcp/127.0.0.1:{port}"]):
        device = open_device(f"//127.0.0.1:{port}")
        with pytest.raises(Unavailable, match="are the robot's nodes running"):
            device.open()
        device.close()


def test_without_the_packages_a_sentence_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    for package in ("zenoh", "xxhash"):
        with monkeypatch.context() as patch:
            patch.setitem(sys.modules, package, None)
            with pytest.raises(Unavailable, match=re.escape(install_extra("fleet"))):
                open_device("//127.0.0.1").open()


def signed_certificate(folder: Path) -> tuple[Path, Path, Path]:
    """An authority's certificate, and one for 127.0.0.1 that it has signed, with its key."""
    authority, authority_key = certificate(folder)
    made, key, request, more = (folder / name for name in ("own.pem", "own.key", "own.csr", "own.ext"))
    more.write_text("subjectAltName=IP:127.0.0.1\nbasicConstraints=CA:FALSE\n")
    wish = ["-newkey", "rsa:2048", "-nodes", "-subj", "/CN=robot", "-keyout", str(key), "-out", str(request)]
    signing = ["-CA", str(authority), "-CAkey", str(authority_key), "-CAcreateserial", "-days", "2"]
    files = ["-in", str(request), "-extfile", str(more), "-out", str(made)]
    subprocess.run(["openssl", "req", *wish], check=True, capture_output=True)
    subprocess.run(["openssl", "x509", "-req", *signing, *files], check=True, capture_output=True)
    return authority, made, key


@pytest.mark.skipif(shutil.which("openssl") is None, reason="a certificate needs openssl: apt install openssl")
def test_an_encrypted_router_and_the_console_know_each_other_by_certificate(tmp_path: Path) -> None:
    authority, made, key = signed_certificate(tmp_path)
    secured = {
        "transport__link__tls__listen_certificate": str(made),
        "transport__link__tls__listen_private_key": str(key),
        "transport__link__tls__root_ca_certificate": str(authority),
        "transport__link__tls__enable_mtls": True,
    }
    with running(router=secured) as emulator:
        with live(device_of(emulator, f"?tls=1&ca={authority}&cert={made}&key={key}")) as robot:
            assert robot.profile.laser is not None
            frames(robot, 0.2, Twist(0.1, 0.0))
            until(lambda: emulator.received)
        for options in ("?tls=1", f"?tls=1&ca={authority}"):
            device = device_of(emulator, options)
            with pytest.raises(Unavailable, match=r"with this certificate|hung up"):
                device.open()
            device.close()


def test_of_every_topic_so_many_messages_wait_and_of_pictures_the_newest() -> None:
    waiting = WaitingMessages()
    waiting.add("/scan", newest_only=False)
    waiting.add("/image", newest_only=True)
    for number in range(100):
        waiting.put("/image", b"%d" % number)
        waiting.put("/scan", b"%d" % number, publisher_of(attachment(number + 1, 0, b"%016d" % number)))
    waiting.put("/scan", bytes(MAX_READING_BYTES + 1))
    arrived = waiting.take(0.0)
    assert [payload for topic, payload, _ in arrived if topic == "/image"] == [b"99"]
    scans = [int(payload) for topic, payload, _ in arrived if topic == "/scan"]
    assert [int(bytes.fromhex(publisher)) for topic, _, publisher in arrived if topic == "/scan"] == scans
    assert scans == list(range(100 - MAX_WAITING_MESSAGES, 100)) and arrived[-2][0] == "/image"
    assert waiting.dropped == 99 + 100 - MAX_WAITING_MESSAGES + 1
    assert waiting.take(0.0) == []


def test_a_robot_that_is_closed_while_it_is_looked_for_is_let_go_of(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("core.robots.ros.zenoh_session.CONNECT_TIMEOUT_S", 1.0)
    with socket.socket() as deaf:
        deaf.bind(("127.0.0.1", 0))
        deaf.listen()
        port = deaf.getsockname()[1]

        def look() -> None:
            with pytest.raises(Unavailable):
                LiveRobot([("it", open_device(f"//127.0.0.1:{port}"))], lambda _: pytest.fail("it is not there"))

        look()  # what zenoh sets up once for the process is no leak
        with no_leak():
            look()


def damaged(payload: bytes, rng: np.random.Generator) -> bytes:
    """A message as a broken or hostile robot may send it."""
    match int(rng.integers(4)):
        case 0:
            return payload[: rng.integers(len(payload))]
        case 1:
            return rng.bytes(int(rng.integers(300)))
        case _:
            changed = bytearray(payload)
            for at in rng.integers(0, min(len(payload), 400), 6):
                changed[at] = rng.integers(256)
            return bytes(changed)


def damaged_token(number: int, rng: np.random.Generator) -> str:
    token = f"@ros2_lv/0/abc/0/{number}/MP/%/%/bot/%scan/sensor_msgs::msg::dds_::LaserScan_/RIHS01_0/::,7:,:,:,,"
    letters = list(token)
    for at in rng.integers(9, len(letters), 4):
        letters[at] = "x%§:,é"[int(rng.integers(6))]
    return "".join(letters)


def test_damaged_messages_end_nothing_move_nothing_and_take_no_memory(emulator: ZenohEmulator) -> None:
    device, rng, before = device_of(emulator), np.random.default_rng(13), 0.0
    maker = emulator.maker
    whole = {
        "/scan": maker.scan(Scan(stamp=0.0, ranges=np.ones(90, np.float32), angle_min=-0.5, angle_step=0.01)),
        "/tf_static": maker.frames(),
        "/camera/camera_info": maker.camera_info(0.0),
        "/battery_state": maker.battery(0.5),
    }
    with live(device) as robot, session("client", connect__endpoints=[f"tcp/127.0.0.1:{emulator.port}"]) as rogue:
        assert emulator.node is not None
        keys = {topic: emulator.node.key(topic, device.topics.types[topic]) for topic in whole}  # type: ignore[union-attr]
        frames(robot, 0.1, ZERO)
        for number in range(FUZZ):
            topic = list(whole)[number % len(whole)]
            attached = rng.bytes(int(rng.integers(40))) if number % 2 else None
            rogue.put(keys[topic], damaged(whole[topic], rng), attachment=attached)
            if number % 40 == 0:
                frames(robot, 0.001, ZERO)
            if number < 200:  # zenoh itself keeps some bytes of every key
                rogue.liveliness().declare_token(damaged_token(number, rng))
            if number == FUZZ // 4:
                before = memory()
        until(lambda: sum(device.types.errors.values()) > FUZZ // 4, 30.0)
        assert memory() - before < 20.0
        until(lambda: is_up(robot), 30.0)
        assert emulator.received == [] and emulator.world.speeds[1:] == []
        until(lambda: robot.read().wheels is not None)
