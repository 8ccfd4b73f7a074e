"""Rows of ranges → scans: one meaning for "no measurement" and "nothing there", one direction, sane numbers."""

import itertools
import math
from collections import deque
from dataclasses import replace
from pathlib import Path

import numpy as np

from core.geometry import Pose
from core.message import Array
from core.recording.clocks import MAX_PARTS, MAX_PAUSE_S, MIN_BACK_S, longest_part
from core.recording.odometry_track import OdometryTrack
from core.recording.read_report import BadRecord, ReadReport
from core.recording.recording import LogSettings, ScanRecording
from core.sensors import Laser, Scan
from core.sensors.checks import refusal
from core.sensors.laser import MAX_STAMP_S, MAX_SWEEP_S, beams_malformation
from core.sensors.publishers import scan_turns
from core.sensors.scan_gate import is_constant
from core.slam.scan_matching.wall_shapes import median_change

AT_THE_ORIGIN = Pose()
MIN_SAMPLED_BEAMS = 2000
MAX_SAMPLED_SCANS = 200  # of a log, by which its ranges are judged
MIN_HIT_SHARE = 0.005  # of the beams of a log that measure something
MARK_BAND = 0.01  # of the longest range, in which marks of nothing there lie, with their noise
MARK_CROWDING = 4.0  # times as many beams as in the three such bands before it
MIN_MARK_SHARE = 0.02  # of the beams
MIN_MARK_RANGE = 0.8  # times the longest range, where such a mark lies
MIN_EXACT_SHARE, MAX_EXACT_SHARE = 0.1, 0.9  # of the beams, that end at such a mark to the last bit
MIN_STANDING_SHARE, STANDING_M, BODY_M = 0.1, 0.03, 0.6  # of the beams that stand, by how much, and how near
MIN_VARYING_M, MIN_STANDING_SCANS = 0.3, 20  # by which half of the others vary: the robot moves
MAX_CONSTANT_SHARE = 0.5  # of the scans, all of whose beams are as long
MAX_ECHO_SCANS, MIN_UNIQUE_SHARE = 8, 0.45  # within which a scan comes again; of a log that holds some twice
MIN_REPEATED_SCANS, MAX_REPEATED_SHARE = 30, 0.2  # of a log without odometry, that are those before to the last bit
MAX_MIXED_SHARE = 0.5  # of a log, in which two robots' scans take turns
MIN_KEPT_SHARE = 0.45  # of the scans that a log must have a time for
MIN_SET_BACK_S = 0.25  # by which a clock was set back, where all streams show it as often
COMPARED_SCANS, USUAL_SHARE = 20, 0.9  # before and after a step of a clock, of whose changes of ranges so many …
MAX_CHANGE_RATIO, MIN_CHANGE = 2.0, 0.01  # … times which, but at least that share, one place may change
DEFAULT_RANGE_M = 100.0  # taken for range_max where a log does not give it


def default_angles(beams: int) -> tuple[float, float]:
    """Beams over 180° whose angles are not given → (angle_min, angle_step) [rad].

    181, 361, … beams stand on both ends (-90° … +90°); any other number n stands every 180°/n from -90° on.
    """
    return -math.pi / 2, math.pi / (beams - 1 if beams > 1 and (beams - 1) % 180 == 0 else beams)


def make_scan(
    stamp: float,
    ranges: Array,
    angles: tuple[float, float],
    limits: tuple[float, float | None],
    time_step: float = 0.0,
) -> Scan:
    """Ranges (N,) [m] as logged → a scan from right to left.

    `angles` (angle_min, angle_step) [rad]; `limits` (range_min, range_max or None where it is not given) [m].
    Below range_min, negative or NaN: no measurement. From range_max on or +inf: nothing there; a log that does not
    give range_max claims no free space with such beams. Raises BadRecord.
    """
    angle_min, angle_step = angles
    low, high = limits
    beams = len(ranges)
    if abs(stamp) > MAX_STAMP_S:
        raise BadRecord("its time cannot be")
    if why := beams_malformation(beams, angle_min, angle_step):
        raise BadRecord(why)
    if not math.isfinite(time_step) or not 0 <= time_step * beams < MAX_SWEEP_S:
        time_step = 0.0
    limited = high is not None and 0 < high < 10_000
    top = high if high is not None and limited else DEFAULT_RANGE_M
    low = low if 0 <= low < top else 0.0
    with np.errstate(invalid="ignore", over="ignore"):
        ranges = np.asarray(ranges, np.float32)
        nothing = ranges >= top
        missing = ~(ranges >= max(low, 1e-6))
    clean = np.where(missing, np.nan, np.where(nothing, np.inf if limited else np.nan, ranges))
    if angle_step < 0:
        stamp += time_step * (beams - 1)
        angle_min, angle_step, time_step = angle_min + angle_step * (beams - 1), -angle_step, -time_step
        clean = clean[::-1]
    return Scan(
        stamp=stamp,
        ranges=np.ascontiguousarray(clean, np.float32),
        angle_min=angle_min,
        angle_step=angle_step,
        range_min=low,
        range_max=top,
        time_step=time_step,
    )


def turned_over(scan: Scan) -> Scan:
    """A scan of a laser that hangs upside down → the same as seen from above, again right to left."""
    beams = len(scan.ranges)
    ranges: Array = scan.ranges[::-1]
    return replace(
        scan,
        stamp=scan.stamp + scan.time_step * (beams - 1),
        ranges=ranges,
        angle_min=-(scan.angle_min + scan.angle_step * (beams - 1)),
        time_step=-scan.time_step,
    )


def on_a_clock_that_goes_on(scans: list[Scan], streams: list[Array], tally: ReadReport) -> list[Array]:
    """Times [s] of the scans, and of other readings of the same log, in the order of the file → the same without
    steps back and leaps: a clock was set, where the scans before and after one show the same place.

    All streams count by one clock. What begins again is not changed.
    """
    steps = [
        np.flatnonzero((np.diff(times) < -MIN_SET_BACK_S) | (np.diff(times) > MAX_PAUSE_S)) + 1 for times in streams
    ]
    if not 1 <= len(steps[0]) <= MAX_PARTS or any(len(rows) != len(steps[0]) for rows in steps):
        return streams
    edges = itertools.pairwise([0, *steps[0].tolist()])
    if not all(_goes_on(scans, streams[0], first, row) for first, row in edges):
        return streams
    periods = [float(np.median(np.abs(np.diff(times)))) for times in streams]
    finest = int(np.argmin(periods))
    set_by = np.diff(streams[finest])[steps[finest] - 1] - periods[finest]
    tally.fault("clock.set", "the laser", used=True, jump=f"{set_by[np.argmax(np.abs(set_by))]:+.0f}")
    shifts = np.append(0.0, -np.cumsum(set_by))
    return [
        times + shifts[np.searchsorted(rows, np.arange(len(times)), "right")]
        for times, rows in zip(streams, steps, strict=True)
    ]


def _goes_on(scans: list[Scan], times: Array, first: int, row: int) -> bool:
    """Return whether a scan whose time does not follow that of the last one, `row`, was taken just after it.

    `first`: the row from which on the times rose. A second recording in the file shows another place, begins at the
    same time, or has a scan that is the one at that time again.
    """
    if abs(times[row] - times[first]) < MIN_BACK_S:
        return False
    near = scans[max(first, row - COMPARED_SCANS) : row + COMPARED_SCANS]
    usual = np.quantile([median_change(two.ranges, one.ranges) for one, two in itertools.pairwise(near)], USUAL_SHARE)
    change = median_change(scans[row].ranges, scans[row - 1].ranges)
    twin = scans[first + int(np.argmin(np.abs(times[first:row] - times[row])))]
    again = times[row] > times[first] and 2 * median_change(scans[row].ranges, twin.ranges) < change
    return change < MAX_CHANGE_RATIO * max(float(usual), MIN_CHANGE) and not again


def in_time_order(scans: list[Scan], tally: ReadReport) -> list[Scan]:
    """Scans in any order → rising stamps; what repeats a stamp is left out and counted.

    Raises BadInput where fewer than MIN_KEPT_SHARE of the longest part in one clock are left.
    """
    first, last = longest_part(np.array([scan.stamp for scan in scans]))
    if last - first < len(scans):
        tally.fault("clock.begins_again", "the laser", used=True, kept=last - first, all=len(scans))
        scans = scans[first:last]
    ordered = sorted(scans, key=lambda scan: scan.stamp)
    kept = [scan for index, scan in enumerate(ordered) if index == 0 or scan.stamp > ordered[index - 1].stamp]
    tally.drop("the stamp is that of another scan", count=len(ordered) - len(kept))
    kept = _without_echoes(kept, tally)
    if len(kept) < MIN_KEPT_SHARE * len(scans):
        raise refusal("clock.few_left", kept=len(kept), all=len(scans))
    return kept


def _without_echoes(scans: list[Scan], tally: ReadReport) -> list[Scan]:
    """Scans in time order → the same without those that come once more after another one, to the last bit."""
    recent: deque[bytes] = deque(maxlen=MAX_ECHO_SCANS)
    kept = list[Scan]()
    for scan in scans:
        content = scan.ranges.tobytes()
        if content not in recent or content == recent[-1] or not scan.valid.any():
            kept.append(scan)
        recent.append(content)
    if len(kept) < MIN_UNIQUE_SHARE * len(scans):
        return scans
    tally.drop("it is written twice", count=len(scans) - len(kept))
    return kept


def without_walls_at_the_end(scans: list[Scan], tally: ReadReport, settings: LogSettings) -> list[Scan]:
    """Scans of one laser → the same without walls that are a mark for nothing there."""
    sample = scans[:: max(1, len(scans) // MAX_SAMPLED_SCANS)]
    ranges = np.concatenate([scan.ranges for scan in sample])
    hits = ranges[np.isfinite(ranges)]
    typical = scans[len(scans) // 2]
    if len(hits) < MIN_SAMPLED_BEAMS:
        return scans
    top = float(hits.max())
    marked = hits > (1 - MARK_BAND) * top
    below = ~marked & (hits > (1 - 4 * MARK_BAND) * top)
    share = float(np.count_nonzero(marked)) / len(ranges)
    crowded = np.count_nonzero(marked) > MARK_CROWDING * np.count_nonzero(below)
    exact = MIN_EXACT_SHARE * len(ranges) < np.count_nonzero(hits == top) < MAX_EXACT_SHARE * len(ranges)
    at_the_end = exact or top > MIN_MARK_RANGE * typical.range_max
    if share > MIN_MARK_SHARE and crowded and at_the_end and not settings.range_max:
        tally.fault("scan.no_return_mark", "the laser", used=True, share=f"{100 * share:.0f}", range=f"{top:.2f}")
        far, nothing = (1 - MARK_BAND) * top, np.float32(np.inf)
        scans = [
            replace(scan, ranges=np.where(scan.ranges > far, nothing, scan.ranges), range_max=far) for scan in scans
        ]
    return scans


def without_standing_beams(scans: list[Scan], tally: ReadReport) -> list[Scan]:
    """Scans of one laser → the same without beams whose range stands while the robot moves.

    They end on the robot itself, a hand's breadth away, or are repeated to the last bit.
    """
    sample = [scan.ranges for scan in scans[:: max(1, len(scans) // MAX_SAMPLED_SCANS)]]
    if len(sample) < MIN_STANDING_SCANS or len({len(ranges) for ranges in sample}) > 1:
        return scans
    rows = np.where(np.isfinite(sample), sample, np.float32(DEFAULT_RANGE_M))
    low, middle, high = np.quantile(rows, (0.05, 0.5, 0.95), axis=0)
    stands = (middle < DEFAULT_RANGE_M) & ((high == low) | ((high - low < STANDING_M) & (middle < BODY_M)))
    share = float(stands.mean())
    if not MIN_STANDING_SHARE < share < 1.0 or np.median((high - low)[~stands]) < MIN_VARYING_M:
        return scans
    tally.fault("scan.standing_beams", "the laser", used=True, share=f"{100 * share:.0f}")
    return [
        replace(scan, ranges=np.where(stands, np.float32(np.nan), scan.ranges))
        if len(scan.ranges) == len(stands)
        else scan
        for scan in scans
    ]


def laser_of(scans: list[Scan], mounting: Pose, height: float, settings: LogSettings) -> Laser:
    """The laser that made these scans, as its middle scan describes it."""
    typical = scans[len(scans) // 2]
    periods = np.diff([scan.stamp for scan in scans])
    return Laser(
        mounting=settings.mounted(mounting),
        height=height,
        beams=len(typical.ranges),
        angle_min=typical.angle_min,
        angle_step=typical.angle_step,
        range_min=typical.range_min,
        range_max=typical.range_max,
        rate=1 / float(np.median(periods)) if len(periods) else 10.0,
        time_step=typical.time_step,
    )


def scan_recording(
    path: Path,
    scans: list[Scan],
    track: OdometryTrack | None,
    tally: ReadReport,
    form: str,
    settings: LogSettings,
    mounting: Pose = AT_THE_ORIGIN,
    height: float = Laser.height,
) -> ScanRecording:
    """Scans in time order (at least one) and odometry → the recording."""
    scans = without_standing_beams(without_walls_at_the_end(scans, tally, settings), tally)
    share = float(np.mean([np.mean(np.isfinite(scan.ranges)) for scan in scans[:: max(1, len(scans) // 200)]]))
    if share == 0:
        raise refusal("scan.empty", "the laser")
    if share < MIN_HIT_SHARE:
        tally.fault("scan.few_hits", "the laser", used=True, share=f"{100 * share:.1f}")
    sample = scans[:: max(1, len(scans) // MAX_SAMPLED_SCANS)]
    if np.mean([is_constant(scan.ranges) for scan in sample]) > MAX_CONSTANT_SHARE:
        raise refusal("scan.constant", "the laser")
    if (mixed := scan_turns(scans, None if track is None else track.wheels_at)) > MAX_MIXED_SHARE:
        raise refusal("robots.mixed", "the laser")
    if mixed > 0:
        tally.fault("robots.mixed", "the laser", used=True)
    repeats = sum(np.array_equal(one.ranges, two.ranges, equal_nan=True) for one, two in itertools.pairwise(scans))
    if track is None and repeats > max(MIN_REPEATED_SCANS, MAX_REPEATED_SHARE * len(scans)):
        tally.fault("scan.repeated", "the laser", used=True, count=repeats, all=len(scans))
    if track is not None and not (scans[0].stamp < track.times[-1] and track.times[0] < scans[-1].stamp):
        tally.fault("clock.apart", scans=f"{scans[0].stamp:.0f}", odometry=f"{track.times[0]:.0f}")
        track, tally.topics = None, [topic for topic in tally.topics if not topic.endswith("odometry")]
    if track is not None and (scans[0].stamp < track.times[0] - 1 or scans[-1].stamp > track.times[-1] + 1):
        tally.warn("Some scans lie outside the time of the odometry; the wheels are taken to stand still there.")
    return ScanRecording(
        path=path,
        scans=tuple(scans),
        track=track,
        laser=laser_of(scans, mounting, height, settings),
        report=tally.report(form),
    )
