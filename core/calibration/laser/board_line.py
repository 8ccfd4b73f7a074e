"""The board's line in the laser's readings, found without a click.

First against the static background, as a straight run of beams nearer than the empty room; then, once a mount is
known, inside the rectangle where the camera says the board is. Select and solve take turns until they agree.
"""

import itertools

import numpy as np

from core.calibration.board.board import Board
from core.calibration.laser.plane_pairs import planes_of, predict
from core.calibration.laser.planes import BoardPose
from core.calibration.mount import Extrinsics
from core.geometry import Transform
from core.message import Array, message

# Thresholds of the search for the line.
MIN_NEARER_M = 0.06  # [m] that a beam must be shorter than the empty room
MIN_NEARER_SDS = 4.0  # the same in standard deviations of a range
MIN_BEAM_COUNT = 10
LINE_DRAWS = 600
DRAW_SEED = 11
MAX_DRAW_REACH = 120  # beams between the two drawn ones at most
MIN_CHORD_M = 0.08  # [m] between the two drawn beams' ends
LINE_BAND_M = 0.008  # [m] half-width of the line
LINE_BAND_SDS = 2.5  # the same in standard deviations of a range
MAX_GAP_BEAMS = 3  # missing beams that a run may bridge
EXTRA_LENGTH_M = 0.15  # [m] that a run may exceed the panel's width: a tilted panel is cut along its diagonal
UNKNOWN_PANEL_M = 0.6  # [m] width assumed of a panel that was not measured
SIDE_DISTANCE_M = 0.025  # [m] that beams keep from the panel's sides, where they are half on it
EXTRA_BAND_M = 0.003  # [m] added to the band about the prediction
RECTANGLE_SLACK_M = 0.02  # [m] about the predicted rectangle, besides twice the mount's uncertainty …
MAX_SIDE_SLACK_M = 0.03  # [m] … but at most so much to the sides
MAX_HEIGHT_SLACK_M = 0.05  # [m] … and so much above and below
MAX_LINE_COUNT = 8  # lines that are looked for in one scan: without a background, walls are among them


@message
class MeanScan:
    """Scans of a still scene, averaged beam by beam."""

    ranges: Array  # (B,) [m]; NaN = no measurement
    rays: Array  # (B, 3) unit vectors in the laser frame
    sd: float  # [m] standard deviation of an averaged range


def average(scans: Array, rays: Array, noise: float | None = None) -> MeanScan:
    """Scans (K, B) [m] of a still scene, NaN = no measurement → their mean.

    `noise` [m] of one range; by default from the scatter of at least five scans, else 10 mm is assumed. A beam
    counts when half of its readings are valid; readings far from the beam's median are left out.
    """
    count = len(scans)
    valid = np.isfinite(scans)
    steady = valid.sum(axis=0) >= max(1, count / 2)
    kept = np.where(valid & steady, scans, np.nan)
    middle = np.full(scans.shape[1], np.nan)
    middle[steady] = np.nanmedian(kept[:, steady], axis=0)
    away = np.abs(kept - middle)
    if noise is None:
        noise = 1.4826 * float(np.nanmedian(away)) if count >= 5 and steady.any() else 0.01
    noise = max(noise, 0.001)
    kept[away > 4 * noise] = np.nan
    used = np.isfinite(kept).sum(axis=0)
    ranges = np.full(scans.shape[1], np.nan)
    enough = used >= max(1, count / 2)
    ranges[enough] = np.nansum(kept[:, enough], axis=0) / used[enough]
    return MeanScan(ranges=ranges, rays=rays, sd=max(noise / np.sqrt(count), 0.001))


def foreground(scan: MeanScan, background: Array | None) -> Array:
    """(B,) bool: beams that end before the empty room does; without a background, all beams that measured."""
    seen = np.isfinite(scan.ranges) & (scan.ranges > 0)
    if background is None:
        return seen
    empty = np.where(np.isfinite(background), background, np.inf)
    return seen & (empty - scan.ranges > max(MIN_NEARER_SDS * scan.sd, MIN_NEARER_M))


def find_lines(scan: MeanScan, candidates: Array, board: Board) -> tuple[Array, ...]:
    """Candidate beams (B,) bool → numbers (K,) of straight runs of beams no longer than the panel may be, those of
    most beams first.
    """
    rng = np.random.default_rng(DRAW_SEED)
    open_beams, found = candidates.copy(), []
    for _ in range(MAX_LINE_COUNT):
        line = _longest(rng, scan, open_beams, board)
        if line is None:
            break
        found.append(line)
        open_beams[line] = False
    return tuple(sorted(found, key=lambda line: -len(line)))


def select_inside(scan: MeanScan, pose: BoardPose, board: Board, found: Extrinsics) -> Array:
    """Beams (K,) that end on the board where camera and mount predict it, within what is known of the mount.

    A panel that was not measured may be larger than the print, and the beams may pass above or below the print: there
    the run on the board's plane that crosses the print's width is taken.
    """
    laser_from_board = found.transform @ Transform(rotation=pose.rotation, translation=pose.translation)
    q, slope = predict(planes_of([pose.plane]), found.guess)
    with np.errstate(divide="ignore", invalid="ignore"):
        predicted = 1 / (scan.rays @ q[0])
        predicted[predicted <= 0] = np.nan
        spread = slope[0][:, :6] @ found.covariance @ slope[0][:, :6].T
        doubt = predicted**2 * np.sqrt(np.einsum("bi,ij,bj->b", scan.rays, spread, scan.rays))
        near = np.abs(scan.ranges - predicted) < LINE_BAND_SDS * scan.sd + doubt + EXTRA_BAND_M
    places = np.abs(laser_from_board.inverse().apply(scan.rays * predicted[:, None]) - board.centre)
    slack = RECTANGLE_SLACK_M + 2 * float(np.sqrt(np.trace(found.covariance[3:, 3:])))
    half_width, half_height = board.half_size
    if board.panel is not None:
        aside = places[:, 0] < half_width - SIDE_DISTANCE_M + min(slack, MAX_SIDE_SLACK_M)
        return np.flatnonzero(near & aside & (places[:, 1] < half_height + min(slack, MAX_HEIGHT_SLACK_M)))
    run = longest_run(np.flatnonzero(near & (places[:, 0] < UNKNOWN_PANEL_M / 2 + half_width)))
    return run if np.any(places[run, 0] < half_width) else run[:0]


def _longest(rng: np.random.Generator, scan: MeanScan, candidates: Array, board: Board) -> Array | None:
    """The straight run with the most beams, of many drawn through two beams each."""
    beams = np.flatnonzero(candidates)
    if len(beams) < MIN_BEAM_COUNT:
        return None
    longest = (board.panel[0] if board.panel else UNKNOWN_PANEL_M) + EXTRA_LENGTH_M
    points = scan.rays[:, :2] * np.where(candidates, scan.ranges, np.nan)[:, None]
    first = rng.choice(beams, LINE_DRAWS)
    second = rng.choice(beams, LINE_DRAWS)
    chord = np.linalg.norm(points[first] - points[second], axis=1)
    fair = (np.abs(first - second) <= MAX_DRAW_REACH) & (chord > MIN_CHORD_M) & (chord < longest)
    pairs = np.stack((points[first], points[second]), axis=1)[fair]
    pairs = pairs[np.abs(np.linalg.det(pairs)) > 1e-6]
    if not len(pairs):
        return None
    q = np.linalg.solve(pairs, np.ones((len(pairs), 2, 1)))[..., 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        off = np.abs(scan.ranges - 1 / (q @ scan.rays[:, :2].T))
    on = (off < max(LINE_BAND_SDS * scan.sd, LINE_BAND_M)) & candidates
    best: Array | None = None
    counts = on.sum(axis=1)
    for number in np.argsort(-counts):
        if counts[number] < MIN_BEAM_COUNT or (best is not None and counts[number] <= len(best)):
            break  # none of the rest can be longer
        run = longest_run(np.flatnonzero(on[number]))
        length = float(np.linalg.norm(points[run[-1]] - points[run[0]])) if len(run) else 0.0
        if len(run) >= MIN_BEAM_COUNT and length <= longest and (best is None or len(run) > len(best)):
            best = run
    return best


def longest_run(beams: Array) -> Array:
    """Sorted beam numbers → their longest run without a gap of more than MAX_GAP_BEAMS."""
    if not len(beams):
        return beams
    breaks = np.flatnonzero(beams[1:] - beams[:-1] > MAX_GAP_BEAMS + 1) + 1
    ends = [0, *breaks.tolist(), len(beams)]
    first, last = max(itertools.pairwise(ends), key=lambda run: run[1] - run[0])
    return beams[first:last]
