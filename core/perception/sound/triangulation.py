"""Triangulate a voice: bearings from several places of the robot, crossed (RANSAC, then least squares)."""

import itertools
import math
from collections.abc import Sequence

import numpy as np

from core.geometry import Ray, wrap, wrap_all
from core.message import Array, message

MAX_ROUNDS = 20


# Criteria of a trustworthy crossing.
INLIER_SDS = 2.5  # standard deviations
MIN_PARALLAX_RAD = 0.14  # [rad] least angle between two bearings that are crossed (8°)
MAX_DISTANCE_M = 15.0  # [m] from where it was heard
MIN_DISTANCE_M = 0.2  # [m]
MAX_PLACE_SD_M = 1.5  # [m] a less certain place is not reported
MAX_PAIR_COUNT = 2000


@message
class VoicePlace:
    """The place where the bearings cross, or the reason why there is none."""

    position: Array | None  # (2,) [m] in the world
    covariance: Array | None  # (2, 2) [m²]
    used: tuple[int, ...] = ()  # which bearings agree
    reason: str = ""  # a sentence, when there is no position


def cross(bearings: Sequence[Ray]) -> VoicePlace:
    """Bearings of one voice from several poses → its place, or the reason why there is none.

    The distance is never guessed: from one place only, or along one line, there is no answer.
    """
    usable = [one for one in bearings if math.isfinite(one.x + one.y + one.azimuth) and 0 < one.sd < math.pi / 4]
    if len(usable) < 2:
        return _nowhere("I heard the voice from one place only; let me hear it again from somewhere else.")
    table = np.array([(one.x, one.y, one.azimuth, one.sd) for one in usable])
    best: Array | None = None
    score = 0.0
    pairs = list(itertools.combinations(range(len(usable)), 2))
    for first, second in pairs[:: max(1, len(pairs) // MAX_PAIR_COUNT)]:
        start = crossing(table[first], table[second])
        if start is None:
            continue
        gaps = np.abs(_gaps(table, start)) / table[:, 3]
        gain = float(np.sum(np.maximum(0.0, INLIER_SDS**2 - gaps**2)))
        if gain > score:
            score, best = gain, start
    if best is None:
        return _nowhere("The bearings are nearly parallel; let me hear the voice from further aside.")
    return _refined(table, [bearings.index(one) for one in usable], best)


def _nowhere(reason: str) -> VoicePlace:
    return VoicePlace(position=None, covariance=None, reason=reason)


def crossing(one: Array, other: Array) -> Array | None:
    """Cross two rays (x, y, azimuth, …) → the place (2,) [m] ahead of both; None: nowhere, or nearly parallel."""
    if abs(math.sin(wrap(float(one[2] - other[2])))) < math.sin(MIN_PARALLAX_RAD):
        return None
    ahead = np.array([[math.cos(ray[2]), math.sin(ray[2])] for ray in (one, other)])
    along = np.linalg.solve(np.column_stack((ahead[0], -ahead[1])), other[:2] - one[:2])
    if np.any(along < MIN_DISTANCE_M) or np.any(along > MAX_DISTANCE_M):
        return None
    return one[:2] + along[0] * ahead[0]


def _gaps(table: Array, position: Array) -> Array:
    """Angle (N,) [rad] by which each bearing (N, 4) misses the position (2,)."""
    apart = position - table[:, :2]
    return wrap_all(np.arctan2(apart[:, 1], apart[:, 0]) - table[:, 2])


def _slopes(table: Array, position: Array) -> Array:
    """d bearing / d position, (N, 2) [rad/m]."""
    apart = position - table[:, :2]
    return np.column_stack((-apart[:, 1], apart[:, 0])) / np.maximum(np.sum(apart**2, axis=1), 1e-6)[:, None]


def _refined(table: Array, names: list[int], position: Array) -> VoicePlace:
    """Least squares over the bearings that agree."""
    covariance = np.full((2, 2), np.inf)
    chosen = np.zeros(len(table), bool)
    for _ in range(MAX_ROUNDS):
        chosen = np.abs(_gaps(table, position)) < INLIER_SDS * table[:, 3]
        rows = table[chosen]
        if len(rows) < 2:
            return _nowhere("The bearings do not agree on a place; say it again, please.")
        slopes = _slopes(rows, position) / rows[:, 3:]
        normal = slopes.T @ slopes
        if np.linalg.cond(normal) > 1e8:
            return _nowhere("The bearings are nearly parallel; let me hear the voice from further aside.")
        covariance = np.linalg.inv(normal)
        step = -covariance @ slopes.T @ (_gaps(rows, position) / rows[:, 3])
        position = position + step * min(1.0, 1.0 / max(float(np.linalg.norm(step)), 1e-12))
        if np.linalg.norm(step) < 1e-6:
            break
    misfit = np.sum((_gaps(table[chosen], position) / table[chosen, 3]) ** 2) / max(int(chosen.sum()) - 2, 1)
    covariance = covariance * max(1.0, float(misfit))
    if math.sqrt(float(np.linalg.eigvalsh(covariance)[-1])) > MAX_PLACE_SD_M:
        return _nowhere("The place of the voice is too uncertain; let me hear it from further aside.")
    return VoicePlace(
        position=position,
        covariance=covariance,
        used=tuple(name for name, use in zip(names, chosen, strict=True) if use),
    )
