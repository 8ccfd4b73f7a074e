"""Recordings with defects that were met in public: as exact as the sound one, or the cause is named."""

from pathlib import Path

import numpy as np
import pytest

from core.errors import BadInput
from core.pipelines.slam import slam_log
from core.recording import ScanRecording, open_log

FOLDER = Path(__file__).parents[3] / "shared" / "data" / "strangers" / "recordings"
CONTROL_MEAN_M = 0.021  # of the sound recording of the same drive
QUICK = {"01d_laser_clock_4s.mcap": {"clock.differs"}}
OTHERS = {
    "04_odometry_reset.mcap": {"odometry.restarted"},
    "32_carmen_rawlaser.log": set[str](),
    "01_laser_clock_since_boot.mcap": {"clock.differs"},
    "02_clock_set_in_the_middle.mcap": {"clock.recorder_set", "clock.set"},
    "03_two_robots_one_bag.mcap": {"robots.several"},
    "05_odometry_quaternion_zero.mcap": {"odometry.no_heading"},
    "06_gps_odometry_quicker.mcap": {"odometry.several"},
    "08_upside_down.mcap": set[str](),
    "13_scan_in_mm.mcap": {"scan.units"},
    "16_recorder_died.bag.active": set[str](),
    "16d_sqlite_named.db": set[str](),
    "20_underscore_frames_tf_only.mcap": set[str](),
    "22_step_zero.mcap": {"scan.step_zero"},
    "31_carmen_fov_240.log": set[str](),
    "34_carmen_tabs.clf": set[str](),
}
NAMED = {
    "11b_split_later_half": "mount.unknown",
    "14c_no_return_just_below_max.mcap": "scan.no_return_mark",
    "27_missing_link_laser_turned_90.mcap": "mount.unknown",
    "50_carmen_stamps_zero.log": "clock.none",
    "53_scan_set_t_zero.npz": "clock.none",
}
REFUSED = {
    "15d_packed_folder": "unpack them first",
    "21_laser_on_its_side.mcap": "tilted by 90",
    "40_map_yaw/map.yaml": "a map of Nav2",
}

pytestmark = [
    pytest.mark.real_data,
    pytest.mark.skipif(not FOLDER.is_dir(), reason="needs ../shared/data/strangers beside the repository"),
]


def mean_error(path: Path) -> tuple[float, set[str]]:
    """The mean distance [m] to the truth, and the codes of the faults; stamps count from the first scan's second."""
    truth = np.genfromtxt(FOLDER / "truth.csv", delimiter=",", names=True)
    result = slam_log(path)
    assert isinstance(result.recording, ScanRecording)
    stamps = np.array(result.stamps) - np.floor(result.stamps[0])
    places = np.array([(pose.x, pose.y) for pose in result.poses])
    true = np.column_stack([np.interp(stamps, truth["t_s"], truth[name]) for name in ("x_m", "y_m")])
    found = {one.code for one in result.recording.report.faults}
    return float(np.linalg.norm(places - true, axis=1).mean()), found


@pytest.mark.parametrize(
    ("name", "codes"), [*QUICK.items(), *(pytest.param(*row, marks=pytest.mark.campaign) for row in OTHERS.items())]
)
def test_a_defect_that_can_be_mended_costs_no_exactness(name: str, codes: set[str]) -> None:
    error, found = mean_error(FOLDER / name)
    assert error <= 2 * CONTROL_MEAN_M and found == codes


@pytest.mark.parametrize(("name", "code"), NAMED.items())
def test_a_defect_that_costs_exactness_is_named(name: str, code: str) -> None:
    assert code in {one.code for one in open_log(FOLDER / name).report.faults}


@pytest.mark.parametrize(("name", "words"), REFUSED.items())
def test_what_cannot_be_used_is_refused_with_its_cause(name: str, words: str) -> None:
    with pytest.raises(BadInput, match=words):
        open_log(FOLDER / name)


@pytest.mark.parametrize(
    "name", ["00_control.mcap", "10_short_control.mcap", "09_slashes_tf_only.bag", "18_sqlite_bag"]
)
def test_a_sound_recording_has_no_fault(name: str) -> None:
    assert open_log(FOLDER / name).report.faults == ()


def test_headings_like_a_compass_are_turned_by_places_and_scans(tmp_path: Path) -> None:
    rows = [line.split() for line in (FOLDER / "30_carmen_control.log").read_text().splitlines()]
    for row in rows:
        if row[0] == "FLASER":
            for place in (-7, -4):  # headings of the laser and of the robot
                row[place] = str(-float(row[place]))
    (tmp_path / "compass.log").write_text("\n".join(map(" ".join, rows)))
    error, found = mean_error(tmp_path / "compass.log")
    assert found == {"odometry.clockwise"} and error < 2 * CONTROL_MEAN_M
