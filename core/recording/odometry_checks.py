"""Odometry as recorded, checked against itself and against what a base can do."""

import math

import numpy as np

from core.geometry import Pose, rotation, wrap_all
from core.message import Array
from core.recording.clocks import longest_part
from core.recording.odometry_track import OdometryTrack
from core.recording.read_report import ReadReport
from core.sensors.publishers import odometry_turns
from core.sensors.wheels import FIT_WINDOW_S, ORIGIN_M, ORIGIN_RAD, SpeedFit

MAX_SPEED_M_S = 6.0  # of a robot that maps rooms
MAX_TURN_RATE_RAD_S = 7.0
MIN_TURNS = 10  # of the base, by which the unit of its heading is judged
MIN_DEGREES = 12.0  # of a heading in them
MIN_SPIN_RAD_S = 4.0  # that no base turns all the time
MAX_CARRIED_S = 2.0  # over which speeds are carried on, and a jump is judged by them
MIN_WAY_M = 0.5  # by the speeds, over which the place must have moved
MIN_HEADED_WAY_M = 2.0  # over which the direction of the way is compared with the heading
MIN_CHORDS, CHORD_M, MAX_CHORDS = 15, 0.1, 2000  # pieces of the way, and the length of each
MIRRORED_LENGTH, ACROSS_LENGTH = 0.8, 0.6  # of the mean direction of the way: mirrored, and else along the heading
MAX_STRAIGHT_LENGTH = 0.7  # of the mean direction of a way in which no heading is the same all the time
AXIS_OFF_RAD = 0.2  # of the axis of a mirror from one of the frame's own
MIN_HELD_SPAN_RAD, HELD_MARGIN_RAD = 2.2, 0.03  # of headings that are kept within half a turn
HALF_TURN_OFF_RAD = 0.35  # of a jump of such a heading from a half turn
ASIDE_SHARE = 0.15  # of the way that leads aside of the heading
MIN_SILENCE_S, SILENCE_PERIODS = 1.0, 8.0  # after which an odometry that is at its origin started again
STANDING_SHARE = 0.02  # of that way: less, and the place stands
MIN_STEP_M, MIN_STEP_RAD = 0.05, math.radians(3)  # between the only values that a rounded place or heading has
MIN_STEPS, SAME_STEP, SAME_VALUE = 3, 1e-3, 1e-6  # such steps; share to which they are multiples; change
BESIDE_SHARE = 0.5  # of these steps, beside equal readings: what is driven evenly changes all the time
MAX_STEP_RAD = math.radians(40)  # from which it is a turn
JUMP_M, JUMP_RAD = 0.3, 0.6  # beyond what the speeds allow: the base was restarted
JUMP_SPEEDS = 3.0  # times its usual speed that a base may have between two readings
MAX_GAP_S = 60.0  # between two readings over which a speed is judged: a wrong stamp may lie years away
LATE_SHARE = 0.8  # of the usual time between two readings: those that are nearer, one of them was stamped late


def believable_track(
    name: str, times: Array, poses: Array, twists: Array | None, report: ReadReport
) -> OdometryTrack | None:
    """Odometry as recorded → the track, without what cannot be true of it; None: nothing of it can be used.

    Times (N,) [s], poses (N, 3), headings NaN where they carry none, twists (N, 2) [m/s, rad/s]. What was found is a
    fault of the report.
    """
    part = slice(*longest_part(times))
    times, poses, twists = times[part], poses[part], None if twists is None else twists[part]
    order = np.argsort(times, kind="stable")
    times, poses = times[order], poses[order]
    twists = None if twists is None else twists[order]
    driven: Array | None = poses
    if len(times) and (np.mean(np.isnan(poses[:, 2])) > 0.5 or _never_turns(poses, twists)):
        instead = "it is not used" if twists is None else "its speeds are used"
        report.fault("odometry.no_heading", name, used=twists is not None, instead=instead)
        driven = _integrated(times, twists)
    elif _stands(times, poses, twists):
        report.fault("odometry.stands", name, used=True)
        driven = _integrated(times, twists)
    elif _counts_degrees(times, poses[:, 2]):
        report.fault("odometry.degrees", name, used=True)
        driven = np.column_stack([poses[:, :2], np.radians(poses[:, 2])])
    elif _is_rounded(name, poses, report):  # its jumps are no faults of their own
        return OdometryTrack.of(times, poses, twists)
    if driven is poses:
        driven = _of_one_sense(name, poses, report)
    twists = _true_speeds(name, times, driven, twists, report)
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
    first = poses[np.isfinite(poses).all(axis=1)][:1]
    origin = Pose(*first[0].tolist()).inverse() if len(first) and driven is poses else Pose()
    return _without_restarts(name, track, speed, origin, report)


def _true_speeds(
    name: str, times: Array, poses: Array | None, twists: Array | None, report: ReadReport
) -> Array | None:
    """Twists (N, 2) → the same, or None where they do not fit the changes of the poses (N, 3) at times (N,) [s]."""
    if twists is None or poses is None or report.has_fault("clock.none"):
        return twists  # a pace that was made up says nothing of speeds
    good = np.isfinite(times) & np.isfinite(poses).all(axis=1)
    if not good.any():
        return twists
    times, poses, speeds = times[good], poses[good], np.nan_to_num(twists[good], posinf=0.0, neginf=0.0)
    lasted = np.diff(times, prepend=times[:1])
    way = np.cumsum(np.where(lasted < FIT_WINDOW_S, lasted, 0.0)[:, None] * np.clip(speeds, -1e6, 1e6), axis=0)
    at = np.unique(np.floor((times - times[0]) / FIT_WINDOW_S), return_index=True)[1]
    near = np.diff(times[at]) < 2 * FIT_WINDOW_S
    steps, headings = np.diff(poses[at], axis=0), poses[at[:-1], 2]
    ahead = steps[:, 0] * np.cos(headings) + steps[:, 1] * np.sin(headings)
    fit = SpeedFit()
    moves, claimed = np.column_stack([ahead, wrap_all(steps[:, 2])])[near], np.diff(way[at], axis=0)[near]
    possible = np.hypot(*steps[near, :2].T) < FIT_WINDOW_S * MAX_SPEED_M_S
    fit.add(moves[possible], claimed[possible])
    if fit.is_wrong:
        ways, turns = fit.ratios
        report.fault("odometry.speeds", name, used=True, ways=f"{ways:.2g}", turns=f"{turns:.2g}")
    return twists if fit.is_used else None


def _of_one_sense(name: str, poses: Array, report: ReadReport) -> Array | None:
    """Poses (N, 3) → the same with headings and places of one sense; None: the headings are kept within half a turn.

    A base goes along its heading. Where the direction of its way turns against its heading, one of both is mirrored
    (x and y exchanged, one of them negated).
    """
    rows = poses[np.isfinite(poses).all(axis=1)]
    way = np.cumsum(np.hypot(*np.diff(rows[:, :2], axis=0, prepend=rows[:1, :2]).T)) if len(rows) else np.zeros(1)
    if not np.isfinite(way[-1]) or way[-1] < MIN_HEADED_WAY_M or len(rows) < MIN_CHORDS:
        return poses
    chord = max(CHORD_M, float(way[-1]) / MAX_CHORDS)
    at = np.unique(np.searchsorted(way, np.arange(0.0, way[-1], chord)))
    if len(at) < MIN_CHORDS:
        return poses
    steps, headings = np.diff(rows[at, :2], axis=0), rows[(at[:-1] + at[1:]) // 2, 2]
    directions = np.arctan2(steps[:, 1], steps[:, 0])
    aside, mirrored = directions - headings, directions + headings
    # twice the angle for a base that backs as well; once for corridors at right angles, in which twice shows nothing
    found = [(abs(np.exp(1j * k * aside).mean()), abs(np.exp(1j * k * mirrored).mean())) for k in (1, 2)]
    if any(against > MIRRORED_LENGTH and along < ACROSS_LENGTH for along, against in found):
        axis = float(np.angle(np.exp(1j * mirrored).mean()))
        square = round(axis / (math.pi / 2)) * math.pi / 2
        axis = square if abs(axis - square) < AXIS_OFF_RAD else axis
        report.fault("odometry.mirrored", name, used=True, axis=f"{math.degrees(axis):.0f}")
        return np.column_stack([(poses[:, :2] * [1.0, -1.0]) @ rotation(axis).T, poses[:, 2]])
    within = rows[:, 2] - min(0.0, float(rows[:, 2].min()))
    halves = np.abs(np.abs(np.diff(rows[:, 2])) - math.pi) < HALF_TURN_OFF_RAD
    kept = MIN_HELD_SPAN_RAD < float(np.ptp(rows[:, 2])) < math.pi + HELD_MARGIN_RAD
    kept &= bool(rows[:, 2].min() > -math.pi / 2 - HELD_MARGIN_RAD and within.max() < math.pi + HELD_MARGIN_RAD)
    if kept and (halves.any() or np.mean(np.abs(np.sin(aside)) > 0.5) > ASIDE_SHARE):
        report.fault("odometry.half_turn", name)
        return None
    return poses


def _never_turns(poses: Array, twists: Array | None) -> bool:
    """Return whether the heading is the same all along a way that leads round corners, and no speed says so, too."""
    rows = poses[np.isfinite(poses).all(axis=1)]
    if len(rows) < MIN_CHORDS or np.ptp(rows[:, 2]) > SAME_VALUE or (twists is not None and not np.any(twists[:, 1])):
        return False
    steps = np.diff(rows[:, :2], axis=0)
    lengths, directions = np.hypot(*steps.T), np.arctan2(*steps.T[::-1])
    mean = abs((lengths * np.exp(2j * directions)).sum()) / max(float(lengths.sum()), 1e-9)
    return bool(lengths.sum() > MIN_HEADED_WAY_M and mean < MAX_STRAIGHT_LENGTH)


def _counts_degrees(times: Array, headings: Array) -> bool:
    """Headings (N,) as logged → whether they are degrees: as radians the base would spin."""
    lasted = np.diff(times)
    with np.errstate(invalid="ignore", divide="ignore"):
        rates = np.abs(np.diff(headings))[lasted > 0] / lasted[lasted > 0]
    rates = rates[np.isfinite(rates) & (rates > 0)]
    if len(rates) < MIN_TURNS or not np.nanmax(np.abs(headings)) > MIN_DEGREES:
        return False
    return bool(MIN_SPIN_RAD_S < np.quantile(rates, 0.9) < math.degrees(MAX_TURN_RATE_RAD_S))


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
    spread = np.nanmax(np.ptp(poses[:, :2], axis=0), initial=0.0)
    return bool(
        way[0] + way[1] > MIN_WAY_M and moved.sum() < STANDING_SHARE * (way[0] + way[1]) and spread < MIN_WAY_M
    )


def _is_rounded(name: str, poses: Array, report: ReadReport) -> bool:
    """Say of poses (N, 3) that they are rounded → whether they are."""
    way, turn = max(_step(poses[:, 0]), _step(poses[:, 1])), _step(poses[:, 2])
    turns = MIN_STEP_RAD < turn < MAX_STEP_RAD
    if way <= MIN_STEP_M and not turns:
        return False
    step = f"{math.degrees(turn):.3g}°" if turns else f"{way:.3g} m"
    report.fault("odometry.rounded", name, used=True, step=step)
    return True


def _step(values: Array) -> float:
    """Return the step of which all changes of values (N,) are multiples, most beside none; 0: there is none."""
    changes = np.abs(np.diff(values[np.isfinite(values)]))
    moved = changes > SAME_VALUE
    steps = changes[moved]
    beside = moved[1:-1] & ~(moved[:-2] & moved[2:])
    if len(steps) < MIN_STEPS or beside.sum() < BESIDE_SHARE * len(steps):
        return 0.0
    counts = steps / steps.min()
    return float(steps.min()) if np.allclose(counts, np.rint(counts), rtol=SAME_STEP) else 0.0


def _usual_speed(track: OdometryTrack) -> float:
    """The speed [m/s] that the places of the track are driven at, of the quicker tenth.

    Over pieces of `MAX_CARRIED_S`: the stamps of single readings may be as late as the computer was busy.
    """
    way = np.append(0.0, np.cumsum(np.hypot(*np.diff(track.poses[:, :2], axis=0).T)))
    times = np.append(0.0, np.cumsum(np.minimum(np.diff(track.times), MAX_GAP_S)))
    ends = np.linspace(0.0, times[-1], 1 + max(1, int(times[-1] / MAX_CARRIED_S)))
    speeds = np.diff(np.interp(ends, times, way)) / np.diff(ends)
    moved = speeds > 0
    return float(np.quantile(speeds[moved], 0.9)) if moved.any() else 0.0


def _starts_again(track: OdometryTrack, origin: Pose, way: Array, turned: Array) -> Array:
    """Return which steps (N-1,) lead to the origin of the base or of the log, from afar, after a silence."""
    lasted = np.diff(track.times)
    silent = lasted > max(MIN_SILENCE_S, SILENCE_PERIODS * float(np.median(lasted)))
    home = np.zeros(len(lasted), bool)
    for place in (origin, Pose()):
        off = np.hypot(track.poses[1:, 0] - place.x, track.poses[1:, 1] - place.y)
        home |= (off < 2 * ORIGIN_M) & (np.abs(wrap_all(track.poses[1:, 2] - place.heading)) < 2 * ORIGIN_RAD)
    return silent & home & ((way > JUMP_M) | (turned > JUMP_RAD))


def _without_restarts(
    name: str, track: OdometryTrack, speed: float, origin: Pose, report: ReadReport
) -> OdometryTrack:
    """Join the track where its base was restarted: it goes on from where it was. `origin` is the base's."""
    lasted = np.diff(track.times)
    way = np.hypot(*np.diff(track.poses[:, :2], axis=0).T)
    turned = np.abs(wrap_all(np.diff(track.poses[:, 2])))
    usual, row = float(np.median(lasted)), np.arange(len(lasted))
    around = track.times[np.minimum(row + 2, len(row))] - track.times[np.maximum(row - 1, 0)]
    carried = np.minimum(
        np.where(lasted < LATE_SHARE * usual, around, lasted), max(MAX_CARRIED_S, JUMP_SPEEDS * usual)
    )
    far = way > JUMP_M + JUMP_SPEEDS * speed * carried
    round_ = (turned > JUMP_RAD + MAX_TURN_RATE_RAD_S * carried) & (lasted < MAX_CARRIED_S)
    jumps = np.flatnonzero(far | round_ | _starts_again(track, origin, way, turned)) + 1
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
