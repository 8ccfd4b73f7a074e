"""Archives and text of sightings, and scan sets: columns, steps, identities, noise."""

import math
from pathlib import Path

import numpy as np
import pytest

from core.errors import BadInput
from core.geometry import Pose
from core.recording import open_log
from core.sensors.checks import UnusableReading
from core.slam.motion import Increment, control_jacobian


def save(path, **arrays):
    np.savez_compressed(path, **arrays)
    return path


@pytest.fixture
def runs(tmp_path):
    """Two runs of 24 steps, straight ahead and turning; sightings after every 8."""
    speeds = np.full((2, 24), 0.1)
    steers = np.vstack([np.zeros(24), np.full(24, 0.5)])
    rows = [[run, k, mark, 2.0 + mark, 0.1 * mark] for run in (0, 1) for k in (8, 16, 24) for mark in (0, 3)]
    still = [[run, frame, 5, 1.5, -0.2] for run in (0, 1) for frame in range(10)]
    truth = np.full((25, 3), np.nan)  # would poison whatever reads it
    return save(
        tmp_path / "runs.npz",
        v_noisy=speeds,
        steer_noisy=steers,
        obs=np.array(rows),
        still_obs=np.array(still),
        truth=truth,
    )


def whole(recording) -> Increment:
    """All moves of a recording as one."""
    moved = Increment()
    for step in recording:
        moved = moved.then(step.increment)
    return moved


def test_a_run_has_one_step_per_instant_with_sightings(runs):
    recording = open_log(f"{runs}#1")
    assert [step.stamp for step in recording] == pytest.approx([0.2, 0.4, 0.6])
    assert [seen.id for seen in recording.steps[0].sightings] == [0, 3]
    assert [(seen.range, seen.bearing) for seen in recording.steps[2].sightings] == [
        (2.0, 0.0),
        (5.0, pytest.approx(0.3)),
    ]
    assert recording.steps[0].sightings[0].covariance == pytest.approx(np.diag([0.08**2, math.radians(1) ** 2]))


def test_the_moves_follow_the_car_like_model(runs):
    straight, turning = whole(open_log(runs)), whole(open_log(f"{runs}#1"))
    assert straight.pose.vector == pytest.approx((0.06, 0, 0), abs=1e-12)
    assert straight.covariance[0, 0] == pytest.approx(24 * (0.2 * 0.025) ** 2)
    pose = np.zeros(3)
    for _ in range(24):
        pose += 0.0025 * np.array([math.cos(0.5 + pose[2]), math.sin(0.5 + pose[2]), math.sin(0.5) / 0.1])
    assert turning.pose.vector == pytest.approx(pose, abs=1e-12)


def test_still_frames_come_first_when_asked_for(runs):
    recording = open_log(runs, still=True)
    assert len(recording) == 13 and len(open_log(runs)) == 3
    assert [step.stamp for step in recording][:11] == pytest.approx([*np.arange(-2.0, 0, 0.2), 0.2])
    assert all(step.increment.still for step in recording.steps[:10])


def test_hidden_identities_are_shown_nowhere(runs):
    given, hidden = open_log(runs), open_log(runs, ids="hidden")
    assert all(seen.id is not None for step in given for seen in step.sightings)
    assert all(seen.id is None for step in hidden for seen in step.sightings)
    assert [len(step.sightings) for step in given] == [len(step.sightings) for step in hidden]


def test_runs_that_are_not_there_are_refused(runs):
    for wrong, words in (("#2", "runs 0 to 1"), ("#x", "a number"), ("#-1", "a number")):
        with pytest.raises(BadInput, match=words):
            open_log(f"{runs}{wrong}")


def test_the_corridor_log_carries_its_own_covariance_and_clutter_is_left_out(tmp_path):
    covariance = np.tile([4e-4, 1e-4, 2e-5, 3e-4, 1e-5, 5e-4], (3, 1))
    rows = np.array([[0, 7, 2.0, 0.1], [0, -1, 3.0, 0.2], [2, 7, 1.9, 0.1], [9, 7, 1.0, 0.0]])
    path = save(tmp_path / "log.npz", odo=np.tile([0.1, 0.0, 0.0], (3, 1)), odo_cov=covariance, obs=rows)
    recording = open_log(path)
    assert [step.stamp for step in recording] == pytest.approx([0.2, 0.6])
    assert [seen.id for seen in recording.steps[0].sightings] == [7]
    assert [len(step.sightings) for step in open_log(path, ids="hidden")] == [2, 1]
    first = recording.steps[0].increment
    assert first.covariance == pytest.approx(np.array([[4e-4, 1e-4, 2e-5], [1e-4, 3e-4, 1e-5], [2e-5, 1e-5, 5e-4]]))
    assert recording.steps[1].increment.pose == Pose(0.2, 0.0, 0.0)
    assert "1 because its step is not one of the log" in recording.report.warnings[0]


def test_the_adapters_read_no_truth(tmp_path):
    """What is not needed is not even unpacked: an unreadable truth does not matter."""
    rows = np.array([[0, 7, 2.0, 0.1]])
    objects = np.array([None], object)
    path = save(
        tmp_path / "log.npz",
        odo=np.zeros((1, 3)),
        odo_cov=np.zeros((1, 6)),
        obs=rows,
        truth=objects,
        landmarks=objects,
    )
    assert len(open_log(path)) == 1


@pytest.fixture
def folder(tmp_path):
    """Robot 2 drives 1 m/s for 1 s, stands, then turns; it sees landmark 8 (barcode 70), robot 1 and a stranger."""
    robots = tmp_path / "robots"
    robots.mkdir()
    (robots / "Barcodes.dat").write_text("# Subject # Barcode\n 1 5\n 8 70\n")
    odometry = [(10.0, 1.0, 0.0), (11.0, 0.0, 0.0), (12.0, 0.0, 0.5), (13.0, 0.0, 0.0)]
    (robots / "Robot2_Odometry.dat").write_text("".join(f"{t} {v} {w}\n" for t, v, w in odometry))
    seen = [(9.0, 70, 1, 0), (10.5, 70, 3.0, 0.1), (10.5, 5, 1, 0), (11.5, 70, 2.5, 0.1), (12.0, 99, 1, 0)]
    seen += [(13.0, 70, 2.5, -0.4), (13.5, 70, 1, 0)]
    (robots / "Robot2_Measurement.dat").write_text(
        "# header\n" + "".join(f"{t} {c} {r} {b}\n" for t, c, r, b in seen)
    )
    return robots


def test_an_mrclam_robot_sees_landmarks_within_its_odometry(folder):
    recording = open_log(f"{folder}#2")
    assert [step.stamp for step in recording] == [10.5, 11.5, 13.0]
    assert all(seen.id == 8 for step in recording for seen in step.sightings)
    assert [step.increment.pose.vector for step in recording] == [
        pytest.approx((0.5, 0, 0)),
        pytest.approx((0.5, 0, 0)),
        pytest.approx((0, 0, 0.5)),
    ]
    assert recording.steps[0].increment.covariance[0, 0] == pytest.approx(0.5 * 0.03**2)
    assert recording.steps[2].increment.covariance[2, 2] == pytest.approx(math.radians(2) ** 2)
    assert "1 because its barcode is unknown" in recording.report.warnings[0]


def test_a_long_move_has_the_covariance_of_its_steps_composed(folder):
    """The law behind the closed form: C ← F C Fᵀ + G Q Gᵀ, step by step."""
    rng = np.random.default_rng(2)
    rows = np.column_stack(
        [10 + np.cumsum(rng.uniform(0.01, 0.2, 40)), rng.normal(0.3, 0.2, 40), rng.normal(0, 1, 40)]
    )
    (folder / "Robot2_Odometry.dat").write_text("".join(f"{t} {v} {w}\n" for t, v, w in rows.tolist()))
    end = rows[-1, 0]
    (folder / "Robot2_Measurement.dat").write_text(f"{end} 70 1 0\n")
    composed = Increment()
    for (_, speed, turn_rate), seconds in zip(rows[:-1].tolist(), np.diff(rows[:, 0]).tolist(), strict=True):
        way, turn = speed * seconds, turn_rate * seconds
        gain = control_jacobian(way, turn)
        noise = np.diag([0.03**2, math.radians(2) ** 2]) * seconds
        step = Pose(way * math.cos(turn / 2), way * math.sin(turn / 2), turn)
        composed = composed.then(Increment(step, gain @ noise @ gain.T))
    (step,) = open_log(f"{folder}#2")
    assert step.increment.pose.vector == pytest.approx(composed.pose.vector)
    assert step.increment.covariance == pytest.approx(composed.covariance, rel=1e-9)


def test_a_robot_that_is_not_there_is_refused_with_those_that_are(folder):
    with pytest.raises(BadInput, match="no robot 1; it has 2"):
        open_log(folder)


def test_victoria_park_text_shares_numbers_between_poses_and_trees(tmp_path):
    path = tmp_path / "park.txt"
    path.write_text(
        "ODOMETRY 0 1 1.0 0 0 1 0 0 1 0 1\nLANDMARK 1 2 3 4 0.4 0 0.4\nODOMETRY 1 3 1.0 0 0.1 1 0 0 1 0 1\n"
        "ODOMETRY 3 4 1.0 0 0\nLANDMARK 4 2 3 -4\nLANDMARK 77 2 1 1\nLANDMARK 4 2\nODOMETRY 4\n"
    )
    recording = open_log(path)
    assert [step.stamp for step in recording] == [1.0, 3.0]
    assert [step.increment.pose.x for step in recording] == [1.0, pytest.approx(1 + math.cos(0.1))]
    (seen,) = recording.steps[1].sightings
    assert (seen.id, seen.range, seen.bearing) == (2, 5.0, pytest.approx(math.atan2(-4, 3)))
    assert recording.report.skipped == 3


def test_a_car_is_less_sure_of_its_heading_the_more_it_has_turned(tmp_path):
    path = tmp_path / "park.txt"
    path.write_text(
        "".join(
            f"ODOMETRY {2 * n} {2 * n + 2} 1.0 0 {turn}\nLANDMARK {2 * n + 2} 1 5 0\n"
            for n, turn in enumerate((0.0, 0.1, -0.1, 0.2))
        )
        + "".join(f"ODOMETRY {n} {n + 2} 0.5 0 0.1\n" for n in (8, 10))
        + "LANDMARK 12 1 5 0\n"
    )
    straight, left, right, more, parts = (step.increment.covariance[2, 2] for step in open_log(path))
    assert left == pytest.approx(right)
    assert straight < left < more
    assert more - straight == pytest.approx(2 * (left - straight))
    assert parts == pytest.approx(more + straight)  # a bend in two lines turns as far as in one


def test_a_scan_set_needs_no_odometry(tmp_path):
    ranges = np.tile(np.arange(205, 295, dtype=np.uint16), (4, 1))
    ranges[:, 3] = 8183
    path = save(tmp_path / "set.npz", t=np.arange(4) * 2.0, scan_cm=ranges)
    recording = open_log(path)
    (first, *_) = recording
    assert not recording.has_wheels and recording.laser.rate == pytest.approx(0.5)
    assert np.degrees(first.scan.angles[[0, -1]]) == pytest.approx([-90, 88])
    assert np.isposinf(first.scan.ranges[3]) and first.scan.ranges[4] == pytest.approx(2.09)


def test_arrays_that_do_not_fit_are_refused(tmp_path):
    for arrays, words in (
        ({"t": np.arange(3.0), "scan_cm": np.ones((4, 5))}, "different lengths"),
        ({"t": np.arange(3.0), "scan_cm": np.ones(3)}, "shape"),
        ({"t": np.array([1.0, np.nan]), "scan_cm": np.ones((2, 3))}, "not finite"),
        ({"pictures": np.ones(3)}, "it holds pictures"),
    ):
        with pytest.raises(BadInput, match=words):
            open_log(save(tmp_path / "set.npz", **arrays))


@pytest.mark.parametrize("mixed", [(), ("odo_raw",), ("odo_raw", "scan_cm")])
def test_a_log_of_two_robots_in_turns_is_not_believed(tmp_path, mixed):
    times = 0.1 * np.arange(200)
    poses = np.column_stack([0.02 * np.arange(200), np.zeros((200, 2))])
    ranges = np.linspace(210.0, 390.0, 180) + np.random.default_rng(1).normal(0, 1, (200, 180))
    if "odo_raw" in mixed:
        poses[::2] = (7.0, 1.0, 2.0)
    if "scan_cm" in mixed:
        ranges[::2] += 150.0
    path = save(tmp_path / "set.npz", t=times, scan_cm=ranges, odo_raw=poses)
    if "scan_cm" in mixed:
        with pytest.raises(UnusableReading, match="under one name") as refused:
            open_log(path)
        assert [one.code for one in refused.value.faults] == ["robots.mixed"]
        return
    log = open_log(path)
    assert [one.code for one in log.report.faults] == ["robots.mixed"] * len(mixed)
    assert (log.track is None) is bool(mixed)


@pytest.mark.parametrize(
    ("move", "away", "found"),
    [(0.1, 2.0, []), (15.0, 60.0, []), (100.0, 2.0, ["sighting.units"]), (0.1, 2000.0, ["sighting.units"])],
)
@pytest.mark.parametrize("between", [" ", "\t"])
def test_a_sightings_log_in_another_unit_has_that_said(
    tmp_path: Path, move: float, away: float, found: list[str], between: str
) -> None:
    lines = [
        f"ODOMETRY {k} {k + 1} {move} 0 0.01 1 0 0 1 0 1\nLANDMARK {k} {1000 + k % 3} {away} 0.5 1 0 1"
        for k in range(9)
    ]
    log = tmp_path / "park.txt"
    log.write_text("\n".join(lines).replace(" ", between) + "\n")
    assert [one.code for one in open_log(log).report.faults] == found


@pytest.mark.parametrize("between", [" ", "\t", ",", ", ", ";"])
def test_the_tables_of_a_folder_may_have_any_sign_between_their_numbers(tmp_path: Path, between: str) -> None:
    tables = {
        "Barcodes": "6 63\n",
        "Robot1_Odometry": "".join(f"{k / 10} 0.1 0.0\n" for k in range(50)),
        "Robot1_Measurement": "".join(f"{k / 2} 63 2.0 0.1\n" for k in range(1, 9)),
    }
    for name, table in tables.items():
        (tmp_path / f"{name}.dat").write_text(table.replace(" ", between))
    assert len(open_log(f"{tmp_path}#1").steps) == 8


def park_lines(turn_unit: float = 1.0, left: float = 1.0, far: float = 1.0) -> str:
    """A car on a circle among trees; `turn_unit` per radian, `left`: -1 where sightings count clockwise, `far`: unit
    of the sightings per metre."""
    pose, lines = Pose(), list[str]()
    for step in range(60):
        turn = 0.08 if step % 20 < 15 else 0.0
        pose = pose @ Pose(0.5 * math.cos(turn / 2), 0.5 * math.sin(turn / 2), turn)
        lines.append(
            f"ODOMETRY {step} {step + 1} {0.5 * math.cos(turn / 2)} {0.5 * math.sin(turn / 2)} {turn * turn_unit}"
        )
        for tree, place in enumerate(((5, 9), (-4, 6), (3, -6), (9, 1))):
            x, y = (pose.inverse() @ Pose(*place)).vector[:2]
            lines.append(f"LANDMARK {step + 1} {1000 + tree} {far * x} {far * left * y}")
    return "\n".join(lines)


def test_turns_in_degrees_are_converted(tmp_path):
    (tmp_path / "park.txt").write_text(park_lines())
    (tmp_path / "degrees.txt").write_text(park_lines(turn_unit=180 / math.pi))
    sound, degrees = open_log(tmp_path / "park.txt"), open_log(tmp_path / "degrees.txt")
    assert not sound.report.faults and [one.code for one in degrees.report.faults] == ["sighting.degrees"]
    assert whole(degrees).pose.vector == pytest.approx(whole(sound).pose.vector)


@pytest.mark.parametrize("park", [{"turn_unit": 0.3}, {"turn_unit": -1.0}, {"left": -1.0}])
def test_turns_that_the_sightings_contradict_are_said(tmp_path, park):
    (tmp_path / "park.txt").write_text(park_lines(**park))
    assert [one.code for one in open_log(tmp_path / "park.txt").report.faults] == ["sighting.turns"]


@pytest.mark.parametrize("far", [0.3048, 3.28])
def test_ways_that_the_sightings_contradict_are_said(tmp_path, far):
    (tmp_path / "park.txt").write_text(park_lines(far=far))
    (found,) = open_log(tmp_path / "park.txt").report.faults
    assert found.code == "sighting.ways" and float(found.values["times"]) == pytest.approx(far, rel=0.1)


@pytest.mark.parametrize("unit", [1e3, 1e9])
def test_times_of_mrclam_in_parts_of_a_second_are_brought_to_seconds(folder, unit):
    begun = 1_248_272_272.0
    rows = [(begun + 0.02 * n, 0.1, 0.1) for n in range(100)]
    seen = [(begun + 0.03 + 0.1 * n, 70, 3.0, 0.1) for n in range(18)]
    for name, lines in (("Odometry", rows), ("Measurement", seen)):
        text = "".join(f"{t * unit:.0f} {' '.join(map(str, more))}\n" for t, *more in lines)
        (folder / f"Robot2_{name}.dat").write_text(text)
    found = open_log(f"{folder}#2")
    assert np.diff([step.stamp for step in found]) == pytest.approx(0.1, abs=1e-3)
    assert {one.code for one in found.report.faults} == {"clock.unit"}


def test_steering_in_degrees_is_converted(runs, tmp_path):
    arrays = dict(np.load(runs))
    path = save(tmp_path / "degrees.npz", **arrays | {"steer_noisy": np.degrees(arrays["steer_noisy"])})
    found = open_log(f"{path}#1")
    assert [one.sensor for one in found.report.faults] == ["steer_noisy"]
    assert whole(found).pose.vector == pytest.approx(whole(open_log(f"{runs}#1")).pose.vector)


def test_turn_rates_and_bearings_of_mrclam_in_degrees_are_converted(folder):
    rows = [(10 + 0.1 * n, 0.3, 0.4 * math.sin(n / 9)) for n in range(100)]
    seen = [(10.05 + 0.2 * n, 70, 3.0, 0.5 - 0.02 * n) for n in range(45)]
    for unit in (1.0, 180 / math.pi):
        (folder / "Robot2_Odometry.dat").write_text("".join(f"{t} {v} {w * unit}\n" for t, v, w in rows))
        (folder / "Robot2_Measurement.dat").write_text("".join(f"{t} {c} {r} {b * unit}\n" for t, c, r, b in seen))
        found = open_log(f"{folder}#2")
        codes = [one.code for one in found.report.faults if one.code == "sighting.degrees"]
        assert len(codes) == (0 if unit == 1.0 else 2)
        assert found.steps[3].sightings[0].bearing == pytest.approx(0.44)
