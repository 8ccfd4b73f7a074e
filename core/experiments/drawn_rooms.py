"""Figure 16's drive in many drawn rooms: how much of its error is the luck of where the corners are.

The print does not say where its corners were. Sightings are drawn as in `figure-16-conditions`: the camera's field,
edges required, names hidden, moving at once, and the control noise with which dead reckoning errs as in print.
"""

from functools import partial
from pathlib import Path
from typing import TypedDict

import numpy as np

from core.experiments.figure_16_conditions import FAIR_CONDITIONS, FORM, PAPER_ERROR_M, ROOM, Condition, limit
from core.experiments.paper_course import mapped
from core.experiments.plan import About, ChapterValue, ExperimentPlan, RunBatch
from core.experiments.result import ExperimentResult, stored
from core.message import message

DRIVES_PER_ROOM = 20
SHOWN_PERCENTILES = (10, 50, 90)
ROOM_CONDITIONS = (FAIR_CONDITIONS[0], FAIR_CONDITIONS[3])
"""The camera's field to 4 m and to 5.6 m, names hidden, moving at once."""

ABOUT = About(
    title="Figure 16 in drawn rooms",
    reproduces="Figure 16's drive among twelve corners of its own for every room; edges required in the "
    "camera's field, names hidden, moving at once, the control noise with which dead reckoning errs as in print.",
    runs=50,
    counts="rooms",
    base_s=1.0,
    run_s=9.0,
    chapter=tuple(
        ChapterValue(
            name=f"Worst average error, median room; laser to {one.reach:g} m",
            value=PAPER_ERROR_M,
            unit="m",
            ours=f"conditions.{row}.worst_m.1",
        )
        for row, one in enumerate(ROOM_CONDITIONS)
    ),
)


@message
class RoomErrors:
    """Average errors [m] of the drives in one drawn room, under one condition."""

    worst: float
    mean: float
    nees: float
    limit: float  # [m] of the mean


class RoomFigures(TypedDict):
    """Drawn rooms under one condition, as JSON."""

    condition: str
    share_within_paper: float  # of the rooms whose worst drive errs 0.08 m at most
    share_mean_within_paper: float  # of those whose drives err so in the mean
    share_limit_within_paper: float  # of those whose sightings allow it in the mean
    worst_m: list[float]  # 10th, 50th, 90th percentile over the rooms
    mean_m: list[float]
    limit_m: list[float]
    nees: float


class DrawnRooms(ExperimentResult):
    """The result, as JSON."""

    rooms: int
    drives: int
    conditions: list[RoomFigures]


def plan(*, runs: int | None = None, seed: int = 0) -> ExperimentPlan:
    """Plan `runs` rooms (50) with 20 drives in each, with the laser's reach of 4 m and of 5.6 m."""
    batches = tuple(
        RunBatch(partial(room_errors, one, seed, DRIVES_PER_ROOM), runs or ABOUT.runs, RoomErrors)
        for one in ROOM_CONDITIONS
    )
    return ExperimentPlan(batches, partial(_result, seed))


def room_errors(one: Condition, seed: int, drives: int, number: int) -> RoomErrors:
    """As many drives in the drawn room of that number."""
    draws = one.draws(seed, room=number)
    done = [mapped(draws.run(drive), FORM, one.still) for drive in range(drives)]
    averages = [each.average for each in done]
    return RoomErrors(
        worst=max(averages),
        mean=float(np.mean(averages)),
        nees=float(np.nanmean([each.nees for each in done])),
        limit=limit(draws, one.still),
    )


def _result(seed: int, out: Path | None, *done: list[RoomErrors]) -> DrawnRooms:
    rows = [_row(one, rooms) for one, rooms in zip(ROOM_CONDITIONS, done, strict=True)]
    result: DrawnRooms = {
        "rooms": len(done[0]),
        "drives": DRIVES_PER_ROOM,
        "seed": seed,
        "conditions": rows,
        "text": table(rows, len(done[0])),
        "files": {},
    }
    return stored(result, out, "drawn_rooms")


def _row(one: Condition, rooms: list[RoomErrors]) -> RoomFigures:
    errors = np.array([(each.worst, each.mean, each.limit) for each in rooms])
    share, (worst, mean, limits) = (
        np.mean(errors <= PAPER_ERROR_M, axis=0),
        np.percentile(errors, SHOWN_PERCENTILES, axis=0).T,
    )
    return {
        "condition": one.subtitle.replace(ROOM, "twelve corners drawn"),
        "share_within_paper": float(share[0]),
        "share_mean_within_paper": float(share[1]),
        "share_limit_within_paper": float(share[2]),
        "worst_m": worst.tolist(),
        "mean_m": mean.tolist(),
        "limit_m": limits.tolist(),
        "nees": float(np.nanmean([each.nees for each in rooms])),
    }


def table(rows: list[RoomFigures], count: int) -> str:
    """The table; the condition stands under every row."""
    lines = [
        f"{count} drawn rooms, {DRIVES_PER_ROOM} drives in each: 10th / 50th / 90th percentile over the rooms [m]",
        f"{'worst of a room':>23}{'mean':>23}{'limit of the mean':>23}{'worst ≤ ' + f'{PAPER_ERROR_M:g}':>14}"
        f"{'mean ≤':>8}{'NEES':>7}",
    ]
    for row in rows:
        cells = (" / ".join(f"{one:.3f}" for one in row[key]) for key in ("worst_m", "mean_m", "limit_m"))
        lines += [
            "".join(f"{cell:>23}" for cell in cells)
            + f"{row['share_within_paper']:14.0%}{row['share_mean_within_paper']:8.0%}{row['nees']:7.2f}",
            f"    {row['condition']}",
        ]
    return "\n".join(lines)
