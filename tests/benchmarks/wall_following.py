"""FOLLOW WALL by laps: `python -m tests.benchmarks.wall_following --place lab --laps 10 --seed 0`.

The robot goes by its wheels' word and the laser with its noise, behind its gate, without keeping real time. A lap
ends where the robot comes by its starting line again. Straight: nothing but one straight wall within 0.8 m (`aside`).
Printed: root mean square and 95 % of the distance's error on straight walls, the least room around the body, laps,
contacts, what the trace checker says, and the seconds a lap takes. Laps are independent: run parts by seed.
"""

import math
from itertools import count
from typing import Annotated

import numpy as np

from core.commands.command import Command
from core.commands.follow_wall import FOLLOW_WALL
from core.experiments.table_2_trials import aside
from core.geometry import Pose
from core.simulation.world import world_named
from tests.benchmarks.bare_drive import BareDrive
from tests.benchmarks.command import print_row, run_command

STARTS = {"lab": Pose(-0.4, -2.0, 0.0), "floor": Pose(0.2, -0.5, 0.0)}
FOLLOW = Command(name="follow_wall", numbers={"distance_m": 0.5}, heard_as="follow wall")
AWAY = 3.0  # [m] that a lap leads away from its start, before it can end there
LONGEST = 1500.0  # [s] of a lap


def lap(place: str, seed: int, cruise: float) -> dict[str, object]:
    """One lap by a robot of that luck."""
    rng = np.random.default_rng(seed)
    start = STARTS[place] @ Pose(*rng.uniform((-0.05, -0.1, -0.3), (0.05, 0.1, 0.3)))
    drive = BareDrive(place, start, seed=seed, cruise=cruise)
    surfaces = world_named(place).surfaces(0.12)
    action = FOLLOW_WALL.begin(FOLLOW, drive.here)
    off: list[float] = []
    room, left, began, words = math.inf, False, drive.here.stamp, ""
    for frame in count():
        progress = drive.drive(action)
        truth = drive.truth
        if progress.finished or drive.here.stamp - began > LONGEST:
            words = progress.remark or "too long"
            break
        if frame % 4 == 0:
            error = aside(truth, surfaces.faces, surfaces.posts)
            off += [] if error is None else [error]
            room = min(room, drive.clearance)
        away = truth.distance_to(start.x, start.y)
        left = left or away > AWAY
        if left and away < 0.3:
            break
    return {
        "seed": seed,
        "done": not words,
        "words": words,
        "seconds": round(drive.here.stamp - began, 1),
        "contacts": drive.contacts,
        "faults": len(drive.faults()),
        "least_room_m": round(room, 3),
        "off": off,
    }


def main(
    *,
    place: Annotated[str, STARTS] = "lab",
    laps: int = 10,
    seed: int = 0,
    cruise: float = 0.1,  # metres a second
) -> None:
    rows = []
    for number in range(seed, seed + laps):
        rows.append(lap(place, number, cruise))
        print_row({key: value for key, value in rows[-1].items() if key != "off"})
    off = np.array([error for one in rows for error in one["off"]])
    figures = {
        "place": place,
        "cruise_m_s": cruise,
        "laps": len(rows),
        "laps_done": sum(one["done"] for one in rows),
        "contacts": sum(one["contacts"] for one in rows),
        "faults": sum(one["faults"] for one in rows),
        "rms_m": float(np.sqrt(np.mean(off**2))) if len(off) else None,
        "p95_m": float(np.percentile(np.abs(off), 95)) if len(off) else None,
        "least_room_m": min(one["least_room_m"] for one in rows),
        "seconds_per_lap": float(np.median([one["seconds"] for one in rows])),
        "straight_samples": len(off),
    }
    print_row(figures)


if __name__ == "__main__":
    run_command(main)
