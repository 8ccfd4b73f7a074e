"""ROS 2 on zenoh: the wire form, by its test vectors."""

import numpy as np
import pytest

from core.robots.ros.zenoh_keys import Endpoint, OwnNode, attachment, endpoint_id, parse_token, topic_key

LASER_HASH = "RIHS01_64c191398013af96509d518dac71d5164f9382553fce5c1f8cca5be7924bd828"
TOKEN = (
    f"@ros2_lv/0/a1b2c3/0/1/MP/%/%robot1/bot/%robot1%scan/sensor_msgs::msg::dds_::LaserScan_/{LASER_HASH}/::,7:,:,:,,"
)
SCAN = Endpoint("/robot1/scan", "sensor_msgs/msg/LaserScan", True, "rmw", LASER_HASH, False, "a1b2c3")


def test_the_identifier_and_the_attachment_are_those_of_the_test_vectors() -> None:
    identifier = bytes.fromhex("cdf9c1fa87abd4da42301aec0205a260")
    assert endpoint_id(TOKEN) == identifier
    raw = attachment(1, 1_700_000_000 * 10**9, identifier)
    assert raw == bytes.fromhex("0100000000000000 00002a36fe9c9717 10") + identifier
    assert len(raw) == 33


def test_a_topic_s_key_has_the_domain_the_type_and_any_hash() -> None:
    key = topic_key("rmw", 0, "/robot1/scan", "sensor_msgs/msg/LaserScan", LASER_HASH)
    assert key == f"0/robot1/scan/sensor_msgs::msg::dds_::LaserScan_/{LASER_HASH}"
    assert topic_key("rmw", 7, "/scan", "std_msgs/msg/Bool") == "7/scan/std_msgs::msg::dds_::Bool_/*"
    assert topic_key("bridge", 7, "/bot1/scan", "std_msgs/msg/Bool") == "bot1/scan"


def test_a_token_says_who_publishes_what() -> None:
    assert parse_token(TOKEN) == SCAN
    assert parse_token(TOKEN + "/zenoh") == SCAN  # newer ones append more
    listener = parse_token(TOKEN.replace("/MP/", "/MS/").replace(LASER_HASH, "TypeHashNotSupported"))
    assert listener == SCAN._replace(publishes=False, hash="TypeHashNotSupported")
    assert parse_token(TOKEN.replace("sensor_msgs::msg::dds_::LaserScan_", "sensor_msgs%msg%LaserScan")) == SCAN
    assert parse_token(TOKEN.replace("::,7", ":1:,1")) == SCAN._replace(latched=True)


@pytest.mark.parametrize(
    ("token", "endpoint"),
    [
        (
            "@/f00/@ros2_lv/MP/bot1§scan/sensor_msgs§msg§LaserScan/:1:0:1,7",
            Endpoint("/bot1/scan", "sensor_msgs/msg/LaserScan", True, "bridge", owner="f00"),
        ),
        (
            "@/f00/@ros2_lv/MP/tf_static/tf2_msgs§msg§TFMessage/:1:1:1,1",
            Endpoint("/tf_static", "tf2_msgs/msg/TFMessage", True, "bridge", latched=True, owner="f00"),
        ),
        (
            "@/f00/@ros2_lv/MS/cmd_vel/geometry_msgs§msg§Twist/K:0:0:1,10:data",
            Endpoint("/cmd_vel", "geometry_msgs/msg/Twist", False, "bridge", owner="f00"),
        ),
    ],
)
def test_a_bridge_s_token_says_it_too(token: str, endpoint: Endpoint) -> None:
    assert parse_token(token) == endpoint


@pytest.mark.parametrize(
    "token",
    [
        "@ros2_lv/0/a1b2c3/0/0/NN/%/%/bot",
        TOKEN.replace("/MP/", "/SS/"),
        TOKEN.replace("%robot1%scan", "%robot1%**"),
        TOKEN.replace("%robot1%scan", "%" + 300 * "a"),
        TOKEN.replace("sensor_msgs::msg::dds_::LaserScan_", "LaserScan"),
        "@/f00/@ros2_lv/SS/bot1§reset/std_srvs§srv§Empty",
        "@/f00/@ros2_lv/MP/*/std_msgs§msg§Bool/::",
        "@",
        "",
    ],
)
def test_other_tokens_are_none_of_a_topic(token: str) -> None:
    assert parse_token(token) is None


def test_damaged_tokens_are_none_or_name_a_topic() -> None:
    rng = np.random.default_rng(5)
    bridge = "@/f00/@ros2_lv/MP/bot1§scan/sensor_msgs§msg§LaserScan/:1:0:1,7"
    read = 0
    for number in range(4000):
        letters = list((TOKEN, bridge)[number % 2])
        for at in rng.integers(0, len(letters), 3):
            letters[at] = "/%§@:*,a\0é"[int(rng.integers(10))]
        endpoint = parse_token("".join(letters[: rng.integers(len(letters) + 1)] if number % 3 else letters))
        if endpoint is not None:
            read += 1
            assert "*" not in endpoint.topic + endpoint.type and endpoint.type.count("/") == 2
    assert read > 100


def test_the_console_s_own_tokens_are_read_by_the_same_rules() -> None:
    node = OwnNode(3, "c0ffee")
    assert node.token == "@ros2_lv/3/c0ffee/0/0/NN/%/%/beckon"
    first = node.endpoint_token("/robot1/scan", SCAN.type, LASER_HASH, publishes=True)
    second = node.endpoint_token("/robot1/scan", SCAN.type, LASER_HASH, publishes=False)
    assert parse_token(first) == SCAN._replace(owner="c0ffee")
    assert parse_token(second) == SCAN._replace(owner="c0ffee", publishes=False)
    assert endpoint_id(first) != endpoint_id(second)
    assert first.startswith("@ros2_lv/3/c0ffee/0/1/MP/") and second.startswith("@ros2_lv/3/c0ffee/0/2/MS/")
