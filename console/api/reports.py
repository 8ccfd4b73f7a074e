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
from console.api import CalibrationSessions, HistoryInUse, SavedMaps, Texts, part, router, sends_file
from console.api.experiments import FIGURES
from console.calibration.answers import Document
from console.experiments.runs import ExperimentRun, ExperimentRuns
from console.http.downloads import file_named
from console.http.problems import Problem
from console.maps.plan import plan_svg
from console.maps.service import MapService
from console.maps.trajectory import laid_out
from console.messages.calibration import CalibrationKind
from core.message import Array
from core.pipelines.report_document import document_html, picture_html, table_html
from core.sentences import PageTexts

reports = router("reports", 404, 409, 503)

MEDIA_TYPE = "text/html"
SVG_TYPE = "image/svg+xml"
MAX_LISTED = 500  # rows of a table
DAY = len("2026-11-30")
MINUS = re.compile(r"(?<!\S)-(?=\d)")  # of a number, as it is typed
CAMERA_LABELS = {  # numbers of a camera, as the page names them
    "fx": "figures.focal_length_across",
    "fy": "figures.focal_length_down",
    "cx": "figures.centre_across",
    "cy": "figures.centre_down",
    "k1": "figures.radial_square",
    "k2": "figures.radial_4th_power",
    "p1": "figures.tangential",
    "p2": "figures.tangential",
    "k3": "figures.radial_6th_power",
}
MOUNT_LABELS = {  # … and of a mount: three turns, three shifts
    "roll": "figures.turned_about_the_line_of_sight",
    "pitch": "figures.looking_up_or_down",
    "yaw": "figures.looking_left_or_right",
    "forward": "figures.in_front_of_the_laser",
    "sideways": "figures.to_the_left_of_the_laser",
    "height": "figures.above_the_laser",
}
MAX_DECIMALS = 5  # of a number of a calibration


@reports.get("/reports/map", **sends_file(MEDIA_TYPE))
@needs("viewer")
async def map_report(maps: SavedMaps, texts: Texts) -> Response:
    """The map in use: its plan, what it is made of, places, zones and landmarks."""
    return sent(await asyncio.to_thread(map_document, maps, texts), maps.shown.name or "map")


@reports.get("/reports/drive", **sends_file(MEDIA_TYPE))
@needs("viewer")
async def drive_report(maps: SavedMaps, history: HistoryInUse, texts: Texts) -> Response:
    """The drive so far: the way on the plan, its length and time, and every command with its end."""
    begun, kept = maps.trajectory.begun, history.newest_first(commands_only=False, limit=MAX_LISTED)
    listed = [entry for entry in reversed(kept) if entry.what == "command" and entry.wall >= begun]
    today = {clock(time.time())[:DAY]} >= {clock(entry.wall)[:DAY] for entry in listed}  # the title has the day
    rows = [
        (
            clock(entry.wall)[DAY + 1 if today else 0 :],
            MINUS.sub("−", entry.heard_as or entry.words),
            entry.who,
            texts.t(f"state.{entry.state}"),
            texts.said(entry.remark),
        )
        for entry in listed
    ]
    whole = len(kept) < MAX_LISTED or kept[-1].wall < begun
    return sent(await asyncio.to_thread(lambda: drive_document(maps, rows, texts, whole=whole)), "drive")


@reports.get("/reports/calibration/{kind}", **sends_file(MEDIA_TYPE))
@needs("viewer")
async def calibration_report(kind: CalibrationKind, calibrations: CalibrationSessions, texts: Texts) -> Response:
    """The accepted calibration of the camera or of the laser: its numbers with what is known of their errors."""
    found = calibrations.used()[kind]
    if found is None:
        raise Problem(404, f"No calibration of the {kind} was accepted yet.")
    return sent(calibration_document(kind, found, texts), f"calibration-{kind}")


@reports.get("/reports/experiments/{id}", **sends_file(MEDIA_TYPE))
@needs("viewer")
async def experiment_report(
    id: Annotated[str, Path(max_length=40)], kept: Annotated[ExperimentRuns, part(ExperimentRuns)], texts: Texts
) -> Response:
    """One run of an experiment: its figures beside the chapter's, its pictures and its text."""
    run = kept.find(id)
    return sent(
        await asyncio.to_thread(lambda: experiment_document(run, kept, texts)), f"experiment-{run.entry.name}"
    )


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
    return f"{value:.2f}\N{NO-BREAK SPACE}m".replace("-", "−")


def map_document(maps: MapService, texts: PageTexts) -> str:
    """Raises BadInput where nothing is known yet."""
    t, snapshot, plan = texts.t, maps.snapshot, maps.plan_in(texts)
    facts = [
        (t("report.made"), clock(time.time())),
        (t("report.rooms"), str(len(snapshot.floor.submaps))),
        (t("map-card.landmarks"), str(len(snapshot.landmarks))),
    ]
    parts = [table_html(("", ""), facts), picture_html(plan_svg(plan), SVG_TYPE, t("map-card.plan"))]
    if plan.places:
        rows = [(place.name, metres(place.x_m), metres(place.y_m)) for place in plan.places]
        parts += headed(t("place-list.places"), table_html((t("zone-sheet.name"), "x", "y"), rows))
    if plan.zones:
        rows = [
            (one.name, t("report.slow", speed=f"{one.max_speed:g}") if one.max_speed else t("report.keep_out"))
            for one in plan.zones
        ]
        parts += headed(t("place-list.zones"), table_html((t("zone-sheet.name"), t("report.rule")), rows))
    if snapshot.landmarks:
        rows = [
            (str(one.id), metres(one.position[0]), metres(one.position[1]), f"{deviation(one.covariance):.3f} m")
            for one in snapshot.landmarks[:MAX_LISTED]
        ]
        head = (t("report.number"), "x", "y", t("report.deviation"))
        parts += headed(t("map-card.landmarks"), table_html(head, rows))
    return document_html(plan.title, parts, texts.language)


def headed(heading: str, part: str) -> tuple[str, str]:
    """A part of a report under its heading."""
    return f"<h2>{escape(heading)}</h2>", part


def deviation(covariance: Array) -> float:
    """Covariance (2, 2) [m²] → standard deviation of the weaker direction [m]."""
    return math.sqrt(max(0.0, float(np.linalg.eigvalsh(covariance)[-1])))


def drive_document(
    maps: MapService, commands: list[tuple[str, str, str, str, str]], texts: PageTexts, *, whole: bool
) -> str:
    """The way on the plan, and the commands, `whole`: all of them. Raises BadInput where nothing is known yet."""
    t = texts.t
    stamps, poses = laid_out(maps.trajectory.rows(), maps.snapshot.floor)
    way = np.array([(pose.x, pose.y) for pose in poses]).reshape(-1, 2)
    length = float(np.hypot(*np.diff(way, axis=0).T).sum()) if len(way) > 1 else 0.0
    plan, number = maps.plan_in(texts), len(commands)
    facts = [
        (t("report.made"), clock(time.time())),
        (t("report.length_of_the_way"), f"{length:.2f} m"),
        (t("report.time"), lasting(stamps[-1] - stamps[0] if stamps else 0.0)),
        (t("report.commands"), str(number) if whole else t("report.the_newest", number=number)),
    ]
    head = [t(f"report.{name}") for name in ("at", "command", "by", "end", "remark")]
    listed = table_html(head, commands) if commands else f"<p>{escape(t('report.no_command_was_given'))}</p>"
    parts = [
        table_html(("", ""), facts),
        picture_html(plan_svg(replace(plan, way=way)), SVG_TYPE, t("report.the_way_on_the_map")),
        *headed(t("report.commands"), listed),
    ]
    return document_html(t("report.drive", map=plan.title), parts, texts.language)


def calibration_document(kind: CalibrationKind, found: Document, texts: PageTexts) -> str:
    """Numbers with their standard deviations, how well they are known, and all that the file says."""
    t, accepted_s, why_not = texts.t, found.get("accepted_s"), found.get("not_used")
    known = {
        "report.accepted": None if accepted_s is None else clock(accepted_s),
        "report.by": found.get("accepted_by"),
        "report.not_used": texts.said(why_not) if isinstance(why_not, str) else None,
        "report.views": found.get("views_used", found.get("poses_used")),
        "report.rms": in_unit(found, "rms_px", "px"),
        "report.residual": in_unit(found, "residual_rms_m", "m"),
        "report.uncertainty": in_unit(found.get("uncertainty"), "p95_px", "px"),
    }
    rows = [
        (name, t(key), *with_deviation(value, sd, unit)) for name, key, value, sd, unit in numbers_of(kind, found)
    ]
    doubts = [texts.said(str(one)) for one in found.get("warnings") or ()]
    everything = dict(flat({name: value for name, value in found.items() if name not in ("accepted_s", "warnings")}))
    parts = [table_html(("", ""), [(t(key), str(value)) for key, value in known.items() if value])]
    if rows:
        head = ("", "", t("values-card.value"), t("values-card.standard_dev"))
        parts += headed(t("report.numbers"), table_html(head, rows))
    if doubts:
        parts += headed(t("report.warnings"), f"<ul>{''.join(f'<li>{escape(one)}</li>' for one in doubts)}</ul>")
    parts += headed(t("report.all_values"), table_html(("", ""), everything.items()))
    return document_html(t(f"report.calibration_{kind}"), parts, texts.language)


def in_unit(values: object, name: str, unit: str) -> str | None:
    """A number of a file that anybody may have written, in words; None where there is none."""
    value = values.get(name) if isinstance(values, dict) else None
    return f"{value:.3g} {unit}" if isinstance(value, float) else None


def numbers_of(kind: CalibrationKind, found: Document) -> Iterator[tuple[str, str, float | None, float | None, str]]:
    """Each number of a camera [pixel] or of a mount [°, m].

    Its name, the key of what it is, its value where that is known, its standard deviation, its unit.
    """
    if kind == "camera":
        sds = found.get("sd") or {}
        for name, key in CAMERA_LABELS.items():
            if name in found:
                yield name, key, found[name], sds.get(name), ""
        return
    unknown = found.get("not_known") or ()
    turns = ("°", list(MOUNT_LABELS)[:3], found.get("turn_deg"), found.get("sd_rotation_deg"))
    shifts = (" m", list(MOUNT_LABELS)[3:], found.get("translation_m"), found.get("sd_translation_m"))
    for unit, names, values, sds in (turns, shifts):
        for name, value, sd in zip(names, values or (), sds or (None, None, None), strict=True):
            yield name, MOUNT_LABELS[name], None if name in unknown else value, sd, unit


def with_deviation(value: float | None, sd: float | None, unit: str) -> tuple[str, str]:
    """A number and its standard deviation in words, to two digits of the latter; "–" for what is not known."""
    if value is None:
        return "–", "–"
    digits = min(MAX_DECIMALS, max(0, 1 - math.floor(math.log10(sd)))) if sd else MAX_DECIMALS
    said = f"{value:.{digits}f}{unit}".replace("-", "−")
    return said, "–" if sd is None else f"±{sd:.{digits}f}{unit}"


def experiment_document(run: ExperimentRun, kept: ExperimentRuns, texts: PageTexts) -> str:
    t, shown = texts.t, run.shown
    end = t(f"state.{shown.state}")
    facts = [
        (t("report.by"), f"{shown.who}, {clock(shown.at_s)}"),
        (t("experiment-result.runs"), str(shown.runs)),
        (t("report.seed"), str(shown.seed)),
        (t("report.end"), f"{end}: {texts.said(shown.reason)}" if shown.reason else end),
        (t("report.time"), lasting(shown.took_s)),
    ]
    parts = [table_html(("", ""), facts)]
    if shown.compared:
        rows = [
            (
                texts.said(one.name),
                f"{one.chapter:g} {one.unit}",
                "–" if one.ours is None else f"{one.ours:.4g} {one.unit}",
            )
            for one in shown.compared
        ]
        head = [t(f"experiment-result.{name}") for name in ("figure", "the_chapter", "here")]
        parts.append(table_html(head, rows))
    for one in shown.files:
        path = kept.file(run, one.name)
        if (kind := FIGURES.get(path.suffix)) is not None:
            parts.append(picture_html(path.read_bytes(), kind, path.stem.replace("_", " ")))
    if shown.text:
        parts.append(f"<pre>{escape(shown.text)}</pre>")
    return document_html(texts.said(shown.title), parts, texts.language)


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
    if isinstance(value, list):
        return f"[{', '.join(plain(one) for one in cast('list[object]', value))}]"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
