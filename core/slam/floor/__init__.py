"""The scan layer: rooms joined into a floor.

One room is one submap, in which the paper's filter works as ever; a graph of poses holds the submaps together, and
places that are recognised pull it straight. Everything heavy is done in small pieces, a few with every frame.

The doors of the pilot (from any thread, with effect from the next frame on):
`undo_closure(id)`, `redo_closure(id)`, `place_at(x, y, heading | None)`, `keep_map() -> SavedMap`,
`enter_map(saved)`.
"""

from core.slam.floor.health import Closure, ClosureState, FloorHealth, Lost, LostPhase, SubmapView

__all__ = ["Closure", "ClosureState", "FloorHealth", "Lost", "LostPhase", "SubmapView"]
