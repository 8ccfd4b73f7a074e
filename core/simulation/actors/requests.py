"""Requests to put things into the simulated world, checked."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from core.errors import BadInput
from core.geometry import Pose
from core.simulation.world import COLOURS, GESTURES, SIZES, Thing, World

BOARD, HOLDER = "board", "board's holder"  # ids of the chessboard and of who holds it
MOST = 30  # things that may be placed
ELBOW_ROOM = 0.02  # [m] between the robot and what is placed next to it
EDGE = (0.05, 1.5)  # [m] of a box
TALL = (0.8, 2.2)  # [m] height of a person


def number(request: Mapping[str, object], key: str, default: float | None = None) -> float:
    """The number under `key`; BadInput when it is none, or absent without a default."""
    value = request.get(key)
    if value is None and default is not None:
        return default
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise BadInput(f"{key} must be a number.")
    try:
        found = float(value)
    except OverflowError:
        found = math.inf
    if not math.isfinite(found):
        raise BadInput(f"{key} must be a finite number.")
    return found


def thing_asked_for(request: dict[str, Any], world: World, robot: Pose, radius: float) -> Thing:
    """The person or box of a `place` request, where it may stand; BadInput says why it may not."""
    what = request.get("what")
    if not isinstance(what, str) or what not in SIZES:
        raise BadInput(f"what must be one of {', '.join(SIZES)}, board or robot.")
    placed = [thing for thing in world.things if not thing.fixed]
    name = request.get("id", _new_name(what, placed))
    if not isinstance(name, str) or not 0 < len(name) <= 40:
        raise BadInput("id must be a text of 1 to 40 characters.")
    if any(thing.id == name and thing.fixed for thing in world.things):
        raise BadInput("That id belongs to a piece of the room; choose another.")
    if name in (BOARD, HOLDER):
        raise BadInput("That id belongs to the chessboard; choose another.")
    others = world.without(name) if any(thing.id == name for thing in placed) else world
    if len([thing for thing in placed if thing.id != name]) >= MOST:
        raise BadInput(f"There are {MOST} things already; remove one first.")
    length, depth, height = _size(request, what)
    heading = math.remainder(number(request, "heading_rad", 0.0), math.tau)
    pose = Pose(number(request, "x_m"), number(request, "y_m"), heading)
    look, gesture = _appearance(request, what, next((thing for thing in placed if thing.id == name), None))
    thing = Thing(
        id=name, what=what, pose=pose, length=length, depth=depth, height=height, look=look, gesture=gesture
    )
    tall = height if what == "person" else 0.0
    if not others.free(pose.x, pose.y, thing.reach) or (
        tall and not others.upright(pose.x, pose.y, thing.reach, tall)
    ):
        raise BadInput(f"A {what} does not fit there; choose a place on the free floor, away from walls and things.")
    if robot.distance_to(pose.x, pose.y) < thing.reach + radius + ELBOW_ROOM:
        raise BadInput("The robot stands there; choose a place next to it.")
    return thing


def _appearance(request: dict[str, Any], what: str, former: Thing | None) -> tuple[str, str]:
    """Return clothes and gesture of a person; a person who is moved keeps those that are not given."""
    look, gesture = request.get("clothes"), request.get("gesture")
    if what != "person":
        if look is not None or gesture is not None:
            raise BadInput("Only a person has clothes and gestures; leave them out.")
        return "", ""
    look = (former.look if former else "") if look is None else look
    gesture = (former.gesture if former else "") if gesture is None else gesture
    if not isinstance(look, str) or (look and not _are_clothes(look)):
        raise BadInput(f"clothes must be shirt and trousers like red/blue, of {', '.join(COLOURS)}.")
    if not isinstance(gesture, str) or gesture not in GESTURES:
        raise BadInput(f"gesture must be one of {', '.join(GESTURES[1:])}, or empty.")
    return look, gesture


def _are_clothes(look: str) -> bool:
    parts = look.split("/")
    return len(parts) == 2 and all(part in COLOURS for part in parts)


def describe(thing: Thing) -> dict[str, Any]:
    """A thing as the answers have it."""
    worn = {"clothes": thing.look, "gesture": thing.gesture} if thing.what == "person" else {}
    return {
        "id": thing.id,
        "what": thing.what,
        "x_m": thing.pose.x,
        "y_m": thing.pose.y,
        "heading_rad": thing.pose.heading,
        "length_m": thing.length,
        "depth_m": thing.depth,
        "height_m": thing.height,
        "fixed": thing.fixed,
        **worn,
    }


def _size(request: dict[str, Any], what: str) -> tuple[float, float, float]:
    length, depth, height = SIZES[what]  # type: ignore[index]
    if request.get("size_m") is None:
        return length, depth, height
    size = number(request, "size_m")
    low, high = EDGE if what == "box" else TALL
    if not low <= size <= high:
        raise BadInput(f"size_m of a {what} must lie between {low:g} and {high:g}.")
    return (size, size, size) if what == "box" else (length, depth, size)


def _new_name(what: str, placed: list[Thing]) -> str:
    taken = {thing.id for thing in placed}
    return next(name for n in range(1, MOST + 2) if (name := f"{what} {n}") not in taken)
