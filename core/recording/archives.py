"""NumPy archives: runs of the paper's simulation, the corridor loop, and scan sets."""

import math
from pathlib import Path

import numpy as np

from core.errors import BadInput
from core.geometry import Pose
from core.recording.clocks import evenly_spread, seconds_per_unit, unwrapped
from core.recording.laser_sense import with_laser_as_driven
from core.recording.npz import Archive
from core.recording.odometry_checks import believable_track
from core.recording.read_report import BadRecord, ReadReport
from core.recording.recording import LogSettings, Recording, ScanRecording, SightingRecording, stamped
from core.recording.scans import default_angles, in_time_order, make_scan, on_a_clock_that_goes_on, scan_recording
from core.recording.sightings import (
    MAX_BEARING_RAD,
    MAX_STEER_RAD,
    MOST_ROWS,
    Ids,
    SightingSteps,
    grouped,
    in_radians,
)
from core.sensors import Scan
from core.slam.motion import Increment, MotionSettings, steered

CONTROLS = MotionSettings(model="paper")  # 40 Hz, wheelbase 0.10 m, Q of eq. 43: they made the runs, whatever is set
FRAME_PERIOD_S = 0.2  # between still frames (section 6: 5 Hz)
RUN_NOISE = 0.08, math.radians(1.0)  # [m], [rad] (eq 43)
STEP_S = 0.2  # between steps of the corridor loop: 5 Hz
CORRIDOR_NOISE = 0.03, math.radians(0.6)  # [m], [rad]
UPPER = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])  # where the six columns stand in a covariance
MAX_RANGE_M = 81.0  # readings of a scan set from here on mean that nothing came back


def read(path: Path, number: int | None, ids: Ids, still: bool, settings: LogSettings) -> Recording:
    """Read an archive, whichever form it has. Raises BadInput."""
    archive = Archive(path, settings.largest_file)
    try:
        if {"obs", "v_noisy", "steer_noisy"} <= archive.names:
            return _runs(archive, number or 0, ids, still)
        if {"obs", "odo", "odo_cov"} <= archive.names:
            return _corridor(archive, ids)
        if {"t", "scan_cm"} <= archive.names:
            return _scan_set(archive, settings)
    finally:
        archive.close()
    held = ", ".join(sorted(archive.names)[:12]) or "nothing"
    if not archive.has_arrays:
        raise BadInput(f"{path.name} is an archive of files ({held}). Unpack it, and give the recording in it.")
    raise BadInput(
        f"{path.name} is no known form of log: t and scan_cm, or obs with v_noisy and steer_noisy, or obs with odo "
        f"and odo_cov are expected; it holds {held}."
    )


def _runs(archive: Archive, run: int, ids: Ids, still: bool) -> SightingRecording:
    """One run of the paper's simulation as frozen draws, the first is 0: noisy controls and sightings.

    `v_noisy`, `steer_noisy` (runs, steps): speed [m/s] and steer [rad] as the filter gets them; `obs` (M, 5): run,
    step k (seen after k steps), id, range, bearing; `still_obs` (S, 5): run, frame, id, range, bearing at the start
    pose; with `still`, its still frames come first, at negative times.
    """
    speeds, steers = archive.floats("v_noisy", 0), archive.floats("steer_noisy", 0)
    rows = archive.floats("obs", 5)
    if speeds.shape != steers.shape or not len(speeds):
        raise BadInput(f"v_noisy and steer_noisy in {archive.path.name} do not fit together.")
    if run >= len(speeds):
        raise BadInput(f"{archive.path.name} has runs 0 to {len(speeds) - 1}; there is no run {run}.")
    if speeds.shape[1] > MOST_ROWS:
        raise BadInput(f"{archive.path.name} has more than {MOST_ROWS} steps in a run.")
    tally = ReadReport(archive.path)
    steers = in_radians(steers, MAX_STEER_RAD, "steer_noisy", tally)
    rows[:, 4] = in_radians(rows[:, 4], MAX_BEARING_RAD, "obs", tally)
    steps = SightingSteps(RUN_NOISE, ids, tally)
    if still:
        _take_still_frames(archive, run, steps)
    by_step = grouped(rows[rows[:, 0] == run, 1], rows[rows[:, 0] == run, 2:])
    beyond = [k for k in by_step if not 0 <= k <= speeds.shape[1]]
    tally.skip("its step is not one of the run", count=sum(len(by_step.pop(k)) for k in beyond))
    moved = Increment()
    for k, (speed, steer) in enumerate(zip(speeds[run].tolist(), steers[run].tolist(), strict=True), start=1):
        moved = moved.then(steered(speed, steer, CONTROLS.step, CONTROLS))
        if k in by_step:
            steps.add(k * CONTROLS.step, moved, by_step[k])
            moved = Increment()
    tally.topics = [f"run {run}: speed, steer, sightings"]
    return steps.finish(archive.path, "seed-mc runs")


def _take_still_frames(archive: Archive, run: int, steps: SightingSteps) -> None:
    rows = archive.floats("still_obs", 5)
    frames = grouped(rows[rows[:, 0] == run, 1], rows[rows[:, 0] == run, 2:])
    for number, found in enumerate(frames.values()):
        steps.add((number - len(frames)) * FRAME_PERIOD_S, Increment(), found)


def _corridor(archive: Archive, ids: Ids) -> SightingRecording:
    """The corridor loop: odometry increments with covariance, and sightings among clutter.

    `odo` (K, 3): increments x, y [m], heading [rad] in the robot frame; `odo_cov` (K, 6): xx xy xt yy yt tt; `obs`
    (M, 4): step k (seen after increment k, the first is 0), id (-1: clutter), range [m], bearing [rad]. Step k is
    stamped (k + 1) · 0.2 s. With given ids, clutter is left out.
    """
    increments, covariances, rows = archive.floats("odo", 3), archive.floats("odo_cov", 6), archive.floats("obs", 4)
    if len(increments) != len(covariances) or len(increments) > MOST_ROWS:
        raise BadInput(f"odo and odo_cov in {archive.path.name} do not fit together.")
    tally = ReadReport(archive.path)
    rows[:, 3] = in_radians(rows[:, 3], MAX_BEARING_RAD, "obs", tally)
    by_step = grouped(rows[:, 0], rows[:, 1:])
    beyond = [k for k in by_step if not 0 <= k < len(increments)]
    tally.skip("its step is not one of the log", count=sum(len(by_step.pop(k)) for k in beyond))
    moved = Increment()
    steps = SightingSteps(CORRIDOR_NOISE, ids, tally)
    for k, (increment, covariance) in enumerate(zip(increments.tolist(), covariances, strict=True)):
        moved = moved.then(Increment(Pose(*increment), covariance[UPPER]))
        if k in by_step:
            steps.add((k + 1) * STEP_S, moved, by_step[k])
            moved = Increment()
    tally.topics = ["odo: odometry", "obs: sightings"]
    return steps.finish(archive.path, "corridor loop")


def _scan_set(archive: Archive, settings: LogSettings) -> ScanRecording:
    """Scans: `t` (N,) [s], `scan_cm` (N, beams) [cm] and, with odometry, `odo_raw` (N, 3).

    The beams stand every 180°/n from -90° on, the laser at the robot's origin.
    """
    tally = ReadReport(archive.path)
    times, ranges = archive.floats("t"), archive.floats("scan_cm", 0) / 100
    poses = archive.floats("odo_raw", 3) if "odo_raw" in archive.names else None
    if len(times) != len(ranges) or (poses is not None and len(poses) != len(times)):
        raise BadInput(f"t, scan_cm and odo_raw in {archive.path.name} have different lengths.")
    if ranges.nbytes > 2 * settings.most_readings:
        raise BadInput(f"{archive.path.name} holds more scans than log.most_readings_mb of the settings allows.")
    scans: list[Scan] = []
    used: list[int] = []
    limits = (0.0, settings.range_max or MAX_RANGE_M)
    for number, (stamp, row) in enumerate(zip(times.tolist(), ranges, strict=True)):
        try:
            scans.append(make_scan(stamp, row, default_angles(max(1, ranges.shape[1])), limits))
            used.append(number)
            tally.read += 1
        except BadRecord as problem:
            tally.skip(str(problem), f"row {number}")
    if not scans:
        raise BadInput(f"{archive.path.name} holds no scan that can be used. {tally.reasons()}")
    stamps = unwrapped(times[used], "t", tally)
    places = None if poses is None else poses[used, :2]
    stamps = evenly_spread(stamps * seconds_per_unit(stamps, "t", tally), tally, "t", places)
    (stamps,) = on_a_clock_that_goes_on(scans, [stamps], tally)
    scans = in_time_order([stamped(scan, float(stamp)) for scan, stamp in zip(scans, stamps, strict=True)], tally)
    wanted = poses is not None and settings.odometry_topic != "none"
    track = believable_track("odo_raw", stamps, poses[used], None, tally) if wanted and poses is not None else None
    tally.topics = ["scan_cm: laser"] + (["odo_raw: odometry"] if track is not None else [])
    recording = scan_recording(archive.path, scans, track, tally, "scan set", settings)
    return with_laser_as_driven(recording, heading=settings.mounting_heading is None)
