"""The simulated robot's world: floor plans, the things in them, and rays through them."""

from core.errors import BadInput
from core.simulation.world.floor import FLOOR
from core.simulation.world.held_board import HeldBoard
from core.simulation.world.lab import LAB
from core.simulation.world.objects import (
    COLOURS,
    FOOT_REACH_M,
    FOOT_SWING_M,
    GESTURES,
    SIZES,
    Solid,
    Thing,
    furniture,
)
from core.simulation.world.plan import Dressing, Rect, World, Zone, outline
from core.simulation.world.ray_casting import Hits, Surfaces, cast, distances
from core.simulation.world.weak import BARE, CORRIDOR, GLASS

WORLDS = {"lab": LAB, "floor": FLOOR, "corridor": CORRIDOR, "bare": BARE, "glass": GLASS}


def world_named(name: str) -> World:
    """The world of that name; BadInput for any other."""
    if name not in WORLDS:
        raise BadInput(f"There is no such simulated world; choose one of {', '.join(WORLDS)}, as in sim:lab.")
    return WORLDS[name]


__all__ = [
    "COLOURS",
    "FLOOR",
    "FOOT_REACH_M",
    "FOOT_SWING_M",
    "GESTURES",
    "LAB",
    "SIZES",
    "WORLDS",
    "Dressing",
    "HeldBoard",
    "Hits",
    "Rect",
    "Solid",
    "Surfaces",
    "Thing",
    "World",
    "Zone",
    "cast",
    "distances",
    "furniture",
    "outline",
    "world_named",
]
