"""Odometry as recorded, checked against itself and against what a base can do."""

import math

import numpy as np

from core.geometry import rotation, wrap_all
from core.message import Array
from core.recording.odometry_track import OdometryTrack
from core.recording.read_report import ReadReport
from core.sensors.publishers import odometry_turns

MAX_SPEED_M_S = 6.0  # of a robot that maps rooms
MAX_TURN_RATE_RAD_S = 7.0
MIN_TURNS = 10  # of the base, by which the unit of its heading is judged
MIN_DEGREES = 12.0  # of a heading in them
MIN_SPIN_RAD_S = 4.0  # that no base turns all the time
MAX_CARRIED_S = 2.0  # over which speeds are carried on, and a jump is judged by them
MIN_WAY_M = 0.5  # by the speeds, over which the place must have moved
STANDING_SHARE = 0.02  # of that way: less, and the place stands
JUMP_M, JUMP_RAD = 0.3, 0.6  # beyond what the speeds allow: the base was restarted
JUMP_SPEEDS = 3.0  # times its usual speed that a base may have between two readings


def believable_track(
    name: str, times: Array, poses: Array, twists: Array | None, report: ReadReport
) -> OdometryTrack | None:
    """Odometry as recorded → the track, without what cannot be true of it; None: nothing of it can be used.

    Times (N,) [s], poses (N, 3), headings NaN where they carry none, twists (N, 2) [m/s, rad/s]. What was found is a
    fault of the report.
    """
    order = np.argsort(times, kind="stable")
    times, poses = times[order], poses[order]
    twists = None if twists is None else twists[order]
    driven: Array | None = poses
    if len(times) and np.mean(np.isnan(poses[:, 2])) > 0.5:
        report.fault("odometry.no_heading", name, used=twists is not None, instead=_instead(twists))
        driven = _integrated(times, twists)
    elif _stands(times, poses, twists):
        report.fault("odometry.stands", name, used=True)
        driven = _integrated(times, twists)
    elif _counts_degrees(times, poses[:, 2]):
        report.fault("odometry.degrees", name, used=True)
        driven = np.column_stack([poses[:, :2], np.radians(poses[:, 2])])
    track = None if driven is None else OdometryTrack.of(times, driven, twists)
    if track is None:
        if len(times) > 1 and not np.isfinite(poses).all(axis=1).any() and driven is not None:
            report.fault("odometry.malformed", name, what="its numbers are not finite")
        return None
    if odometry_turns(track.times, track.poses) > 0.0:
        report.fault("robots.mixed", name)
        return None
    speed = _usual_speed(track)
    if speed > MAX_SPEED_M_S:
        report.fault("odometry.too_fast", name, speed=f"{speed:.3g}")
        return None
    return _without_restarts(name, track, speed, report)


def _counts_degrees(times: Array, headings: Array) -> bool:
    """Headings (N,) as logged → whether they are degrees: as radians the base would spin."""
    lasted = np.diff(times)
    with np.errstate(invalid="ignore", divide="ignore"):
        rates = np.abs(np.diff(headings))[lasted > 0] / lasted[lasted > 0]
    rates = rates[np.isfinite(rates) & (rates > 0)]
    if len(rates) < MIN_TURNS or not np.nanmax(np.abs(headings)) > MIN_DEGREES:
        return False
    return bool(MIN_SPIN_RAD_S < np.quantile(rates, 0.9) < math.degrees(MAX_TURN_RATE_RAD_S))


def _instead(twists: Array | None) -> str:
    return "its speeds are used" if twists is not None else "it is not used"


def _integrated(times: Array, twists: Array | None) -> Array | None:
    """Twists (N, 2) at times (N,) → poses (N, 3) from (0, 0, 0); None without twists."""
    if twists is None:
        return None
    steps = np.minimum(np.diff(times, prepend=times[:1]), MAX_CARRIED_S)[:, None] * np.nan_to_num(twists)
    heading = np.cumsum(steps[:, 1])
    middle = heading - steps[:, 1] / 2
    return np.column_stack(
        [np.cumsum(steps[:, 0] * np.cos(middle)), np.cumsum(steps[:, 0] * np.sin(middle)), heading]
    )


def _stands(times: Array, poses: Array, twists: Array | None) -> bool:
    """Return whether the place stays where it is while the speeds say that the wheels roll."""
    rolled = _integrated(times, twists)
    if rolled is None or len(times) < 2:
        return False
    way = np.abs(np.diff(rolled, axis=0)).sum(axis=0)
    with np.errstate(invalid="ignore"):
        moved = np.nan_to_num(np.abs(np.diff(poses, axis=0))).sum(axis=0)
    return bool(way[0] + way[1] > MIN_WAY_M and moved.sum() < STANDING_SHARE * (way[0] + way[1]))


def _usual_speed(track: OdometryTrack) -> float:
    """The speed [m/s] that the places of the track are driven at, of the quicker tenth."""
    lasted = np.diff(track.times)
    way = np.hypot(*np.diff(track.poses[:, :2], axis=0).T)
    moved = way > 0
    return float(np.quantile(way[moved] / lasted[moved], 0.9)) if moved.any() else 0.0


def _without_restarts(name: str, track: OdometryTrack, speed: float, report: ReadReport) -> OdometryTrack:
    """Join the track where its base was restarted: it goes on from where it was."""
    lasted = np.diff(track.times)
    way = np.hypot(*np.diff(track.poses[:, :2], axis=0).T)
    turned = np.abs(wrap_all(np.diff(track.poses[:, 2])))
    far = way > JUMP_M + JUMP_SPEEDS * speed * np.minimum(lasted, MAX_CARRIED_S)
    round_ = (turned > JUMP_RAD + MAX_TURN_RATE_RAD_S * np.minimum(lasted, MAX_CARRIED_S)) & (lasted < MAX_CARRIED_S)
    jumps = np.flatnonzero(far | round_) + 1
    if not len(jumps):
        return track
    report.fault(
        "odometry.restarted", name, used=True, count=len(jumps), at=f"{track.times[jumps[0]] - track.times[0]:.1f}"
    )
    poses = track.poses.copy()
    for jump in jumps.tolist():
        before, after = poses[jump - 1].copy(), poses[jump].copy()
        turn = before[2] - after[2]
        poses[jump:, :2] = before[:2] + (poses[jump:, :2] - after[:2]) @ rotation(turn).T
        poses[jump:, 2] += turn
    speeds, rates = track.speeds.copy(), track.turn_rates.copy()
    speeds[jumps], rates[jumps] = speeds[jumps - 1], rates[jumps - 1]
    return OdometryTrack(times=track.times, poses=poses, speeds=speeds, turn_rates=rates)
