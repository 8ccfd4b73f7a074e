"""What was found on a robot, and the robot file that is made of it."""

import math
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.errors import BadInput
from core.geometry import Transform
from core.robots import Profile
from core.robots.connect import connect, parts_of
from core.robots.connection import FoundRobot, ReadConnection, ReadRobotFile, angles_of
from core.robots.device import TopicRole
from core.robots.requests import ReadTruth
from core.robots.robot_file import (
    CameraTable,
    LaserTable,
    MicrophonesTable,
    RobotFile,
    TopicChoice,
    absolute,
    mounting_of,
    parse_robot_file,
    toml_text,
    with_topics,
    without_lock,
)
from core.robots.ros.findings import Traffic, roles_of
from core.robots.ros.topics import RosSettings, choose_topics
from core.robots.ros.typestore import TWIST
from tests.core.robots.links import until
from tests.emulators.foxglove import FoxgloveEmulator
from tests.emulators.serial_base import SerialRobot
from tests.emulators.world import World

SCAN = "sensor_msgs/msg/LaserScan"
FOUND = [("/front/scan", SCAN), ("/scan_filtered", SCAN), ("/odom", "nav_msgs/msg/Odometry"), ("/tab_vel", TWIST)]
NUMBER = st.floats(-9, 9).map(lambda value: round(value, 4))
ANGLE = st.floats(-80, 80)
STREAMS = "/camera/image/compressed, /odom, /scan"  # what the world sends, all by one clock
TEXT = st.text(st.characters(exclude_categories=["Cs"]), max_size=12)
OWN = st.recursive(
    st.one_of(TEXT, st.booleans(), st.integers(-(10**9), 10**9), st.floats(allow_nan=False)),
    lambda inner: st.lists(inner, max_size=3),
    max_leaves=5,
)


def roles(settings: RosSettings, traffic: Traffic | None = None) -> dict[str, TopicRole]:
    topics = choose_topics(FOUND, settings, {"/tab_vel", "/other_cmd_vel"})
    return {one.role: one for one in roles_of(topics, settings, traffic or Traffic())}


def test_every_role_has_its_topics_what_comes_on_them_and_its_alternatives() -> None:
    traffic = Traffic()
    for _ in range(4):
        traffic.note("/front/scan", SimpleNamespace(header=SimpleNamespace(frame_id="/front_laser")))
        time.sleep(0.01)
    found = roles(RosSettings(), traffic)
    (used,) = found["scan"].used
    assert (used.topic, used.type, used.frame) == ("/front/scan", SCAN, "front_laser")
    assert used.rate_hz is not None and 20 < used.rate_hz < 110
    assert used.age_s is not None and used.age_s < 1
    assert [one.topic for one in found["scan"].candidates] == ["/front/scan", "/scan_filtered"]
    assert found["scan"].most == 2 and found["odometry"].most == 1
    assert found["odometry"].used[0].age_s is None  # nothing came
    assert [one.topic for one in found["cmd_vel"].candidates] == ["/tab_vel", "/other_cmd_vel", "/cmd_vel"]


def test_what_is_missing_is_said_and_what_is_switched_off_too() -> None:
    found = roles(RosSettings.of({"odometry": "none"}))
    assert found["odometry"].used == () and found["odometry"].candidates[0].topic == "/odom"
    assert found["odometry"].remark == "The odometry is not used, as it was chosen."
    assert "no laser" not in found["scan"].remark and "no camera" in found["image"].remark
    assert found["camera_info"].remark == ""  # without a camera it is not missed


@given(x=NUMBER, angles=st.tuples(ANGLE, ANGLE, ANGLE))
def test_the_angles_of_a_camera_are_those_of_its_robot_file(x: float, angles: tuple[float, float, float]) -> None:
    table = CameraTable(x=x, y=1.0, z=0.5, yaw_deg=angles[0], pitch_deg=angles[1], roll_deg=angles[2])
    mounting: Transform = mounting_of(x, table)
    assert angles_of(mounting) == pytest.approx([math.radians(angle) for angle in angles], abs=2e-5)


@given(
    own=st.dictionaries(TEXT, OWN, max_size=4),
    sensors=st.dictionaries(TEXT, NUMBER, max_size=2),
    name=TEXT.filter(str.isprintable),
    comment=st.text(st.characters(categories=["L", "Zs"]), max_size=20),
)
def test_a_robot_file_that_is_written_is_read_back(
    own: dict[str, object], sensors: dict[str, float], name: str, comment: str
) -> None:
    lasers = {key: LaserTable(x=value, height=0.2, time_offset=0.1) for key, value in sensors.items()}
    cameras = {key: CameraTable(x=value, yaw_deg=3.0) for key, value in sensors.items()}
    file = RobotFile(url="foxglove://a", name=name, radius=0.2, lasers=lasers, cameras=cameras, robot=own)
    assert parse_robot_file(toml_text(file, comment), "it") == file


def test_a_choice_leaves_the_url_and_stands_in_the_file() -> None:
    url = "foxglove://a:8765?scan=/old&tls=1+scip:///dev/ttyACM0+zenoh://b:7447?battery=/b"
    choices = [
        TopicChoice(role="scan", topics=("/front", "/rear")),
        TopicChoice(role="odometry", topics=()),
        TopicChoice(part=2, role="battery", topics=("/battery",)),
    ]
    file = with_topics(RobotFile(url=url, robot={"lock": "/stop"}), choices, parts_of(url))
    assert file.url == "foxglove://a:8765?tls=1+scip:///dev/ttyACM0+zenoh://b:7447?battery=/battery"
    assert file.robot == {"lock": "/stop", "scan": ["/front", "/rear"], "odometry": "none"}
    looked = without_lock(file, parts_of(file.url + "&lock=/stop&domain=1"))
    assert "lock" not in looked.robot and looked.url == file.url + "&domain=1"
    with pytest.raises(BadInput, match="no such part"):
        with_topics(file, [TopicChoice(part=3, role="scan", topics=())], parts_of(file.url))


def test_a_file_that_moves_keeps_its_calibrations(tmp_path: Path) -> None:
    (tmp_path / "array.toml").touch()
    file = RobotFile(
        cameras={"camera": CameraTable(calibration="camera.yaml")},
        microphones={"a": MicrophonesTable(profile="array.toml"), "b": MicrophonesTable(profile="respeaker")},
        robot={"array": "array.toml", "ca": "missing.pem", "cmd_vel": "array.toml"},
    )
    moved = absolute(file, tmp_path)
    assert moved.cameras["camera"].calibration == str(tmp_path / "camera.yaml")
    assert [one.profile for one in moved.microphones.values()] == [str(tmp_path / "array.toml"), "respeaker"]
    assert moved.robot == {"array": str(tmp_path / "array.toml"), "ca": "missing.pem", "cmd_vel": "array.toml"}


def numbers(profile: Profile) -> list[float]:
    """All that a robot file may say of a robot."""
    found = [
        profile.radius,
        profile.wheelbase,
        profile.cruise,
        profile.max_speed,
        profile.max_turn_rate,
        profile.rate,
    ]
    for laser in profile.lasers:
        at = laser.mounting
        found += [at.x, at.y, at.heading, laser.height, laser.range_min, laser.range_max, laser.rate]
        found += [laser.beams, laser.angle_min, laser.angle_step, laser.time_step, laser.time_offset]
    for camera in profile.cameras:
        model = camera.model
        found += [*camera.mounting.rotation.ravel(), *camera.mounting.translation, camera.rate]
        found += [model.fx, model.fy, model.cx, model.cy, model.k1, model.width, model.height]
    return found


def confirmed(found: FoundRobot, file: RobotFile) -> RobotFile:
    """The file of an operator who agrees with everything."""
    choices = [
        TopicChoice(role=one.role, topics=tuple(topic.topic for topic in one.used))  # type: ignore[arg-type]
        for one in found.parts[0].findings.roles
        if one.role != "frames" and one.used
    ]
    lasers = {
        one.name: LaserTable(x=one.x_m, y=one.y_m, heading_deg=math.degrees(one.heading_rad), height=one.height_m)
        for one in found.lasers
    }
    cameras = {
        one.name: CameraTable(
            x=one.x_m,
            y=one.y_m,
            z=one.z_m,
            yaw_deg=math.degrees(one.yaw_rad),
            pitch_deg=math.degrees(one.pitch_rad),
            roll_deg=math.degrees(one.roll_rad),
        )
        for one in found.cameras
    }
    whole = RobotFile(url=file.url, name=found.name, lasers=lasers, cameras=cameras)
    return with_topics(whole, choices, parts_of(file.url))


def test_a_robot_started_by_its_written_file_has_the_same_profile(tmp_path: Path) -> None:
    world = World()
    emulator = FoxgloveEmulator(world)
    emulator.maker.start = time.time()
    emulator.start()
    world.start()
    try:
        robot = connect(emulator.url)
        until(lambda: robot.ask(ReadConnection()).parts[0].findings.roles[1].used[0].rate_hz)
        until(lambda: [one.clock for one in robot.ask(ReadConnection()).parts[0].findings.clocks] == [STREAMS])
        found, before = robot.ask(ReadConnection()), robot.profile
        file = confirmed(found, robot.ask(ReadRobotFile()))
        with pytest.raises(BadInput, match="understands the requests connection, robot_file and listen"):
            robot.ask(ReadTruth())
        robot.close()
        (part,) = found.parts
        assert part.up and part.drives and part.findings.base_frame == "base_footprint"
        assert [one.mounting for one in (*found.lasers, *found.cameras)] == ["robot", "robot"]
        assert {one.name for one in found.limits if one.origin == "assumed"} >= {"radius", "wheelbase"}
        (clock,) = part.findings.clocks
        assert clock.clock == STREAMS
        assert clock.ahead_s is not None and abs(clock.ahead_s) < 60
        path = tmp_path / "robot.toml"
        path.write_text(toml_text(file))
        again = connect(str(path))
        after, how = again.profile, again.ask(ReadConnection())
        again.close()
    finally:
        world.stop()
        emulator.stop()
    assert numbers(after) == pytest.approx(numbers(before), abs=1e-5)
    assert (after.name, after.url, after.failsafe) == (before.name, before.url, before.failsafe)
    assert (after.odometry, after.capabilities) == (before.odometry, before.capabilities)
    assert np.array_equal([one.name for one in after.lasers], [one.name for one in before.lasers])
    assert [one.mounting for one in (*how.lasers, *how.cameras)] == ["file", "file"]


def test_bare_hardware_is_shown_by_its_parts_and_its_clock() -> None:
    world = World()
    emulator = SerialRobot(world)
    emulator.start()
    world.start()
    try:
        robot = connect(emulator.url)
        until(lambda: robot.ask(ReadConnection()).parts[0].findings.clocks)
        (part,) = robot.ask(ReadConnection()).parts
        robot.close()
    finally:
        world.stop()
        emulator.stop()
    assert part.name == emulator.url.partition("?")[0] and part.drives
    assert part.findings.roles == () and part.lasers == ()
    assert part.findings.clocks[0].clock == "base" and part.findings.clocks[0].ahead_s is None
