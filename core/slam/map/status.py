"""The status of the scan layer: submaps, closures, and whether the robot knows where it is."""

from typing import Literal

from core.geometry import Pose
from core.message import Array, message

ClosureState = Literal["accepted", "undone", "doubtful"]
LostPhase = Literal["searching", "confirming", "asking"]


@message
class SubmapView:
    """A room as the map has it."""

    id: int
    pose: Pose  # world_from_submap
    extent: Array  # (2, 2) [m], submap frame: lowest and highest x, y of what was drawn
    active: bool  # the robot is in it


@message
class ClosureStatus:
    """A place that was recognised: the robot at `position_from` sees what it saw of `submap_to` before."""

    id: int
    stamp: float  # [s] when it was found
    submap_from: int
    submap_to: int
    position_from: Array  # (2,) [m], world
    position_to: Array  # (2,) [m], world: where the older view of the same place was taken
    score: float  # 0..1 of the match
    state: ClosureState = "accepted"  # "doubtful": the map does not bend to it, it contradicts the others
    words: str = ""  # a sentence for the operator


@message
class LostStatus:
    """The robot does not know where it is: it stands, and nothing is written to the map."""

    phase: LostPhase
    words: str  # a sentence: what is being done, or what the operator should do
    since: float  # [s], robot clock
    candidates: Array  # (K, 3) x, y [m], heading [rad], world; best first
    asked: bool = False  # an operator began it: a map was loaded, or another place clicked


@message
class MapStatus:
    """The health of the scan layer."""

    submaps: tuple[SubmapView, ...] = ()
    closures: tuple[ClosureStatus, ...] = ()
    lost: LostStatus | None = None
    match_score: float | None = None  # 0..1 of the newest scan on the map; None: there was none to match
    slipping: bool = False  # the scans contradict the wheels
    graph_revision: int = 0  # rises whenever submaps were moved
