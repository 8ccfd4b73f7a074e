"""Robots behind rosbridge: what differs between ROS 1 and 2 and between versions, and damaged messages."""

import builtins
import json
import math
import os
import re
from collections.abc import Iterator
from typing import Any

import cbor2
import numpy as np
import pytest

from core.errors import BadInput, Unavailable
from core.gate import ZERO, Twist
from core.install import install_extra
from core.robots.connection import ReadConnection
from core.robots.ros.typestore import TWIST_STAMPED
from core.robots.rosbridge import RosbridgeRobot, as_fields, open_device
from core.sensors import Scan
from tests.core.robots.links import frames, is_up, live, memory, until
from tests.emulators.rosbridge import RosbridgeEmulator
from tests.emulators.world import World

FUZZ = int(os.environ.get("BECKON_FUZZ", "400"))  # damaged messages; 100000 by hand


def device_of(emulator: RosbridgeEmulator, options: str = "") -> RosbridgeRobot:
    device = open_device(emulator.url.removeprefix("rosbridge:") + options)
    assert isinstance(device, RosbridgeRobot)
    return device


def scan(stamp: float) -> Scan:
    return Scan(stamp=stamp, ranges=np.ones(90, np.float32), angle_min=-0.5, angle_step=0.01)


@pytest.fixture
def emulator(monkeypatch: pytest.MonkeyPatch) -> Iterator[RosbridgeEmulator]:
    """Nothing is sensed but what a test says, and nothing is waited for."""
    monkeypatch.setattr("core.robots.ros.socket_link.LEARNING_TIMEOUT_S", 0.3)
    one = RosbridgeEmulator(World())
    yield one
    one.stop()


@pytest.mark.parametrize(("ros1", "stamp"), [(False, {"sec": 0, "nanosec": 0}), (True, {"secs": 0, "nsecs": 0})])
def test_stamped_speeds_have_the_stamp_0_of_their_ros(
    emulator: RosbridgeEmulator, ros1: bool, stamp: dict[str, int]
) -> None:
    emulator.ros1, emulator.cmd_vel_type = ros1, TWIST_STAMPED
    emulator.start()
    with live(device_of(emulator, "?base_frame=base_link")) as robot:
        frames(robot, 0.1, Twist(0.1, 0.5))
        until(lambda: emulator.commands)
    assert emulator.commands[0]["header"] == {"stamp": stamp, "frame_id": "base_link"}
    assert emulator.received[0][1:] == (0.1, 0.5)


def test_pictures_are_asked_for_at_a_bounded_rate_and_in_their_own_bytes(emulator: RosbridgeEmulator) -> None:
    emulator.start()
    with live(device_of(emulator)):
        until(lambda: "/camera/image/compressed" in emulator.subscribed)
        request = emulator.subscribed["/camera/image/compressed"]
    assert (request["compression"], request["throttle_rate"], request["queue_length"]) == ("cbor-raw", 60, 1)
    assert emulator.subscribed["/scan"]["throttle_rate"] == 0


def test_an_older_rosapi_without_definitions_is_enough(emulator: RosbridgeEmulator) -> None:
    emulator.services = ("/rosapi/topics",)
    emulator.start()
    device = device_of(emulator)
    with live(device) as robot:
        frames(robot, 0.1)
        emulator.log("/scan", emulator.maker.scan(scan(0.0)))
        until(lambda: robot.read().scan is not None)


def test_a_robot_without_rosapi_is_a_sentence(emulator: RosbridgeEmulator) -> None:
    emulator.services = ()
    emulator.start()
    device = device_of(emulator)
    with pytest.raises(Unavailable, match="start its node rosapi, too"):
        device.open()
    device.close()


def test_what_rosbridge_has_to_say_reaches_the_operator_once(emulator: RosbridgeEmulator) -> None:
    emulator.start()
    with live(device_of(emulator)) as robot:
        for level, sentence in (("info", "hello"), ("error", "no topic"), ("error", "no topic")):
            emulator.status(sentence, level)
        notes = " ".join(note for frame in frames(robot, 0.4) for note in frame.notes)
        assert notes.count("The robot's rosbridge says: no topic") == 1 and "hello" not in notes


def test_without_its_package_the_sentence_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def without(name: str, *rest: Any, **more: Any) -> Any:
        if name == "cbor2":
            raise ModuleNotFoundError(name=name)
        return real(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(Unavailable, match=re.escape(install_extra("rosbridge"))):
        open_device("//robot")
    assert open_device("//robot?encoding=json")
    with pytest.raises(BadInput, match="encoding is cbor or json"):
        open_device("//robot?encoding=xml")


def damaged(emulator: RosbridgeEmulator, number: int, rng: np.random.Generator) -> str | bytes:
    """A message as a broken or hostile robot may send it."""
    payload = bytearray(emulator.maker.scan(scan(0.1 * number)) if number % 2 else emulator.maker.frames())
    topic = "/scan" if number % 2 else "/tf_static"
    junk = [None, 3, "x", [], {}, [None], math.inf, {"bytes": 3}, {"bytes": b""}, {"a": []}][int(rng.integers(10))]
    match number // 2 % 6:
        case 0:
            for at in rng.integers(0, len(payload), 4):
                payload[at] = rng.integers(256)
            return cbor2.dumps({"op": "publish", "topic": topic, "msg": {"bytes": bytes(payload)}})
        case 1:
            cut = bytes(payload[: rng.integers(len(payload))])
            return cbor2.dumps({"op": "publish", "topic": topic, "msg": {"bytes": cut}})
        case 2:
            whole = cbor2.dumps({"op": "publish", "topic": topic, "msg": {"bytes": bytes(payload)}})
            return whole[: rng.integers(len(whole))]
        case 3:
            op = ["publish", "service_response", "status", "fragment", None, 3][int(rng.integers(6))]
            return (
                json.dumps({"op": op, "topic": topic, "id": "/rosapi/topics", "level": "error"})
                if (isinstance(junk, dict) and junk)
                else cbor2.dumps({"op": op, "topic": topic, "msg": junk, "values": junk, "result": True})
            )
        case 4:
            return rng.bytes(int(rng.integers(200)))
        case _:
            return "[" * int(rng.integers(1, 5000))


def test_damaged_messages_end_nothing_move_nothing_and_take_no_memory(emulator: RosbridgeEmulator) -> None:
    emulator.start()
    device, rng = device_of(emulator), np.random.default_rng(12)
    with live(device) as robot:
        frames(robot, 0.1, ZERO)
        before = 0.0
        for number in range(FUZZ):
            emulator.say(damaged(emulator, number, rng))
            if number % 50 == 0:
                frames(robot, 0.001, ZERO)
            if number == FUZZ // 4:
                before = memory()
        until(lambda: device.unreadable > FUZZ // 3, 60.0)
        assert memory() - before < 20.0
        assert is_up(robot) and len(emulator.clients) == 1
        until(lambda: emulator.log("/scan", emulator.maker.scan(scan(1e5))) or robot.read().scan is not None)
        assert emulator.received == []


@pytest.mark.parametrize("ros1", [False, True])
def test_damaged_json_ends_nothing_either(emulator: RosbridgeEmulator, ros1: bool) -> None:
    emulator.ros1 = ros1
    emulator.start()
    device, rng = device_of(emulator, "?encoding=json"), np.random.default_rng(13)
    junk = [None, 3, "x", [], {}, [None], [3], math.inf, {"a": []}]
    with live(device) as robot:
        frames(robot, 0.1, ZERO)
        before = 0.0
        for number in range(FUZZ):
            name = ("ranges", "header", "angle_min", "range_max", "transforms", "data")[number % 6]
            content = {"header": {"stamp": {"secs": number}}, name: junk[int(rng.integers(len(junk)))]}
            emulator.say(
                json.dumps({"op": "publish", "topic": list(emulator.subscribed)[number % 6], "msg": content})
            )
            if number % 50 == 0:
                frames(robot, 0.001, ZERO)
            if number == FUZZ // 4:
                before = memory()
        until(lambda: sum(device.types.errors.values()) >= FUZZ // 2, 60.0)
        assert memory() - before < 20.0
        until(lambda: emulator.log("/scan", emulator.maker.scan(scan(1e5))) or robot.read().scan is not None)
        assert is_up(robot) and emulator.received == []


@pytest.mark.parametrize(
    ("unit", "codes"), [(1.0, set[str]()), (1000.0, {"scan.units"}), (100.0, {"scan.units"}), (0.001, {"scan.units"})]
)
def test_ranges_in_another_unit_come_in_metres_and_the_unit_is_named(
    emulator: RosbridgeEmulator, unit: float, codes: set[str]
) -> None:
    emulator.start()
    shown = Scan(
        stamp=0.0,
        ranges=np.linspace(1.7, 4.4, 90, dtype=np.float32) * np.float32(unit),
        angle_min=-0.5,
        angle_step=0.01,
        range_min=0.1 * unit,
        range_max=5.0 * unit,
    )
    with live(device_of(emulator)) as robot:
        until(lambda: "/scan" in emulator.subscribed)
        seen: list[Scan] = []
        found: set[str] = set()
        while not seen or (codes and not found):
            emulator.log("/scan", emulator.maker.scan(shown))
            for frame in frames(robot, 0.1):
                seen += [frame.scan] if frame.scan is not None else []
                found |= {one.code for one in frame.faults if one.code.startswith("scan.")}
        (part,) = robot.ask(ReadConnection()).parts
    assert seen[-1].ranges == pytest.approx(np.linspace(1.7, 4.4, 90), rel=1e-4)
    assert seen[-1].range_max == pytest.approx(5.0)
    assert {one.code for one in part.findings.faults if one.code.startswith("scan.u")} == codes


def test_intensities_in_the_place_of_ranges_never_become_a_scan(emulator: RosbridgeEmulator) -> None:
    emulator.start()
    shown = Scan(stamp=0.0, ranges=np.arange(90.0) % 64 + 1, angle_min=-0.5, angle_step=0.01, range_max=100.0)
    with live(device_of(emulator)) as robot:
        until(lambda: "/scan" in emulator.subscribed)
        emulator.log("/scan", emulator.maker.scan(shown))
        until(
            lambda: "scan.whole_numbers" in {one.code for one in robot.ask(ReadConnection()).parts[0].findings.faults}
        )
        assert all(frame.scan is None for frame in frames(robot, 0.3))


def test_only_data_of_bytes_come_in_base_64() -> None:
    assert as_fields({"data": "robot"}, is_text=True).data == "robot"
    assert as_fields({"data": "AQI="}).data == b"\x01\x02"
