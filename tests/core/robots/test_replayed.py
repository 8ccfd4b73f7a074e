"""A recording plays in its own time, can be steered, and cannot be driven."""

import itertools
import json

import msgspec
import numpy as np
import pytest

from core.errors import BadInput
from core.gate import Twist
from core.pilot.replayed_drive import open_robot
from core.pipelines.slam import slam_log
from core.robots.replayed import ReplayedRobot
from core.robots.requests import Pause, Play, ReadMarks, ReadTruth, Seek, SetSpeed

SCANS = 30


@pytest.fixture
def scans(tmp_path):
    """A log of 30 scans at 10 Hz without odometry; the range of its first beam is its number + 1."""
    path = tmp_path / "scans.jsonl"
    angles = {"angle_min": -0.1, "angle_increment": 0.1}
    rows = [{"t": 5 + 0.1 * n, "ranges": [n + 1, n + 2, n + 3]} | angles for n in range(SCANS)]
    path.write_text("".join(json.dumps(row) + "\n" for row in rows))
    return path


@pytest.fixture
def drive(tmp_path):
    """A scan set of 2 scans 1 s apart with odometry 0.5 m apart."""
    path = tmp_path / "drive.npz"
    scan = np.linspace(150, 250, 180).astype(np.uint16)
    np.savez(path, t=[0.0, 1.0], odo_raw=[[1, 1, 0], [1.5, 1, 0]], scan_cm=[scan, scan])
    return path


def opened(path) -> ReplayedRobot:
    """Told to play."""
    robot = open_robot(str(path), seed=0, settings=None)
    robot.ask(Play())
    return robot


def numbers(frames):
    return [round(frame.scan.ranges[0]) - 1 for frame in frames if frame.scan is not None]


def until_the_end(robot):
    return list(itertools.takewhile(lambda frame: frame.running, (robot.read() for _ in range(10_000))))


def test_the_profile_says_what_it_is(scans):
    profile = opened(scans).profile
    assert (profile.kind, profile.drives, profile.name) == ("LOG", False, "scans.jsonl")
    assert profile.duration == pytest.approx(2.9) and profile.laser.beams == 3
    assert profile.url == f"log:{scans}"


def test_long_gaps_are_named_from_the_start_and_usual_periods_are_none(scans, drive, tmp_path):
    assert opened(scans).profile.gaps == () and opened(drive).profile.gaps == ()
    lines = scans.read_text().splitlines()
    broken = tmp_path / "broken.jsonl"
    broken.write_text("\n".join(lines[:5] + lines[20:]))
    assert opened(broken).profile.gaps == (pytest.approx((0.4, 2.0)),)


def test_every_scan_comes_once_in_its_own_time(scans):
    frames = until_the_end(opened(scans))
    assert numbers(frames) == list(range(SCANS))
    assert [frame.stamp for frame in frames if frame.scan] == pytest.approx(5 + 0.1 * np.arange(SCANS))
    assert all(frame.wheels is None for frame in frames)


def test_it_waits_at_its_first_scan_until_it_is_played(scans):
    robot = open_robot(str(scans), seed=0, settings=None)
    frames = [robot.read() for _ in range(200)]
    assert numbers(frames) == [0] and not frames[-1].running
    assert (frames[-1].stamp, frames[-1].progress) == (5.0, 0.0)
    robot.ask(Play())
    assert numbers(until_the_end(robot)) == list(range(1, SCANS))
    jumped = open_robot(str(scans), seed=0, settings=None)
    jumped.read()
    jumped.ask(Seek(value=0.5))
    assert not any(jumped.read().running for _ in range(20))


def test_time_passes_smoothly_between_scans(scans):
    robot = opened(scans)
    stamps = np.array([frame.stamp for frame in until_the_end(robot)])
    steps = np.diff(stamps)
    assert len(stamps) == pytest.approx(2.9 * robot.profile.rate, abs=4)
    assert steps.min() >= 0 and steps.max() <= 2.01 / robot.profile.rate


@pytest.mark.parametrize("speed", [0.1, 0.5, 2.0, 4.0, 10.0])
def test_at_any_speed_no_scan_is_left_out_and_time_never_goes_back(scans, speed):
    robot = opened(scans)
    robot.ask(SetSpeed(value=speed))
    frames = until_the_end(robot)
    assert numbers(frames) == list(range(SCANS))
    assert np.diff([frame.stamp for frame in frames]).min() >= 0
    if speed <= 2:
        assert len(frames) == pytest.approx(2.9 * 40 / speed, rel=0.05)


@pytest.mark.parametrize(("rate", "most"), [(2, 10.0), (10, 4.0), (40, 1.0)])
def test_the_speed_that_is_told_is_the_speed_it_plays_at(tmp_path, rate, most):
    path = tmp_path / "scans.jsonl"
    path.write_text("".join(json.dumps({"t": n / rate, "ranges": [1, 2, 3]}) + "\n" for n in range(4 * rate + 1)))
    robot = opened(path)
    for asked in (0.5, 1.0, 5.0, 10.0):
        robot.ask(Play())
        told = robot.ask(SetSpeed(value=asked)).speed
        assert told == pytest.approx(min(asked, most))
        frames = until_the_end(robot)
        assert len(numbers(frames)) == 4 * rate + 1
        assert 4.0 * robot.profile.rate / len(frames) == pytest.approx(told, rel=0.1)


def test_wheels_are_told_for_every_frame(drive):
    frames = until_the_end(opened(drive))
    for frame in frames:
        assert frame.wheels.odometry.x == pytest.approx(0.5 * frame.stamp)
        assert frame.wheels.speed == pytest.approx(0.5)


def test_at_the_end_it_stands_and_says_so_once(scans):
    robot = opened(scans)
    until_the_end(robot)
    after = [robot.read() for _ in range(3)]
    assert all(not frame.running and frame.scan is None and frame.progress == 1.0 for frame in after)
    robot = opened(scans)
    notes = [note for frame in (robot.read() for _ in range(200)) for note in frame.notes]
    assert notes == ["The recording ends here."]


def test_play_after_the_end_starts_again(scans):
    robot = opened(scans)
    until_the_end(robot)
    state = msgspec.to_builtins(robot.ask(Play()))
    known = {key: state[key] for key in ("playing", "speed", "position_s", "duration_s", "progress")}
    assert known == pytest.approx(
        {"playing": True, "speed": 1.0, "position_s": 0.0, "duration_s": 2.9, "progress": 0.0}
    )
    assert numbers(until_the_end(robot)) == list(range(SCANS))


def test_a_pause_stops_time_and_loses_nothing(scans):
    robot = opened(scans)
    robot.ask(SetSpeed(value=10.0))
    before = [robot.read() for _ in range(7)]
    robot.ask(Pause())
    paused = [robot.read() for _ in range(5)]
    assert {frame.stamp for frame in paused} == {before[-1].stamp}
    assert all(not frame.running and frame.scan is None for frame in paused)
    robot.ask(Play())
    after = until_the_end(robot)
    assert numbers(before + after) == list(range(SCANS))
    assert after[0].stamp >= before[-1].stamp


@pytest.mark.parametrize(("share", "first"), [(0.0, 0), (0.5, 15), (1.0, 29)])
def test_seeking_goes_on_from_there(scans, share, first):
    robot = opened(scans)
    for _ in range(50):
        robot.read()
    answer = robot.ask(Seek(value=share))
    assert answer.position_s == pytest.approx(share * 2.9) and answer.playing
    frames = until_the_end(robot)
    assert numbers(frames) == list(range(first, SCANS))
    assert frames[0].stamp >= 5 + share * 2.9 - 1e-9


def test_progress_rises_to_the_whole(scans):
    robot = opened(scans)
    shares = [frame.progress for frame in until_the_end(robot)] + [robot.read().progress]
    assert shares[0] < 0.05 and shares[-1] == 1.0 and np.diff(shares).min() >= 0


def test_driving_changes_nothing(scans):
    robot = opened(scans)
    robot.drive(Twist(0.3, 1.0))
    assert numbers(until_the_end(robot)) == list(range(SCANS))
    robot.close()


@pytest.mark.parametrize(
    "request_",
    [
        ReadTruth(),
        SetSpeed(value=0.01),
        SetSpeed(value=21),
        SetSpeed(value=float("nan")),
        Seek(value=-0.1),
        Seek(value=1.1),
    ],
)
def test_requests_that_make_no_sense_are_refused_in_a_sentence(scans, request_):
    with pytest.raises(BadInput, match=r"\.$"):
        opened(scans).ask(request_)


def test_what_was_skipped_while_reading_is_told_with_the_first_frame(scans):
    scans.write_text(scans.read_text() + "{cut\n")
    assert "1 of 31 records skipped" in " ".join(opened(scans).read().notes)


def test_one_scan_is_a_recording_too(tmp_path):
    (tmp_path / "one.jsonl").write_text('{"t": 3.0, "ranges": [1, 2, 3]}\n')
    robot = opened(tmp_path / "one.jsonl")
    assert numbers(until_the_end(robot)) == [0]
    assert robot.read().progress == 1.0


@pytest.fixture
def sightings(tmp_path):
    """Sixty steps of 0.1 m past two landmarks, seen without an error."""
    places, rows = {7: np.array([2.0, 1.0]), 9: np.array([4.0, -1.0])}, []
    for step in range(60):
        for number, place in places.items():
            x, y = place - (0.1 * step, 0.0)
            rows.append([step, number, np.hypot(x, y), np.arctan2(y, x)])
    moves = np.tile([0.1, 0.0, 0.0], (60, 1))
    moves[0] = 0.0
    path = tmp_path / "log.npz"
    np.savez(path, odo=moves, odo_cov=np.tile([1e-4, 0, 0, 1e-4, 0, 1e-6], (60, 1)), obs=np.array(rows))
    return path


def test_sightings_play_as_slam_estimates_them(sightings):
    frames = until_the_end(opened(sightings))
    last, result = frames[-1].shown, slam_log(sightings)
    assert last.estimate.pose == result.poses[-1]
    assert [row.position.tolist() for row in last.landmarks] == [row.position.tolist() for row in result.landmarks]
    assert last.trail[-1] == pytest.approx([5.9, 0.0], abs=0.1) and last.velocity.v > 0
    assert last.progress == 1.0


def test_sightings_wait_at_their_first_step_and_are_sought_in_both_directions(sightings):
    robot = open_robot(str(sightings), seed=0, settings=None)
    assert (robot.read().progress, robot.read().running) == (0.0, False)
    for share in (0.75, 0.25):
        robot.ask(Seek(value=share))
        reads = (robot.read() for _ in range(10_000))
        frame = next(frame for frame in reads if frame.progress == pytest.approx(share))
        assert frame.shown.estimate.pose.x == pytest.approx(5.9 * share, abs=0.15) and not frame.running
    robot.ask(Play())
    assert until_the_end(robot)[-1].progress == 1.0
    assert robot.ask(ReadMarks()).marks == ()
