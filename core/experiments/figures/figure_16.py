"""Figure 16: the worst run's paths above, its absolute and average errors below, all other runs faintly behind."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from core.experiments.course_traces import Trace
from core.experiments.drives import DriveSurroundings
from core.experiments.figures.chart import SOFT, TEXT, Area, LegendEntry, SvgChart, legend, rounded_up, sheet
from core.message import Array

WIDTH, HEIGHT = 1240, 1024
LEFTS, ACROSS = (80, 690), 510  # [px] of the two columns
TOPS, DOWNS = (148, 668), (430, 290)  # [px] of the two rows
RIM = 0.5  # [m] around everything on the map
COLOURS = ("#c8671b", "#0b7fb0")  # dead reckoning, EKF-SLAM: as in the 3-D scene, darker for white paper
TRUTH = TEXT
START = np.zeros((1, 2))  # [m]: the world begins where the robot woke
PROBABLE = 2.4477  # standard deviations that hold 95 % in the plane
KEY_AT = (36, 98)  # [px]
FAINT = 160  # points that a faint line is drawn through
KEY = (
    LegendEntry("true path", TRUTH, 1.6, dash="6 4"),
    LegendEntry("worst run: path, error", COLOURS, 2.2),
    LegendEntry("its average error so far", TEXT, 2.4),
    LegendEntry("the paper’s average", SOFT, 1.4, dash="2 5"),
    LegendEntry("the other runs", COLOURS, 0.8, opacity=0.5),
    LegendEntry("corner or wall, true", SOFT, 1.4, form="cross"),
    LegendEntry("95 % region it believes", COLOURS, 1.2, form="ellipse"),
)


@dataclass(frozen=True)
class Panel:
    """One estimator's column."""

    title: str
    run: int
    runs: int
    trace: Trace
    others: list[tuple[Array, Array]]  # of every run that is drawn faintly: errors (2, M) and places (M, 2)
    printed: float  # [m], the paper's average error


def figure_16(panels: list[Panel], room: DriveSurroundings, subtitle: str) -> str:
    """Both columns and the room around → an SVG file."""
    parts = [legend(KEY_AT, KEY)]
    for number, panel in enumerate(panels):
        parts.append(_map(number, panel, room).svg(f"map{number}"))
        parts.append(_errors(number, panel).svg(f"errors{number}"))
    return sheet(WIDTH, HEIGHT, "Figure 16: dead reckoning and EKF-SLAM on the paper’s drive", subtitle, parts)


def _map(number: int, panel: Panel, room: DriveSurroundings) -> SvgChart:
    """Paths in the room."""
    area = Area(LEFTS[number], TOPS[0], ACROSS, DOWNS[0])
    chart = SvgChart(
        area, *_extent(np.vstack((room.corners, room.walls.reshape(-1, 2), START, panel.trace.truth)), area)
    )
    chart.scales("x [m]", "y [m]")
    colour, trace = COLOURS[number], panel.trace
    for ends in room.walls:
        chart.line(ends, SOFT, 1.4)
    for _, places in panel.others:
        chart.line(places[:: max(1, len(places) // FAINT)], colour, 0.8, opacity=0.16)
    for place in room.corners:
        chart.cross(place.tolist(), SOFT)
    for mark in trace.landmarks:
        chart.ellipse(mark.position, mark.covariance, colour, PROBABLE)
    chart.line(np.vstack((START, trace.truth)), TRUTH, 1.6, dash="6 4")
    chart.line(np.vstack((START, trace.places)), colour, 2.2)
    pose = trace.last.pose
    chart.ellipse(np.array([pose.x, pose.y]), trace.last.covariance[:2, :2], colour, PROBABLE)
    chart.dot(START[0].tolist(), TRUTH, hollow=True)
    chart.dot(trace.truth[-1].tolist(), TRUTH)
    chart.dot((pose.x, pose.y), colour)
    chart.word("start", START[0].tolist(), TRUTH, shift=(-8, -8), anchor="end")
    chart.title("ab"[number], panel.title, f"worst of {panel.runs} runs: run {panel.run}")
    return chart


def _errors(number: int, panel: Panel) -> SvgChart:
    """Errors over time."""
    trace, colour = panel.trace, COLOURS[number]
    top = rounded_up(max(float(trace.errors.max()), panel.printed))
    area = Area(LEFTS[number], TOPS[1], ACROSS, DOWNS[1])
    chart = SvgChart(area, (0.0, float(trace.times[-1])), (0.0, top))
    chart.scales("time [s]", "error of the place [m]")
    for errors, _ in panel.others:
        chart.line(errors.T[:: max(1, errors.shape[1] // FAINT)], colour, 0.8, opacity=0.16)
    average = np.cumsum(trace.errors) / np.arange(1, len(trace.errors) + 1)
    chart.line(np.column_stack((trace.times, trace.errors)), colour, 1.6)
    chart.line(np.column_stack((trace.times, average)), TEXT, 2.4)
    chart.line(np.array([[0.0, panel.printed], [trace.times[-1], panel.printed]]), SOFT, 1.4, dash="2 5")
    chart.title(
        "cd"[number], "Absolute and average error", f"average {trace.average:.3f} m, paper {panel.printed:g} m"
    )
    return chart


def _extent(points: Array, area: Area) -> tuple[tuple[float, float], tuple[float, float]]:
    """Points (N, 2) → rims in x and y that hold all of them, to one scale."""
    low, high = points.min(axis=0) - RIM, points.max(axis=0) + RIM
    scale = max((high[0] - low[0]) / area.width, (high[1] - low[1]) / area.height)
    middle = (low + high) / 2
    half = 0.5 * scale * np.array([area.width, area.height])
    (x0, y0), (x1, y1) = (middle - half).tolist(), (middle + half).tolist()
    return (x0, x1), (y0, y1)
