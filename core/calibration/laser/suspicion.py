"""Suspect the scans: what would make the laser see the board where the camera does?

Ranges in another unit, angles that run the other way and scans that belong to other pictures all end in the same
"sees the board in only 2 of 12 poses", or in a mount that the sensors contradict. Each is tried as a rival: the scans
as they would have been. One that explains far more poses, far better, names the cause.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from core.calibration.board.board import Board
from core.calibration.laser.board_line import MeanScan
from core.calibration.laser.explanation import MAX_MISFIT, square_doubt
from core.calibration.laser.range_lines import unit_rays
from core.calibration.laser.solve import LaserCalibration, LaserPose, calibrate_laser, lines_of, nearest_line
from core.calibration.mount import Mount
from core.errors import BadInput
from core.message import Array
from core.sensors.checks import UnusableReading, refusal

ENOUGH_POSES_SHARE = 0.6  # of the poses that show the board to the laser, and …
ODD_MISFIT = 300.0  # … this misfit: beyond either the scans are suspected
MISFIT_GAIN = 10.0  # a cause has so much less misfit …
LEAST_FIT = 100.0  # … and less than this, where there is no solution to compare it with
FULL_TRIALS = 6  # rivals that are solved in full, those that show most boards first, until one fits
AT_BOARD = 0.4  # share of the board's distance by which the nearest range may differ, in a unit worth trying
LEAST_SD_M = 0.001  # of an averaged range

METRES = {"metres": 1.0, "millimetres": 1e-3, "centimetres": 1e-2, "inches": 0.0254, "feet": 0.3048}  # of one
UNITS = tuple(
    (true if said == "metres" else f"{true}, not in {said}", METRES[true] / METRES[said])
    for said in METRES
    for true in METRES
    if true != said
)
MAX_SCALE = 5.0  # of squares that were measured wrongly: it looks like another unit of the ranges that fits less well
MIXED_TIMES = 6.0  # by which the median ranges of scans of one place differ at most
ANGLES = (
    ("its angles run the other way (clockwise)", -1.0, 0.0),
    ("its angles are turned by half a turn", 1.0, np.pi),
    ("its angles are turned by a quarter", 1.0, np.pi / 2),
    ("its angles are turned by a quarter", 1.0, -np.pi / 2),
    ("its angles are twice too large", 0.5, 0.0),
)


@dataclass(frozen=True)
class Rival:
    """Poses as they would be if the scans were something else than they say."""

    code: str  # of the check
    what: str  # the cause in words
    poses: tuple[LaserPose, ...]
    background: Array | None = None
    factor: float = 1.0  # of the ranges


def doubt_of(
    found: LaserCalibration | None,
    poses: Sequence[LaserPose],
    pairings: Sequence[Rival],
    board: Board,
    background: Array | None,
    mount: Mount | None,
) -> UnusableReading | None:
    """Return the error that names what explains the poses far better; None: nothing does, or nothing is odd."""
    if not is_suspicious(found, len(poses)):
        return None
    medians = np.array([np.nanmedian(pose.scan.ranges) for pose in poses])
    large = medians > math.sqrt(MIXED_TIMES) * medians.min()
    if medians.max() > MIXED_TIMES * medians.min() and not np.any(large & (medians < medians.max() / 2)):
        times = f"{np.median(medians[large]) / np.median(medians[~large]):.3g}"
        return refusal("laser.mixed_units", large=int(large.sum()), count=len(poses), times=times)
    cause = find_cause(found, poses, pairings, board, background, mount)
    if cause is None:
        return None
    rival, other = cause
    fits, seen = (0 if one is None else int(np.count_nonzero(one.used)) for one in (other, found))
    scale = other.square[0] / rival.factor / board.square
    if 1 / MAX_SCALE < scale < MAX_SCALE and rival.factor != 1.0 and square_doubt(other, board):
        sizes = {"side": f"{1e3 * scale * board.square:.3g}", "entered": f"{1e3 * board.square:.3g}"}
        return refusal("laser.squares", fits=fits, count=len(poses), seen=seen, **sizes)
    return refusal(rival.code, what=rival.what, fits=fits, count=len(poses), seen=seen)


def is_suspicious(found: LaserCalibration | None, count: int) -> bool:
    """Return whether a solution of `count` poses, or that there is none, asks for another explanation."""
    return found is None or found.extrinsics.misfit > ODD_MISFIT or int(found.used.sum()) < ENOUGH_POSES_SHARE * count


def find_cause(
    found: LaserCalibration | None,
    poses: Sequence[LaserPose],
    pairings: Sequence[Rival],
    board: Board,
    background: Array | None,
    mount: Mount | None,
) -> tuple[Rival, LaserCalibration] | None:
    """Find the rival that explains far more poses, far better, and the mount that it gives."""
    mount = mount or Mount()
    least = max(3, ENOUGH_POSES_SHARE * len(poses), 0 if found is None else int(found.used.sum()))
    limit = LEAST_FIT if found is None else found.extrinsics.misfit / MISFIT_GAIN
    boards: list[tuple[int, Rival]] = []
    for unit, factor in (("", 1.0), *UNITS):
        if _may_be_metres(poses, factor):
            scaled = _rival(poses, background, f"its ranges are in {unit}" if unit else "", factor)
            lines = [lines_of(pose, board, scaled.background) for pose in scaled.poses]
            rivals = _forms(scaled, pairings if not unit else ())
            boards += [(_boards_met(each, scaled.poses, lines, mount), each) for each in rivals]
    boards.sort(key=lambda each: -each[0])
    best: tuple[float, Rival, LaserCalibration] | None = None
    for _, rival in boards[:FULL_TRIALS]:
        try:
            other = calibrate_laser(rival.poses, board, rival.background, mount)
        except BadInput:
            continue
        misfit, seen = other.extrinsics.misfit, int(other.used.sum())
        if seen >= least and misfit < (limit if best is None else best[0]):
            best = misfit, rival, other
            if misfit < MAX_MISFIT:
                break
    return None if best is None else best[1:]


def _boards_met(rival: Rival, poses: Sequence[LaserPose], lines: Sequence[tuple[Array, ...]], mount: Mount) -> int:
    """Count the boards of a rival where a line of its scan is; the lines are those of the poses' own scans."""
    by_scan = {pose.scan.ranges.tobytes(): each for pose, each in zip(poses, lines, strict=True)}
    return sum(
        nearest_line(pose, by_scan.get(pose.scan.ranges.tobytes(), ()), mount) is not None for pose in rival.poses
    )


def _forms(scaled: Rival, pairings: Sequence[Rival]) -> Iterator[Rival]:
    """Scans in one unit, with other angles or of other pictures."""
    if scaled.what:
        yield scaled
    for words, along, turn in ANGLES:
        what = " and ".join(filter(None, (scaled.what, words)))
        yield _rival(scaled.poses, scaled.background, what, along=along, turn=turn)
    yield from pairings


def _rival(
    poses: Sequence[LaserPose],
    background: Array | None,
    what: str,
    factor: float = 1.0,
    *,
    along: float = 1.0,
    turn: float = 0.0,
) -> Rival:
    """The scans with ranges times `factor` and angles `along` times as large, turned by `turn` [rad]."""
    return Rival(
        "laser.other_form",
        what,
        tuple(_changed(pose, factor, along, turn) for pose in poses),
        None if background is None else background * factor,
        factor,
    )


def _may_be_metres(poses: Sequence[LaserPose], factor: float) -> bool:
    off: list[float] = []
    for pose in poses:
        distance = float(np.linalg.norm(pose.board.translation))
        seen = pose.scan.ranges[np.isfinite(pose.scan.ranges)] * factor
        off.append(float(np.abs(seen - distance).min(initial=np.inf)) / distance)
    return float(np.median(off)) < AT_BOARD


def _changed(pose: LaserPose, factor: float, along: float, turn: float) -> LaserPose:
    bearings = np.unwrap(np.arctan2(pose.scan.rays[:, 1], pose.scan.rays[:, 0]))
    bearings = bearings - 2 * np.pi * np.round(bearings.mean() / (2 * np.pi))
    scan = MeanScan(
        ranges=pose.scan.ranges * factor,
        rays=unit_rays(along * bearings + turn),
        sd=max(pose.scan.sd * min(factor, 1.0), LEAST_SD_M),
    )
    return replace(pose, scan=scan, background=None if pose.background is None else pose.background * factor)
