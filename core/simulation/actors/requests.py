"""Requests to put things into the simulated world, checked against it."""

import math

import msgspec

from core.errors import BadInput
from core.geometry import Pose
from core.robots.requests import CarryRobot, PlacedThing, PlaceThing, finite
from core.simulation.world import COLOURS, GESTURES, SIZES, Thing, World

BOARD, HOLDER = "board", "board's holder"  # ids of the chessboard and of who holds it
MAX_THINGS = 30  # things that may be placed
ELBOW_ROOM_M = 0.02  # between the robot and what is placed next to it
BOX_EDGES_M = (0.05, 1.5)  # of a box
PERSON_HEIGHTS_M = (0.8, 2.2)  # height of a person


def thing_asked_for(request: PlaceThing, world: World, robot: Pose, radius: float) -> Thing:
    """The person or box of a request, where it may stand; BadInput says why it may not."""
    what = request.what
    placed = [thing for thing in world.things if not thing.fixed]
    name = _new_name(what, placed) if request.id is None else request.id
    if not 0 < len(name) <= 40:
        raise BadInput("id must be a text of 1 to 40 characters.")
    if any(thing.id == name and thing.fixed for thing in world.things):
        raise BadInput("That id belongs to a piece of the room; choose another.")
    if name in (BOARD, HOLDER):
        raise BadInput("That id belongs to the chessboard; choose another.")
    others = world.without(name) if any(thing.id == name for thing in placed) else world
    if len([thing for thing in placed if thing.id != name]) >= MAX_THINGS:
        raise BadInput(f"There are {MAX_THINGS} things already; remove one first.")
    length, depth, height = _size(request)
    pose = pose_asked_for(request)
    look, gesture = _appearance(request, next((thing for thing in placed if thing.id == name), None))
    thing = Thing(
        id=name, what=what, pose=pose, length=length, depth=depth, height=height, look=look, gesture=gesture
    )
    tall = height if what == "person" else 0.0
    if not others.free(pose.x, pose.y, thing.reach) or (
        tall and not others.upright(pose.x, pose.y, thing.reach, tall)
    ):
        raise BadInput(f"A {what} does not fit there; choose a place on the free floor, away from walls and things.")
    if robot.distance_to(pose.x, pose.y) < thing.reach + radius + ELBOW_ROOM_M:
        raise BadInput("The robot stands there; choose a place next to it.")
    return thing


def pose_asked_for(request: PlaceThing | CarryRobot) -> Pose:
    """The pose of a request. Raises BadInput where it is not finite."""
    heading = math.remainder(finite(request.heading_rad, "heading_rad"), math.tau)
    return Pose(finite(request.x_m, "x_m"), finite(request.y_m, "y_m"), heading)


def _appearance(request: PlaceThing, former: Thing | None) -> tuple[str, str]:
    """Return clothes and gesture of a person; a person who is moved keeps those that are not given."""
    if request.what != "person":
        if request.clothes is not None or request.gesture is not None:
            raise BadInput("Only a person has clothes and gestures; leave them out.")
        return "", ""
    look = (former.look if former else "") if request.clothes is None else request.clothes
    gesture = (former.gesture if former else "") if request.gesture is None else request.gesture
    if look and not _are_clothes(look):
        raise BadInput(f"clothes must be shirt and trousers like red/blue, of {', '.join(COLOURS)}.")
    if gesture not in GESTURES:
        raise BadInput(f"gesture must be one of {', '.join(GESTURES[1:])}, or empty.")
    return look, gesture


def _are_clothes(look: str) -> bool:
    parts = look.split("/")
    return len(parts) == 2 and all(part in COLOURS for part in parts)


def describe(thing: Thing) -> PlacedThing:
    """A thing as the answers have it."""
    is_person = thing.what == "person"
    return PlacedThing(
        id=thing.id,
        what=thing.what,
        x_m=thing.pose.x,
        y_m=thing.pose.y,
        heading_rad=thing.pose.heading,
        length_m=thing.length,
        depth_m=thing.depth,
        height_m=thing.height,
        fixed=thing.fixed,
        clothes=thing.look if is_person else msgspec.UNSET,
        gesture=thing.gesture if is_person else msgspec.UNSET,
    )


def _size(request: PlaceThing) -> tuple[float, float, float]:
    what = request.what
    length, depth, height = SIZES[what]
    if request.size_m is None:
        return length, depth, height
    size = finite(request.size_m, "size_m")
    low, high = BOX_EDGES_M if what == "box" else PERSON_HEIGHTS_M
    if not low <= size <= high:
        raise BadInput(f"size_m of a {what} must lie between {low:g} and {high:g}.")
    return (size, size, size) if what == "box" else (length, depth, size)


def _new_name(what: str, placed: list[Thing]) -> str:
    taken = {thing.id for thing in placed}
    return next(name for n in range(1, MAX_THINGS + 2) if (name := f"{what} {n}") not in taken)
