"""Logs whose readings cannot be true: units, angles, clocks, headings and forms of text as met in the field."""

import bz2
import gzip
import io
import lzma
import math
import tarfile
import tracemalloc
import zipfile
from dataclasses import replace
from pathlib import Path

import lz4.frame
import numpy as np
import pytest

from core.errors import BadInput
from core.recording import open_log
from core.recording.clocks import (
    StampedStream,
    longest_part,
    on_one_clock,
    seconds_per_unit,
    settled_stamps,
    unwrapped,
)
from core.recording.odometry_checks import believable_track
from core.recording.read_report import ReadReport
from core.sensors.scan_gate import RangeUnit, checked_angles
from tests.core.recording.log_writers import START, carmen_lines, robot_messages, two, write_mcap

RANGES = np.linspace(1.7, 6.4, 180).astype(np.float32)
TIMES = 1.7e9 + 0.1 * np.arange(200)
STEP = math.radians(1.0)


def codes(report: ReadReport) -> list[str]:
    return [one.code for one in report.report("test").faults]


@pytest.mark.parametrize(
    ("per_metre", "limits", "found"),
    [
        (1, (0.1, 10), []),
        (1, (0.1, 0), []),
        (1, (0.1, math.nan), []),
        (1000, (100, 10000), ["scan.units"]),
        (100, (10, 1000), ["scan.units"]),
        (1000, (0.1, 10), ["scan.units", "scan.limits"]),
        (0.001, (0.0001, 0.01), ["scan.units"]),
        (1, (100, 10000), ["scan.limits"]),
    ],
)
def test_ranges_and_their_limits_are_brought_to_metres_each_by_itself(per_metre, limits, found):
    report = ReadReport(Path("x"))
    ranges, (low, high) = RangeUnit("/scan", report).metres(RANGES * np.float32(per_metre), limits)
    assert ranges == pytest.approx(RANGES, rel=1e-5) and codes(report) == found
    assert low == pytest.approx(0.1) and (not high > 0 or high == pytest.approx(10.0))


@pytest.mark.parametrize("limits", [(9.0, 10.0), (12.0, 0.1), (0.1, 1.0), (0.1, 4.0)])
def test_limits_that_fit_few_ranges_cost_no_range(limits):
    report = ReadReport(Path("x"))
    ranges, (low, high) = RangeUnit("/scan", report).metres(np.minimum(RANGES, 6.0) + 1.0, limits)
    assert ranges.min() > 2.6 and low == 0.0 and math.isnan(high) and codes(report) == ["scan.limits"]


def test_an_open_place_of_which_only_marks_come_back_has_sound_limits():
    report = ReadReport(Path("x"))
    _, limits = RangeUnit("/scan", report).metres(np.full(180, 65.533, np.float32), (0.1, 6.0))
    assert limits == (0.1, 6.0) and codes(report) == []


@pytest.mark.parametrize(
    ("ends", "step", "angles", "found"),
    [
        ((-math.pi / 2, math.pi / 2 - STEP), STEP, (-math.pi / 2, STEP), []),
        ((-math.pi / 2, math.pi / 2), STEP, (-math.pi / 2, STEP), []),
        ((-math.pi / 2, 0.0), STEP, (-math.pi / 2, STEP), []),
        ((math.pi / 2, -math.pi / 2 + STEP), -STEP, (math.pi / 2, -STEP), []),
        ((-90.0, 89.0), 1.0, (-math.pi / 2, STEP), ["scan.degrees"]),
        ((-math.pi / 2, 89.0), 1.0, (-math.pi / 2, STEP), ["scan.degrees"]),
        ((-2.0, 2.0), STEP, (-2.0, STEP), ["scan.step_differs"]),
        ((-math.pi / 2, math.pi / 2 - STEP), 0.0, (-math.pi / 2, STEP), ["scan.step_zero"]),
    ],
)
def test_the_angles_of_a_scan_are_checked_with_each_other(ends, step, angles, found):
    report = ReadReport(Path("x"))
    assert checked_angles("/scan", 180, ends, step, report) == pytest.approx(angles, abs=1e-6)
    assert codes(report) == found


@pytest.mark.parametrize(
    ("own", "code"),
    [
        (TIMES[::-1], "clock.backward"),
        (np.where(np.arange(200) // 50 == 1, TIMES[99] + TIMES[50] - TIMES, TIMES), "clock.backward"),
        (np.floor(TIMES) + 1 - TIMES % 1, "clock.backward"),
        (5 + 1000 * (TIMES - TIMES[0]), "clock.rate"),
        (TIMES[0] + 0.001 * (TIMES - TIMES[0]), "clock.rate"),
    ],
)
def test_stamps_that_run_backward_or_in_another_unit_give_way_to_the_recorders_times(own, code):
    report, logged = ReadReport(Path("x")), TIMES + 0.02
    settled, good = settled_stamps(StampedStream("/scan", own.copy(), logged), report)
    assert good.all() and (settled.own == logged).all() and codes(report) == [code]


@pytest.mark.parametrize("slew", [-0.05, 0.05])
def test_of_two_clocks_the_one_that_drifts_gives_way(slew):
    report = ReadReport(Path("x"))
    laser = StampedStream("/scan", TIMES + slew * (TIMES - TIMES[0]), TIMES + 0.02)
    wheels = StampedStream("/odom", TIMES.copy(), TIMES + 0.01)
    assert on_one_clock(laser, wheels, report) == (0.0, 0.0)
    assert np.abs(laser.own - TIMES).max() < 0.03 and (wheels.own == TIMES).all() and codes(report) == ["clock.rate"]


def test_a_simulator_whose_clock_is_slow_for_all_has_sound_clocks():
    report = ReadReport(Path("x"))
    streams = [StampedStream(name, 0.4 * (TIMES - TIMES[0]) + 5, TIMES + 0.02) for name in ("/scan", "/odom")]
    assert on_one_clock(*streams, report) == (0.0, 0.0) and codes(report) == []


def test_limits_of_a_carmen_log_that_its_ranges_exceed_cost_no_range(tmp_path):
    ranges = " ".join(f"{3 + 0.05 * beam:.3f}" for beam in range(90))
    line = "RAWLASER1 0 -0.785 1.57 0.01764 {} 0.01 0 90 {} 0 {:.3f} host {:.3f}"
    for limit, found in ((1.5, ["scan.limits"]), (8.0, [])):
        lines = [line.format(limit, ranges, 5 + 0.1 * n, 0.1 * n) for n in range(20)]
        recording = open_log(written(tmp_path, "\n".join(lines).encode()))
        assert [one.code for one in recording.report.faults] == found and np.isfinite(recording.scan(0).ranges).all()


@pytest.mark.parametrize(
    ("start", "field", "step", "found"),
    [
        (-0.785, 1.57, 0.01764, []),
        (-0.785, 1.59, 0.01764, []),  # as those write it who count a step for the last beam, too
        (-0.785, 0.0, 0.01764, []),
        (-44.98, 89.95, 1.0107, ["scan.degrees"]),
        (-0.785, 1.57, 0.00882, ["scan.step_differs"]),
    ],
)
def test_the_angles_of_a_carmen_log_are_checked_with_each_other(start, field, step, found, tmp_path):
    ranges = " ".join(f"{3 + 0.05 * beam:.3f}" for beam in range(90))
    line = f"RAWLASER1 0 {start} {field} {step} 80 0.01 0 90 {ranges} 0 {{:.3f}} host {{:.3f}}"
    lines = [line.format(5 + 0.1 * n, 0.1 * n) for n in range(20)]
    recording = open_log(written(tmp_path, "\n".join(lines).encode()))
    assert [one.code for one in recording.report.faults] == found
    assert recording.scan(0).angle_min == pytest.approx(-0.785, abs=1e-3)


def circle(times, radius=1.0):
    turned = 0.3 * (times - times[0])
    return np.column_stack([radius * np.sin(turned), radius * (1 - np.cos(turned)), turned])


def test_headings_in_degrees_are_converted():
    report, poses = ReadReport(Path("x")), circle(TIMES)
    track = believable_track("odo", TIMES, poses * [1, 1, math.degrees(1)], None, report)
    assert (
        track is not None and track.poses == pytest.approx(poses, abs=1e-6) and codes(report) == ["odometry.degrees"]
    )


def test_odometry_far_from_its_origin_is_as_good_as_any_other():
    report, poses = ReadReport(Path("x")), circle(TIMES)
    track = believable_track("odo", TIMES, poses + np.array([4.5e5, 5.4e6, 0.0]), None, report)
    assert track is not None and track.poses == pytest.approx(poses, abs=1e-6) and codes(report) == []


def test_odometry_without_a_finite_number_is_said_to_be_left_out():
    report = ReadReport(Path("x"))
    assert believable_track("odo", TIMES, np.full((200, 3), np.inf), None, report) is None
    assert codes(report) == ["odometry.malformed"]


def test_a_scan_that_is_written_twice_is_taken_once(tmp_path):
    messages = [one for one in robot_messages(two) for _ in range(1 + (one[0] == "/scan"))]
    recording = open_log(write_mcap(tmp_path / "twice.mcap", messages))
    assert len(recording.scans) == 20 and recording.report.skipped == 20 and recording.report.faults == ()


def test_a_mounting_in_millimetres_is_none(tmp_path):
    recording = open_log(write_mcap(tmp_path / "far.mcap", robot_messages(two, mounting=(100.0, -50.0, 0.2))))
    assert [one.code for one in recording.report.faults] == ["mount.too_far"]
    assert recording.laser.mounting.vector == pytest.approx((0.0, 0.0, 0.2), abs=1e-6)


def test_a_laser_that_never_measured_anything_is_refused(tmp_path):
    lines = [" ".join([*line.split()[:2], *["81.91"] * 180, *line.split()[182:]]) for line in carmen_lines()[3::2]]
    with pytest.raises(BadInput, match="No beam of the laser measured anything"):
        open_log(written(tmp_path, "\n".join(lines).encode()))


def written(folder: Path, content: bytes, name: str = "robot.log") -> Path:
    path = folder / name
    path.write_bytes(content)
    return path


def of_lasers(name: str) -> str:
    """The log with its scans as records of another kind of laser."""
    step = f"{math.pi / 180:.8f}"
    texts = []
    for line in carmen_lines(20):
        words = line.split()
        if words[0] == "FLASER":
            words = [
                name,
                "0",
                "-1.5708",
                "3.1416",
                step,
                "81.9",
                "0.01",
                "0",
                "180",
                *words[2:182],
                "0",
                *words[-3:],
            ]
        texts.append(" ".join(words))
    return "\n".join(texts)


TEXT = "\n".join(carmen_lines(20))
FORMS = {
    "plain": TEXT.encode(),
    "CR": TEXT.replace("\n", "\r").encode(),
    "CRLF": TEXT.replace("\n", "\r\n").encode(),
    "BOM": b"\xef\xbb\xbf" + "\n".join(carmen_lines(20)[2:]).encode(),
    "UTF-16": TEXT.encode("utf-16"),
    "decimal commas": TEXT.replace(".", ",").encode(),
    "commas": TEXT.replace(" ", ",").encode(),
    "semicolons": TEXT.replace(" ", ";").encode(),
    "comments": TEXT.replace("\nODOM", " # ok\nODOM").encode(),
    "lower case": TEXT.replace("FLASER", "flaser").encode(),
    "xz": lzma.compress(TEXT.encode()),
    "lz4": lz4.frame.compress(TEXT.encode()),
    "bz2": bz2.compress(TEXT.encode()),
    "gz twice": gzip.compress(gzip.compress(TEXT.encode())),
    "two lasers": f"{TEXT}\n{of_lasers('RAWLASER2')}".encode(),
    **{name: of_lasers(name).encode() for name in ("RAWLASER1", "RAWLASER3", "RAWLASER4")},
}


@pytest.mark.parametrize("form", FORMS)
def test_every_way_to_write_a_carmen_log_gives_all_its_scans(form, tmp_path):
    recording = open_log(written(tmp_path, FORMS[form]))
    assert len(recording.scans) == 20 and recording.track is not None and recording.report.skipped == 0
    assert [one.code for one in recording.report.faults] == []
    assert recording.scans[3].ranges == pytest.approx(
        open_log(written(tmp_path, FORMS["plain"], "p")).scans[3].ranges
    )


@pytest.mark.parametrize("unit", [100, 1000])
def test_ranges_of_a_carmen_log_are_brought_to_metres(unit, tmp_path):
    def scaled(line: str) -> str:
        words = line.split()
        at = slice(2, 182) if words[0] == "FLASER" else slice(0, 0)
        words[at] = [f"{unit * (1 + float(word)):.1f}" for word in words[at]]
        return " ".join(words)

    recording = open_log(written(tmp_path, "\n".join(map(scaled, carmen_lines())).encode()))
    assert [one.code for one in recording.report.faults] == ["scan.units"]
    assert np.nanmedian(recording.scans[0].ranges) < 20


@pytest.mark.parametrize(("unit", "since_start"), [(1e3, False), (1e6, False), (1e9, False), (1e3, True)])
def test_times_of_a_carmen_log_in_parts_of_a_second_are_brought_to_seconds(unit, since_start, tmp_path):
    def scaled(line: str) -> str:
        words = line.split()
        if words[0] in ("FLASER", "ODOM"):
            words[-3], words[-1] = (f"{unit * (float(words[k]) - since_start * 1.7e9):.0f}" for k in (-3, -1))
        return " ".join(words)

    recording = open_log(written(tmp_path, "\n".join(map(scaled, carmen_lines(20))).encode()))
    assert "clock.unit" in [one.code for one in recording.report.faults]
    assert len(recording.scans) == 20 and recording.report.skipped == 0 and recording.track is not None
    stamps = [scan.stamp for scan in recording.scans]
    assert np.diff(stamps) == pytest.approx(0.2, abs=1e-3)
    assert recording.track.times[-1] == pytest.approx(stamps[-1], abs=0.1)


@pytest.mark.parametrize("times", [1000, 0.001])
def test_times_of_all_clocks_in_another_unit_are_brought_to_seconds(times, tmp_path):
    rows = []
    for name, kind, stamp, message in robot_messages(two, scans=30):
        stamp = START + times * (stamp - START)
        timed = name in ("/scan", "/odom")
        header = two.header(stamp, message.header.frame_id) if timed else None
        rows.append((name, kind, stamp, replace(message, header=header) if timed else message))
    recording = open_log(write_mcap(tmp_path / "a.mcap", rows))
    assert [one.code for one in recording.report.faults] == ["clock.unit"]
    assert recording.scans[-1].stamp - recording.scans[0].stamp == pytest.approx(2.9, abs=0.01)
    assert recording.track is not None and np.ptp(recording.track.times) == pytest.approx(2.95, abs=0.01)


def on_the_move(change):
    """An MCAP recording's messages, whose scans come nearer by 2 cm each; `change` their ranges (90,)."""
    rng, number = np.random.default_rng(3), 0
    for name, kind, stamp, message in robot_messages(two, scans=40):
        if name == "/scan":
            ranges = 3.0 - 0.02 * number + 0.01 * np.arange(90) + rng.normal(0, 0.01, 90)
            message, number = replace(message, ranges=change(ranges.astype(np.float32))), number + 1
        yield name, kind, stamp, message


def of_part(value):
    """Fill in `value` for a third of the ranges."""
    return lambda ranges: np.where(np.arange(90) < 30, value, ranges).astype(np.float32)


@pytest.mark.parametrize("change", [of_part(0.25), of_part(2.0)])
def test_beams_that_stand_while_the_robot_moves_are_left_out_and_named(change, tmp_path):
    recording = open_log(write_mcap(tmp_path / "a.mcap", on_the_move(change)))
    assert [one.code for one in recording.report.faults] == ["scan.standing_beams"]
    assert all(np.isnan(scan.ranges[:30]).all() and scan.valid[30:].all() for scan in recording.scans)


def test_a_mark_for_nothing_there_is_told_wherever_it_lies(tmp_path):
    rows = on_the_move(lambda ranges: np.where(ranges > 2.9, np.float32(4.0), ranges))
    recording = open_log(write_mcap(tmp_path / "a.mcap", rows))
    assert [one.code for one in recording.report.faults] == ["scan.no_return_mark"]
    assert max(scan.ranges[scan.valid].max(initial=0.0) for scan in recording.scans) < 2.91


def test_sound_scans_of_a_robot_on_the_move_have_no_fault(tmp_path):
    assert open_log(write_mcap(tmp_path / "a.mcap", on_the_move(lambda ranges: ranges))).report.faults == ()


def test_ranges_whose_bytes_are_in_another_order_are_refused(tmp_path):
    rows = [
        (*row[:3], replace(row[3], ranges=row[3].ranges.byteswap()) if row[0] == "/scan" else row[3])
        for row in robot_messages(two)
    ]
    with pytest.raises(BadInput, match="order"):
        open_log(write_mcap(tmp_path / "a.mcap", rows))


def test_a_laser_that_sees_nothing_now_and_then_is_one_laser(tmp_path):
    rows, number = [], 0
    for name, kind, stamp, message in robot_messages(two, scans=60):
        number += name == "/scan"
        empty = name == "/scan" and number % 10 == 5
        rows.append(
            (name, kind, stamp, replace(message, ranges=np.full(90, np.inf, np.float32)) if empty else message)
        )
    recording = open_log(write_mcap(tmp_path / "a.mcap", rows))
    assert len(recording.scans) == 60 and recording.report.faults == ()


def test_a_cut_packed_log_is_read_as_far_as_it_goes(tmp_path):
    whole = write_mcap(tmp_path / "a.mcap", robot_messages(two), chunk_size=1000).read_bytes()
    assert len(open_log(written(tmp_path, gzip.compress(whole)[:-300], "a.mcap.gz")).scans) > 10


def archive(kind: str) -> bytes:
    stream = io.BytesIO()
    if kind == "zip":
        with zipfile.ZipFile(stream, "w") as packed:
            packed.writestr("a.log", TEXT)
    else:
        with tarfile.open(fileobj=stream, mode="w") as packed:
            packed.addfile(tarfile.TarInfo("a.log"), io.BytesIO())
    return stream.getvalue()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (archive("zip"), "archive of files"),
        (archive("tar"), "archive of files"),
        (b"rosbag2_bagfile_information:\n  version: 9\n", "Give the folder"),
        (TEXT.replace("FLASER 180", "FLASER 178").encode(), "more numbers than it says"),
    ],
)
def test_what_cannot_be_read_is_refused_with_its_remedy(content, words, tmp_path):
    with pytest.raises(BadInput, match=words):
        open_log(written(tmp_path, content))


def test_a_bag_from_before_version_2_names_its_remedy(tmp_path):
    with pytest.raises(BadInput, match="rosbag fix"):
        open_log(written(tmp_path, b"#ROSBAG V1.2\n" + bytes(500), "old.bag"))


@pytest.mark.parametrize(
    ("change", "found"),
    [
        (lambda p: p[:, [1, 0, 2]], ["odometry.mirrored"]),
        (lambda p: p * [-1, 1, 1], ["odometry.mirrored"]),
        (lambda p: p * [1, -1, 1], ["odometry.mirrored"]),
        (lambda p: p * [1, 1, -1], ["odometry.mirrored"]),
        (lambda p: p * [-1, -1, 1], []),
        (lambda p: p + np.array([0, 0, math.pi / 2]), []),
        (lambda p: p, []),
    ],
)
def test_places_mirrored_against_their_headings_are_mirrored_back(change, found):
    report = ReadReport(Path("x"))
    track = believable_track("odo", TIMES, change(circle(TIMES)), None, report)
    assert track is not None and codes(report) == found
    if found:
        assert np.abs(track.speeds - 0.3).max() < 0.01


def right_angles() -> np.ndarray:
    """Poses (200, 3) round a rectangle of corridors, each the same way twice."""
    ends = np.array([[0, 0], [6, 0], [6, 4], [0, 4], [0, 0], [6, 0], [6, 4], [0, 4], [0, 0]], float)
    way, along = np.append(0, np.cumsum(np.hypot(*np.diff(ends, axis=0).T))), np.linspace(0, 39.9, 200)
    heading = (math.pi / 2) * (np.searchsorted(way, along, side="right") - 1)
    return np.column_stack([np.interp(along, way, ends[:, 0]), np.interp(along, way, ends[:, 1]), heading])


@pytest.mark.parametrize(
    ("change", "found"),
    [
        (lambda p: p, []),
        (lambda p: p * [-1, 1, 1], ["odometry.mirrored"]),
        (lambda p: p[:, [1, 0, 2]], ["odometry.mirrored"]),
        (lambda p: p * [1, 1, -1], ["odometry.mirrored"]),
        (lambda p: p * [1, 1, 0], ["odometry.no_heading"]),
    ],
)
def test_corridors_at_right_angles_tell_as_much_of_headings(change, found):
    report = ReadReport(Path("x"))
    track = believable_track("odo", 7 * TIMES, change(right_angles()), None, report)
    assert codes(report) == found and (track is None) == (found == ["odometry.no_heading"])


def test_a_base_that_drives_round_corners_without_a_turn_is_one_that_goes_sideways():
    report, speeds = ReadReport(Path("x")), np.tile([0.286, 0.0], (200, 1))
    assert believable_track("odo", 7 * TIMES, right_angles() * [1, 1, 0], speeds, report) is not None
    assert codes(report) == []


@pytest.mark.parametrize(
    "kept",
    [
        lambda h: np.clip((h + math.pi) % math.tau - math.pi, 0, math.pi),
        lambda h: np.clip(h % math.tau, 0, math.pi),
        lambda h: h % math.pi,
        lambda h: np.abs((h + math.pi) % math.tau - math.pi),
        lambda h: np.arctan(np.tan(h)),
    ],
)
def test_headings_kept_within_half_a_turn_are_not_believed(kept):
    report, poses = ReadReport(Path("x")), circle(TIMES)
    poses[:, 2] = kept(poses[:, 2])
    assert believable_track("odo", TIMES, poses, None, report) is None and codes(report) == ["odometry.half_turn"]


@pytest.mark.parametrize(
    ("steps", "said"),
    [((0.1, 1e-9), "0.1 m"), ((1.0, 1e-9), "1 m"), ((1e-9, math.radians(5)), "5°"), ((0.001, 0.001), "")],
)
def test_rounded_odometry_is_named_and_used(steps, said):
    step, report = np.array([steps[0], *steps]), ReadReport(Path("x"))
    poses = circle(TIMES, 2.0)
    assert believable_track("odo", TIMES, np.round(poses / step) * step, None, report) is not None
    assert codes(report) == (["odometry.rounded"] if said else [])
    assert not said or f"steps of {said} only" in report.report("test").faults[0].sentence


def test_a_base_that_is_driven_evenly_is_not_rounded():
    report, way = ReadReport(Path("x")), np.minimum(0.1 * np.arange(len(TIMES)), 8.0)
    even = np.column_stack([way, np.zeros_like(way), np.zeros_like(way)])
    assert believable_track("odo", TIMES, even, None, report) is not None and codes(report) == []


def test_a_base_that_goes_sideways_has_sound_headings():
    report, way = ReadReport(Path("x")), np.linspace(0.0, 4.0, 200)
    aside = np.column_stack([np.minimum(way, 2.0), np.maximum(way - 2.0, 0.0), 0.1 * way])
    assert believable_track("odo", TIMES, aside, None, report) is not None and codes(report) == []


def test_an_odometry_at_its_origin_after_a_silence_began_anew():
    report, poses = ReadReport(Path("x")), np.column_stack([0.01 * np.arange(200), np.zeros(200), np.zeros(200)])
    times, twice = np.concatenate([TIMES, TIMES + 60.0]), np.concatenate([poses, poses])
    track = believable_track("odo", times, twice, None, report)
    assert track is not None and codes(report) == ["odometry.restarted"] and track.poses[-1, 0] > 3.9


@pytest.mark.parametrize("unit", [1e-3, 1e-6, 1e3])
def test_times_in_another_unit_are_taken_for_it(unit):
    report, stamps = ReadReport(Path("x")), 0.2 * np.arange(50)
    assert seconds_per_unit(stamps / unit, "the laser", report) == unit and codes(report) == ["clock.unit"]
    assert seconds_per_unit(1e4 + 15 * stamps, "the laser", report) == 1.0


def test_a_file_that_begins_again_is_used_in_its_longest_part_and_one_in_no_order_whole():
    stamps = np.concatenate([TIMES[:150], TIMES])
    assert longest_part(stamps) == (150, 350)
    assert longest_part(np.random.default_rng(1).permutation(TIMES)) == (0, 200)
    assert longest_part(np.concatenate([TIMES[100:], TIMES[:100]])) == (0, 200)


def test_messages_in_no_order_are_read_by_their_stamps(tmp_path):
    messages = robot_messages(two, scans=60)
    np.random.default_rng(1).shuffle(messages)
    recording = open_log(write_mcap(tmp_path / "shuffled.mcap", messages))
    assert len(recording.scans) == 60 and recording.report.warnings == ()


@pytest.mark.parametrize(
    ("ranges", "words"),
    [
        (np.full(180, 2.0), "as long, scan after scan"),
        (2.0 + np.random.default_rng(2).normal(0, 0.01, 180), "as long, scan after scan"),
        (np.arange(180) % 90, "whole numbers"),
    ],
)
def test_what_fills_in_for_ranges_is_refused(ranges, words, tmp_path):
    told = [(topic, kind, stamp, two.scan(stamp, ranges) if topic == "/scan" else one)
            for topic, kind, stamp, one in robot_messages(two)]  # fmt: skip
    with pytest.raises(BadInput, match=words):
        open_log(write_mcap(tmp_path / "filled.mcap", told))


SCAN_STAMPS_S = 0.2 * np.arange(100)


@pytest.mark.parametrize("signed", [False, True])
@pytest.mark.parametrize(
    ("span", "per_second"),
    [
        (2**16, 1e3),
        (2**24, 1e3),
        (2**31, 1e6),
        (2**32, 1e6),
        (2**32, 1e3),
        (86400, 1.0),
        (86400_000, 1e3),
        (604800, 1.0),
        (604800 * 10**6, 1e6),
    ],
)
def test_a_counter_that_is_full_goes_on(span: int, per_second: float, signed: bool) -> None:
    report = ReadReport(Path("x"))
    counted = per_second * (SCAN_STAMPS_S - 8.0) + (span / 2 if signed else span)
    times = (counted + span / 2) % span - span / 2 if signed else counted % span
    assert np.count_nonzero(np.diff(times) < 0) == 1
    assert unwrapped(times, "laser", report) == pytest.approx(counted)
    assert codes(report) == ["clock.counter"]


@pytest.mark.parametrize(
    "times",
    [
        1.7e9 + SCAN_STAMPS_S,
        np.where(SCAN_STAMPS_S > 8, SCAN_STAMPS_S - 3, SCAN_STAMPS_S),  # the clock was set
        np.concatenate((SCAN_STAMPS_S, SCAN_STAMPS_S)),  # two recordings
        np.concatenate((SCAN_STAMPS_S + 65_000, SCAN_STAMPS_S)),
        SCAN_STAMPS_S[::-1],
        np.zeros(100),
        np.full(100, np.nan),
        np.empty(0),
    ],
)
def test_times_that_are_no_full_counter_stay(times: np.ndarray) -> None:
    report = ReadReport(Path("x"))
    assert unwrapped(times, "laser", report) is times and codes(report) == []


def test_a_pause_makes_no_clock_slow() -> None:
    report = ReadReport(Path("x"))
    times = np.where(TIMES[100] < TIMES, TIMES + 5000.0, TIMES)
    settled, good = settled_stamps(StampedStream("laser", times, times + 0.01), report)
    assert settled.own == pytest.approx(times) and good.all() and codes(report) == []


def test_both_halves_of_a_log_whose_counter_was_full_are_in_their_order(tmp_path: Path) -> None:
    lines = [one for one in carmen_lines(60) if one.startswith("FLASER")]

    def at(line: str, time: float) -> str:
        words = line.split()
        return " ".join([*words[:-3], f"{time}", words[-2], f"{time}"])

    log = tmp_path / "a.log"
    log.write_text("\n".join(at(line, (k * 200 + 2**32 - 5000) % 2**32) for k, line in enumerate(lines)) + "\n")
    read = open_log(log)
    assert np.diff([one.stamp for one in read.scans]) == pytest.approx(0.2)
    assert [one.code for one in read.report.faults] == ["clock.counter", "clock.unit"]


def sparse_carmen_lines(times: np.ndarray) -> list[str]:
    """A log of a scan every 1.1 m along a straight corridor; its ODOM lines have times that are no clock's."""
    ranges = " ".join(f"{value:.2f}" for value in RANGES)
    lines = []
    for number, time in enumerate(times.tolist()):
        pose = f"{1.1 * number:.2f} 0 0"
        lines += [f"FLASER 180 {ranges} {pose} {pose} {time} robot {time}"]
        lines += [f"ODOM {pose} 0 0 0 {(number % 2) * 4294967295} robot {number % 7}"]
    return lines


@pytest.mark.parametrize(
    "times", [np.zeros(40), np.full(40, 1.01893e9), np.repeat([1.13486e9, 1.13487e9], 20), np.full(40, 4294967295)]
)
def test_scans_without_times_keep_the_odometry_beside_them(times, tmp_path):
    """The pace is made up then, so it cannot speak against the odometry."""
    recording = open_log(written(tmp_path, "\n".join(sparse_carmen_lines(times)).encode()))
    assert [one.code for one in recording.report.faults] == ["clock.none"]
    assert recording.track is not None and recording.track.poses[-1, 0] == pytest.approx(1.1 * 39)
    assert 0.1 < 1.1 * 39 / recording.duration < 1.0  # [m/s]


def test_odometry_in_centimetres_is_found_without_times_too(tmp_path):
    words = [line.split() for line in sparse_carmen_lines(np.zeros(40)) if line.startswith("FLASER")]
    for number, row in enumerate(words):
        row[182] = row[185] = str(110.0 * number)
    recording = open_log(written(tmp_path, "\n".join(" ".join(row) for row in words).encode()))
    assert recording.track is None and "odometry.too_fast" in [one.code for one in recording.report.faults]


@pytest.mark.parametrize("period", [0.025, 0.1, 0.6])
def test_readings_that_are_stamped_late_are_no_jumps(period):
    """A computer that is busy reads two scans at once: the way between them takes no time by their stamps."""
    rng, count = np.random.default_rng(1), 400
    times = period * np.arange(count) + rng.choice([0.0, 0.95 * period], count, p=[0.8, 0.2])
    poses = np.column_stack([0.6 * period * np.arange(count), np.zeros(count), np.zeros(count)])
    report = ReadReport(Path("x"))
    track = believable_track("odo", times, poses, None, report)
    assert codes(report) == [] and track is not None and track.poses == pytest.approx(poses)
    poses[200:, 0] += 2.5
    assert believable_track("odo", times, poses, None, report) is not None and codes(report) == ["odometry.restarted"]


def test_a_stamp_years_away_takes_no_memory() -> None:
    times, poses = 0.1 * np.arange(200), np.zeros((200, 3))
    poses[:, 0], times[-1] = 0.02 * np.arange(200), 1.7e9
    report = ReadReport(Path("x"))
    tracemalloc.start()
    track = believable_track("the wheels", times, poses, np.tile([0.2, 0.0], (200, 1)), report)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert track is not None and report.report("x").faults == () and peak < 1e7


@pytest.mark.parametrize("made_up", [False, True])
def test_a_pace_that_was_made_up_says_nothing_of_speeds(made_up: bool) -> None:
    times, poses = 0.1 * np.arange(200), np.zeros((200, 3))
    poses[:, 0] = 0.2 * np.arange(200)
    report = ReadReport(Path("x"))
    if made_up:
        report.fault("clock.none", "the laser", used=True, rate="10")
    believable_track("the wheels", times, poses, np.tile([0.2, 0.0], (200, 1)), report)
    assert report.has_fault("odometry.speeds") is not made_up
