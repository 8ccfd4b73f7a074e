"""What goes over the socket of the floor: rooms, closures, being lost, and which saved map it is."""

from __future__ import annotations

import msgspec

from core.slam.floor import ClosureState, LostPhase

Struct = msgspec.Struct


class Spot(Struct):
    """A point of the world frame."""

    x_m: float
    y_m: float


class Candidate(Struct):
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
    position_from: Spot
    position_to: Spot
    score: float
    state: ClosureState
    words: str


class LostState(Struct):
    """The robot does not know where it is."""

    phase: LostPhase
    words: str
    since_s: float
    candidates: list[Candidate]


class FloorState(Struct):
    """How the scan layer fares."""

    submaps: list[SubmapRow]
    closures: list[ClosureRow]  # the newest, oldest first
    closures_count: int  # of all there are
    lost: LostState | None
    match_score: float | None
    slipping: bool
    graph_revision: int


class MapState(Struct):
    """Which saved map the robot goes on in."""

    name: str | None  # None: none, the map is only in memory
    revision: int  # of the list of saved maps
