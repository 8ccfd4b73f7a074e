"""The two floor plans, and what can be put into them."""

import itertools

import numpy as np
import pytest

from core.errors import BadInput
from core.geometry import Pose
from core.simulation.world import WORLDS, Rect, Thing, World, cast, outline, world_named

ALL = pytest.mark.parametrize("world", list(WORLDS.values()), ids=list(WORLDS))
FURNISHED = pytest.mark.parametrize("world", [WORLDS[name] for name in ("lab", "floor")], ids=("lab", "floor"))
ROBOT = 0.09  # [m]


def box(x: float, y: float) -> Thing:
    return Thing(id="a box", what="box", pose=Pose(x, y, 0.3), length=0.4, depth=0.3, height=0.3)


def sweep_is_free(world: World, start: tuple[float, float], end: tuple[float, float], radius: float) -> bool:
    return all(world.free(*(np.array(start) + t * np.subtract(end, start)), radius) for t in np.linspace(0, 1, 30))


def test_an_outline_goes_around_the_free_floor_with_the_floor_on_the_left() -> None:
    walls = outline([Rect(0, 0, 4, 3), Rect(4, 1, 5, 2)], [Rect(1, 1, 2, 2)])
    length = np.abs(walls[:, 2:] - walls[:, :2]).sum()
    assert length == pytest.approx(4 + 3 + 4 + 1 + 1 + 1 + 1 + 1 + 4)
    assert len(walls) == 8 + 4
    doubled = (walls[:, 0] * walls[:, 3] - walls[:, 2] * walls[:, 1]).sum()
    assert doubled / 2 == pytest.approx(4 * 3 + 1 - 1)


@ALL
def test_walls_are_closed(world: World) -> None:
    starts = sorted(map(tuple, world.walls[:, :2].round(6).tolist()))
    ends = sorted(map(tuple, world.walls[:, 2:].round(6).tolist()))
    assert starts == ends


@FURNISHED
def test_a_robot_can_do_the_first_commands(world: World) -> None:
    assert sweep_is_free(world, (0, 0), (1.5, 0), ROBOT + 0.25)
    assert sweep_is_free(world, (0, 0), (0, 1.5), ROBOT + 0.25)
    for goal in ((1.0, 0.5), (2.0, 1.0)):
        assert sweep_is_free(world, (0, 0), goal, 0.35)


@FURNISHED
def test_clearance_is_negative_off_the_free_floor(world: World) -> None:
    assert world.clearance(0, 0) >= 0.5
    assert world.clearance(world.bounds.x0 - 1, 0) < 0
    cabinet = next(t for t in world.things if t.what == "cabinet")
    assert world.clearance(cabinet.pose.x, cabinet.pose.y) < 0


@pytest.mark.parametrize("world", [world for world in WORLDS.values() if world.things], ids=lambda one: one.name)
def test_every_thing_of_the_room_stands_inside_its_walls(world: World) -> None:
    bare = World(name="bare", walls=world.walls)
    for thing in world.things:
        assert bare.inside(thing.pose.x, thing.pose.y), thing.id


def corners_in_view(world: World, x: float, y: float) -> set[int]:
    """Corners between two walls of at least 0.25 m that a laser at (x, y) sees within 4 m."""
    lengths = np.abs(world.walls[:, 2:] - world.walls[:, :2]).sum(axis=1)
    before = {tuple(end): k for k, end in enumerate(world.walls[:, 2:].round(6).tolist())}
    seen: set[int] = set()
    for number, start in enumerate(world.walls[:, :2].round(6).tolist()):
        former = before[tuple(start)]
        if min(lengths[number], lengths[former]) < 0.25:
            continue
        points = [
            world.walls[number, :2] + 0.1 * (world.walls[number, 2:] - world.walls[number, :2]) / lengths[number],
            world.walls[former, 2:] - 0.1 * (world.walls[former, 2:] - world.walls[former, :2]) / lengths[former],
        ]
        rays = np.array(points) - (x, y)
        hits = cast(np.array([x, y]), rays, world.surfaces(0.12))
        if (hits.distance > 0.999).all() and np.hypot(*rays[0]) < 4:
            seen.add(number)
    return seen


def test_a_tour_of_the_laboratory_shows_many_corners() -> None:
    tour = [(0, 0), (1.5, 0), (3.0, 0.0), (3.0, 1.5), (1.0, 2.0), (-1.0, 1.0), (-1.2, -0.5), (0.5, -1.2)]
    assert all(WORLDS["lab"].free(x, y, 0.35) for x, y in tour)
    seen = [corners_in_view(WORLDS["lab"], x, y) for x, y in tour]
    assert len(set().union(*seen)) >= 25
    assert min(map(len, seen)) >= 4


def test_the_floor_has_a_loop_that_a_robot_can_drive() -> None:
    around = [(0, -0.1), (11.8, -0.1), (11.8, 7.6), (-2.0, 7.6), (-2.0, -0.1), (0, -0.1)]
    floor = WORLDS["floor"]
    for start, end in itertools.pairwise(around):
        assert sweep_is_free(floor, start, end, 0.3)
    assert not sweep_is_free(floor, (0, -0.1), (0, 7.6), 0.1)  # the block in the middle


def test_a_thing_takes_room_until_it_is_taken_away() -> None:
    lab = WORLDS["lab"]
    full = lab.with_thing(box(1.0, 0.0))
    assert lab.free(1.0, 0.0, 0.2)
    assert full.clearance(1.0, 0.0) < 0
    moved = full.with_thing(box(1.0, 1.0))
    assert moved.free(1.0, 0.0, 0.2)
    assert len(moved.things) == len(full.things)
    assert moved.without("a box").things == lab.things


def test_only_what_was_placed_can_be_taken_away() -> None:
    for name in ("crate", "nothing"):
        with pytest.raises(BadInput, match="placed so far: a box"):
            WORLDS["lab"].with_thing(box(1, 0)).without(name)


def test_a_table_is_in_the_way_only_with_its_legs() -> None:
    lab = WORLDS["lab"]
    table = next(t for t in lab.things if t.what == "table")
    assert lab.free(table.pose.x, table.pose.y, ROBOT)
    leg = table.solids[0]
    assert lab.clearance(*leg.centre) < 0


def test_an_unknown_world_is_refused_with_the_names_of_the_known() -> None:
    with pytest.raises(BadInput, match="lab, floor"):
        world_named("moon")
