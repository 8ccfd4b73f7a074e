"""Where the simulated robot lives: floor plans, what stands in them, and rays through them."""

from __future__ import annotations

from core.errors import BadInput
from core.world.board import HeldBoard
from core.world.casting import Hits, Surfaces, cast, distances
from core.world.floor import FLOOR
from core.world.lab import LAB
from core.world.outline import Rect, outline
from core.world.plan import Dressing, World, Zone
from core.world.things import COLOURS, GESTURES, SIZES, SWING, Solid, Thing, furniture

WORLDS = {"lab": LAB, "floor": FLOOR}


def world_named(name: str) -> World:
    """The world of that name; BadInput for any other."""
    if name not in WORLDS:
        raise BadInput(f"There is no such simulated world; choose one of {', '.join(WORLDS)}, as in sim:lab.")
    return WORLDS[name]


__all__ = [
    "COLOURS",
    "FLOOR",
    "GESTURES",
    "LAB",
    "SIZES",
    "SWING",
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
