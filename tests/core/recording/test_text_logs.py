"""CARMEN text and JSON lines."""

import gzip
import json
import math
from pathlib import Path

import numpy as np
import pytest

from core.errors import BadInput
from core.geometry import Pose
from core.pipelines.slam import slam_log
from core.recording import LogSettings, open_log
from core.recording.json_scan import read_json_scan
from core.recording.read_report import BadRecord, ReadReport
from core.sensors.scan_gate import RangeUnit
from tests.core.recording.log_writers import START, carmen_lines, pose_of, ranges_of


def write(path, lines):
    path.write_text("\n".join(lines) + "\n")
    return path


def test_flaser_gives_scans_the_robots_poses_and_the_lasers_place(tmp_path):
    recording = open_log(write(tmp_path / "robot.log", carmen_lines()))
    start = Pose(*pose_of(0.0))
    assert len(recording) == 10
    for index, frame in enumerate(recording):
        assert frame.stamp == pytest.approx(START + 0.2 * index, abs=1e-6)
        assert frame.scan.ranges == pytest.approx(ranges_of(index, 180), abs=1e-3)
        truth = start.inverse() @ Pose(*pose_of(0.2 * index))
        assert frame.wheels.odometry.vector == pytest.approx(truth.vector, abs=1e-5)
        assert (frame.wheels.speed, frame.wheels.turn_rate) == pytest.approx((0.2, 0.2), abs=0.01)
    assert recording.laser.mounting.vector == pytest.approx((0.2, 0.0, 0.0), abs=1e-4)
    assert recording.report.skipped == 0


@pytest.mark.parametrize(
    ("beams", "first", "last"), [(180, -90, 89), (181, -90, 90), (361, -90, 90), (60, -90, 87), (682, -90, 89.736)]
)
def test_beams_spread_over_180_degrees(beams, first, last, tmp_path):
    (frame, *_) = open_log(write(tmp_path / "robot.log", carmen_lines(beams=beams)))
    assert np.degrees(frame.scan.angles[[0, -1]]) == pytest.approx([first, last], abs=1e-3)


def test_readings_at_the_maximum_are_nothing_there(tmp_path):
    line = carmen_lines(scans=1)[-1].split()
    line[2:5] = ["81.83", "0.0", "79.0"]
    (frame,) = open_log(write(tmp_path / "robot.log", [" ".join(line)]))
    assert np.isposinf(frame.scan.ranges[0]) and np.isnan(frame.scan.ranges[1]) and frame.scan.ranges[2] == 79.0


def test_a_corrected_log_is_not_taken_for_a_strange_mounting(tmp_path):
    lines = [line.split() for line in carmen_lines() if line.startswith("FLASER")]
    for number, words in enumerate(lines):
        words[182] = str(3.0 * number)
    recording = open_log(write(tmp_path / "robot.log", [" ".join(words) for words in lines]))
    assert recording.laser.mounting == Pose()
    assert "corrected map" in recording.report.warnings[0]


def test_robotlaser_tells_its_own_angles_and_range(tmp_path):
    lines = []
    for n in range(5):
        x = 0.1 * n
        told = [0, -1.5, 3.0, 0.5, 20.0, 0.01, 0, 7, 1, 2, 3, 4, 5, 6, 20.0, 2, 9, 9]
        told += [x + 0.3, 0, 0, x, 0, 0, 0.5, 0, 0, 0, 0]
        lines.append("ROBOTLASER1 " + " ".join(map(str, told)) + f" {START + 0.2 * n:.3f} host {0.2 * n:.3f}")
    recording = open_log(write(tmp_path / "robot.log", lines))
    frames = list(recording)
    assert frames[0].scan.angles == pytest.approx([-1.5, -1, -0.5, 0, 0.5, 1, 1.5])
    assert frames[0].scan.ranges == pytest.approx([1, 2, 3, 4, 5, 6, math.inf])
    assert recording.laser.mounting.vector == pytest.approx((0.3, 0, 0), abs=1e-6)
    assert frames[-1].wheels.odometry.x == pytest.approx(0.4)
    assert recording.duration == pytest.approx(0.8)


def test_odometry_lines_serve_where_the_scans_carry_no_poses(tmp_path):
    lines = []
    for line in carmen_lines():
        words = line.split()
        if words[0] == "FLASER":
            words[182:188] = ["0"] * 6
        lines.append(" ".join(words))
    recording = open_log(write(tmp_path / "robot.log", lines))
    assert recording.report.topics[1] == "ODOM: odometry"
    end = Pose(*pose_of(0.0)).inverse() @ Pose(*pose_of(1.8))
    assert recording.wheels_at(START + 1.8).odometry.vector == pytest.approx(end.vector, abs=1e-5)


def test_cut_lines_are_counted_with_their_place(tmp_path):
    lines = carmen_lines()
    lines[5] = lines[5][:300]
    lines[7] = lines[7].replace("FLASER 180", "FLASER 999999")
    report = open_log(write(tmp_path / "robot.log", lines)).report
    assert report.skipped == 2
    assert "2 of 20 records skipped" in report.warnings[0] and "line 6" in report.warnings[0]


def test_packed_text_is_read_as_it_is(tmp_path):
    path = tmp_path / "robot.log.gz"
    packed = gzip.compress("\n".join(carmen_lines(scans=50)).encode())
    path.write_bytes(packed)
    assert len(open_log(path)) == 50
    path.write_bytes(packed[: len(packed) * 3 // 4])
    cut = open_log(path)
    assert 10 < len(cut) < 50 and "packed file is cut" in cut.report.warnings[0]


def test_lines_without_scans_are_refused(tmp_path):
    with pytest.raises(BadInput, match="no FLASER, ROBOTLASER1 or RAWLASER1"):
        open_log(write(tmp_path / "robot.log", [line for line in carmen_lines() if "ODOM" in line]))


GOOD = {"t": 1.0, "ranges": [1.0, None, 3.0]}


def a_laser() -> RangeUnit:
    return RangeUnit("the laser", ReadReport(Path("scans.jsonl")))


def test_json_lines_give_scans_and_every_unusable_line_is_counted(tmp_path):
    lines = [
        json.dumps(GOOD),
        json.dumps(GOOD | {"t": 2.0, "angle_min": -1.0, "angle_increment": 1.0, "range_max": 2.5}),
        json.dumps(GOOD),  # time stands still
        json.dumps({"ranges": [1.0, 2.0]}),  # no time
        json.dumps(GOOD | {"t": 3.0, "ranges": []}),
        json.dumps(GOOD | {"t": 3.0, "ranges": ["1", 2]}),
        json.dumps(GOOD | {"t": 3.0, "ranges": [None, -1]}),
        json.dumps(GOOD | {"t": "late"}),
        json.dumps(GOOD | {"t": 1e300}),
        "[1, 2]",
        '{"t": 4',
        "",
    ]
    recording = open_log(write(tmp_path / "scans.jsonl", lines))
    first, second = recording
    assert first.scan.ranges == pytest.approx([1.0, math.nan, 3.0], nan_ok=True)
    assert second.scan.ranges == pytest.approx([1.0, math.nan, math.inf], nan_ok=True)
    assert second.scan.angles == pytest.approx([-1, 0, 1])
    assert recording.report.read == 2 and recording.report.skipped == 10
    assert recording.report.warnings[0].startswith("10 of 12 records skipped")


@pytest.mark.parametrize(
    ("more", "stamp"),
    [
        ({"t": 2}, 2.0),
        ({"t": {"sec": 3, "nsec": 5e8}}, 3.5),
        ({"header": {"stamp": {"sec": 3, "nanosec": 500_000_000}}}, 3.5),
        ({"t": "late", "stamp": 4.0}, 4.0),
        ({"t": "17.5"}, 17.5),
        ({"time": 5.0}, 5.0),
        ({"ts": "2024-05-01T12:00:03.500Z"}, 1714564803.5),
        ({"timestamp": "2024-05-01 14:00:03.5+02:00"}, 1714564803.5),
        ({"header": {"frame_id": "laser"}}, math.nan),
    ],
)
def test_a_json_scan_has_its_time_in_any_of_the_usual_forms(more, stamp):
    read = read_json_scan(json.dumps({"ranges": [1.0, 2.0]} | more), 0.0, a_laser())
    assert read is not None and read[1] == pytest.approx(stamp, nan_ok=True)


@pytest.mark.parametrize(("range_max", "nothing"), [("5.0", math.inf), ("Infinity", math.nan)])
def test_numbers_that_are_not_finite_are_read_as_most_programs_write_them(range_max, nothing):
    text = f'{{"t": 1.0, "ranges": [NaN, Infinity, 1e999, 2.0], "range_max": {range_max}}}'
    read = read_json_scan(text, 0.0, a_laser())
    assert read is not None
    assert read[0].ranges == pytest.approx([math.nan, nothing, nothing, 2.0], nan_ok=True)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"ranges": [1.0, "2"]}, "ranges are no numbers"),
        ({"ranges": [1.0, True]}, "ranges are no numbers"),
        ({"ranges": [10**400]}, "ranges are no numbers"),
        ({"ranges": "1, 2"}, "ranges are no list"),
        ({"range_max": 10**400}, "too large"),
        ({"range_max": "far"}, "a number is missing"),
        ({"\ud800": 1}, "no JSON"),
    ],
)
def test_what_is_wrong_with_a_json_scan_is_said(more, words):
    with pytest.raises(BadRecord, match=words):
        read_json_scan(json.dumps({"t": 1.0, "ranges": [1.0, 2.0]} | more), 0.0, a_laser())


def test_the_maximum_range_of_the_settings_goes_before_that_of_the_log(tmp_path):
    path = write(tmp_path / "scans.jsonl", [json.dumps({"t": 0.0, "ranges": [1.0, 2.0, 3.0]})])
    (frame,) = open_log(path, LogSettings(range_max=2.0))
    assert frame.scan.ranges == pytest.approx([1.0, math.inf, math.inf])


RAYS = [2.0 + 0.01 * beam for beam in range(41)]


@pytest.mark.parametrize(
    ("change", "codes"),
    [
        (lambda at: {}, set()),
        (lambda at: {"ranges": [1000 * far for far in RAYS], "range_max": 12000.0}, {"scan.units"}),
        (lambda at: {"ranges": [100 * far for far in RAYS], "range_max": 12.0}, {"scan.units", "scan.limits"}),
        (lambda at: {"range_max": 0.5}, {"scan.limits"}),
        (lambda at: {"angle_min": -57.29578, "angle_increment": 2.864789}, {"scan.degrees"}),
        (lambda at: {"angle_increment": None, "angle_max": 1.0, "angle_step": None}, set()),
        (lambda at: {"t": 1.7e18 + 1e8 * at}, {"clock.unit"}),
        (lambda at: {"t": 1.7e12 + 100 * at}, {"clock.unit"}),
        (lambda at: {"t": 0.0}, {"clock.none"}),
        (lambda at: {"t": at // 5}, {"clock.rounded"}),
        (lambda at: {"t": 3.0 - 0.1 * at}, set()),
    ],
)
def test_json_lines_are_checked_as_every_other_log_is(change, codes, tmp_path):
    sound = {"angle_min": -1.0, "angle_increment": 0.05, "range_max": 12.0, "ranges": RAYS}
    lines = [sound | {"t": 0.1 * at} | change(at) for at in range(30)]
    lines = [json.dumps({key: entry for key, entry in line.items() if entry is not None}) for line in lines]
    recording = open_log(write(tmp_path / "scans.jsonl", lines))
    assert {one.code for one in recording.report.faults} == codes
    assert len(recording) == 30 and recording.duration == pytest.approx(2.9 if "rounded" not in str(codes) else 5.8)
    scan = recording.scan(7)
    assert scan.angles[[0, -1]] == pytest.approx([-1.0, 1.0], abs=1e-5)
    assert scan.ranges == pytest.approx(RAYS, abs=1e-4)


def test_scans_that_repeat_without_odometry_are_a_robot_that_may_stand(tmp_path):
    sound = {"angle_min": -1.0, "angle_increment": 0.05, "range_max": 12.0}
    lines = [sound | {"t": 0.1 * at, "ranges": [far + 0.02 * max(0, at - 40) for far in RAYS]} for at in range(60)]
    path = write(tmp_path / "scans.jsonl", [json.dumps(line) for line in lines])
    result = slam_log(path)
    assert [one.code for one in result.report.faults] == ["scan.repeated"]
    assert "40 of 60" in result.report.warnings[0] and len(result.poses) == 60


def test_json_scans_that_say_no_angles_have_that_said(tmp_path):
    recording = open_log(write(tmp_path / "scans.jsonl", [json.dumps(GOOD), json.dumps(GOOD | {"t": 2.0})]))
    assert [one.code for one in recording.report.faults] == ["scan.no_angles"]
