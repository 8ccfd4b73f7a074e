"""Messages of the map: submaps, closures, being lost, and which saved map it is."""

import math

import msgspec

from console.messages import filled
from core.geometry import Pose, wrap
from core.message import Array
from core.slam.consistency import nees
from core.slam.estimate import Estimate
from core.slam.map.status import ClosureState, ClosureStatus, LostPhase, LostStatus, MapStatus, SubmapView

Struct = msgspec.Struct


class PlaceState(Struct):
    """A point of the world frame."""

    x_m: float
    y_m: float


class CandidateState(Struct):
    """A pose of the world frame where the robot may be."""

    x_m: float
    y_m: float
    heading_rad: float


class SubmapRow(Struct):
    """A room as the map has it."""

    id: int
    x_m: float  # world_from_submap
    y_m: float
    heading_rad: float
    extent_m: tuple[float, float, float, float]  # submap frame: lowest x, lowest y, highest x, highest y
    active: bool


class ClosureRow(Struct):
    """A place that was recognised."""

    id: int
    stamp_s: float
    submap_from: int
    submap_to: int
    position_from: PlaceState
    position_to: PlaceState
    score: float
    state: ClosureState
    words: str


class LocalizationState(Struct):
    """The robot does not know where it is."""

    phase: LostPhase
    words: str
    since_s: float
    candidates: list[CandidateState]


class SubmapsState(Struct):
    """How the scan layer fares."""

    submaps: list[SubmapRow]
    closures: list[ClosureRow]  # the newest, oldest first
    closures_count: int  # of all there are
    lost: LocalizationState | None
    match_score: float | None
    slipping: bool
    graph_revision: int


class MapState(Struct):
    """Which saved map the robot goes on in."""

    name: str | None  # None: none, the map is only in memory
    revision: int  # of the list of saved maps
    unsaved: bool  # the robot has moved since this map was begun, saved or loaded
    marks: int  # rises whenever places have changed, or have moved with the map


MAX_CLOSURES = 20  # closures that are sent with every state; all of them stand under /api/slam/closures


def floor(health: MapStatus) -> SubmapsState:
    return SubmapsState(
        submaps=[submap(room) for room in health.submaps],
        closures=[closure(status) for status in health.closures[-MAX_CLOSURES:]],
        closures_count=len(health.closures),
        lost=None if health.lost is None else lost(health.lost),
        match_score=None if health.match_score is None else round(health.match_score, 3),
        slipping=health.slipping,
        graph_revision=health.graph_revision,
    )


def submap(room: SubmapView) -> SubmapRow:
    (low_x, low_y), (high_x, high_y) = room.extent.round(2).tolist()
    at = room.pose
    place = (round(at.x, 3), round(at.y, 3), round(at.heading, 4))
    return SubmapRow(room.id, *place, (low_x, low_y, high_x, high_y), room.active)


def closure(status: ClosureStatus) -> ClosureRow:
    ends = {"position_from": spot(status.position_from), "position_to": spot(status.position_to)}
    return filled(ClosureRow, status, 3, **ends)


def lost(status: LostStatus) -> LocalizationState:
    candidates = [CandidateState(x, y, heading) for x, y, heading in status.candidates.round(3).tolist()]
    return LocalizationState(status.phase, status.words, round(status.since, 2), candidates)


def spot(position: Array) -> PlaceState:
    """A point, to a millimetre."""
    x, y = position.round(3).tolist()
    return PlaceState(x, y)


def accuracy(estimate: Estimate, truth: Pose | None) -> tuple[float | None, float | None, float | None]:
    """How far off the estimate is [m], [rad], and the square of that in its own uncertainty; None without a truth."""
    if truth is None:
        return None, None, None
    pose = estimate.pose
    squared = nees(estimate, truth)
    turned = abs(wrap(pose.heading - truth.heading))
    away = pose.distance_to(truth.x, truth.y)
    return round(away, 4), round(turned, 5), round(squared, 2) if math.isfinite(squared) else None
