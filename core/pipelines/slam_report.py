"""The files an offline run leaves: trajectory (TUM), landmarks (CSV), map (Nav2, PNG), and its report (HTML)."""

import base64
import math
from collections.abc import Iterable
from dataclasses import fields
from html import escape
from pathlib import Path

import cv2
import numpy as np

from core.files import save_all
from core.geometry import Pose
from core.message import Array
from core.pipelines.nav2_map import map_pixels, nav2_map
from core.pipelines.report_document import document_html, table_html
from core.pipelines.slam_result import SlamResult
from core.settings import Settings
from core.slam.consistency import faded_band
from core.slam.ekf_slam import NIS_FADE
from core.slam.estimate import Landmark
from core.slam.map.occupancy import OccupancyGrid
from core.slam.map.status import ClosureStatus

MAX_POINTS = 3000  # of a line that is drawn
ELLIPSE_SIGMAS = 2.0
SPOT_M = 0.06  # radius of the ring at a landmark, whose ellipse may be too small to be seen
MARGIN_M = 0.5  # around everything in the map
CHART_WIDTH, CHART_HEIGHT = 860, 180  # [px]
CHART_LEFT, CHART_FOOT = 46, 22  # [px] for the numbers
MAX_ROWS = 200  # of a table


def trajectory_tum(stamps: Iterable[float], poses: Iterable[Pose]) -> str:
    """Stamps [s] and poses → lines `t tx ty tz qx qy qz qw`, eight columns, single spaces."""
    return "".join(
        f"{stamp:.6f} {pose.x:.6f} {pose.y:.6f} 0 0 0 "
        f"{math.sin(pose.heading / 2):.9f} {math.cos(pose.heading / 2):.9f}\n"
        for stamp, pose in zip(stamps, poses, strict=True)
    )


def landmarks_csv(landmarks: Iterable[Landmark]) -> str:
    """The table of landmarks, one a line."""
    lines = ["id,x_m,y_m,var_x_m2,cov_xy_m2,var_y_m2,hits,misses,kind"]
    for mark in landmarks:
        (x, y), ((xx, xy), (_, yy)) = mark.position.tolist(), mark.covariance.tolist()
        lines.append(f"{mark.id},{x:.6f},{y:.6f},{xx:.9g},{xy:.9g},{yy:.9g},{mark.hits},{mark.misses},{mark.kind}")
    return "\n".join(lines) + "\n"


def save(folder: Path, run: SlamResult, settings: Settings) -> dict[str, str | None]:
    """Write everything into `folder` → what lies where; without a grid there is no map. Raises Unwritable."""
    contents: dict[str, tuple[str, bytes]] = {
        "trajectory_tum": ("trajectory.tum", trajectory_tum(run.stamps, run.poses).encode()),
        "landmarks_csv": ("landmarks.csv", landmarks_csv(run.landmarks).encode()),
        "report_html": ("report.html", report_html(run, settings).encode()),
    }
    if run.grid is not None:
        text, picture = nav2_map(run.grid)
        contents |= {
            "map_yaml": ("map.yaml", text.encode()),
            "map_pgm": ("map.pgm", picture),
            "map_png": ("map.png", map_png(run.grid)),
        }
    return {"map_yaml": None, **save_all(folder, contents)}


def map_png(grid: OccupancyGrid) -> bytes:
    """A grid as a PNG with the grey values of Nav2's map, the highest y at the top."""
    return cv2.imencode(".png", map_pixels(grid))[1].tobytes()


def report_html(run: SlamResult, settings: Settings) -> str:
    """The report: one HTML file with everything in it, to be read without a network."""
    seconds = np.asarray(run.stamps) - run.stamps[0]
    low, high = faded_band(NIS_FADE)
    parts = [
        table_html(("", ""), _facts(run)),
        *(f"<p>{escape(one)}</p>" for one in run.report.warnings),
        "<h2>Trajectory and map</h2>",
        _map(run),
        '<p class="faint">Blue: the way. Green: landmarks with their ellipses of two standard deviations. '
        "Orange: places that were recognised; dashed where that was taken back.</p>",
        "<h2>Consistency (NIS)</h2>",
        _chart(seconds, run.course.nis, "", band=(low, high)),
        '<p class="faint">Normalised innovation squared per degree of freedom, running mean: 1 is ideal. In the band '
        "it lies for 95 % of the time where the filter is as sure as it should be; above, it is surer.</p>",
        "<h2>Standard deviation of the position</h2>",
        _chart(seconds, run.course.position_sd, "m"),
        "<h2>Loop closures</h2>",
        _closures(run),
        "<h2>Processing time</h2>",
        _chart(seconds, run.course.step_ms, "ms"),
        _timing(run.course.step_ms),
        "<h2>Settings</h2>",
        *_settings(settings),
    ]
    return document_html(run.recording.path.name, parts)


def _facts(run: SlamResult) -> list[tuple[str, str]]:
    return [
        ("form", f"{run.report.form}: {', '.join(run.report.topics)}".rstrip(": ")),
        ("readings", f"{len(run.poses)} over {run.stamps[-1] - run.stamps[0]:.1f} s"),
        ("records skipped", str(run.report.skipped)),
        ("odometry", "yes" if run.recording.has_wheels else "no"),
        ("path", f"{run.path:.2f} m"),
        ("landmarks", str(len(run.landmarks))),
    ]


def _map(run: SlamResult) -> str:
    """The map from above, y up, in metres."""
    way = np.array([(pose.x, pose.y) for pose in run.poses])
    places = np.concatenate([way, *(mark.position[None] for mark in run.landmarks)])
    low, high = places.min(axis=0) - MARGIN_M, places.max(axis=0) + MARGIN_M
    inside: list[str] = []
    if run.grid is not None and (run.grid.log_odds != 0).any():
        known = np.argwhere(run.grid.log_odds != 0)[:, ::-1] * run.grid.resolution + run.grid.origin
        low, high = np.minimum(low, known.min(axis=0)), np.maximum(high, known.max(axis=0))
        inside.append(_map_image(run.grid))
    inside += [_ellipse(mark) for mark in run.landmarks]
    inside += [_closure_line(one) for one in run.course.closures]
    inside.append(f'<polyline class="way" points="{_points(way * [1, -1])}"/>')
    width, height = high - low
    box = f"{low[0]:.3f} {-high[1]:.3f} {width:.3f} {height:.3f}"
    return f'<svg viewBox="{box}" role="img" aria-label="map">{"".join(inside)}</svg>'


def _map_image(grid: OccupancyGrid) -> str:
    x, y = grid.origin.tolist()
    rows, columns = grid.log_odds.shape
    width, height = columns * grid.resolution, rows * grid.resolution
    content = base64.b64encode(map_png(grid)).decode()
    return (
        f'<image class="map" x="{x:.3f}" y="{-y - height:.3f}" width="{width:.3f}" height="{height:.3f}" '
        f'href="data:image/png;base64,{content}"/>'
    )


def _ellipse(mark: Landmark) -> str:
    values, vectors = np.linalg.eigh(mark.covariance)
    across, along = (ELLIPSE_SIGMAS * np.sqrt(np.maximum(values, 0))).tolist()
    x, y = mark.position.tolist()
    turned = -math.degrees(math.atan2(vectors[1, 1], vectors[0, 1]))
    spot = f'<circle class="spot" cx="{x:.3f}" cy="{-y:.3f}" r="{SPOT_M}"/>'
    title = f"<title>{mark.id}: {x:.2f}, {y:.2f} m, seen {mark.hits} times</title>"
    return (
        f'{spot}<ellipse class="mark" rx="{along:.4f}" ry="{across:.4f}" '
        f'transform="translate({x:.3f} {-y:.3f}) rotate({turned:.1f})">{title}</ellipse>'
    )


def _closure_line(one: ClosureStatus) -> str:
    (x1, y1), (x2, y2) = one.position_from.tolist(), one.position_to.tolist()
    undone = "" if one.state == "accepted" else " undone"
    return f'<line class="loop{undone}" x1="{x1:.3f}" y1="{-y1:.3f}" x2="{x2:.3f}" y2="{-y2:.3f}"/>'


def _chart(seconds: Array, values: Array, unit: str, band: tuple[float, float] | None = None) -> str:
    """Values (N,) over the time (N,) [s] as a line; `band`: from and to, what is usual."""
    known = np.isfinite(values)
    if not known.any():
        return "<p>Nothing was measured.</p>"
    top = max(float(values[known].max()), 0.0 if band is None else band[1]) * 1.05 or 1.0
    end = max(float(seconds[-1]), 1e-9)
    across, down = CHART_WIDTH - CHART_LEFT, CHART_HEIGHT - CHART_FOOT
    points = np.column_stack([CHART_LEFT + across * seconds[known] / end, down * (1 - values[known] / top)])
    inside = [f'<line class="axis" x1="{CHART_LEFT}" y1="{down}" x2="{CHART_WIDTH}" y2="{down}"/>']
    if band is not None:
        high, low = (down * (1 - edge / top) for edge in reversed(band))
        box = f'x="{CHART_LEFT}" y="{high:.1f}" width="{across}" height="{low - high:.1f}"'
        inside.append(f'<rect class="band" {box}/>')
    inside += [
        f'<polyline class="way" points="{_points(points)}"/>',
        f'<text x="0" y="10">{top:.3g} {unit}</text><text x="0" y="{down}">0</text>',
        f'<text x="{CHART_LEFT}" y="{CHART_HEIGHT - 6}">0 s</text>',
        f'<text x="{CHART_WIDTH}" y="{CHART_HEIGHT - 6}" text-anchor="end">{end:.0f} s</text>',
    ]
    return f'<svg viewBox="0 0 {CHART_WIDTH} {CHART_HEIGHT}" role="img">{"".join(inside)}</svg>'


def _points(line: Array) -> str:
    """A line (N, 2) as SVG has it, thinned."""
    thin = line[:: max(1, math.ceil(len(line) / MAX_POINTS))]
    return " ".join(f"{x:.3f},{y:.3f}" for x, y in thin.tolist())


def _closures(run: SlamResult) -> str:
    if not run.course.closures:
        return "<p>No place was recognised again.</p>"
    rows = [
        (f"{one.stamp - run.stamps[0]:.1f} s", f"{one.submap_from} → {one.submap_to}", f"{one.score:.2f}", one.state)
        for one in run.course.closures[:MAX_ROWS]
    ]
    return table_html(("time", "rooms", "score", "state"), rows)


def _timing(step_ms: Array) -> str:
    shares = [(f"{share} %", f"{np.percentile(step_ms, share):.2f} ms") for share in (50, 90, 99, 100)]
    return table_html(("of all readings took at most", ""), [*shares, ("together", f"{step_ms.sum() / 1e3:.2f} s")])


def _settings(settings: Settings) -> Iterable[str]:
    usual, changed, every = Settings(), list[tuple[str, str]](), list[tuple[str, str]]()
    for section in fields(settings):
        values, defaults = getattr(settings, section.name), getattr(usual, section.name)
        for one in fields(values):
            row = f"{section.name}.{one.name}", str(getattr(values, one.name))
            every.append(row)
            if getattr(values, one.name) != getattr(defaults, one.name):
                changed.append((row[0], f"{row[1]} (else {getattr(defaults, one.name)})"))
    yield table_html(("changed", "value"), changed) if changed else "<p>All settings are the defaults.</p>"
    yield f"<details><summary>All settings</summary>{table_html(('setting', 'value'), every)}</details>"
