"""STOP that nobody spoke: `python -m tests.benchmarks.false_stops [--minutes 10]`.

The robot drives about in `sim:lab` and in `sim:floor`, for a moment and for ten seconds at a time, to commands that
are typed, nobody is in the room, and its ears are open beside its own motors. Told: how much of the time it drove,
how many utterances its own noise was taken for, and how often for a STOP or for another command, in an hour of it.
"""

from typing import Any

from core.experiments.spoken_room import SpokenRoom
from tests.benchmarks.carried_out import carried_out
from tests.benchmarks.command import print_row, run_command

SHORT = ("turn left", "turn right", "continue 0.5 meters", "turn left", "turn left", "continue 0.5 meters")
WORDS = (*SHORT, "continue 2 meters", "turn right", "continue 1.5 meters")
WORLDS = ("lab", "floor")
PART = 120.0  # [s] that one robot drives before another takes its place


def drive(number: int, seconds: float = PART) -> dict[str, Any]:
    """One robot that hears only itself, for so long; `number` is its seed and chooses its world."""
    world = WORLDS[number % len(WORLDS)]
    room = SpokenRoom(world, number)
    begun = before = room.robot.snapshot.stamp
    given, order = 0, None
    drove, heard, stops, others = 0.0, 0, list[float](), list[str]()
    for snapshot, spoken in room.overheard(seconds):
        if order is None or room.robot.ended(order) is not None:
            order = room.robot.tell(WORDS[given % len(WORDS)])
            given += 1
        drove += (snapshot.stamp - before) * (snapshot.velocity.v != 0 or snapshot.velocity.w != 0)
        before = snapshot.stamp
        for one in spoken:
            heard += 1
            if one.decision.command is None:
                continue
            stop = one.decision.stops
            stops.extend([round(snapshot.stamp - begun, 2)] if stop else [])
            others.extend([] if stop else [one.decision.echo])
    told = {"world": world, "number": number, "drove_s": drove, "commands": given, "heard": heard}
    return told | {"stops": stops, "others": others}


def main(
    *,
    minutes: float = 10.0,  # in each of the two worlds
    workers: int = 2,
) -> None:
    count = max(round(minutes * 60 / PART), 1) * len(WORLDS)
    rows = carried_out(drive, count, workers)
    for world in WORLDS:
        these = [row for row in rows if row["world"] == world]
        hours = sum(row["drove_s"] for row in these) / 3600
        line = {
            "world": world,
            "drove_min": round(60 * hours, 2),
            "commands": sum(row["commands"] for row in these),
            "utterances": sum(row["heard"] for row in these),
            "stops": {row["number"]: row["stops"] for row in these if row["stops"]},
            "other_commands": [word for row in these for word in row["others"]],
            "stops_per_hour": round(sum(len(row["stops"]) for row in these) / hours, 1),
        }
        print_row(line)


if __name__ == "__main__":
    run_command(main)
