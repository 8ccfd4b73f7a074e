"""The chapter's own forms and ours, column by column, on the same drives and seeds through the whole robot.

Every column is one run of the experiment of its row under one value of `[chapter] mode`; the drives are those of
figure 16 in the simulated laboratory, with the camera's edges found in pictures and the paper's wheels.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Literal, TypedDict

from core.calibration.files.written import write_all
from core.experiments import dead_reckoning_vs_slam
from core.experiments.about import About
from core.experiments.drives import FIGURED, PLAIN
from core.experiments.result import ExperimentResult
from core.settings import Settings, as_printed

RUNS = 10

ABOUT = About(
    title="The chapter's forms and ours, side by side",
    reproduces="The drive of figure 16 through the whole simulated robot, by equations 14-40 as printed and by ours.",
    runs=RUNS,
    counts="drives in either form",
    base_s=0.0,
    run_s=0.0,
)
Column = Literal["printed", "ours"]


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


def of_column(column: Column) -> Settings:
    """The settings of a column; the wheels are the paper's in both."""
    plain = Settings()
    chosen = replace(
        plain,
        simulation=replace(plain.simulation, wheel_noise="paper"),
        motion=replace(plain.motion, model="paper"),
    )
    return as_printed(chosen) if column == "printed" else chosen


def run(
    *,
    runs: int | None = None,
    seed: int = 0,
    out: Path | None = None,
    tell: Callable[[str], None] | None = None,
    workers: int | None = None,
) -> PrintedAndOurs:
    """`runs` drives (10) in either mode. Raises Unwritable."""
    count = runs or RUNS
    columns: dict[Column, ColumnFigures] = {}
    dead = 0.0
    for column in ("printed", "ours"):
        drives = dead_reckoning_vs_slam.run(
            runs=count, seed=seed, tell=tell, settings=of_column(column), through="sensors", workers=workers
        )
        row, dead = drives["estimators"][FIGURED], drives["estimators"][PLAIN]["worst_average_error_m"]
        columns[column] = {
            "worst_average_error_m": row["worst_average_error_m"],
            "mean_average_error_m": row["mean_average_error_m"],
            "mean_final_error_m": row["mean_final_error_m"],
            "nees_mean": row["nees_mean"],
        }
    result: PrintedAndOurs = {
        "runs": count,
        "seed": seed,
        "dead_reckoning_worst_m": dead,
        "columns": columns,
        "text": table(columns, count),
        "files": {},
    }
    if out is not None:
        whole = json.dumps({key: value for key, value in result.items() if key != "files"}, indent=1)
        result["files"] = write_all(out, {"json": ("printed_and_ours.json", whole)})
    return result


def table(columns: dict[Column, ColumnFigures], count: int) -> str:
    """Figures down, modes across."""
    lines = [
        f"sim:lab, whole robot, the paper's wheels, {count} drives",
        f"{'':26}{'printed':>12}{'ours':>12}",
    ]
    printed, ours = columns["printed"], columns["ours"]
    pairs = (
        ("worst average error [m]", printed["worst_average_error_m"], ours["worst_average_error_m"]),
        ("mean average error [m]", printed["mean_average_error_m"], ours["mean_average_error_m"]),
        ("mean final error [m]", printed["mean_final_error_m"], ours["mean_final_error_m"]),
        ("NEES (ideal 3)", printed["nees_mean"], ours["nees_mean"]),
    )
    return "\n".join(lines + [f"{name:26}{one:12.3f}{other:12.3f}" for name, one, other in pairs])
