"""Reports of a map, a drive, a calibration, an experiment: one HTML file each, read and printed without a network."""

import asyncio
import math
import re
import time
from collections.abc import Iterator
from dataclasses import replace
from html import escape
from typing import Annotated, cast

import numpy as np
from fastapi import Path, Response

from console.access.roles import needs
from console.api import CalibrationSessions, HistoryInUse, SavedMaps, part, router, sends_file
from console.api.experiments import FIGURES
from console.experiments.runs import ExperimentRun, ExperimentRuns
from console.http.downloads import file_named
from console.http.problems import Problem
from console.maps.plan import plan_svg
from console.maps.service import MapService
from console.maps.trajectory import laid_out
from console.messages.calibration import CalibrationKind
from core.message import Array
from core.pipelines.report_document import document_html, picture_html, table_html

reports = router("reports", 404, 409, 503)

MEDIA_TYPE = "text/html"
SVG_TYPE = "image/svg+xml"
MAX_LISTED = 500  # rows of a table
DAY = len("2026-11-30")
MINUS = re.compile(r"(?<!\S)-(?=\d)")  # of a number, as it is typed
STATE_WORDS = {"pre-empted": "replaced"}  # as the page says it


@reports.get("/reports/map", **sends_file(MEDIA_TYPE))
@needs("viewer")
async def map_report(maps: SavedMaps) -> Response:
    """The map in use: its plan, what it is made of, places, zones and landmarks."""
    return sent(await asyncio.to_thread(map_document, maps), maps.shown.name or "map")


@reports.get("/reports/drive", **sends_file(MEDIA_TYPE))
@needs("viewer")
async def drive_report(maps: SavedMaps, history: HistoryInUse) -> Response:
    """The drive so far: the way on the plan, its length and time, and every command with its end."""
    begun, kept = maps.trajectory.begun, history.newest_first(commands_only=False, limit=MAX_LISTED)
    listed = [entry for entry in reversed(kept) if entry.what == "command" and entry.wall >= begun]
    today = {clock(time.time())[:DAY]} >= {clock(entry.wall)[:DAY] for entry in listed}  # the title has the day
    rows = [
        (
            clock(entry.wall)[DAY + 1 if today else 0 :],
            MINUS.sub("−", entry.heard_as or entry.words),
            entry.who,
            STATE_WORDS.get(entry.state, entry.state),
            entry.remark,
        )
        for entry in listed
    ]
    whole = len(kept) < MAX_LISTED or kept[-1].wall < begun
    return sent(await asyncio.to_thread(lambda: drive_document(maps, rows, whole=whole)), "drive")


@reports.get("/reports/calibration/{kind}", **sends_file(MEDIA_TYPE))
@needs("viewer")
async def calibration_report(kind: CalibrationKind, calibrations: CalibrationSessions) -> Response:
    """The accepted calibration of the camera or of the laser: its numbers with what is known of their errors."""
    found = calibrations.used()[kind]
    if found is None:
        raise Problem(404, f"No calibration of the {kind} was accepted yet.")
    title, accepted_s = f"Calibration of the {kind}", found["accepted_s"]
    accepted = {} if accepted_s is None else {"accepted": clock(accepted_s)}
    shown = {**{name: value for name, value in found.items() if name != "accepted_s"}, **accepted}
    return sent(document_html(title, [table_html(("", ""), flat(shown))]), f"calibration-{kind}")


@reports.get("/reports/experiments/{id}", **sends_file(MEDIA_TYPE))
@needs("viewer")
async def experiment_report(
    id: Annotated[str, Path(max_length=40)], kept: Annotated[ExperimentRuns, part(ExperimentRuns)]
) -> Response:
    """One run of an experiment: its figures beside the chapter's, its pictures and its text."""
    run = kept.find(id)
    return sent(await asyncio.to_thread(lambda: experiment_document(run, kept)), f"experiment-{run.entry.name}")


def sent(document: str, name: str) -> Response:
    return file_named(document.encode(), f"report-{name}.html", MEDIA_TYPE)


def clock(seconds: float) -> str:
    """Unix time [s] as day and time of this computer."""
    return time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(seconds))


def lasting(seconds: float) -> str:
    """A time [s] in words: "42 s", "9 min 35 s", "2 h 5 min"."""
    hours, minutes, rest = round(seconds) // 3600, round(seconds) // 60 % 60, round(seconds) % 60
    return f"{hours} h {minutes} min" if hours else f"{minutes} min {rest} s" if minutes else f"{rest} s"


def metres(value: float) -> str:
    """A coordinate [m] in words, with the minus sign of the page."""
    return f"{value:.2f} m".replace("-", "−")


def map_document(maps: MapService) -> str:
    """Raises BadInput where nothing is known yet."""
    snapshot, plan = maps.snapshot, maps.plan
    facts = [
        ("made", clock(time.time())),
        ("submaps", str(len(snapshot.floor.submaps))),
        ("landmarks", str(len(snapshot.landmarks))),
    ]
    parts = [table_html(("", ""), facts), picture_html(plan_svg(plan), SVG_TYPE, "The plan")]
    if plan.places:
        rows = [(place.name, metres(place.x_m), metres(place.y_m)) for place in plan.places]
        parts += ["<h2>Places</h2>", table_html(("place", "x", "y"), rows)]
    if plan.zones:
        rows = [(one.name, f"at most {one.max_speed:g} m/s" if one.max_speed else "keep out") for one in plan.zones]
        parts += ["<h2>Zones</h2>", table_html(("zone", "rule"), rows)]
    rows = [
        (str(one.id), metres(one.position[0]), metres(one.position[1]), f"{deviation(one.covariance):.3f} m")
        for one in snapshot.landmarks[:MAX_LISTED]
    ]
    parts += ["<h2>Landmarks</h2>", table_html(("number", "x", "y", "standard deviation"), rows)]
    return document_html(maps.title, parts)


def deviation(covariance: Array) -> float:
    """Covariance (2, 2) [m²] → standard deviation of the weaker direction [m]."""
    return math.sqrt(max(0.0, float(np.linalg.eigvalsh(covariance)[-1])))


def drive_document(maps: MapService, commands: list[tuple[str, str, str, str, str]], *, whole: bool) -> str:
    """The way on the plan, and the commands, `whole`: all of them. Raises BadInput where nothing is known yet."""
    stamps, poses = laid_out(maps.trajectory.rows(), maps.snapshot.floor)
    way = np.array([(pose.x, pose.y) for pose in poses]).reshape(-1, 2)
    length = float(np.hypot(*np.diff(way, axis=0).T).sum()) if len(way) > 1 else 0.0
    title = f"Drive: {maps.title}"
    facts = [
        ("made", clock(time.time())),
        ("length of the way", f"{length:.2f} m"),
        ("time", lasting(stamps[-1] - stamps[0] if stamps else 0.0)),
        ("commands", str(len(commands)) if whole else f"the newest {len(commands)}"),
    ]
    head = ("time", "command", "by", "end", "remark")
    return document_html(
        title,
        [
            table_html(("", ""), facts),
            picture_html(plan_svg(replace(maps.plan, way=way)), SVG_TYPE, "The way on the map"),
            "<h2>Commands</h2>",
            table_html(head, commands) if commands else "<p>No command was given.</p>",
        ],
    )


def experiment_document(run: ExperimentRun, kept: ExperimentRuns) -> str:
    shown = run.shown
    facts = [
        ("run by", f"{shown.who}, {clock(shown.at_s)}"),
        ("runs", str(shown.runs)),
        ("seed", str(shown.seed)),
        ("end", " ".join((shown.state, shown.reason)).strip()),
        ("took", lasting(shown.took_s)),
    ]
    parts = [table_html(("", ""), facts)]
    if shown.compared:
        rows = [
            (one.name, f"{one.chapter:g} {one.unit}", "–" if one.ours is None else f"{one.ours:.4g} {one.unit}")
            for one in shown.compared
        ]
        parts.append(table_html(("figure", "the chapter", "here"), rows))
    for one in shown.files:
        path = kept.file(run, one.name)
        if (kind := FIGURES.get(path.suffix)) is not None:
            parts.append(picture_html(path.read_bytes(), kind, path.stem.replace("_", " ")))
    if shown.text:
        parts.append(f"<pre>{escape(shown.text)}</pre>")
    return document_html(shown.title, parts)


def flat(document: object, name: str = "") -> Iterator[tuple[str, str]]:
    """Yield every value of nested tables under the names that lead to it."""
    if isinstance(document, dict):
        for key, value in cast("dict[str, object]", document).items():
            yield from flat(value, f"{name}.{key}" if name else key)
    elif isinstance(document, list):
        values = cast("list[object]", document)
        if any(isinstance(value, dict) for value in values):
            for number, value in enumerate(values[:MAX_LISTED]):
                yield from flat(value, f"{name}.{number}")
        else:
            yield name, ", ".join(plain(value) for value in values[:MAX_LISTED])
    else:
        yield name, plain(document)


def plain(value: object) -> str:
    """A value as text, a number with six digits."""
    return f"{value:.6g}" if isinstance(value, float) else str(value)
