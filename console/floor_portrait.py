"""The floor's part of the message that every viewer gets: rooms, closures, being lost, and how true it all is."""

from __future__ import annotations

import math

from console import wire
from core.geometry import Pose, wrap
from core.message import Array
from core.slam.consistency import nees
from core.slam.estimate import Estimate
from core.slam.floor import Closure, FloorHealth, Lost, SubmapView

NEWEST = 20  # closures that are told with every state; all of them stand under /api/slam/closures


def floor(health: FloorHealth) -> wire.FloorState:
    """How the scan layer fares."""
    return wire.FloorState(
        submaps=[submap(room) for room in health.submaps],
        closures=[closure(told) for told in health.closures[-NEWEST:]],
        closures_count=len(health.closures),
        lost=None if health.lost is None else lost(health.lost),
        match_score=None if health.match_score is None else round(health.match_score, 3),
        slipping=health.slipping,
        graph_revision=health.graph_revision,
    )


def submap(room: SubmapView) -> wire.SubmapRow:
    """A room."""
    (low_x, low_y), (high_x, high_y) = room.extent.round(2).tolist()
    at = room.pose
    place = (round(at.x, 3), round(at.y, 3), round(at.heading, 4))
    return wire.SubmapRow(room.id, *place, (low_x, low_y, high_x, high_y), room.active)


def closure(told: Closure) -> wire.ClosureRow:
    """A place that was recognised."""
    return wire.ClosureRow(
        id=told.id,
        stamp_s=round(told.stamp, 2),
        submap_from=told.submap_from,
        submap_to=told.submap_to,
        position_from=spot(told.position_from),
        position_to=spot(told.position_to),
        score=round(told.score, 3),
        state=told.state,
        words=told.words,
    )


def lost(told: Lost) -> wire.LostState:
    """The robot does not know where it is."""
    candidates = [wire.Candidate(x, y, heading) for x, y, heading in told.candidates.round(3).tolist()]
    return wire.LostState(told.phase, told.words, round(told.since, 2), candidates)


def spot(position: Array) -> wire.Spot:
    """A point, to a millimetre."""
    x, y = position.round(3).tolist()
    return wire.Spot(x, y)


def accuracy(estimate: Estimate, truth: Pose | None) -> tuple[float | None, float | None, float | None]:
    """How far off the estimate is [m], [rad], and the square of that in its own uncertainty; None without a truth."""
    if truth is None:
        return None, None, None
    pose = estimate.pose
    squared = nees(estimate, truth)
    turned = abs(wrap(pose.heading - truth.heading))
    away = pose.distance_to(truth.x, truth.y)
    return round(away, 4), round(turned, 5), round(squared, 2) if math.isfinite(squared) else None
