"""From still poses of the board to the mount: find the lines, solve, find them better, solve again."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from core.calibration.board.board import Board
from core.calibration.laser.board_line import MIN_BEAM_COUNT, MeanScan, find_lines, foreground, select_inside
from core.calibration.laser.extrinsics import Freedom, solve
from core.calibration.laser.plane_pairs import Guess, PlanePair, disagreement
from core.calibration.laser.planes import BoardPose, Plane
from core.calibration.laser.range_lines import fit_ranges, unit_rays
from core.calibration.mount import NAMES, Extrinsics, Mount
from core.calibration.printed import mount_by_equation_13
from core.errors import BadInput
from core.geometry import Transform
from core.message import Array, message
from core.optics import CameraModel
from core.sensors.laser import Scan

FIRST_TURN, FIRST_SHIFT = np.deg2rad(8), 0.15  # [rad], [m]: how far a mount may be off its nominal value at first
HELD_TURN, HELD_SHIFT = np.deg2rad(0.5), 0.005  # [rad], [m]: what is left open, while the squares are checked
LINE_CHI2 = 25.0  # chi-square (2 dof) up to which a line may belong to the board as the nominal mount predicts it
RANGE_FLOOR_M = 0.002  # no averaged range is believed better than this


MAX_SELECT_ROUNDS = 5  # of selecting and solving


@message
class LaserPose:
    """One still pose of the board."""

    name: str
    board: BoardPose
    scan: MeanScan
    background: Array | None = None  # (B,) [m]: the empty room from where the robot stood; None: the one for all


@message
class LaserCalibration:
    """The mount and what became of every pose."""

    extrinsics: Extrinsics
    beams: tuple[Array, ...]  # of every pose: the beam numbers that were taken for the board
    reasons: tuple[str, ...]  # of every pose: why it is not used; empty: it is
    residuals: tuple[Array, ...]  # of every pose: measured minus predicted range [m] of those beams
    range_sd: float  # [m] of an averaged range, from the straightness of the lines
    square: tuple[float, float]  # [m] side of a square as the laser believes it, and its sd
    doubt: str = ""  # what explains the poses far better; empty: nothing

    @property
    def used(self) -> Array:
        """(M,) bool: the poses that took part."""
        return np.array([not reason for reason in self.reasons])

    @property
    def residual_rms(self) -> float:
        """[m] over the beams of the used poses."""
        kept = [each for each, reason in zip(self.residuals, self.reasons, strict=True) if not reason]
        return float(np.sqrt(np.mean(np.concatenate(kept) ** 2)))


def calibrate_laser(
    poses: Sequence[LaserPose],
    board: Board,
    background: Array | None = None,
    mount: Mount | None = None,
    *,
    with_offset: bool = False,
    printed: bool = False,
) -> LaserCalibration:
    """Still poses, the board, and the ranges (B,) [m] of the empty room → the mount.

    A pose that brings its own empty room is looked for in that one. `printed`: by eq. 13, from the
    same beams.
    Raises BadInput where fewer than three poses show the board to the laser.
    """
    mount = mount or Mount()
    freedom = Freedom(offset=with_offset)
    beams = [_first_beams(pose, board, background, mount) for pose in poses]
    found = _solve(poses, beams, mount, freedom)
    for _ in range(MAX_SELECT_ROUNDS):
        again = [_enough(select_inside(pose.scan, pose.board, board, found)) for pose in poses]
        if _seen(again) < max(3, _seen(beams) / 2) or all(map(np.array_equal, again, beams)):
            break  # settled; or a first solution so poor that it misses its own boards
        beams = again
        found = _solve(poses, beams, mount, freedom, found.transform)
    scaled = _solve(poses, beams, _held(mount, found), Freedom(offset=with_offset, scale=True), found.transform)
    factor, factor_sd = scaled.scale or (1.0, 0.0)
    seen = [number for number, each in enumerate(beams) if len(each)]
    if printed:
        found = mount_by_equation_13(
            found,
            [_points_on(poses[number], beams[number]) for number, used in zip(seen, found.used, strict=True) if used],
        )
    fits = dict(zip(seen, zip(found.used, found.chi2, strict=True), strict=True))
    return LaserCalibration(
        extrinsics=found,
        beams=tuple(beams),
        reasons=tuple(_reason(fits.get(number), found) for number in range(len(poses))),
        residuals=tuple(range_residuals(pose, each, found.guess) for pose, each in zip(poses, beams, strict=True)),
        range_sd=_range_sd(poses, beams),
        square=(board.square * factor, board.square * factor_sd),
    )


def lines_of(pose: LaserPose, board: Board, background: Array | None) -> tuple[Array, ...]:
    """The straight runs of beams of a scan that may be the board, the longest first."""
    background = background if pose.background is None else pose.background
    return find_lines(pose.scan, foreground(pose.scan, background), board)


def nearest_line(pose: LaserPose, lines: Sequence[Array], mount: Mount) -> Array | None:
    """The run that fits the nominal mount best, if one fits it at all."""
    if not lines:
        return None
    pairs = [_pair(pose, beams, pose.scan.sd) for beams in lines]
    nominal = Guess(mount.nominal.rotation, mount.nominal.translation)
    chi2 = disagreement(pairs, nominal, np.diag([FIRST_TURN**2] * 3 + [FIRST_SHIFT**2] * 3))
    best = int(np.argmin(chi2))
    return lines[best] if chi2[best] < LINE_CHI2 else None


def range_residuals(pose: LaserPose, beams: Array, guess: Guess) -> Array:
    """Measured minus predicted range (K,) [m] of beams on the board, under a mount."""
    normal = guess.rotation @ pose.board.plane.normal
    nearness = guess.scale * pose.board.plane.distance + normal @ guess.translation
    return pose.scan.ranges[beams] - guess.offset - nearness / (pose.scan.rays[beams] @ normal)


def _held(mount: Mount, found: Extrinsics) -> Mount:
    """The mount with what the data leave open held fast: a free tilt would trade against the size of the squares."""
    tight = tuple(
        min(sd, HELD_TURN if number < 3 else HELD_SHIFT) if name in found.weak else sd
        for number, (name, sd) in enumerate(zip(NAMES, mount.spread, strict=True))
    )
    return Mount(nominal=mount.nominal, spread=tight)


def _first_beams(pose: LaserPose, board: Board, background: Array | None, mount: Mount) -> Array:
    """The run that fits the nominal mount best; if none does, the longest before the empty room; else no beam."""
    lines = lines_of(pose, board, background)
    nearest = nearest_line(pose, lines, mount)
    if nearest is not None:
        return nearest
    known = background is not None or pose.background is not None
    return lines[0] if lines and known else np.empty(0, int)


def _solve(
    poses: Sequence[LaserPose], beams: Sequence[Array], mount: Mount, freedom: Freedom, start: Transform | None = None
) -> Extrinsics:
    seen = [(pose, each) for pose, each in zip(poses, beams, strict=True) if len(each)]
    if len(seen) < 3:
        raise BadInput(
            f"The laser sees the board in only {len(seen)} of {len(poses)} poses; at least 3 are needed. "
            "Hold the board at the laser's height, nearer, and away from walls and furniture."
        )
    sd = _range_sd(poses, beams)
    return solve([_pair(pose, each, sd) for pose, each in seen], mount, start=start, freedom=freedom)


def _points_on(pose: LaserPose, beams: Array) -> tuple[Plane, Array]:
    return pose.board.plane, pose.scan.rays[beams] * pose.scan.ranges[beams][:, None]


def _pair(pose: LaserPose, beams: Array, sd: float) -> PlanePair:
    return PlanePair(plane=pose.board.plane, ranges=fit_ranges(pose.scan.rays[beams], pose.scan.ranges[beams], sd))


def _range_sd(poses: Sequence[LaserPose], beams: Sequence[Array]) -> float:
    """[m] of an averaged range: how straight the beams on each board are; the median over the poses."""
    spreads = [
        float(np.sum(fit_ranges(pose.scan.rays[each], pose.scan.ranges[each], 1.0).residuals ** 2)) / (len(each) - 2)
        for pose, each in zip(poses, beams, strict=True)
        if len(each) > 2
    ]
    return max(float(np.sqrt(np.median(spreads))), RANGE_FLOOR_M)


def _seen(beams: Sequence[Array]) -> int:
    return sum(len(each) > 0 for each in beams)


def _enough(beams: Array) -> Array:
    return beams if len(beams) >= MIN_BEAM_COUNT else np.empty(0, int)


def _reason(fit: tuple[bool, float] | None, found: Extrinsics) -> str:
    if fit is None:
        return "the laser does not meet the board: hold it at the laser's height, nearer, away from walls"
    used, chi2 = fit
    if used:
        return ""
    times = np.sqrt(chi2 / 2 / max(1.0, found.misfit))
    return f"camera and laser disagree {times:.0f} times more than expected: did the board move in between?"


class Check(NamedTuple):
    """Prediction error of a mount for a pose that took no part."""

    residual_rms: float  # [m] along the beams
    off: float  # [pixel] mean distance between where the beams land and where the camera's plane wants them
    beams: int


def dots(scan: Scan, laser_from_camera: Transform, model: CameraModel) -> tuple[Array, Array]:
    """A scan in the picture: (M, 3) u, v [pixel] and range [m] of the points in view, and their beams (M,)."""
    beams = np.flatnonzero(scan.valid)
    ranges = scan.ranges[beams]
    points = unit_rays(scan.angles)[beams] * ranges[:, None]
    pixels = model.project(laser_from_camera.inverse().apply(points))
    with np.errstate(invalid="ignore"):
        inside = np.all((pixels >= 0) & (pixels < (model.width, model.height)), axis=1)
    return np.column_stack((pixels, ranges))[inside], beams[inside]


def check(pose: LaserPose, found: Extrinsics, board: Board, model: CameraModel) -> Check:
    """A pose that took no part → how the mount predicts it. Raises BadInput where the laser misses the board."""
    beams = select_inside(pose.scan, pose.board, board, found)
    if not len(beams):
        raise BadInput("The laser does not meet the board in this pose.")
    residuals = range_residuals(pose, beams, found.guess)
    rays, ranges = pose.scan.rays[beams], pose.scan.ranges[beams]
    into_camera = found.transform.inverse()
    seen = model.project(into_camera.apply(rays * ranges[:, None]))
    wanted = model.project(into_camera.apply(rays * (ranges - residuals)[:, None]))
    off = float(np.nanmean(np.linalg.norm(seen - wanted, axis=1)))
    return Check(float(np.sqrt(np.mean(residuals**2))), off, len(beams))
