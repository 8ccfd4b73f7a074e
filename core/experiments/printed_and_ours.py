"""The chapter's own forms and ours, column by column, on the same drives, commands and seeds through the whole robot.

Every column is a run of the same experiments under one value of `[chapter] mode`: the drives of figure 16 in the
simulated laboratory, with the camera's edges found in pictures and the paper's wheels; and the commands of table 2,
spoken and obeyed. Reading words has no printed form: who is not located is understood all the same.
"""

from functools import partial
from pathlib import Path
from typing import Any, Literal, TypedDict

import msgspec

from core.errors import Unavailable
from core.experiments.dead_reckoning_vs_slam import DriveOutcome, drive_rows, outcome
from core.experiments.drives import FIGURED, PLAIN, lab_drives
from core.experiments.plan import About, ExperimentPlan, RunBatch
from core.experiments.result import ExperimentResult, stored
from core.experiments.table_2 import TrialRow, trial_of
from core.experiments.table_2_trials import TRIALS
from core.settings import Settings, as_printed
from core.speech.synthesis import NO_VOICE, can_speak

ABOUT = About(
    title="The chapter's forms and ours, side by side",
    reproduces="The drive of figure 16 and the commands of table 2 through the whole simulated robot, by equations "
    "14-40 as printed and by ours.",
    runs=10,
    seed=3,
    counts="drives, and runs of every command, in either form",
    base_s=2.0,
    run_s=400.0,
)
Column = Literal["printed", "ours"]
COLUMNS: dict[Column, Settings] = {"printed": as_printed(Settings()), "ours": Settings()}


class ColumnFigures(TypedDict):
    """One column, as JSON."""

    worst_average_error_m: float
    mean_average_error_m: float
    mean_final_error_m: float
    nees_mean: float


class PrintedAndOurs(ExperimentResult):
    """The result, as JSON."""

    runs: int
    dead_reckoning_worst_m: float
    columns: dict[Column, ColumnFigures]
    commands: dict[str, dict[Column, float]]  # share of the runs that succeeded
    contacts: dict[Column, int]


def plan(*, runs: int | None = None, seed: int = 0) -> ExperimentPlan:
    """Plan `runs` drives (10), and runs of every command, in either mode. Raises Unavailable where nothing can
    speak.
    """
    if not can_speak():
        raise Unavailable(NO_VOICE)
    count = runs or ABOUT.runs
    batches: list[RunBatch[Any]] = []
    for settings in COLUMNS.values():
        batches += [
            RunBatch(partial(outcome, lab_drives(settings, seed)), count, DriveOutcome),
            RunBatch(partial(trial_of, seed, count, settings), count * len(TRIALS), TrialRow),
        ]
    return ExperimentPlan(tuple(batches), partial(_result, seed))


def _result(seed: int, out: Path | None, *done: list[Any]) -> PrintedAndOurs:
    count = len(done[0])
    columns: dict[Column, ColumnFigures] = {}
    dead = 0.0
    commands: dict[str, dict[Column, float]] = {name: {} for name in TRIALS}
    contacts: dict[Column, int] = {}
    for place, (column, settings) in enumerate(COLUMNS.items()):
        driven, spoken = done[2 * place : 2 * place + 2]
        rows = drive_rows(lab_drives(settings, seed), driven)
        columns[column] = msgspec.convert(rows[FIGURED], ColumnFigures)
        dead = rows[PLAIN]["worst_average_error_m"]
        for number, name in enumerate(TRIALS):
            some = spoken[number * count : (number + 1) * count]
            commands[name][column] = sum(one["success"] for one in some) / count
        contacts[column] = sum(one["contacts"] for one in spoken)
    result: PrintedAndOurs = {
        "runs": count,
        "seed": seed,
        "dead_reckoning_worst_m": dead,
        "columns": columns,
        "commands": commands,
        "contacts": contacts,
        "text": table(columns, commands, contacts, count),
        "files": {},
    }
    return stored(result, out, "printed_and_ours")


def table(
    columns: dict[Column, ColumnFigures],
    commands: dict[str, dict[Column, float]],
    contacts: dict[Column, int],
    count: int,
) -> str:
    """Figures down, modes across."""
    printed, ours = columns["printed"], columns["ours"]
    pairs = (
        ("worst average error [m]", printed["worst_average_error_m"], ours["worst_average_error_m"]),
        ("mean average error [m]", printed["mean_average_error_m"], ours["mean_average_error_m"]),
        ("mean final error [m]", printed["mean_final_error_m"], ours["mean_final_error_m"]),
        ("NEES (ideal 3)", printed["nees_mean"], ours["nees_mean"]),
    )
    return "\n".join(
        (
            f"sim:lab, whole robot, the paper's wheels, {count} drives",
            f"{'':26}{'printed':>12}{'ours':>12}",
            *(f"{name:26}{one:12.3f}{other:12.3f}" for name, one, other in pairs),
            f"commands of table 2, spoken, {count} runs of each: success [%]",
            *(f"{name:26}{100 * one['printed']:12.0f}{100 * one['ours']:12.0f}" for name, one in commands.items()),
            f"{'contacts':26}{contacts['printed']:12}{contacts['ours']:12}",
        )
    )
