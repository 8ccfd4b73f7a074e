"""What stands in the way: `python -m tests.benchmarks.obstacles [--placements 100] [--goals 20] [--seed 0]`.

Placements: a robot at full speed (0.3 m/s, straight on or in an arc) in `sim:lab`; something of random kind and size
is set down half a metre before its body, more or less aside, and the order to go on stays in force. Told: contacts,
how many stopped it, the time from setting down to rest, the least room left. What lies beside the track is passed.

Goals: the whole robot with its map in `sim:lab` and `sim:floor` goes to random places; at every other one a box is
set down on its way, 0.5 m ahead. Told: how the goals ended, contacts, the way they took, turns to and fro.
"""

import dataclasses
import math

import numpy as np

from core.experiments.rehearsal import Rehearsal
from core.gate import Twist
from core.geometry import Pose, wrap
from core.robots.requests import PlaceThing, RemoveThing
from core.settings import Settings
from core.simulation.settings import SimulationSettings
from core.simulation.world import World, world_named
from tests.benchmarks.bare_drive import BareDrive
from tests.benchmarks.command import print_row, run_command

RADIUS = 0.09  # [m]
FULL = 0.3  # [m/s]
SIZES = (0.15, 0.4)  # [m]: what is lower than the laser's plane, 0.12 m, is not seen at all
KINDS = ("box", "box", "person")
BLIND = dataclasses.replace(Settings(), simulation=SimulationSettings(camera=False))


def free_run(rng: np.random.Generator, way: float = 1.8) -> Pose:
    """A pose in the laboratory with so many metres of free floor ahead."""
    world = world_named("lab")
    while True:
        pose = Pose(*rng.uniform((-2.2, -2.2, -math.pi), (5.2, 3.2, math.pi)))
        places = [pose @ Pose(step, 0.0, 0.0) for step in np.arange(0.0, way, 0.1)]
        if all(world.clearance(place.x, place.y) > 0.45 for place in places):
            return pose


def placement(seed: int) -> dict[str, float | bool]:
    """One thing set down before a robot at full speed."""
    rng = np.random.default_rng(seed)
    start, turn = free_run(rng), float(rng.choice([0.0, 0.0, rng.uniform(-0.4, 0.4)]))
    drive = BareDrive("lab", start, seed=seed, cruise=FULL)
    order = Twist(FULL, turn)
    while drive.here.stamp < 1.2:
        drive.step(order)
    what = str(rng.choice(KINDS))
    size = 0.4 if what == "person" else float(rng.uniform(*SIZES))
    ahead, side = 0.5 + RADIUS + size / 2, float(rng.uniform(-0.25, 0.25))
    spot = drive.truth @ Pose(ahead * math.cos(turn * 0.8), side + ahead * math.sin(turn * 0.8), 0.0)
    drive.robot.ask(PlaceThing(what=what, x_m=spot.x, y_m=spot.y, size_m=None if what == "person" else size))
    down, rest, room, last = drive.here.stamp, math.nan, math.inf, drive.truth
    while drive.here.stamp < down + 6.0:
        drive.step(order)
        truth = drive.truth
        room = min(room, drive.clearance)
        if math.isnan(rest) and truth.distance_to(last.x, last.y) < 1e-4:
            rest = drive.here.stamp - down
        last = truth
    return {"contact": drive.contacts > 0, "seconds": rest, "room": room, "faults": len(drive.faults())}


def goals_in(place: str, count: int, seed: int) -> list[dict[str, object]]:
    """Goals one after the other by the whole robot."""
    rehearsal, rng = Rehearsal(f"sim:{place}", seed=seed, settings=BLIND), np.random.default_rng(seed)
    rehearsal.run(1.5)
    return [_goal(rehearsal, world_named(place), rng, blocked=number % 2 == 1) for number in range(count)]


def _goal(rehearsal: Rehearsal, world: World, rng: np.random.Generator, *, blocked: bool) -> dict[str, object]:
    here = rehearsal.truth
    while True:
        x, y = (round(float(v), 2) for v in rng.uniform((here.x - 3, here.y - 3), (here.x + 3, here.y + 3)))
        if world.clearance(x, y) > 0.15 and here.distance_to(x, y) > 0.8:
            break
    order, began = rehearsal.tell(f"stop at {x} and {y}"), rehearsal.snapshot.stamp
    touched, way, swings, last, side, box = rehearsal.contacts, 0.0, 0, here, 0.0, ""
    while (ended := rehearsal.ended(order)) is None and rehearsal.snapshot.stamp < began + 240:
        now = rehearsal.step().truth
        assert now is not None
        way += now.distance_to(last.x, last.y)
        turned = wrap(now.heading - last.heading)
        if abs(turned) > 0.008:
            swings += turned * side < 0
            side = turned
        last = now
        if blocked and not box and way > 0.4 and now.distance_to(x, y) > 1.0:
            spot = now @ Pose(0.5 + RADIUS + 0.1, float(rng.uniform(-0.1, 0.1)), 0.0)
            if world.clearance(spot.x, spot.y) > 0.12:
                told = rehearsal.robot.ask(PlaceThing(what="box", x_m=spot.x, y_m=spot.y, size_m=0.2))
                box = told.id
    if box:
        rehearsal.robot.ask(RemoveThing(id=box))
    return {
        "goal": [x, y],
        "state": ended.state if ended else "too long",
        "remark": ended.remark if ended else "",
        "off_m": round(last.distance_to(x, y), 3),
        "way_m": round(way, 2),
        "straight_m": round(here.distance_to(x, y), 2),
        "seconds": round(rehearsal.snapshot.stamp - began, 1),
        "swings": swings,
        "boxed": bool(box),
        "contacts": rehearsal.contacts - touched,
    }


def main(
    *,
    placements: int = 100,
    goals: int = 10,  # in each world
    seed: int = 0,
) -> None:
    put = [placement(number) for number in range(seed, seed + placements)]
    if put:
        seconds = np.array([one["seconds"] for one in put])
        stopped = seconds[np.isfinite(seconds)]
        figures = {
            "placements": len(put),
            "contacts": sum(bool(one["contact"]) for one in put),
            "faults": sum(one["faults"] for one in put),
            "stopped": len(stopped),
            "seconds_to_rest_p50": float(np.median(stopped)),
            "seconds_to_rest_p95": float(np.percentile(stopped, 95)),
            "seconds_to_rest_max": float(stopped.max()),
            "least_room_m": min(float(one["room"]) for one in put),
        }
        print_row(figures)
    for place in ("lab", "floor"):
        rows = goals_in(place, goals, seed)
        for row in rows:
            print_row(row)
        ends = {state: sum(row["state"] == state for row in rows) for state in {str(row["state"]) for row in rows}}
        print_row({"place": place, "goals": len(rows), "ends": ends, "contacts": sum(r["contacts"] for r in rows)})


if __name__ == "__main__":
    run_command(main)
