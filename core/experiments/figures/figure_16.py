"""Figure 16: the worst run's paths above, its absolute and average errors below, all other runs faintly behind."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from core.experiments.drives import DriveSurroundings
from core.experiments.figures.drawing import SOFT, TEXT, render
from core.experiments.paper_course import Trace
from core.message import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SIZE_PX = (1240, 1040)  # [px]
MAP_MARGIN_M = 0.5  # around everything on the map
COLOURS = ("#c8671b", "#0b7fb0")  # dead reckoning, EKF-SLAM: as in the 3-D scene, darker for white paper
START = np.zeros((1, 2))  # [m]: the world begins where the robot woke
CONFIDENCE_SDS = 2.4477  # standard deviations that hold 95 % in the plane
MAX_FAINT_POINTS = 160  # of a faint line
FAINT_OPACITY = 0.16  # opacity of a run that is not the worst
TRUTH_STYLE: dict[str, Any] = {"color": TEXT, "linewidth": 1.6, "linestyle": (0, (6, 4))}
AVERAGE_STYLE: dict[str, Any] = {"color": TEXT, "linewidth": 2.2}
PAPER_STYLE: dict[str, Any] = {"color": SOFT, "linewidth": 1.4, "linestyle": (0, (2, 3))}
MARK_STYLE: dict[str, Any] = {"color": SOFT, "linewidth": 0, "marker": "x", "markersize": 7, "markeredgewidth": 1.4}


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
        for column, (panel, colour) in enumerate(zip(panels, COLOURS, strict=True)):
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
        return tuple(Line2D([], [], color=colour, linewidth=width, alpha=opacity) for colour in COLOURS)

    entries = {
        "true path": Line2D([], [], **TRUTH_STYLE),
        "worst run: path, error": both(2.2),
        "its average error so far": Line2D([], [], **AVERAGE_STYLE),
        "average error in the paper": Line2D([], [], **PAPER_STYLE),
        "other runs": both(0.8, 3 * FAINT_OPACITY),
        "true corner": Line2D([], [], **MARK_STYLE),
        "95 % confidence region": tuple(Patch(edgecolor=colour, facecolor=f"{colour}20") for colour in COLOURS),
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
