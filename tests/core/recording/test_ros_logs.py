"""ROS logs of three kinds of file tell the same story."""

import json
import math

import numpy as np
import pytest
from mcap.writer import CompressionType
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import StoragePlugin

from core.errors import BadInput
from core.geometry import Pose
from core.recording import LogSettings, logged_stamp, open_log
from tests.core.recording.log_writers import (
    BEAMS,
    ODOMETRY,
    SCAN,
    START,
    STEP,
    TF,
    one,
    pose_of,
    ranges_of,
    robot_messages,
    two,
    write_bag,
    write_folder,
    write_mcap,
)


def write(form, folder, messages_of):
    if form == "mcap":
        return write_mcap(folder / "log.mcap", messages_of(two))
    if form == "bag":
        return write_bag(folder / "log.bag", messages_of(one))
    if form == "db3 folder":
        return write_folder(folder / "log", messages_of(two))
    if form == "db3":
        return next(write_folder(folder / "log", messages_of(two)).glob("*.db3"))
    return write_folder(folder / "log", messages_of(two), StoragePlugin.MCAP)


FORMS = ["mcap", "bag", "db3 folder", "db3", "mcap folder"]


@pytest.fixture(params=FORMS)
def form(request):
    return request.param


def assert_on_the_arc(recording):
    """The odometry at every scan is the arc, seen from where it began."""
    start = Pose(*pose_of(0.0))
    for frame in recording:
        truth = start.inverse() @ Pose(*pose_of(frame.stamp - START))
        assert frame.wheels is not None
        assert frame.wheels.odometry.vector == pytest.approx(truth.vector, abs=1e-4)


def test_every_form_gives_the_same_scans_and_odometry(form, tmp_path):
    recording = open_log(write(form, tmp_path, robot_messages))
    assert len(recording) == 20 and recording.has_wheels
    assert recording.duration == pytest.approx(1.9, abs=1e-5)
    for index, frame in enumerate(recording):
        assert frame.stamp == pytest.approx(START + 0.1 * index, abs=1e-6)
        assert frame.scan.ranges.dtype == np.float64
        assert frame.scan.ranges == pytest.approx(ranges_of(index), abs=1e-6)
    assert_on_the_arc(recording)
    wheels = recording.wheels_at(START + 0.97)
    assert (wheels.speed, wheels.turn_rate) == pytest.approx((0.1, 0.2))
    assert recording.report.skipped == 0 and recording.report.warnings == ()
    assert recording.report.topics == ("/scan: laser", "/odom: odometry")


def test_odometry_comes_from_tf_where_there_is_no_odometry_message(form, tmp_path):
    recording = open_log(write(form, tmp_path, lambda kind: robot_messages(kind, odometry="tf")))
    assert_on_the_arc(recording)
    wheels = recording.wheels_at(START + 1.0)
    assert (wheels.speed, wheels.turn_rate) == pytest.approx((0.2, 0.2), abs=1e-3)


def test_the_laser_stands_where_the_fixed_transforms_say(form, tmp_path):
    laser = open_log(write(form, tmp_path, robot_messages)).laser
    assert laser.mounting.vector == pytest.approx((0.1, -0.05, 0.2), abs=1e-6)
    assert laser.height == pytest.approx(0.23)
    assert (laser.beams, laser.range_min) == (BEAMS, pytest.approx(0.02))
    assert (laser.angle_min, laser.angle_step) == (pytest.approx(-STEP * (BEAMS - 1) / 2), pytest.approx(STEP))
    assert (laser.range_max, laser.rate) == (pytest.approx(5.6), pytest.approx(10.0))


def test_a_log_without_odometry_has_no_wheels(form, tmp_path):
    recording = open_log(write(form, tmp_path, lambda kind: robot_messages(kind, odometry="", mounting=None)))
    assert not recording.has_wheels and all(frame.wheels is None for frame in recording)


@pytest.mark.parametrize("compression", [CompressionType.NONE, CompressionType.LZ4, CompressionType.ZSTD])
def test_every_compression_of_mcap_is_read(compression, tmp_path):
    assert len(open_log(write_mcap(tmp_path / "log.mcap", robot_messages(two), compression))) == 20


@pytest.mark.parametrize(
    "options", [{"use_chunking": False}, {"use_statistics": False, "use_summary_offsets": False}]
)
def test_an_mcap_without_chunks_or_summary_is_read(options, tmp_path):
    assert len(open_log(write_mcap(tmp_path / "log.mcap", robot_messages(two), **options))) == 20


@pytest.mark.parametrize("compression", [Ros1Writer.CompressionFormat.BZ2, Ros1Writer.CompressionFormat.LZ4])
def test_every_compression_of_bags_is_read(compression, tmp_path):
    assert len(open_log(write_bag(tmp_path / "log.bag", robot_messages(one), compression))) == 20


def scan_message(kind, index=0, **changes):
    return "/scan", SCAN, START + 0.1 * index, kind.scan(START + 0.1 * index, ranges_of(index), **changes)


def test_what_the_laser_could_not_measure_is_neither_hit_nor_free(tmp_path):
    ranges = [0.0, 0.01, math.nan, -1.0, -math.inf, 1.0, 5.6, 9.0, math.inf]
    path = write_mcap(tmp_path / "log.mcap", [("/scan", SCAN, START, two.scan(START, ranges))] * 1)
    (frame,) = open_log(path)
    assert np.isnan(frame.scan.ranges[:5]).all()
    assert frame.scan.ranges[5] == 1.0
    assert np.isposinf(frame.scan.ranges[6:]).all()


def test_a_mirror_that_turns_clockwise_still_reads_right_to_left(tmp_path):
    scan = two.scan(START, ranges_of(0))
    scan.angle_min, scan.angle_increment = -scan.angle_min, -scan.angle_increment
    (frame,) = open_log(write_mcap(tmp_path / "log.mcap", [("/scan", SCAN, START, scan)]))
    assert frame.stamp == logged_stamp(frame.scan) == pytest.approx(START, abs=1e-6)
    assert frame.scan.ranges == pytest.approx(ranges_of(0)[::-1])
    assert frame.scan.angles[0] == pytest.approx(-STEP * (BEAMS - 1) / 2, abs=1e-6)
    assert frame.scan.times[-1] == pytest.approx(START, abs=1e-6)
    assert frame.scan.times[0] == pytest.approx(START + 1e-4 * (BEAMS - 1), abs=1e-6)


def test_a_laser_that_hangs_upside_down_sees_left_and_right_as_they_are(tmp_path):
    hanging = two.tf(START, "base_link", "laser", (0.1, 0.0, 0.0), height=0.5, roll=math.pi)
    ranges = ranges_of(0)
    messages = [("/tf_static", TF, START, hanging), ("/scan", SCAN, START, two.scan(START, ranges))]
    recording = open_log(write_mcap(tmp_path / "log.mcap", messages))
    (frame,) = recording
    assert frame.scan.ranges == pytest.approx(ranges[::-1])  # its first beam points to the robot's left
    assert recording.laser.mounting.vector == pytest.approx((0.1, 0.0, 0.0))


def test_the_laser_is_found_through_a_chain_of_frames_and_old_style_fixed_transforms(tmp_path):
    quarter = math.pi / 2
    chain = []
    for tick in range(3):
        stamp = START + tick * 0.1
        chain.append(("/tf", TF, stamp, one.tf(stamp, "/base_footprint", "/base_link", (0.0, 0.0, 0.0), height=0.1)))
        chain.append(("/tf", TF, stamp, one.tf(stamp, "/base_link", "/mast", (0.2, 0.0, quarter))))
        chain.append(("/tf", TF, stamp, one.tf(stamp, "/mast", "/laser", (0.1, 0.0, 0.0))))
    laser = open_log(write_bag(tmp_path / "log.bag", [*chain, scan_message(one, frame="/laser")])).laser
    assert laser.mounting.vector == pytest.approx((0.2, 0.1, quarter))


def test_settings_name_topics_and_mounting(tmp_path):
    messages = robot_messages(two)
    other = [("/back/scan", SCAN, START + 0.1 * n, two.scan(START + 0.1 * n, [2.0, 2.0, 2.0])) for n in range(3)]
    path = write_mcap(tmp_path / "log.mcap", messages + other)
    assert "/back/scan" in open_log(path).report.warnings[0]
    chosen = LogSettings(scan_topic="back/scan", odometry_topic="none", mounting_x=-0.1, mounting_heading=3.0)
    recording = open_log(path, chosen)
    assert len(recording) == 3 and not recording.has_wheels
    assert recording.laser.mounting == Pose(-0.1, open_log(path).laser.mounting.y, 3.0)
    for wrong in (LogSettings(scan_topic="/front"), LogSettings(odometry_topic="/wheels")):
        with pytest.raises(BadInput, match="It holds /scan"):
            open_log(path, wrong)


def test_robots_that_stamp_nothing_are_dated_by_the_recorder(tmp_path):
    messages = [("/scan", SCAN, START + 0.1 * n, two.scan(0.0, ranges_of(n))) for n in range(5)]
    recording = open_log(write_mcap(tmp_path / "log.mcap", messages))
    assert [frame.stamp for frame in recording] == pytest.approx([START + 0.1 * n for n in range(5)])


def test_a_stamp_far_from_all_others_is_left_out_and_told(tmp_path):
    messages = [scan_message(two, n) for n in range(6)]
    messages[2] = ("/scan", SCAN, START + 0.2, two.scan(START + 1e6, ranges_of(2)))
    messages[4] = ("/scan", SCAN, START + 0.4, two.scan(START + 0.3, ranges_of(4)))
    recording = open_log(write_mcap(tmp_path / "log.mcap", messages))
    assert [frame.stamp - START for frame in recording] == pytest.approx([0.0, 0.1, 0.3, 0.5], abs=1e-6)
    assert recording.report.skipped == 2 and recording.report.read == 4
    assert "2 of 6 records skipped" in recording.report.warnings[0]


def test_messages_out_of_order_come_in_order_of_time(tmp_path):
    messages = [scan_message(two, n) for n in (3, 0, 2, 1)]
    assert [f.stamp - START for f in open_log(write_mcap(tmp_path / "log.mcap", messages))] == pytest.approx(
        [0.0, 0.1, 0.2, 0.3], abs=1e-6
    )


def test_one_unreadable_message_costs_only_itself(tmp_path):
    messages = [scan_message(two, n) for n in range(5)]
    messages[2] = (*messages[2][:3], b"\x00\x01\x00\x00nonsense")
    recording = open_log(write_mcap(tmp_path / "log.mcap", messages))
    assert len(recording) == 4 and recording.report.skipped == 1


def test_channels_of_unknown_types_are_passed_over(tmp_path):
    strange = ("/service", "example/srv/Add_Event", START, b"\x00\x01\x02")
    assert len(open_log(write_mcap(tmp_path / "log.mcap", [strange, *robot_messages(two)]))) == 20


def test_a_log_without_scans_says_what_it_holds(tmp_path):
    path = write_mcap(tmp_path / "log.mcap", [("/odom", ODOMETRY, START, two.odometry(START, (0, 0, 0)))])
    with pytest.raises(BadInput, match=r"no laser scans.*/odom \(1 × Odometry\)"):
        open_log(path)


def test_json_channels_are_read_with_and_without_angles(tmp_path):
    plain = [("/scan", "Scan", START + n, json.dumps({"ranges": [1.0, 2.0, None]}).encode()) for n in range(3)]
    (first, *_) = open_log(write_mcap(tmp_path / "plain.mcap", plain, encoding="json"))
    assert first.stamp == pytest.approx(START)
    assert first.scan.angles == pytest.approx(np.radians([-90, -30, 30]))
    assert first.scan.ranges == pytest.approx([1.0, 2.0, math.nan], nan_ok=True)
    told = {"timestamp": {"sec": 5, "nsec": 500_000_000}, "start_angle": -1.0, "end_angle": 1.0, "ranges": [1, 2, 3]}
    other = ("/events", "Event", START, b'{"words": "turn left"}')
    (frame,) = open_log(
        write_mcap(
            tmp_path / "told.mcap", [("/scan", "Scan", START, json.dumps(told).encode()), other], encoding="json"
        )
    )
    assert frame.stamp == 5.5 and frame.scan.angles == pytest.approx([-1.0, 0.0, 1.0])


def test_a_folder_tells_when_messages_are_missing(tmp_path):
    folder = write_folder(tmp_path / "log", robot_messages(two))
    text = (folder / "metadata.yaml").read_text()
    (folder / "metadata.yaml").write_text(text.replace("message_count: 61", "message_count: 75"))
    assert "75 messages; 61 could be read" in open_log(folder).report.warnings[0]
