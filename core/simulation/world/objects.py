"""Things in a room: furniture, boxes, people."""

import math
from collections.abc import Callable
from functools import cached_property
from typing import Literal

import numpy as np

from core.geometry import Pose
from core.message import Array, message

What = Literal["cabinet", "shelf", "table", "stool", "bin", "pillar", "box", "person"]


@message
class Solid:
    """An upright prism, or with a radius an upright cylinder."""

    corners: Array  # (K, 2) [m], world, counter-clockwise; none for a cylinder
    centre: Array  # (2,) [m], world
    radius: float = 0.0  # [m]
    bottom: float = 0.0  # [m]
    top: float  # [m]
    look: str = ""  # how it is painted; "" = drawn otherwise

    @cached_property
    def faces(self) -> Array:
        """(K, 4): x0 y0 x1 y1 [m], the outside on the left."""
        return np.hstack((np.roll(self.corners, -1, axis=0), self.corners))

    def stands_at(self, height: float) -> bool:
        """Return whether it is in the way at `height` [m]."""
        return self.bottom <= height <= self.top


@message
class Thing:
    """Something that stands on the floor."""

    id: str
    what: What
    pose: Pose  # world, of its centre
    length: float  # [m] along its heading; the diameter of something round
    depth: float  # [m] across
    height: float  # [m]
    look: str = ""  # how it is painted; a person's clothes: "red/blue", shirt and trousers
    fixed: bool = False  # belongs to the room; cannot be removed
    gesture: str = ""  # what a person does with the arms; one of GESTURES
    stride: float = 0.0  # [rad] where in a step a person who walks is; 0: stands

    @cached_property
    def solids(self) -> tuple[Solid, ...]:
        """The solids that it is made of."""
        return BUILDERS[self.what](self)

    @property
    def reach(self) -> float:
        """Radius [m] of the circle around its centre that holds all of it."""
        return self.length / 2 if self.what in ROUND else math.hypot(self.length, self.depth) / 2


def _prism(thing: Thing, bottom: float, top: float, look: str) -> Solid:
    half = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]]) * (thing.length / 2, thing.depth / 2)
    centre = np.array([thing.pose.x, thing.pose.y])
    return Solid(corners=thing.pose.apply(half), centre=centre, bottom=bottom, top=top, look=look)


def _post(thing: Thing, x: float, y: float, radius: float, bottom: float, top: float, look: str) -> Solid:
    """A cylinder at (x, y) [m] in the thing's own frame."""
    centre = thing.pose.apply(np.array([[x, y]]))[0]
    return Solid(corners=np.empty((0, 2)), centre=centre, radius=radius, bottom=bottom, top=top, look=look)


def _box(thing: Thing) -> tuple[Solid, ...]:
    return (_prism(thing, 0.0, thing.height, thing.look or thing.what),)


def _round(thing: Thing) -> tuple[Solid, ...]:
    return (_post(thing, 0.0, 0.0, thing.length / 2, 0.0, thing.height, thing.look or thing.what),)


def _table(thing: Thing) -> tuple[Solid, ...]:
    x, y = thing.length / 2 - 0.06, thing.depth / 2 - 0.06
    under = thing.height - 0.035
    legs = (
        _post(thing, sx * x, sy * y, 0.025, 0.0, under, "steel") for sx, sy in ((1, 1), (-1, 1), (-1, -1), (1, -1))
    )
    return (*legs, _prism(thing, under, thing.height, thing.look or "wood"))


def _stool(thing: Thing) -> tuple[Solid, ...]:
    seat = thing.height - 0.05
    return (
        _post(thing, 0.0, 0.0, 0.03, 0.0, seat, "steel"),
        _post(thing, 0.0, 0.0, thing.length / 2, seat, thing.height, thing.look or "seat"),
    )


def _person(thing: Thing) -> tuple[Solid, ...]:
    """Two legs, which is what a laser at ankle height sees; the figure itself is drawn by the camera."""
    swing = FOOT_SWING_M * math.sin(thing.stride)
    return tuple(
        _post(thing, side * swing, side * FOOT_ASIDE_M, FOOT_RADIUS_M, 0.0, thing.height / 2, "") for side in (1, -1)
    )


FOOT_SWING_M, FOOT_ASIDE_M, FOOT_RADIUS_M = 0.15, 0.10, 0.055  # the first: before and behind the body, of who walks
FOOT_REACH_M = math.hypot(FOOT_SWING_M, FOOT_ASIDE_M) + FOOT_RADIUS_M  # from a walker's middle, in any direction
COLOURS = ("red", "blue", "green", "white", "grey", "black", "yellow", "brown")
"""Of shirts and trousers."""
GESTURES = ("", "wave", "up", "wide", "point", "hips", "crossed")
"""Positions of the arms: hang, one raised, both raised, stretched out, one to the front, on the hips, crossed."""


BUILDERS: dict[What, Callable[[Thing], tuple[Solid, ...]]] = {
    "cabinet": _box,
    "shelf": _box,
    "table": _table,
    "stool": _stool,
    "bin": _round,
    "pillar": _round,
    "box": _box,
    "person": _person,
}

ROUND: frozenset[What] = frozenset(("stool", "bin", "pillar", "person"))

SIZES: dict[What, tuple[float, float, float]] = {"box": (0.35, 0.35, 0.35), "person": (0.40, 0.40, 1.75)}
"""Things that may be placed, and their size when nothing is said: length, depth, height [m]."""


def furniture(
    name: str, what: What, x: float, y: float, size: tuple[float, float, float], degrees: float = 0.0, look: str = ""
) -> Thing:
    """A piece of the room, as a floor plan lists it; `size` = length, depth, height [m]."""
    length, depth, height = size
    pose = Pose(x, y, math.radians(degrees))
    return Thing(id=name, what=what, pose=pose, length=length, depth=depth, height=height, look=look, fixed=True)
