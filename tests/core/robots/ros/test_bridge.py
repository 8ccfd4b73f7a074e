"""A ROS robot's messages → readings, and speeds → messages."""

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest

from core.gate import ZERO, Twist
from core.geometry import OPTICAL, Pose, Transform
from core.recording.ros_pictures import camera_model, describes, is_rectified, raw_pixels
from core.recording.ros_sound import RAW_AUDIO
from core.robots.readings import Readings
from core.robots.ros.bridge import RosClocks, RosSensors, UnmovedBase, VelocityCommands
from core.robots.ros.topics import IMAGE, RosSettings, choose_topics
from core.robots.ros.typestore import TF, RobotTypes
from core.sensors import Image, Scan, Sound, Wheels
from tests.emulators.ros_messages import PROFILE, RosMessageMaker

TOPICS = {
    "/scan": "sensor_msgs/msg/LaserScan",
    "/odom": "nav_msgs/msg/Odometry",
    "/image/compressed": "sensor_msgs/msg/CompressedImage",
    "/camera_info": "sensor_msgs/msg/CameraInfo",
    "/sound": RAW_AUDIO,
    "/battery": "sensor_msgs/msg/BatteryState",
    "/tf_static": TF,
    "/cmd_vel": "geometry_msgs/msg/Twist",
}
START = 1_700_000_000.0


class Wire:
    """Sensors that are given messages, on a clock that a test sets."""

    def __init__(self, **settings: str) -> None:
        self.maker = RosMessageMaker(START)
        self.types = RobotTypes()
        for kind in TOPICS.values():
            self.types.borrow(kind)
        self.sensors = RosSensors(
            self.types, choose_topics(TOPICS.items(), RosSettings.of(settings)), lambda *_: None
        )
        self.clock = 100.0
        self.readings = Readings(lambda: self.clock)

    def take(self, topic: str, payload: bytes) -> None:
        self.sensors.take(topic, payload)

    def scan(self, stamp: float, **changes: object) -> Scan:
        scan = Scan(
            stamp=stamp,
            ranges=np.linspace(1, 2, 90, dtype=np.float32),
            angle_min=-0.5,
            angle_step=0.01,
            time_step=1e-4,
        )
        return replace(scan, **changes)  # type: ignore[arg-type]


def test_what_the_robot_has_is_learnt_from_its_messages() -> None:
    wire = Wire(array="respeaker-odas")
    assert set(wire.sensors.missing) == {"/scan", "/image/compressed", "/camera_info", "/tf_static", "/odom"}
    picture = np.full((256, 320, 3), 90, np.uint8)
    wire.take("/tf_static", wire.maker.frames())
    wire.take("/scan", wire.maker.scan(wire.scan(0.0)))
    wire.take("/image/compressed", wire.maker.image(Image(stamp=0.0, pixels=picture)))
    wire.take("/camera_info", wire.maker.camera_info(0.0))
    wire.take("/odom", wire.maker.odometry(Wheels(odometry=Pose(), speed=0.0, turn_rate=0.0), 0.0))
    assert wire.sensors.missing == []
    found = wire.sensors.equipment("robot")
    laser, camera = found.lasers[0], found.cameras[0]
    assert (laser.beams, laser.rate) == (90, pytest.approx(10.0))
    assert (laser.angle_min, laser.height) == (pytest.approx(-0.5), pytest.approx(0.12))
    assert camera.model.fx == pytest.approx(301.49221) and camera.model.k1 == pytest.approx(-0.43039)
    assert PROFILE.camera is not None
    assert np.allclose(camera.mounting.rotation, OPTICAL)
    assert np.allclose(camera.mounting.translation, PROFILE.camera.mounting.translation)
    assert found.base is not None and found.base.failsafe is None and found.base.odometry
    assert [one.name for one in found.microphones] == ["ReSpeaker 4-mic square, frame of ODAS"]
    assert wire.sensors.notices == []


def test_what_is_missing_is_said_and_the_rest_is_there() -> None:
    wire = Wire()
    wire.take("/scan", wire.maker.scan(wire.scan(0.0)))
    wire.take("/image/compressed", wire.maker.image(Image(stamp=0.0, pixels=np.zeros((128, 160, 3), np.uint8))))
    found = wire.sensors.equipment("robot")
    told = " ".join(wire.sensors.notices)
    assert "/odom is there, but nothing comes on it." in told
    assert found.microphones == () and "microphones of /sound sit is not known" in told
    assert "where laser is mounted" in told and "not calibrated" in told
    assert found.cameras[0].model.width == 160 and found.lasers[0].mounting == Pose()
    wire.sensors.attach(wire.readings)
    assert "not calibrated" in " ".join(wire.readings.frame().notes)


def test_scans_are_stamped_on_the_console_s_clock_and_turned_round() -> None:
    wire = Wire()
    wire.sensors.attach(wire.readings)
    ranges = np.array([0.0, 1.0, 0.01, math.inf, math.nan, 2.0] * 5, np.float32)
    backwards = wire.scan(50.0, ranges=ranges, angle_min=0.5, angle_step=-0.01)
    wire.take("/odom", wire.maker.odometry(Wheels(odometry=Pose(), speed=0.0, turn_rate=0.0), 50.1))
    wire.take("/scan", wire.maker.scan(backwards))
    scan = wire.readings.frame().scan
    assert scan is not None
    assert scan.stamp == pytest.approx(-0.1 + 29 * 1e-4, abs=1e-6)  # now is 0, and odometry came at once
    assert (scan.angle_min, scan.angle_step) == (pytest.approx(0.5 - 0.29), pytest.approx(0.01))
    assert scan.ranges[0] == 2.0 and math.isinf(scan.ranges[2]) and scan.ranges[4] == 1.0
    assert np.isnan(scan.ranges[[1, 3, 5]]).all()
    wire.take("/scan", wire.maker.scan(backwards))
    assert wire.readings.frame().scan is None  # the same once more


def test_no_clock_is_told_while_it_is_only_learnt_what_the_robot_has() -> None:
    """What came then is dated by this computer's time since its start: a robot seemed hours behind."""
    wire = Wire()
    wire.take("/scan", wire.maker.scan(wire.scan(0.0)))
    assert wire.sensors.findings(RosSettings()).clocks == ()
    wire.sensors.attach(wire.readings)
    wire.clock += 1.0
    wire.take("/scan", wire.maker.scan(wire.scan(1.0)))
    (clock,) = wire.sensors.findings(RosSettings()).clocks
    assert clock.offset_s == pytest.approx(-START, abs=0.2)


def test_a_laser_that_hangs_upside_down_is_turned_over() -> None:
    wire = Wire()
    hanging = Transform(rotation=np.diag([1.0, -1.0, -1.0]), translation=np.array([0.1, 0.0, 0.3]))
    stamped = wire.maker.transform("base_link", "laser", hanging)
    wire.take("/tf_static", wire.maker.encode(TF, transforms=[stamped]))
    wire.take("/scan", wire.maker.scan(wire.scan(0.0)))
    laser = wire.sensors.equipment("robot").lasers[0]
    assert laser.angle_min == pytest.approx(0.5 - 0.89) and laser.height == pytest.approx(0.3)
    wire.sensors.attach(wire.readings)
    wire.take("/scan", wire.maker.scan(wire.scan(0.0)))
    scan = wire.readings.frame().scan
    assert scan is not None and scan.ranges[0] == 2.0 and scan.angle_min == pytest.approx(laser.angle_min)


def test_two_lasers_have_names_and_so_have_their_scans() -> None:
    wire = Wire()
    found = [("/front/scan", TOPICS["/scan"]), ("/rear/scan", TOPICS["/scan"])]
    wire.sensors = RosSensors(wire.types, choose_topics(found, RosSettings()), lambda *_: None)
    for topic, _ in found:
        wire.take(topic, wire.maker.scan(wire.scan(0.0)))
    assert {laser.name for laser in wire.sensors.equipment("robot").lasers} == {"front_scan", "rear_scan"}
    wire.sensors.attach(wire.readings)
    for topic, _ in found:
        wire.take(topic, wire.maker.scan(wire.scan(1.0)))
        scan = wire.readings.frame().scan
        assert scan is not None and scan.laser == topic[1:].replace("/", "_")


def test_odometry_begins_where_the_console_connects() -> None:
    wire = Wire()
    wire.sensors.attach(wire.readings)
    for step in range(3):
        wheels = Wheels(odometry=Pose(0.02 * step, 0.0, 0.0), speed=0.4, turn_rate=0.0)
        wire.take("/odom", wire.maker.odometry(wheels, 0.05 * step))
        wire.clock += 0.05
    wheels = wire.readings.frame().wheels
    assert wheels is not None and wheels.speed == pytest.approx(0.4)
    assert wheels.odometry.x == pytest.approx(0.04 + 0.4 * 0.05, abs=1e-6)


def test_blocks_of_sound_follow_each_other_whenever_they_come() -> None:
    wire = Wire()
    wire.sensors.attach(wire.readings)
    rng = np.random.default_rng(1)
    for block in range(10):
        wire.clock = 100.0 + 0.02 * block + float(rng.uniform(0, 0.015))
        sound = Sound(stamp=0.02 * block, rate=16000, samples=np.full((320, 4), 0.25))
        wire.take("/sound", wire.maker.sound(sound))
    sound = wire.readings.frame().sound
    assert sound is not None and sound.samples.shape == (3200, 4) and sound.samples[0, 0] == 0.25


def test_the_battery_is_a_share_even_where_it_is_said_in_per_cent() -> None:
    wire = Wire()
    wire.sensors.attach(wire.readings)
    shares: list[float] = []
    wire.readings.battery = shares.append  # type: ignore[method-assign]
    for said in (0.5, 80.0, math.nan, 1.0, 0.5):
        wire.take("/battery", wire.maker.battery(said))
    assert shares == pytest.approx([0.5, 0.8, 0.01, 0.005])  # the last of a battery in per cent is not a full one


def test_an_odometry_that_is_no_number_leaves_nothing_behind() -> None:
    wire = Wire()
    wire.sensors.attach(wire.readings)
    for step, (x, speed) in enumerate(((1.0, 0.1), (math.nan, 0.1), (1.1, math.nan))):
        wire.clock += 0.05
        wheels = Wheels(odometry=Pose(x, 0.0, 0.0), speed=speed, turn_rate=0.0)
        wire.take("/odom", wire.maker.odometry(wheels, 0.05 * step))
    place, here = wire.sensors.place, wire.sensors.navigation._here
    assert place is not None and here is not None
    assert np.isfinite([*vars(place).values(), *vars(here[1]).values()]).all()
    faults = wire.readings.frame().faults
    assert [one.code for one in faults if one.code.startswith("odometry")] == ["odometry.malformed"]


def test_damaged_messages_are_counted_and_change_nothing() -> None:
    wire = Wire()
    wire.sensors.attach(wire.readings)
    rng = np.random.default_rng(7)
    whole = {
        "/scan": wire.maker.scan(wire.scan(0.0)),
        "/image/compressed": wire.maker.image(Image(stamp=0.0, pixels=np.zeros((128, 160, 3), np.uint8))),
        "/camera_info": wire.maker.camera_info(0.0),
        "/tf_static": wire.maker.frames(),
        "/sound": wire.maker.sound(Sound(stamp=0.0, rate=16000, samples=np.zeros((320, 1)))),
        "/odom": wire.maker.odometry(Wheels(odometry=Pose(), speed=0.0, turn_rate=0.0), 0.0),
    }
    for number in range(2000):
        topic = list(whole)[number % len(whole)]
        damaged = bytearray(whole[topic][: rng.integers(len(whole[topic]) + 1)] if number % 2 else whole[topic])
        for at in rng.integers(0, max(len(damaged), 1), 8) if damaged else ():
            damaged[at] = rng.integers(256)
        wire.clock += 0.01
        wire.take(topic, bytes(damaged))
        wire.readings.frame()
    assert sum(wire.types.errors.values()) >= 1000
    wire.clock += 0.1
    wire.take("/scan", wire.maker.scan(wire.scan(1e6)))
    assert wire.readings.frame().scan is not None


@pytest.mark.parametrize("encoding", ["bgr8", "rgb8", "mono8", "bgra8"])
def test_raw_pictures_become_blue_green_red(encoding: str) -> None:
    make = RosMessageMaker(START)
    channels = {"mono8": 1, "bgra8": 4}.get(encoding, 3)
    rows = np.zeros((4, 6 * channels + 2), np.uint8)  # rows may be padded
    rows[:, : 6 * channels] = np.tile(np.array([200, 30, 10, 255][:channels]), 6)
    content = make.make[IMAGE](
        header=make.header(0.0, "camera"),
        height=4,
        width=6,
        encoding=encoding,
        is_bigendian=0,
        step=rows.shape[1],
        data=rows.ravel(),
    )
    expected = {"mono8": [200, 200, 200], "rgb8": [10, 30, 200]}.get(encoding, [200, 30, 10])
    assert (raw_pixels(content) == np.array(expected)).all()
    with pytest.raises(Exception, match="does not fit"):
        raw_pixels(replace(content, width=60))
    with pytest.raises(Exception, match="are not read"):
        raw_pixels(replace(content, encoding="16UC1"))


def test_a_picture_of_half_the_calibrated_size_has_half_the_focal_length() -> None:
    make = RosMessageMaker(START)
    info = make.store.deserialize_cdr(make.camera_info(0.0), "sensor_msgs/msg/CameraInfo")
    half = camera_model(info, 160, 128)
    assert half is not None and half.fx == pytest.approx(301.49221 / 2)
    assert half.cx == pytest.approx((155.45581 + 0.5) / 2 - 0.5)
    assert camera_model(replace(info, distortion_model="equidistant"), 320, 256) is None
    assert camera_model(replace(info, k=np.zeros(9)), 320, 256) is None


def test_a_model_is_of_the_part_of_the_sensor_that_the_pictures_show_and_of_no_other_shape() -> None:
    make = RosMessageMaker(START)
    info = make.store.deserialize_cdr(make.camera_info(0.0), "sensor_msgs/msg/CameraInfo")
    assert camera_model(info, 320, 180) is None
    region = replace(info.roi, x_offset=40, y_offset=20, width=160, height=128)
    part = camera_model(replace(info, roi=region), 80, 64)  # binned
    assert part is not None and part.fx == pytest.approx(301.49221 / 2)
    assert part.cx == pytest.approx((155.45581 - 40 + 0.5) / 2 - 0.5)


@pytest.mark.parametrize(
    ("topic", "frame", "is_described"),
    [
        ("/left/image_raw", "other", True),
        ("/left/image_raw/compressed", "other", True),
        ("/right/image_raw", "camera_optical_frame", True),
        ("/right/image_raw", "", True),
        ("/right/image_raw", "right_optical", False),
        ("/left/more/image_raw", "right_optical", False),
    ],
)
def test_a_camera_info_describes_the_camera_beside_it_or_that_of_its_frame(
    topic: str, frame: str, is_described: bool
) -> None:
    make = RosMessageMaker(START)
    info = make.store.deserialize_cdr(make.camera_info(0.0), "sensor_msgs/msg/CameraInfo")
    assert describes("/left/camera_info", info, topic, frame) == is_described


def test_rectified_pictures_have_their_projection_and_no_distortion() -> None:
    make = RosMessageMaker(START)
    info = make.store.deserialize_cdr(make.camera_info(0.0), "sensor_msgs/msg/CameraInfo")
    straight = np.array([280.0, 0, 150, 0, 0, 281, 120, 0, 0, 0, 1, 0])
    model = camera_model(replace(info, p=straight, distortion_model="equidistant"), 320, 256, rectified=True)
    assert model is not None and not model.distortion.any()
    assert (model.fx, model.fy, model.cx, model.cy) == (280.0, 281.0, 150.0, 120.0)
    assert is_rectified("/camera/image_rect_color") and not is_rectified("/direct/image_raw")


def test_topics_whose_stamps_agree_share_a_clock_and_a_strange_one_has_its_own() -> None:
    clocks = RosClocks(simulated=False)
    for number in range(50):
        now = 0.1 * number
        assert clocks.stamp("/odom", 1000.0 + now, now + 0.002) == pytest.approx(now + 0.002, abs=1e-4)
        assert clocks.stamp("/scan", 1000.0 + now - 0.1, now + 0.004) == pytest.approx(now - 0.098, abs=1e-4)
        assert clocks.stamp("/sonar", 7.0 + now, now) == pytest.approx(
            now, abs=1e-9
        )  # counts from when it was switched on
        assert clocks.stamp("/image", 0.0, now) == now
    offsets = {one.clock: one.offset_s for one in clocks.offsets}
    assert offsets == pytest.approx({"/odom, /scan": -999.998, "/sonar": -7.0}, abs=1e-4)


@pytest.mark.parametrize("late", [0.4, 1.0, 3.0, 6.0, 30.0])
def test_a_topic_that_falls_behind_is_dated_by_its_own_stamps_however_late_it_is(late: float) -> None:
    clocks, messages = RosClocks(simulated=False), list[tuple[float, str, float]]()
    for number in range(600):
        own = 0.1 * number
        messages += [(own + 0.002, "/odom", own), (own + (late if own > 5.0 else 0.01), "/scan", own)]
    for received, topic, own in sorted(messages):
        assert clocks.stamp(topic, 1000.0 + own, received) == pytest.approx(own, abs=0.03)


@pytest.mark.parametrize("late", [0.4, 3.0, 8.0])
def test_a_topic_that_was_always_late_is_known_by_the_others_of_its_clock(late: float) -> None:
    clocks = RosClocks(simulated=False)
    for number in range(100):
        received = 0.1 * number
        clocks.stamp("/scan", 1000.0 + received - late, received)
        clocks.stamp("/odom", 1000.0 + received - 0.002, received)
    assert 10.0 - clocks.stamp("/scan", 1010.0 - late, 10.0) == pytest.approx(late, abs=0.01)


@pytest.mark.parametrize("step", [-3600.0, -60.0, -1.0, 1.0, 60.0])
def test_a_topic_that_steps_alone_does_not_make_the_clock_and_is_believed_when_it_is_back(step: float) -> None:
    clocks = RosClocks(simulated=False)
    for number in range(300):
        received = 0.1 * number
        leap = step if 10.0 < received < 20.0 else 0.0
        assert clocks.stamp("/scan", START + received + leap, received) - received == pytest.approx(leap, abs=0.01)
        assert clocks.stamp("/odom", START + received, received) == pytest.approx(received, abs=0.01)


def test_a_clock_that_is_set_for_all_its_topics_is_followed_at_once() -> None:
    clocks, off = RosClocks(simulated=False), list[float]()
    for number in range(600):
        received = 0.1 * number
        set_by = (0.0, 3600.0, -7200.0)[number // 200]
        for topic, delay in (("/scan", 0.02), ("/odom", 0.0), ("/image", 0.05)):
            off.append(clocks.stamp(topic, START + received + set_by - delay, received) - received)
    late = [one for one in off if abs(one) > 0.1]
    assert len(late) <= 4


def test_a_clock_that_was_set_is_learnt_anew_by_the_stamps_that_step() -> None:
    clocks = RosClocks(simulated=False)
    for number in range(300):
        received = 0.1 * number
        own = 1000.0 + received + (0.0 if received < 10.0 else -60.0 if received < 20.0 else 3600.0)
        assert received - clocks.stamp("/scan", own - 0.004, received) == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize(("silent", "late"), [(4.0, 3.0), (7.0, 3.0), (20.0, 0.0)])
def test_a_lag_stays_known_over_a_loss_that_is_too_short_for_a_restart(silent: float, late: float) -> None:
    wire = Wire()
    for lag in (0.0, 3.0):
        wire.sensors.attach(wire.readings)
        for _ in range(20):
            wire.clock += 0.1
            wire.take("/scan", wire.maker.scan(wire.scan(wire.clock - lag)))
        wire.sensors.detach()
        scan = wire.readings.frame().scan
        wire.clock += silent
    assert scan is not None and wire.readings.now() - silent - scan.stamp == pytest.approx(late, abs=0.4)


@pytest.mark.parametrize("clock", [(), (("/clock", "rosgraph_msgs/msg/Clock"),)])
def test_only_a_simulators_clock_is_held_up(clock: tuple[tuple[str, str], ...]) -> None:
    topics, late = choose_topics((*TOPICS.items(), *clock), RosSettings()), 0.0
    clocks = RosClocks(simulated=topics.simulated)
    for number in range(100):
        own = 0.1 * number
        lag = 0.0 if own < 2.0 else 1.5
        late = max(own + lag - clocks.stamp(topic, 10.0 + own, own + lag) for topic in ("/scan", "/odom"))
    assert late == pytest.approx(0.0 if clock else 1.5, abs=0.01)


class Sent:
    def __init__(self) -> None:
        self.now = 0.0
        self.speeds: list[tuple[float, Twist]] = []
        self.locks: list[tuple[float, bool]] = []
        self.commands = VelocityCommands(
            lambda twist: self.speeds.append((self.now, twist)),
            lambda closed: self.locks.append((self.now, closed)),
            lambda: self.now,
        )

    def call(self, twist: Twist, seconds: float) -> None:
        for _ in range(round(seconds / 0.025)):
            self.commands.drive(twist)
            self.now += 0.025


def test_nothing_is_sent_while_nothing_is_asked_for() -> None:
    sent = Sent()
    sent.call(ZERO, 1.0)
    assert sent.speeds == []


def test_motion_is_repeated_and_ends_in_five_zeros_and_silence() -> None:
    sent = Sent()
    sent.call(Twist(0.1, 0.0), 0.5)
    sent.call(ZERO, 1.0)
    assert [twist for _, twist in sent.speeds] == [Twist(0.1, 0.0)] * 20 + [ZERO] * 5
    assert sent.speeds[20][0] == pytest.approx(0.5)  # at once


def test_one_stop_without_further_calls_still_ends_in_five_zeros() -> None:
    sent = Sent()
    sent.call(Twist(0.1, 0.0), 0.1)
    sent.commands.drive(ZERO)
    for _ in range(20):
        sent.now += 0.05
        sent.commands.tick()
    assert [twist for _, twist in sent.speeds[4:]] == [ZERO] * 5


def test_after_the_link_was_lost_on_the_move_zeros_come_first() -> None:
    sent = Sent()
    sent.call(Twist(0.1, 0.0), 0.1)
    sent.commands.restart()
    sent.now += 1.0
    sent.commands.tick()
    assert sent.speeds[-1][1] == ZERO


def test_zeros_that_went_into_a_dead_link_are_sent_again_when_it_is_back() -> None:
    sent = Sent()
    sent.commands.restart()
    sent.call(ZERO, 0.5)
    assert sent.speeds == []  # nothing was driven over it
    sent.call(Twist(0.1, 0.0), 0.1)
    sent.call(ZERO, 5.0)  # its loss is noticed after seconds of silence
    before = len(sent.speeds)
    sent.commands.restart()
    for _ in range(20):
        sent.now += 0.05
        sent.commands.tick()
    assert [twist for _, twist in sent.speeds[before:]] == [ZERO] * 4


def test_speeds_that_are_no_numbers_stop() -> None:
    sent = Sent()
    sent.call(Twist(0.1, 0.0), 0.1)
    sent.commands.drive(Twist(math.nan, 0.0))
    assert sent.speeds[-1][1] == ZERO


def test_the_lock_is_a_heartbeat_that_is_open_only_on_the_move() -> None:
    sent = Sent()
    sent.call(ZERO, 1.0)
    assert len(sent.locks) == 10 and all(closed for _, closed in sent.locks)
    sent.locks.clear()
    sent.call(Twist(0.1, 0.0), 1.0)
    assert not any(closed for _, closed in sent.locks) and sent.locks[0][0] <= sent.speeds[0][0]
    sent.locks.clear()
    sent.call(ZERO, 0.5)
    closing = next(time for time, closed in sent.locks if closed)
    assert closing == sent.speeds[-1][0]  # after the last zero, which the lock would hide
    assert max(b[0] - a[0] for a, b in zip(sent.locks, sent.locks[1:], strict=False)) <= 0.13


def test_a_lock_that_was_closed_at_once_is_not_opened_by_zeros_that_are_late_and_by_the_next_motion_it_is() -> None:
    sent = Sent()
    sent.commands.let_drive(True)
    sent.commands.tick()
    assert sent.locks[-1] == (0.0, False)
    sent.commands.stand()
    sent.locks.clear()
    for _ in range(20):
        sent.now += 0.15  # on a computer that is busy
        sent.commands.tick()
    assert sent.locks and all(closed for _, closed in sent.locks)
    sent.commands.stand()
    sent.commands.drive(Twist(0.1, 0.0))
    assert sent.locks[-1] == (sent.now, False)


def test_unread_images_are_all_bytes_a_decoder_may_see() -> None:
    wire = Wire()
    wire.sensors.attach(wire.readings)
    jpeg = cv2.imencode(".jpg", np.zeros((128, 160, 3), np.uint8))[1].tobytes()
    content = wire.maker.make["sensor_msgs/msg/CompressedImage"]
    header = wire.maker.header(0.0, "camera")
    for data in (b"", jpeg[:-50], b"\x89PNG\r\n\x1a\n" + b"\x00" * 40):
        message = content(header=header, format="jpeg", data=np.frombuffer(data, np.uint8))
        kind = "sensor_msgs/msg/CompressedImage"
        wire.take("/image/compressed", bytes(wire.maker.store.serialize_cdr(message, kind)))
    assert wire.readings.frame().image is None and wire.types.errors["/image/compressed"] == 3


def test_an_odometry_without_heading_is_followed_by_its_speeds_and_said() -> None:
    wire = Wire()
    wire.sensors.attach(wire.readings)
    for step in range(20):
        wire.clock = 100.0 + 0.1 * step
        payload = wire.maker.odometry(Wheels(odometry=Pose(), speed=0.5, turn_rate=0.2), 0.1 * step)
        content = wire.types.decode("/odom", TOPICS["/odom"], payload)
        content.pose.pose.orientation.w = 0.0
        wire.sensors.take_fields("/odom", content)
    wheels = wire.readings.frame().wheels
    assert wheels is not None and wheels.odometry.heading == pytest.approx(0.38, abs=0.01)
    assert wheels.odometry.distance_to(0.0, 0.0) == pytest.approx(0.95, abs=0.02)
    assert [one.code for one in wire.sensors.findings(RosSettings()).faults] == ["odometry.no_heading"]


def test_a_mounting_that_comes_on_tf_and_stays_is_taken() -> None:
    wire = Wire()
    found = {topic: kind for topic, kind in TOPICS.items() if topic != "/tf_static"} | {"/tf": TF}
    wire.sensors = RosSensors(wire.types, choose_topics(found.items(), RosSettings()), lambda *_: None)
    for _ in range(3):
        wire.take("/tf", wire.maker.frames())
    wire.take("/scan", wire.maker.scan(wire.scan(0.0)))
    assert wire.sensors.equipment("robot").lasers[0].height == pytest.approx(0.12)
    assert not any("where laser is mounted" in one for one in wire.sensors.notices)


@pytest.mark.parametrize(
    ("speed", "rolls", "period", "doubted"),
    [(0.05, 0.0, 0.025, 1), (0.05, 0.05, 0.025, 0), (0.02, 0.02, 0.1, 0), (0.0, 0.0, 0.025, 0), (0.02, 0.0, 0.1, 1)],
)
def test_a_base_is_doubted_that_does_not_roll_while_it_is_sent_speeds(
    speed: float, rolls: float, period: float, doubted: int
) -> None:
    base, found = UnmovedBase(), 0
    for tick in range(round(2.0 / period)):
        found += base.watch(Twist(speed, 0.0), Pose(rolls * period * tick), period * tick)
    assert found == doubted and base.moved is (rolls > 0)


def test_a_base_that_was_pushed_between_two_motions_has_not_moved_by_its_speeds() -> None:
    base = UnmovedBase()
    base.watch(Twist(0.1, 0.0), Pose(), 0.0)
    base.watch(ZERO, Pose(0.5), 1.0)
    base.watch(Twist(0.1, 0.0), Pose(1.0), 2.0)
    assert not base.moved


@pytest.mark.parametrize(
    "odd", [{"ranges": "far"}, {"angle_increment": None}, {"header": 3}, {"ranges": [[1.0], 2.0]}]
)
def test_messages_of_another_form_are_said(odd: dict[str, object]) -> None:
    wire = Wire()
    wire.sensors.attach(wire.readings)
    content = wire.types.decode("/scan", TOPICS["/scan"], wire.maker.scan(wire.scan(0.0)))
    for name, value in odd.items():
        setattr(content, name, value)
    for _ in range(10):
        wire.sensors.take_fields("/scan", content)
    frame = wire.readings.frame()
    assert frame.scan is None and [(one.code, one.sensor) for one in frame.faults] == [("link.unreadable", "/scan")]


def test_bytes_that_are_no_such_message_are_said_where_they_are_many() -> None:
    wire = Wire()
    wire.sensors.attach(wire.readings)
    payload = wire.maker.scan(wire.scan(0.0))
    for step in range(60):
        wire.clock = 100.0 + 0.1 * step
        wire.take("/scan", payload[:-20] if step % 4 == 0 else wire.maker.scan(wire.scan(0.1 * step)))
    assert "link.unreadable" in {one.code for one in wire.readings.frame().faults}
