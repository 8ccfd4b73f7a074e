"""A real URG-04LX carried by hand through a room: no wheels, no truth."""

import itertools
from pathlib import Path

import numpy as np
import pytest

from core.geometry import Pose, wrap
from core.perception.landmarks.corners import find_corners
from core.perception.landmarks.deskew import deskew
from core.perception.landmarks.landmarks import sight
from core.recording import ScanRecording, open_log
from core.slam.association.visibility import VisibilityCheck
from core.slam.ekf_slam import EkfSlam
from core.slam.scan_matching.scan_odometry import ScanOdometry

pytestmark = pytest.mark.real_data


@pytest.fixture(scope="module")
def recording(shared_data: Path) -> ScanRecording:
    log = open_log(shared_data / "urg04lx_handheld" / "urg04lx_handheld.mcap")
    assert isinstance(log, ScanRecording)
    return log


SOME_SCANS = [pytest.param(90, 0.6, id="a third"), pytest.param(278, 2.0, id="all", marks=pytest.mark.campaign)]


@pytest.mark.parametrize(("scans", "path"), SOME_SCANS)
def test_every_scan_finds_its_place_on_the_scans_before_it(recording: ScanRecording, scans: int, path: float) -> None:
    odometry, poses, scores = ScanOdometry(recording.laser), [Pose()], []
    for frame in itertools.islice(recording, scans):
        assert frame.scan is not None
        odometry.update(frame.scan)
        poses.append(odometry.pose)
        scores.append(odometry.score)
    steps = [b.distance_to(a.x, a.y) for a, b in itertools.pairwise(poses)]
    turns = [abs(wrap(b.heading - a.heading)) for a, b in itertools.pairwise(poses)]
    assert min(score for score in scores if score is not None) > 0.7
    assert max(steps) < 0.08
    assert max(turns) < 0.15
    assert path < sum(steps) < 4 * path


@pytest.mark.parametrize(("scans", "path"), SOME_SCANS)
def test_the_filter_holds_a_small_map_of_the_real_room(recording: ScanRecording, scans: int, path: float) -> None:
    odometry, slam, apart = ScanOdometry(recording.laser), EkfSlam(laser=recording.laser), []
    for frame in itertools.islice(recording, scans):
        assert frame.scan is not None
        step = odometry.update(frame.scan)
        points, beams = deskew(frame.scan, recording.laser, odometry.wheels, frame.stamp)
        sightings, _ = sight(find_corners(frame.scan, recording.laser, points, beams), stamp=frame.stamp)
        slam.advance(step)
        slam.see(sightings, VisibilityCheck(frame.scan, recording.laser.mounting))
        apart.append(slam.estimate.pose.distance_to(odometry.pose.x, odometry.pose.y))
    assert max(apart) < 0.15
    assert 4 <= len(slam.landmarks) <= 30
    assert np.sqrt(np.diag(slam.estimate.covariance)).max() < 0.05
