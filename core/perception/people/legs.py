"""Scan → free-standing things as wide as a pair of legs. Only a picture shows whether they are a person."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from core.message import Array, message

LEG_RADIUS_M = 0.055  # radius of a leg: its front is that much nearer than its middle
BREAK_M, BREAK_SHARE = 0.10, 0.03  # [m], and of the range: a wider gap between neighbours divides two things
MAX_LEGS_WIDTH_M = 0.50  # across of what may be legs
MIN_LEG_WIDTH_M = 0.065  # across of a leg: a table's or a chair's, where it is seen whole, is thinner
MAX_STANCE_M = 0.46  # between the two legs of a walking person
MIN_POINTS = 2  # points
RADIAL_SD, ACROSS_SD = 0.05, 0.05  # [m] of the place of a person whose legs were measured
SINGLE_SD_M = 0.07  # the same where only one leg was seen
HIDDEN_LEG_M = 0.08  # that a person's middle is behind the one leg that is seen: it hides the other
ONE_LEG_WIDTH_M = 0.20  # across: what is wider is both
MIN_WIDTH_M = 0.06  # from the first to the last point on a leg of which nothing but the laser tells
MIN_GAP_M = 0.05  # between two such legs before which nothing else is seen
MAX_RANGE_M = 6.0


@message
class LegCluster:
    """Something that stands there like legs."""

    place: Array  # (2,) [m] robot frame
    covariance: Array  # (2, 2) [m²]
    legs: int  # that could be separated: 1 or 2
    distinct: bool = True  # as wide as legs that show one by one: neither a chair's nor a bin
    pieces: frozenset[int] = frozenset()  # of the scan: what shares one with another is the other seen otherwise

    @property
    def distance(self) -> float:
        """[m] from the robot."""
        return math.hypot(*self.place.tolist())

    @property
    def bearing(self) -> float:
        """[rad] robot frame."""
        return math.atan2(float(self.place[1]), float(self.place[0]))


def find_standers(points: Array, *, every: bool = False) -> tuple[LegCluster, ...]:
    """Scan points (M, 2) [m] in the robot frame → what may be legs, nearest first: pairs, and single ones.

    `every`: also those legs alone that may be one of a pair, since the other may be someone else's.
    """
    if len(points) < MIN_POINTS:
        return ()
    pieces = _free_pieces(points)
    found: list[LegCluster] = []
    paired: set[int] = set()
    for first in range(len(pieces)):
        for second in range(first + 1, min(first + 4, len(pieces))):
            one, other = pieces[first], pieces[second]
            if max(_width(one), _width(other)) < 0.24 and np.hypot(*(_middle(one) - _middle(other))) < MAX_STANCE_M:
                pair = stander_at((_middle(one) + _middle(other)) / 2, 2, first, second)
                found.append(replace(pair, distinct=_are_legs(one, other)))
                paired |= {first, second}
    found += [_alone(piece, number) for number, piece in enumerate(pieces) if every or number not in paired]
    return tuple(sorted(found, key=lambda stander: stander.distance))


def nearest_to(standers: Sequence[LegCluster], place: Array, covariance: Array, gate: float) -> LegCluster | None:
    """The one that fits a place (2,) [m] with this covariance best, within `gate` (chi-square); None: none does."""
    best, least = None, gate
    for stander in standers:
        off = stander.place - place
        distance = float(off @ np.linalg.solve(covariance + stander.covariance, off))
        if distance < least:
            best, least = stander, distance
    return best


def _free_pieces(points: Array) -> list[Array]:
    """Points → pieces before whose ends and behind which there is room, in the order of their bearings."""
    bearings = np.arctan2(points[:, 1], points[:, 0])
    order = np.argsort(bearings)
    points, bearings = points[order], bearings[order]
    ranges = np.hypot(points[:, 0], points[:, 1])
    gaps = np.hypot(*np.diff(points, axis=0).T)
    cuts = np.flatnonzero(gaps > BREAK_M + BREAK_SHARE * np.minimum(ranges[1:], ranges[:-1])) + 1
    begins, ends = [0, *cuts.tolist()], [*cuts.tolist(), len(points)]
    pieces: list[Array] = []
    for begin, end in zip(begins, ends, strict=True):
        piece, far = points[begin:end], float(_median(ranges[begin:end]))
        if len(piece) < MIN_POINTS or far > MAX_RANGE_M or _width(piece) > MAX_LEGS_WIDTH_M:
            continue
        before = ranges[begin - 1] if begin > 0 else math.inf
        behind = ranges[end] if end < len(points) else math.inf
        free = ranges[begin] < before, ranges[end - 1] < behind  # whether that side is not hidden itself
        inside = begin > 0 and end < len(points)
        if all(free) and inside and far * (bearings[end] - bearings[begin - 1]) < MIN_LEG_WIDTH_M:
            continue  # from the ray that passes it at one side to the one at the other
        if any(free):
            pieces.append(piece)
    return pieces


def _alone(piece: Array, number: int) -> LegCluster:
    middle = _middle(piece)
    gaps = np.flatnonzero(np.hypot(*np.diff(piece, axis=0).T) > MIN_GAP_M) + 1
    parts = np.split(piece, gaps.tolist())
    distinct = len(parts) <= 2 and _are_legs(*parts)
    if _width(piece) > ONE_LEG_WIDTH_M:
        return replace(stander_at(middle, 2, number), distinct=distinct)
    alone = stander_at(middle * (1 + HIDDEN_LEG_M / max(float(np.hypot(*middle)), 1e-6)), 1, number)
    return replace(alone, distinct=distinct)


def _are_legs(*pieces: Array) -> bool:
    """Return whether none is wider than a leg, and one is not thinner; it may hide a part of the other."""
    return MIN_WIDTH_M <= max(map(_width, pieces)) <= ONE_LEG_WIDTH_M


def _width(piece: Array) -> float:
    return float(np.hypot(*(piece[-1] - piece[0])))


def _middle(piece: Array) -> Array:
    """Centre of a round object from points on its front."""
    front = _median(piece)
    return front * (1 + 0.8 * LEG_RADIUS_M / max(float(np.hypot(*front)), 1e-6))


def _median(values: Array) -> Array:
    """Median along the first axis; numpy's own takes ten times as long for a few values."""
    ordered, half = np.sort(values, axis=0), len(values) // 2
    return ordered[half] if len(values) % 2 else (ordered[half - 1] + ordered[half]) / 2


def stander_at(place: Array, legs: int = 2, *pieces: int) -> LegCluster:
    """Legs at a place (2,) [m] in the robot's frame; `pieces` of the scan."""
    away = place / max(float(np.hypot(*place)), 1e-6)
    across = np.array([-away[1], away[0]])
    sd = ACROSS_SD if legs == 2 else SINGLE_SD_M
    radial = RADIAL_SD if legs == 2 else SINGLE_SD_M
    covariance = radial**2 * np.outer(away, away) + sd**2 * np.outer(across, across)
    return LegCluster(place=place, covariance=covariance, legs=legs, pieces=frozenset(pieces))
