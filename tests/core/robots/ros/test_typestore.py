"""One robot's message types, on bytes that are known."""

import pytest

from core.gate import Twist
from core.recording.ros_sound import RAW_AUDIO
from core.robots.ros.typestore import BOOL, TWIST, TWIST_STAMPED, RobotTypes

HEADER = bytes.fromhex("00010000")
SPEEDS = bytes.fromhex("9a9999999999b93f") + bytes(32) + bytes.fromhex("000000000000e03f")


def speeds_of(types: RobotTypes, name: str, twist: Twist, frame: str = "") -> bytes:
    return types.encode(name, types.speeds(name, twist, frame))


def test_speeds_are_the_bytes_that_robots_know_with_stamp_0() -> None:
    types = RobotTypes()
    assert speeds_of(types, TWIST, Twist(0.1, 0.5)) == HEADER + SPEEDS
    frame = bytes.fromhex("0a000000626173655f6c696e6b00") + bytes(2)
    assert speeds_of(types, TWIST_STAMPED, Twist(0.1, 0.5), "base_link") == HEADER + bytes(8) + frame + SPEEDS
    assert types.encode(BOOL, types.flag(True)) == bytes.fromhex("0001000001")


def test_ros_1_has_no_encapsulation_and_numbers_its_headers() -> None:
    types = RobotTypes("ros1")
    assert speeds_of(types, TWIST, Twist(0.1, 0.5)) == SPEEDS
    assert speeds_of(types, TWIST_STAMPED, Twist(0.1, 0.5)) == bytes(16) + SPEEDS


def test_a_type_that_the_robot_brings_along_is_decoded() -> None:
    types = RobotTypes()
    assert types.register(
        "own_msgs/msg/Level", "float32 level\nown_msgs/Unit unit\n" + "=" * 80 + "\nMSG: own_msgs/Unit\nuint8 code"
    )
    assert types.decode("/level", "own_msgs/msg/Level", HEADER + bytes.fromhex("0000803f07")).unit.code == 7


@pytest.mark.parametrize(
    ("name", "text", "form", "why"),
    [
        ("a/msg/B", "garbage $$", "ros2msg", "cannot be read"),
        ("a/msg/B", "float32 x", "protobuf", "unknown form"),
        ("a/msg/B", "x" * 2_000_000, "ros2msg", "too long"),
        ("a/msg/B", "module c { struct D { float x; }; };", "ros2idl", "of another type"),
        ("geometry_msgs/msg/Twist", "float32 x", "ros2msg", "cannot be read"),
    ],
)
def test_a_type_that_cannot_be_used_is_skipped_with_a_reason(name: str, text: str, form: str, why: str) -> None:
    types = RobotTypes()
    types.borrow("geometry_msgs/msg/Twist")
    assert not types.register(name, text, form)
    assert why in types.skipped[name]


def test_robots_do_not_share_types() -> None:
    one, other = RobotTypes(), RobotTypes()
    assert one.register("a/msg/B", "float32 x") and other.register("a/msg/B", "uint8 y")


def test_bytes_that_are_no_message_are_counted_by_topic() -> None:
    types = RobotTypes()
    types.borrow(TWIST)
    whole = speeds_of(types, TWIST, Twist(0.1, 0.5))
    for damaged in (b"", whole[:20], whole + b"more"):
        assert types.decode("/cmd_vel", TWIST, damaged) is None
    assert types.errors == {"/cmd_vel": 3}


def test_types_outside_the_usual_collections_are_known() -> None:
    types = RobotTypes()
    assert types.borrow(RAW_AUDIO) and "uint32 sample_rate" in types.definition(RAW_AUDIO)
    assert not types.borrow("own_msgs/msg/Level") and types.definition("own_msgs/msg/Level") == ""
