"""Figure 16 reproduced: the paper's drive 40 times with dead reckoning and with EKF-SLAM; the worst runs are drawn.

The filter of the figure is the paper's own form unless settings say otherwise; the other form runs too, on the
same draws. How good a worst run is depends on where the corners are first seen from: after two seconds at rest
(`still`) it errs by a quarter.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NotRequired, TypedDict

import numpy as np

from core.errors import BadInput
from core.experiments.drawing import SOFT, TEXT, render
from core.experiments.drives import (
    PATH_LENGTH_M,
    DrawnDrives,
    DriveSetup,
    DriveSurroundings,
    LabDrives,
    drawn_drives,
    lab_drives,
)
from core.experiments.paper_course import Field, Trace, frozen
from core.experiments.plan import About, ChapterValue, ExperimentPlan, RunBatch
from core.experiments.result import ExperimentResult, FileContents, as_csv, stored
from core.message import Array, message
from core.recording import Ids
from core.settings import Settings

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Through = Literal["drawn", "sensors"]
Drives = DrawnDrives | LabDrives  # by their number; the same number is always the same drive
MOST_RUNS = 100_000  # of a seed: beyond, the next seed begins
WHOLE_PATH_SHARE = 0.99  # of the path, below which a drive broke off
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
SIZE_PX = (1240, 1040)  # [px]
MAP_MARGIN_M = 0.5  # around everything on the map
ESTIMATOR_COLOURS = ("#c8671b", "#0b7fb0")  # dead reckoning, EKF-SLAM: as in the 3-D scene, darker for white paper
START = np.zeros((1, 2))  # [m]: the world begins where the robot woke
CONFIDENCE_SDS = 2.4477  # standard deviations that hold 95 % in the plane
MAX_FAINT_POINTS = 160  # of a faint line
FAINT_OPACITY = 0.16  # opacity of a run that is not the worst
TRUTH_STYLE: dict[str, Any] = {"color": TEXT, "linewidth": 1.6, "linestyle": (0, (6, 4))}
AVERAGE_STYLE: dict[str, Any] = {"color": TEXT, "linewidth": 2.2}
PAPER_STYLE: dict[str, Any] = {"color": SOFT, "linewidth": 1.4, "linestyle": (0, (2, 3))}
MARK_STYLE: dict[str, Any] = {"color": SOFT, "linewidth": 0, "marker": "x", "markersize": 7, "markeredgewidth": 1.4}


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
    short_drives: NotRequired[int]  # that broke off before their end, where there are any


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
    short = sum(min(one.path_m.values()) < WHOLE_PATH_SHARE * PATH_LENGTH_M for one in done)
    if short:
        result["short_drives"] = short
        result["text"] += f"\nOf the drives {short} ended before {PATH_LENGTH_M:g} m; they count as they are."
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


@dataclass(frozen=True)
class Panel:
    """One estimator's column."""

    title: str
    run: int
    runs: int
    trace: Trace
    others: list[tuple[Array, Array]]  # of every run that is drawn faintly: errors (2, M) and places (M, 2)
    printed: float  # [m], the paper's average error


def figure_16(panels: list[Panel], room: DriveSurroundings, conditions: str) -> bytes:
    """Both columns and the room around → an SVG file. Raises Unavailable without matplotlib."""

    def draw(figure: Figure) -> None:
        grid = figure.add_gridspec(3, 2, height_ratios=(0.1, 1.45, 1))
        _add_legend(figure.add_subplot(grid[0, :]), bool(len(room.walls)))
        for column, (panel, colour) in enumerate(zip(panels, ESTIMATOR_COLOURS, strict=True)):
            paths, errors = (figure.add_subplot(grid[row, column]) for row in (1, 2))
            _draw_paths(paths, panel, room, colour)
            _draw_errors(errors, panel, colour)
            _name(paths, "ab"[column], panel.title, f"worst of {panel.runs} runs: run {panel.run}")
            summary = f"average {panel.trace.average:.3f} m, paper {panel.printed:g} m"
            _name(errors, "cd"[column], "Absolute and average error", summary)

    return render("svg", SIZE_PX, "Figure 16: dead reckoning and EKF-SLAM on the paper’s drive", conditions, draw)


def _name(axes: Axes, letter: str, title: str, summary: str) -> None:
    axes.set_title(f"({letter}) {title}", loc="left", fontweight="bold")
    axes.set_title(summary, loc="right", fontsize=9.5, color=SOFT)


def _draw_paths(axes: Axes, panel: Panel, room: DriveSurroundings, colour: str) -> None:
    """Paths in the room, to one scale."""
    trace, pose = panel.trace, panel.trace.last.pose
    for ends in room.walls:
        axes.plot(*ends.T, color=SOFT, linewidth=1.4)
    for _, places in panel.others:
        axes.plot(*_thinned(places).T, color=colour, linewidth=0.8, alpha=FAINT_OPACITY)
    axes.plot(*room.corners.T, **MARK_STYLE)
    for mark in trace.landmarks:
        _add_ellipse(axes, mark.position, mark.covariance, colour)
    axes.plot(*np.vstack((START, trace.places)).T, color=colour, linewidth=2.2)
    axes.plot(*np.vstack((START, trace.truth)).T, **TRUTH_STYLE)
    _add_ellipse(axes, np.array([pose.x, pose.y]), trace.last.covariance[:2, :2], colour)
    axes.plot(*START.T, marker="o", color=TEXT, markerfacecolor="white")
    axes.plot(*trace.truth[-1:].T, marker="o", color=TEXT)
    axes.plot(pose.x, pose.y, marker="o", color=colour)
    axes.annotate("start", START[0].tolist(), (-8, 8), textcoords="offset points", ha="right", fontweight="bold")
    shown = np.vstack((room.corners, room.walls.reshape(-1, 2), START, trace.truth))
    low, high = shown.min(axis=0) - MAP_MARGIN_M, shown.max(axis=0) + MAP_MARGIN_M
    axes.set(xlabel="x [m]", ylabel="y [m]", xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    axes.set_aspect("equal", adjustable="box")


def _draw_errors(axes: Axes, panel: Panel, colour: str) -> None:
    trace = panel.trace
    for errors, _ in panel.others:
        axes.plot(*_thinned(errors.T).T, color=colour, linewidth=0.8, alpha=FAINT_OPACITY)
    average = np.cumsum(trace.errors) / np.arange(1, len(trace.errors) + 1)
    axes.plot(trace.times, trace.errors, color=colour, linewidth=1.6)
    axes.plot(trace.times, average, **AVERAGE_STYLE)
    axes.axhline(panel.printed, **PAPER_STYLE)
    top = 1.05 * max(
        panel.printed, *(float(each.max()) for each in (trace.errors, *(row[1] for row, _ in panel.others)))
    )
    axes.set(xlabel="time [s]", ylabel="position error [m]", xlim=(0, float(trace.times[-1])), ylim=(0, top))


def _add_ellipse(axes: Axes, middle: Array, covariance: Array, colour: str) -> None:
    """Around a point (2,) [m]: the 95 % region of a covariance (2, 2) [m²]."""
    from matplotlib.patches import Ellipse

    values, vectors = np.linalg.eigh(covariance)
    width, height = (2 * CONFIDENCE_SDS * np.sqrt(np.maximum(values, 0.0))).tolist()
    angle = math.degrees(math.atan2(vectors[1, 0], vectors[0, 0]))
    centre = (float(middle[0]), float(middle[1]))
    axes.add_patch(
        Ellipse(centre, width, height, angle=angle, edgecolor=colour, facecolor=f"{colour}20", linewidth=1.2)
    )


def _add_legend(axes: Axes, walls: bool) -> None:
    from matplotlib.legend_handler import HandlerTuple
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    def both(width: float, opacity: float = 1.0) -> tuple[Line2D, ...]:
        return tuple(Line2D([], [], color=colour, linewidth=width, alpha=opacity) for colour in ESTIMATOR_COLOURS)

    entries = {
        "true path": Line2D([], [], **TRUTH_STYLE),
        "worst run: path, error": both(2.2),
        "its average error so far": Line2D([], [], **AVERAGE_STYLE),
        "average error in the paper": Line2D([], [], **PAPER_STYLE),
        "other runs": both(0.8, 3 * FAINT_OPACITY),
        "true corner": Line2D([], [], **MARK_STYLE),
        "95 % confidence region": tuple(
            Patch(edgecolor=colour, facecolor=f"{colour}20") for colour in ESTIMATOR_COLOURS
        ),
    }
    if walls:
        entries["wall"] = Line2D([], [], color=SOFT, linewidth=1.4)
    axes.set_axis_off()
    axes.legend(
        entries.values(),
        entries.keys(),
        loc="center",
        ncols=4,
        labelcolor=SOFT,
        handler_map={tuple: HandlerTuple(ndivide=None)},
        handlelength=3,
    )


def _thinned(points: Array) -> Array:
    """Of points (N, 2) about `MAX_FAINT_POINTS`."""
    return points[:: max(1, len(points) // MAX_FAINT_POINTS)]
