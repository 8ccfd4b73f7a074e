"""Figure 16 reproduced: the paper's drive 40 times with dead reckoning and with EKF-SLAM; the worst runs are drawn.

The filter of the figure is the paper's own form unless settings say otherwise; the other form runs too, on the
same draws. How good a worst run is depends on where the corners are first seen from: after two seconds at rest
(`still`) it errs by a quarter.
"""

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Literal, NotRequired, TypedDict

import numpy as np

from core.errors import BadInput
from core.experiments.drives import DrawnDrives, DriveSetup, LabDrives, drawn_drives, lab_drives
from core.experiments.figures.figure_16 import Panel, figure_16
from core.experiments.paper_course import Field, frozen
from core.experiments.plan import About, ChapterValue, ExperimentPlan, RunBatch
from core.experiments.result import ExperimentResult, FileContents, as_csv, stored
from core.message import Array, message
from core.recording import Ids
from core.settings import Settings

Through = Literal["drawn", "sensors"]
Drives = DrawnDrives | LabDrives  # by their number; the same number is always the same drive
MOST_RUNS = 100_000  # of a seed: beyond, the next seed begins
MAX_DRAWN_RUNS = 40  # runs drawn faintly behind the worst
PRINTED = {"dead_reckoning": (0.2, 0.06), "ekf_slam": (0.08, 0.025)}
"""The paper's worst average error [m], and what it is of the path ("more than")."""

ABOUT = About(
    title="Figure 16: dead reckoning against EKF-SLAM",
    reproduces="Figure 16: the chapter's drive; the laser's field of view, the corners' names given.",
    runs=40,
    counts="drives",
    base_s=1.7,
    run_s=0.8,
    chapter=tuple(
        ChapterValue(
            name=f"{title}, worst average error",
            value=PRINTED[name][0],
            unit="m",
            ours=f"estimators.{name}.worst_average_error_m",
        )
        for name, title in (("dead_reckoning", "Dead reckoning"), ("ekf_slam", "EKF-SLAM"))
    ),
    swept=(
        "estimators.ekf_slam.worst_average_error_m",
        "estimators.ekf_slam.mean_average_error_m",
        "estimators.ekf_slam.nees_mean",
        "estimators.dead_reckoning.mean_average_error_m",
    ),
)


@message
class DriveOutcome:
    """Figures of one run by estimator, and for the figure its errors."""

    average_error_m: dict[str, float]
    path_m: dict[str, float]
    final_error_m: dict[str, float]
    nees: dict[str, float]
    errors: dict[str, Array]  # times [s] and errors [m] as rows (2, M); empty for runs that are not drawn
    places: dict[str, Array]  # (M, 2) [m]


class EstimatorFigures(TypedDict):
    """The figures of one estimator over all runs, as JSON."""

    worst_average_error_m: float
    mean_average_error_m: float
    worst_run: int
    path_m: float  # of the worst run
    nees_mean: float
    worst_share_of_path: float
    mean_final_error_m: float
    paper_worst_average_error_m: NotRequired[float]
    paper_share_of_path: NotRequired[float]


class DriveComparison(ExperimentResult):
    """The result, as JSON."""

    runs: int
    setup: DriveSetup
    estimators: dict[str, EstimatorFigures]


def outcome(drives: Drives, number: int) -> DriveOutcome:
    """One run."""
    traces = drives.traces(number)
    drawn = {name: trace for name, trace in traces.items() if number < MAX_DRAWN_RUNS}
    return DriveOutcome(
        average_error_m={name: trace.average for name, trace in traces.items()},
        path_m={name: trace.path for name, trace in traces.items()},
        final_error_m={name: trace.final for name, trace in traces.items()},
        nees={name: trace.nees for name, trace in traces.items()},
        errors={name: np.stack((trace.times, trace.errors)) for name, trace in drawn.items()},
        places={name: trace.places for name, trace in drawn.items()},
    )


def plan(
    *,
    runs: int | None = None,
    seed: int = 0,
    settings: Settings | None = None,
    data: Path | None = None,
    noise: float | None = None,
    field: Field | None = None,
    still: bool = False,
    ids: Ids | None = None,
    through: Through = "drawn",
) -> ExperimentPlan:
    """Plan `runs` drives (40) → the worst and mean average error of each estimator, with figure and tables.

    `through`: sightings drawn about the true corners, or made out by the whole robot in `sim:lab`. Of drawn ones:
    `data`: frozen draws instead of the simulator; `noise`: all of eq. 43 times so much; `field`: what is seen of the
    room ("laser"); `still`: ten frames at rest first. Raises BadInput, Unavailable.
    """
    if through == "sensors":
        if data is not None or noise is not None or field is not None or still or ids is not None:
            raise BadInput(
                "Through its sensors the robot sees what it sees; leave out data, noise, field, still, ids."
            )
        drives, most = lab_drives(settings, seed), MOST_RUNS
    else:
        drives = drawn_drives(settings, seed, data, noise, field, still, ids or "given")
        most = MOST_RUNS if data is None else len(frozen(data).speeds)
    count = runs or min(ABOUT.runs, most)
    if count > most:
        raise BadInput(f"{data.name if data else 'The seed'} has {most} runs; {count} cannot be had from it.")
    batch = RunBatch(partial(outcome, drives), count, DriveOutcome)
    return ExperimentPlan((batch,), partial(_compared, drives, seed))


def _compared(drives: Drives, seed: int, out: Path | None, done: list[DriveOutcome]) -> DriveComparison:
    rows = drive_rows(drives, done)
    result: DriveComparison = {
        "runs": len(done),
        "seed": seed,
        "setup": drives.setup,
        "estimators": rows,
        "text": "\n".join(layout(rows, len(done))),
        "files": {},
    }
    table = {"csv": ("dead_reckoning_vs_slam.csv", as_csv(_table(done)))}
    return stored(result, out, "dead_reckoning_vs_slam", table, lambda: _figure(result, done, drives))


def drive_rows(drives: Drives, done: list[DriveOutcome]) -> dict[str, EstimatorFigures]:
    """The figures of every estimator over some runs of drives."""
    return {name: _row(name, done) for name in drives.rows}


def layout(rows: Mapping[str, EstimatorFigures], count: int) -> list[str]:
    """The table next to the paper's figures."""
    worst = f"worst of {count}"
    lines = [f"{'Average error':24}{worst:>14}{'mean':>10}{'of the path':>13}{'NEES':>8}{'paper':>10}"]
    for name, row in rows.items():
        ours = (row["worst_average_error_m"], row["mean_average_error_m"], 100 * row["worst_share_of_path"])
        paper = f"{row['paper_worst_average_error_m']:.2f} m" if "paper_worst_average_error_m" in row else ""
        line = (
            f"{TITLES[name]:24}{ours[0]:12.3f} m{ours[1]:8.3f} m{ours[2]:11.1f} %{row['nees_mean']:8.2f}{paper:>10}"
        )
        lines.append(line.rstrip())
    return lines


TITLES = {
    "dead_reckoning": "dead reckoning",
    "ekf_slam": "EKF-SLAM",
    "ekf_slam_paper": "  paper's form",
    "ekf_slam_invariant": "  right-invariant form",
}


def _figure(result: DriveComparison, done: list[DriveOutcome], drives: Drives) -> FileContents:
    """Figure 16. Raises Unavailable without matplotlib."""
    worst = {name: drives.traces(row["worst_run"])[name] for name, row in result["estimators"].items()}
    panels = [
        Panel(
            title=title,
            run=result["estimators"][name]["worst_run"],
            runs=result["runs"],
            trace=worst[name],
            others=[(each.errors[name], each.places[name]) for each in done if name in each.errors],
            printed=PRINTED[name][0],
        )
        for name, title in (("dead_reckoning", "Dead reckoning"), ("ekf_slam", "EKF-SLAM"))
    ]
    return {"figure_16": ("figure_16.svg", figure_16(panels, drives.room, drives.words))}


def _row(name: str, done: list[DriveOutcome]) -> EstimatorFigures:
    averages = np.array([one.average_error_m[name] for one in done])
    worst = int(averages.argmax())
    path = done[worst].path_m[name]
    row: EstimatorFigures = {
        "worst_average_error_m": float(averages.max()),
        "mean_average_error_m": float(averages.mean()),
        "worst_run": worst,
        "path_m": path,
        "nees_mean": float(np.nanmean([one.nees[name] for one in done])),
        "worst_share_of_path": float(averages.max()) / path,
        "mean_final_error_m": float(np.mean([one.final_error_m[name] for one in done])),
    }
    if name in PRINTED:
        row["paper_worst_average_error_m"], row["paper_share_of_path"] = PRINTED[name]
    return row


def _table(done: list[DriveOutcome]) -> list[dict[str, object]]:
    return [
        {
            "run": number,
            "estimator": name,
            "average_error_m": f"{one.average_error_m[name]:.6g}",
            "final_error_m": f"{one.final_error_m[name]:.6g}",
            "nees": f"{one.nees[name]:.6g}",
        }
        for number, one in enumerate(done)
        for name in one.average_error_m
    ]
