"""Which of a robot's topics are used, and for what."""

import pytest

from core.errors import BadInput, Unavailable
from core.robots.ros.topics import RosSettings, choose_topics
from core.robots.ros.typestore import TWIST, TWIST_STAMPED

TURTLEBOT = [
    ("/scan", "sensor_msgs/msg/LaserScan"),
    ("/odom", "nav_msgs/msg/Odometry"),
    ("/camera/image_raw", "sensor_msgs/msg/Image"),
    ("/camera/image_raw/compressed", "sensor_msgs/msg/CompressedImage"),
    ("/camera/image_raw/compressedDepth", "sensor_msgs/msg/CompressedImage"),
    ("/camera/camera_info", "sensor_msgs/msg/CameraInfo"),
    ("/depth/camera_info", "sensor_msgs/msg/CameraInfo"),
    ("/battery_state", "sensor_msgs/msg/BatteryState"),
    ("/tf_static", "tf2_msgs/msg/TFMessage"),
    ("/map", "nav_msgs/msg/OccupancyGrid"),
    ("/local_costmap/costmap", "nav_msgs/msg/OccupancyGrid"),
    ("/amcl_pose", "geometry_msgs/msg/PoseWithCovarianceStamped"),
    ("/cmd_vel", TWIST),
    ("/microphone", "foxglove_msgs/msg/RawAudio"),
    ("/rosout", "rcl_interfaces/msg/Log"),
]


def test_a_usual_robot_needs_no_settings() -> None:
    topics = choose_topics(TURTLEBOT, RosSettings())
    assert topics.scans == ("/scan",)
    assert (topics.odometry, topics.battery, topics.map) == ("/odom", "/battery_state", "/map")
    assert (topics.image, topics.camera_info) == ("/camera/image_raw/compressed", "/camera/camera_info")
    assert (topics.pose, topics.sound, topics.frames) == ("/amcl_pose", "/microphone", "/tf_static")
    assert (topics.cmd_vel, topics.cmd_vel_type) == ("/cmd_vel", TWIST)
    assert topics.types["/camera/image_raw/compressed"] == "sensor_msgs/msg/CompressedImage"
    assert {"/map", "/amcl_pose", "/scan"} <= set(topics.read) and topics.goal == "/goal_pose"


def test_ros_1_names_of_types_are_the_same_types() -> None:
    topics = choose_topics([("/base_scan", "sensor_msgs/LaserScan"), ("/tf_static", "tf/tfMessage")], RosSettings())
    assert topics.scans == ("/base_scan",) and topics.frames == "/tf_static"


def test_two_lasers_are_two_and_a_filtered_scan_is_none_of_its_own() -> None:
    kind = "sensor_msgs/msg/LaserScan"
    both = choose_topics([("/front/scan", kind), ("/rear/scan", kind), ("/rear/scan_filtered", kind)], RosSettings())
    assert both.scans == ("/rear/scan", "/front/scan") or both.scans == ("/front/scan", "/rear/scan")
    one = choose_topics([("/scan_filtered", kind), ("/scan", kind), ("/merged/scan", kind)], RosSettings())
    assert one.scans == ("/scan",) and "lasers are taken to be /scan" in one.notices[0]


def test_the_type_of_speeds_comes_from_the_robot_and_settings_overrule_it() -> None:
    assert choose_topics([("/cmd_vel", TWIST_STAMPED)], RosSettings()).cmd_vel_type == TWIST_STAMPED
    both = [("/cmd_vel", TWIST_STAMPED), ("/cmd_vel", TWIST)]
    assert "set cmd_vel_type" in choose_topics(both, RosSettings()).notices[0]
    assert choose_topics(both, RosSettings.of({"cmd_vel_type": "Twist"})).cmd_vel_type == TWIST
    unknown = choose_topics([], RosSettings())
    assert unknown.cmd_vel_type == TWIST and "/cmd_vel" in unknown.notices[0]


def test_speeds_go_where_someone_listens() -> None:
    found = [("/cmd_vel", TWIST), ("/diff_drive_controller/cmd_vel", TWIST_STAMPED)]
    heard = choose_topics(found, RosSettings(), listeners={"/diff_drive_controller/cmd_vel"})
    assert (heard.cmd_vel, heard.cmd_vel_type) == ("/diff_drive_controller/cmd_vel", TWIST_STAMPED)


def test_settings_choose_and_a_topic_that_is_not_there_is_a_sentence() -> None:
    chosen = RosSettings.of({"scan": "/front/scan", "image": "none", "cmd_vel": "/tab_vel", "lock": "/stop_lock"})
    found = [*TURTLEBOT, ("/front/scan", "sensor_msgs/msg/LaserScan")]
    topics = choose_topics(found, chosen)
    assert (topics.scans, topics.image, topics.camera_info) == (("/front/scan",), "", "")
    assert (topics.cmd_vel, topics.lock) == ("/tab_vel", "/stop_lock")
    with pytest.raises(Unavailable, match="no topic /front/scan of type LaserScan; of this type it has /scan"):
        choose_topics(TURTLEBOT, chosen)


def test_a_robot_in_a_namespace_is_left_in_it() -> None:
    found = [(f"/{name}{topic}", kind) for name in ("one", "two") for topic, kind in TURTLEBOT]
    topics = choose_topics(found, RosSettings.of({"namespace": "two", "odometry": "odom"}))
    assert (topics.scans, topics.odometry, topics.cmd_vel) == (("/two/scan",), "/two/odom", "/two/cmd_vel")
    assert topics.frames == "/two/tf_static"


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"scam": "/scan"}, "no setting 'scam'"),
        ({"odometry": 3}, "odometry is the name of a topic"),
        ({"cmd_vel": "a b"}, "cmd_vel is the name"),
        ({"scan": ["/a", "/b", "/c"]}, "or a list of two"),
        ({"array": "nobodys"}, "array profile nobodys cannot be read"),
        ({"cmd_vel_type": "twist"}, "Twist or TwistStamped"),
    ],
)
def test_settings_that_are_none_are_refused_in_words(fields: dict[str, object], words: str) -> None:
    with pytest.raises(BadInput, match=words):
        RosSettings.of(fields)


def several(*spaces: str, leaves: tuple[str, ...] = ("scan", "odom", "cmd_vel")) -> list[tuple[str, str]]:
    kinds = {"scan": "sensor_msgs/msg/LaserScan", "odom": "nav_msgs/msg/Odometry", "cmd_vel": TWIST}
    return [(f"{space}/{leaf}", kinds[leaf]) for space in spaces for leaf in leaves]


@pytest.mark.parametrize(
    ("found", "listeners"),
    [
        (several("/robot1", "/robot2"), None),
        (several("/robot1", "/robot2"), {"/robot2/cmd_vel"}),
        (several("/lab/a", "/lab/b", "/lab/c"), None),
        (several("", "/robot2"), None),
        (several("/one", "/two", leaves=("scan", "cmd_vel")), None),
        (several("/robot1", "/robot2", leaves=("scan", "odom")), {"/robot1/cmd_vel", "/robot2/cmd_vel"}),
    ],
)
def test_with_several_robots_nothing_is_driven_and_all_that_is_read_is_of_one(found, listeners) -> None:
    topics = choose_topics(found, RosSettings(), listeners)
    assert topics.cmd_vel == "" and "several robots" in topics.notices[0] and "?namespace=" in topics.notices[0]
    spaces = {topic.rpartition("/")[0] for topic in (*topics.scans, topics.odometry) if topic}
    assert len(spaces) == 1
    chosen = next(space for space in {topic.rpartition("/")[0] for topic, _ in found} if space)
    named = choose_topics(found, RosSettings(namespace=chosen), listeners)
    assert named.cmd_vel == f"{chosen}/cmd_vel" and all(topic.startswith(chosen) for topic in named.scans)


@pytest.mark.parametrize(
    "found",
    [
        several("", leaves=("odom", "cmd_vel")) + several("/front", "/rear", leaves=("scan",)),
        several("", leaves=("odom", "scan")) + several("/joy", "/nav", leaves=("cmd_vel",)),
        several("") + several("/diff_drive_controller", leaves=("odom", "cmd_vel")),
        several("/tb4"),
    ],
)
def test_sensors_and_controllers_of_one_robot_in_namespaces_are_no_other_robots(found) -> None:
    topics = choose_topics(found, RosSettings())
    assert topics.cmd_vel and not any("several robots" in one for one in topics.notices)


def test_frames_and_goals_are_looked_for_beside_the_topics_of_the_one_robot() -> None:
    found = [*several("/tb4"), ("/tb4/tf_static", "tf2_msgs/msg/TFMessage"), ("/tb4/tf", "tf2_msgs/msg/TFMessage")]
    topics = choose_topics([*found, ("/tb4/map", "nav_msgs/msg/OccupancyGrid")], RosSettings())
    assert (topics.frames, topics.moving_frames, topics.goal) == ("/tb4/tf_static", "/tb4/tf", "/tb4/goal_pose")
