"""Laying a scan on a field: near where it is expected, or far around."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

import cv2
import numpy as np

from core.geometry import Pose, rotation, wrap
from core.message import Array
from core.setting import Meta, Section
from core.slam.map.keyframe import thinned
from core.slam.scan_matching.likelihood_field import CELL_M, LikelihoodField, Match
from core.slam.scan_matching.match_covariance import match_information, match_spread

STRIDE_CELLS = 4  # cells of one step of the wide search
SEARCH_TURN_RAD = math.radians(2.0)  # of one step of the wide search
COARSE_POINTS = 100  # points that the searches look at
APART_M, APART_RAD = 0.5, math.radians(8)  # matches that differ by more are different places
MAX_REFINED_PEAKS = 6  # peaks of the wide search that are refined
SLIDE_STEP_M, SLIDE_REACH_M = 0.1, 1.0  # how finely and how far around a match it is asked whether it fits there too
ANYWHERE_SHARE = 0.99  # of the spread of all places that are asked, from which the match may be at any of them
EQUAL_SCORE = 0.04  # of score that a place may fit worse and still be possible
AT_ONCE = 4  # headings of the wide search in one piece of work


@dataclass(frozen=True)
class ScanMatchingSettings(Section):
    """Settings of scan matching against earlier scans, and of its covariance.

    Watch:
        corrects: the map after a loop: doubled walls
        reach: walls that double where the wheels slip (then raise it)
        angle: walls that double in turns (then raise it)
        score: walls that double where people walk (then raise it)
    """

    reach_per_way: float = 0.4  # [m/m] further distance per way driven
    reach_per_turn: float = 0.2  # [m/rad] further distance per turn
    widest: float = 0.75  # [m] distance that is searched, at most
    angle_per_way: float = math.radians(6)  # [rad/m] further angle per way driven
    angle_per_turn: float = 0.4  # [rad/rad] further angle per turn
    widest_angle: float = math.radians(30)  # [rad] angle that is searched, at most
    point_sd: float = 0.1  # [m] sd of a point across its wall, correlation included
    wall: float = 0.5  # [m] distance between neighbouring points on one wall, at most
    place_sd: float = 0.02  # [m] least sd of a matched place
    heading_sd: float = math.radians(0.4)  # [rad] least sd of a matched heading
    corrects: Annotated[
        bool, Meta(meaning="scans correct the wheels' move and close loops; false: landmarks alone, as in the paper")
    ] = True
    reach: Annotated[float, Meta("m", 0.02, 1, "distance around the expected place searched at least")] = 0.1
    angle: Annotated[float, Meta("rad", 0.01, 0.8, "angle around the expected heading, at least")] = math.radians(3)
    score: Annotated[float, Meta("", 0.05, 0.95, "score of a match, at least")] = 0.4


def window(move: Pose, settings: ScanMatchingSettings) -> tuple[float, float]:
    """A move by the wheels → how far around its end to look: [m] and [rad] to either side."""
    way, turn = math.hypot(move.x, move.y), abs(move.heading)
    reach = settings.reach + settings.reach_per_way * way + settings.reach_per_turn * turn
    angle = settings.angle + settings.angle_per_way * way + settings.angle_per_turn * turn
    return min(reach, settings.widest), min(angle, settings.widest_angle)


def match_scan(field: LikelihoodField, points: Array, guess: Pose, reach: float, angle: float) -> Match:
    """The best pose of a scan's points (M, 2) [m] within ±`reach` [m] and ±`angle` [rad] of a guess."""
    few = thinned(points, COARSE_POINTS)
    coarse = field.search(few, guess, reach, angle, 2 * CELL_M, math.radians(1))
    fine = field.search(few, coarse, CELL_M, math.radians(0.5), CELL_M, math.radians(0.25))
    return field.refine(points, fine)


def spread(field: LikelihoodField, points: Array, pose: Pose, settings: ScanMatchingSettings) -> Array:
    """Covariance (3, 3) of a matched pose, in the frame of the robot there."""
    return match_spread(
        points,
        point_sd=settings.point_sd,
        wall=settings.wall,
        unknown=np.array([settings.widest, settings.widest, settings.widest_angle]),
        floor=np.array([settings.place_sd, settings.place_sd, settings.heading_sd]),
        believed=field.values_at(points, pose),
    )


def information(
    field: LikelihoodField, points: Array, match: Match, reach: float, settings: ScanMatchingSettings
) -> Array:
    """Information (3, 3) on a matched pose, in the frame of the robot there; singular where walls leave it open.

    Less than the walls give where the points (M, 2) fit nearly as well elsewhere within `reach` [m], and never more
    than that of the settings' least sd.
    """
    found = match_information(
        points, point_sd=settings.point_sd, wall=settings.wall, believed=field.values_at(points, match.pose)
    )
    doubt = np.diag(np.square([settings.place_sd, settings.place_sd, settings.heading_sd]))
    back = rotation(-match.pose.heading)
    doubt[:2, :2] += back @ ambiguity(field, points, match, reach) @ back.T
    return blurred(found, doubt)


def blurred(information: Array, doubt: Array) -> Array:
    """Information (k, k), which may be singular, of something to whose errors a covariance (k, k) is added."""
    return np.linalg.solve(np.eye(len(doubt)) + information @ doubt, information)


def ambiguity(field: LikelihoodField, points: Array, match: Match, reach: float = SLIDE_REACH_M) -> Array:
    """Covariance (2, 2) [m²] of where else within `reach` [m] the points (M, 2) fit nearly as well, field's axes.

    Every place around weighs the less the worse it fits (Olson, ICRA 2009). What looking no farther than `reach` adds
    is taken out again: where all places around fit alike, along a bare corridor, the match says nothing.
    """
    few = thinned(points, COARSE_POINTS)
    count = max(2, round(reach / SLIDE_STEP_M))
    steps = SLIDE_STEP_M * np.arange(-count, count + 1)
    shifts = np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)
    placed = match.pose.apply(few)
    here = field.cells_at(placed[None]).mean()
    scores = field.cells_at(placed[None] + shifts[:, None]).mean(axis=1)
    weights = np.exp(np.minimum((scores - here) / EQUAL_SCORE, 0.0))
    found, directions = np.linalg.eigh((shifts * weights[:, None]).T @ shifts / (weights.sum() + 1.0))
    share = np.minimum(found / np.mean(steps**2), ANYWHERE_SHARE)
    return directions * (found / (1.0 - share)) @ directions.T


def search_wide(
    field: LikelihoodField, points: Array, guess: Pose, reach: float, angle: float
) -> Iterator[list[Match]]:
    """The best places, different ones, within ±`reach` [m] and ±`angle` [rad] of a guess, best first.

    A coarse lattice over the field widened to the lattice's step, so that no peak falls between; then each of the
    highest peaks is refined. Each value is a piece of work and holds the places found by then; the last holds all.
    """
    steps, turns = max(1, round(reach / (STRIDE_CELLS * CELL_M))), max(1, round(angle / SEARCH_TURN_RAD))
    margin = STRIDE_CELLS * steps + STRIDE_CELLS
    wide = cv2.dilate(field.values.astype(np.float32), np.ones((STRIDE_CELLS + 1, STRIDE_CELLS + 1), np.uint8))
    wide = np.pad(wide, 2 * margin)
    few = thinned(points, COARSE_POINTS)
    shift = np.arange(-steps, steps + 1) * STRIDE_CELLS
    offsets = (shift[:, None] * wide.shape[1] + shift[None, :]).ravel()
    headings = guess.heading + SEARCH_TURN_RAD * np.arange(-turns, turns + 1)
    scores = np.empty((len(headings), len(shift), len(shift)))
    yield []
    for number, heading in enumerate(headings):
        place = few @ rotation(float(heading)).T + (guess.x, guess.y)
        cells = np.floor((place - field.origin) / CELL_M).astype(int) + 2 * margin
        cells = np.clip(cells, margin, np.array(wide.shape[::-1]) - margin - 1)
        flat = cells[:, 1] * wide.shape[1] + cells[:, 0]
        scores[number] = wide.ravel()[flat[None, :] + offsets[:, None]].mean(axis=1).reshape(len(shift), -1)
        if number % AT_ONCE == AT_ONCE - 1:
            yield []
    found: list[Match] = []
    for turn, row, column in _peaks(scores):
        x, y = guess.x + CELL_M * shift[column], guess.y + CELL_M * shift[row]
        coarse = Pose(float(x), float(y), wrap(float(headings[turn])))
        match = field.refine(
            points, field.search(few, coarse, 3 * CELL_M, SEARCH_TURN_RAD, CELL_M, SEARCH_TURN_RAD / 2)
        )
        if not any(same_place(match.pose, other.pose) and match.score <= other.score for other in found):
            found = [other for other in found if not same_place(match.pose, other.pose)] + [match]
        yield sorted(found, key=lambda match: -match.score)


def same_place(one: Pose, other: Pose) -> bool:
    """Return whether two matches are the same place."""
    return one.distance_to(other.x, other.y) < APART_M and abs(wrap(one.heading - other.heading)) < APART_RAD


def _peaks(scores: Array) -> list[tuple[int, int, int]]:
    """The highest cells of scores (headings, rows, columns), none next to a higher one."""
    left, found = scores.copy(), list[tuple[int, int, int]]()
    while len(found) < MAX_REFINED_PEAKS:
        turn, row, column = (int(index) for index in np.unravel_index(int(left.argmax()), left.shape))
        if left[turn, row, column] <= 0:
            break
        found.append((turn, row, column))
        left[max(0, turn - 3) : turn + 4, max(0, row - 2) : row + 3, max(0, column - 2) : column + 3] = 0.0
    return found
