"""A log through the estimators: the robot is where it was, and the files say so."""

import json
import math
import re
from dataclasses import replace
from html.parser import HTMLParser
from types import SimpleNamespace
from typing import cast

import cv2
import numpy as np
import pytest

from core.errors import BadInput, Unavailable
from core.gate import Twist
from core.geometry import Pose
from core.pilot import Pilot
from core.pipelines import slam
from core.pipelines.record import RobotRecording
from core.pipelines.slam import ChosenSensors, slam_log
from core.pipelines.slam_report import landmarks_csv, trajectory_tum
from core.recording.drive import DriveRecording
from core.robots.connect import connect
from core.robots.requests import Speak
from core.sensors.checks import UnusableReading
from core.settings import Settings, read
from core.simulation.faulty_robot import open_robot
from core.simulation.settings import SimulationSettings
from core.slam.estimate import Landmark


def test_a_trajectory_line_has_eight_columns_and_gives_the_pose_back():
    text = trajectory_tum([1_700_000_000.25, -0.5], [Pose(1.5, -2.25, 3.0), Pose(0, 0, -0.1)])
    lines = text.split("\n")
    assert lines[0].startswith("1700000000.250000 1.500000 -2.250000 0 0 0 ") and lines[2] == ""
    for line, heading in zip(lines, (3.0, -0.1), strict=False):
        words = line.split(" ")
        assert len(words) == 8
        assert 2 * math.atan2(float(words[6]), float(words[7])) == pytest.approx(heading, abs=1e-8)


def test_the_table_of_landmarks_is_read_back_by_its_header():
    mark = Landmark(
        id=7,
        position=np.array([1, -2]),
        covariance=np.array([[4e-4, 1e-5], [1e-5, 9e-4]]),
        hits=5,
        misses=1,
        kind="convex",
    )
    header, row, _ = landmarks_csv([mark]).split("\n")
    assert dict(zip(header.split(","), row.split(","), strict=True)) == {
        "id": "7", "x_m": "1.000000", "y_m": "-2.000000", "var_x_m2": "0.0004", "cov_xy_m2": "1e-05",
        "var_y_m2": "0.0009", "hits": "5", "misses": "1", "kind": "convex",
    }  # fmt: skip


MARKS = np.array(
    [[3.0, 1.0], [4.0, -2.0], [0.0, 3.0], [-2.0, 0.5], [1.0, -2.5], [2.5, 3.5], [-1.5, -2.0], [4.5, 1.5]]
)


@pytest.fixture
def circling(tmp_path):
    """A corridor-form log: 300 steps around a circle of 1 m, eight landmarks all seen, truth after every step."""
    rng = np.random.default_rng(5)
    pose, rows, odometry, truth = Pose(), [], [], []
    for k in range(300):
        pose = pose @ Pose(0.05, 0.0, 0.05)
        truth.append(pose)
        odometry.append(np.array([0.05, 0.0, 0.05]) + rng.normal(0, [0.003, 0.001, 0.004]))
        for number, (x, y) in enumerate(MARKS):
            sighting = (pose.distance_to(x, y) + rng.normal(0, 0.03), pose.bearing_to(x, y) + rng.normal(0, 0.01))
            rows.append([k, number + 100, *sighting])
    covariance = np.tile([9e-6, 0, 0, 1e-6, 0, 1.6e-5], (300, 1))
    path = tmp_path / "circle.npz"
    np.savez(path, odo=np.array(odometry), odo_cov=covariance, obs=np.array(rows))
    return SimpleNamespace(path=path, truth=truth)


@pytest.mark.parametrize("ids", ["given", "hidden"])
def test_sightings_lead_back_to_the_true_path_and_landmarks(circling, ids):
    result = slam_log(circling.path, ids=ids)
    errors = [pose.distance_to(true.x, true.y) for pose, true in zip(result.poses, circling.truth, strict=True)]
    assert np.mean(errors) < 0.03
    assert len(result.landmarks) == len(MARKS)
    for mark in result.landmarks:
        nearest = np.hypot(*(MARKS - mark.position).T)
        assert nearest.min() < 0.1
        if ids == "given":
            assert result.identities[mark.id] == 100 + nearest.argmin()
    assert bool(result.identities) == (ids == "given")


def test_what_is_told_is_plain_and_finite(circling):
    told = json.loads(json.dumps(slam_log(circling.path).json(), allow_nan=False))
    assert told["frames"] == 300 and told["duration_s"] == pytest.approx(59.8)
    assert told["path_m"] == pytest.approx(15.0, rel=0.05)
    assert {"id", "x_m", "y_m", "cov_m2", "hits", "misses"} <= set(told["landmarks"][0])
    assert np.array(told["landmarks"][0]["cov_m2"]).shape == (2, 2)
    assert told["files"] == {"trajectory_tum": None, "map_yaml": None}
    assert "processing_s" not in told  # nothing here reads a clock


def test_a_sightings_log_leaves_a_trajectory_and_landmarks_but_no_map(circling, tmp_path):
    files = slam_log(circling.path, out=tmp_path / "new" / "out").files
    assert files["map_yaml"] is None
    assert len((tmp_path / "new/out/trajectory.tum").read_text().splitlines()) == 300
    assert len((tmp_path / "new/out/landmarks.csv").read_text().splitlines()) == 1 + len(MARKS)


def test_the_report_is_one_file_that_needs_no_network_and_shows_everything(circling, tmp_path):
    path = circling.path.rename(circling.path.with_name("<i>circle & more.npz"))
    settings = read("[ekf]\ngate = 7.5\n")
    result = slam_log(path, settings, out=tmp_path / "out")
    text = (tmp_path / "out" / "report.html").read_text()
    assert result.files["report_html"] == str(tmp_path / "out" / "report.html")
    assert "http" not in text.replace("http-equiv", "") and "<script" not in text and "<i>" not in text
    assert "&lt;i&gt;circle &amp; more.npz" in text
    assert text.count("<ellipse") == len(result.landmarks) == len(MARKS)
    assert text.count('<polyline class="way"') == 4  # way, NIS, standard deviation, time
    assert "ekf.gate" in text and "7.5 (else" in text
    [way, *_] = re.findall(r'<polyline class="way" points="([^"]*)"', text)
    points = np.array([one.split(",") for one in way.split()], float) * [1, -1]
    assert points == pytest.approx(np.array([(pose.x, pose.y) for pose in result.poses]), abs=1e-3)
    assert np.isfinite(result.course.nis[-1]) and (result.course.step_ms > 0).all()
    parser = CountingParser()
    parser.feed(text)
    assert parser.open == []


class CountingParser(HTMLParser):
    """Every element that is begun is ended."""

    EMPTY = ("meta", "line", "rect", "image", "circle", "polyline")

    def __init__(self):
        super().__init__()
        self.open = []

    def handle_starttag(self, tag, attrs):
        if tag not in self.EMPTY:
            self.open.append(tag)

    def handle_endtag(self, tag):
        if tag not in self.EMPTY:
            assert self.open.pop() == tag


def test_a_place_that_cannot_be_written_to_is_told(circling, tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(Unavailable, match="cannot be made"):
        slam_log(circling.path, out=tmp_path / "file" / "out")


def test_the_same_log_gives_the_same_numbers(circling):
    assert slam_log(circling.path).poses == slam_log(circling.path).poses


def test_what_is_no_log_is_refused(tmp_path):
    with pytest.raises(BadInput, match="There is no file"):
        slam_log(tmp_path / "absent.mcap")


@pytest.fixture(scope="module")
def driven(tmp_path_factory):
    """A CARMEN log of the simulated laboratory: 2 s at rest, then an arc, 15 s in all; the truth at every scan."""
    robot = connect("sim:lab", seed=4, settings=SimpleNamespace(simulation=SimulationSettings(camera=False)))
    laser = robot.profile.laser
    lines, truth = [], []
    for tick in range(15 * 40):
        robot.drive(Twist(0.15, 0.25) if tick > 80 else Twist())
        frame = robot.read()
        if frame.scan is None:
            continue
        scan, wheels = frame.scan, frame.wheels
        ranges = np.where(np.isposinf(scan.ranges), scan.range_max, np.nan_to_num(scan.ranges))
        body, eye = wheels.odometry, wheels.odometry @ laser.mounting
        words = ["ROBOTLASER1", 0, scan.angle_min, 4.0, scan.angle_step, scan.range_max, 0.01, 0, len(ranges)]
        words += [f"{value:.3f}" for value in ranges] + [0]
        words += [eye.x, eye.y, eye.heading, body.x, body.y, body.heading, wheels.speed, wheels.turn_rate, 0, 0, 0]
        lines.append(" ".join(map(str, [*words, f"{frame.stamp:.6f}", "host", f"{frame.stamp:.6f}"])))
        truth.append(frame.truth)
    folder = tmp_path_factory.mktemp("driven")
    (folder / "lab.log").write_text("\n".join(lines))
    return SimpleNamespace(path=folder / "lab.log", lines=lines, truth=truth, folder=folder)


def test_scans_with_odometry_lead_to_the_true_pose_a_map_and_its_corners(driven):
    result = slam_log(driven.path, out=driven.folder / "out")
    assert len(result.poses) == len(driven.lines) == 150
    end, true = result.poses[-1], driven.truth[-1]
    assert end.distance_to(true.x, true.y) < 0.05
    assert len(result.landmarks) >= 4
    scales = result.json()["wheels_over_scans"]
    assert scales["way"] == pytest.approx(1.0, abs=max(0.05, 4 * scales["way_sd"]))
    assert result.path == pytest.approx(0.15 * 13, rel=0.08)
    stamps = [float(line.split()[0]) for line in (driven.folder / "out/trajectory.tum").read_text().splitlines()]
    assert stamps == pytest.approx([float(line.split()[-1]) for line in driven.lines])
    picture = (driven.folder / "out/map.pgm").read_bytes()
    assert picture.startswith(b"P5\n")
    assert {0, 205, 254} == set(picture.split(b"\n", 3)[3])
    shown = cv2.imread(str(driven.folder / "out/map.png"), cv2.IMREAD_UNCHANGED)
    assert shown.tobytes() == picture.split(b"\n", 3)[3]
    assert "data:image/png;base64," in (driven.folder / "out/report.html").read_text()
    assert "image: map.pgm" in (driven.folder / "out/map.yaml").read_text()


@pytest.mark.campaign
def test_scans_alone_lead_close_to_it(driven):
    bare = []
    for line in driven.lines:
        words = line.split(" ")
        words[-14:-3] = ["0"] * 11
        bare.append(" ".join(words))
    path = driven.folder / "bare.log"
    path.write_text("\n".join(bare))
    result = slam_log(path)
    assert not result.recording.has_wheels
    end, true = result.poses[-1], driven.truth[-1]
    assert end.distance_to(true.x, true.y) < 0.15
    assert abs((true.inverse() @ end).heading) < math.radians(5)


def test_own_recordings_and_logs_alike_end_where_nothing_fits(tmp_path):
    robot, rng = open_robot("lab", seed=5, settings=None), np.random.default_rng(2)
    pilot, stamps, stands = Pilot(robot.profile, Settings()), [], []
    for _ in range(400):
        robot.drive(Twist(0.2, 0.4))
        frame = replace(robot.read(), image=None)
        if frame.scan is not None:
            frame = replace(frame, scan=replace(frame.scan, ranges=rng.uniform(0.1, 1.0, len(frame.scan.ranges))))
            stamps.append(frame.stamp)
            stands.append(pilot.anchored_pose)
        pilot.step(frame)
    run = slam._PilotRun(pilot, stamps, stands, [], slam._CourseTaker().course())
    with pytest.raises(UnusableReading, match="no distances") as told:
        slam._result(cast(DriveRecording, SimpleNamespace(path=tmp_path / "own.mcap")), run)
    assert [one.code for one in told.value.faults] == ["agreement.no_fit"]


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """Five seconds of a robot without a camera, recorded with scans, sound and the truth."""
    path = tmp_path_factory.mktemp("recorded") / "drive.mcap"
    robot = open_robot("lab", seed=3, settings=SimulationSettings(camera=False))
    robot.ask(Speak(text="hello", x_m=1.0, y_m=0.0, id="person"))
    recording = RobotRecording(robot, path)
    for _ in range(200):
        recording.add()
    recording.file.finish()
    return path


def test_an_estimate_is_made_from_the_chosen_sensors_alone(recorded):
    every, laser = slam_log(recorded), slam_log(recorded, sensors=ChosenSensors(True, 0, False))
    blind = slam_log(recorded, sensors=ChosenSensors(False, 0, True))
    assert len(every.poses) == len(laser.poses) == len(blind.poses) > 20
    assert laser.landmarks and not blind.landmarks
    assert blind.errors == pytest.approx({"mean_m": 0.0, "worst_m": 0.0, "final_m": 0.0}, abs=0.01)  # it stood
    assert "error" in laser.json()
    for chosen in (ChosenSensors(True, 1, True), ChosenSensors.named("camera, laser")):
        with pytest.raises(BadInput, match="has no camera that"):
            slam_log(recorded, sensors=chosen)


def test_sensors_are_named_and_sightings_have_none(circling):
    assert ChosenSensors.named("laser,microphones") == ChosenSensors(True, 0, True)
    for text in ("", "laser,,camera", "voice"):
        with pytest.raises(BadInput, match="Sensors are some of laser, camera, microphones"):
            ChosenSensors.named(text)
    with pytest.raises(BadInput, match="no sensor to choose"):
        slam_log(circling.path, sensors=ChosenSensors())
