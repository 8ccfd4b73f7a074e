"""Figure 16 anew: the paper's drive 40 times with dead reckoning and with EKF-SLAM, the worst run of each shown.

The filter of the figure is the paper's own form unless settings say otherwise; the other form runs beside it on the
same draws. How good a worst run is depends on where the corners are first seen from: after two seconds at rest
(`still`) it errs by a quarter.
"""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from core.calibration.written import write_all
from core.errors import BadInput
from core.experiments.course_draws import Draws, Field, frozen
from core.experiments.course_traces import Trace, mapped, reckoned
from core.experiments.figure_16 import Panel, figure_16
from core.experiments.paper_course import EVERY
from core.experiments.side_by_side import side_by_side
from core.log import Ids
from core.message import Array, message
from core.settings import Settings
from core.slam.ekf import EkfSettings

RUNS = 40
SHOWN = 40  # runs drawn faintly behind the worst
PRINTED = {"dead_reckoning": (0.2, 0.06), "ekf_slam": (0.08, 0.025)}
"""The paper's worst average error [m], and what it is of the path ("more than")."""


@dataclass(frozen=True)
class Plan:
    """What every run goes through."""

    draws: Draws
    ekf: EkfSettings
    still: bool

    @property
    def forms(self) -> dict[str, EkfSettings]:
        """The filters by the name of their row: the figure's first, then its other form."""
        other = "invariant" if self.ekf.mode == "paper" else "paper"
        return {"ekf_slam": self.ekf, f"ekf_slam_{other}": replace(self.ekf, mode=other)}

    def traces(self, number: int) -> dict[str, Trace]:
        """One run through every estimator."""
        run = self.draws.run(number)
        return {"dead_reckoning": reckoned(run)} | {
            name: mapped(run, ekf, self.still) for name, ekf in self.forms.items()
        }


@message
class Outcome:
    """Figures of one run by estimator, and for the figure its errors."""

    average: dict[str, float]  # [m]
    final: dict[str, float]  # [m]
    nees: dict[str, float]
    errors: dict[str, Array]  # times [s] and errors [m] as rows (2, M); empty for runs that are not drawn
    places: dict[str, Array]  # (M, 2) [m]


def outcome(plan: Plan, number: int) -> Outcome:
    """One run."""
    traces = plan.traces(number)
    drawn = {name: trace for name, trace in traces.items() if number < SHOWN}
    return Outcome(
        average={name: trace.average for name, trace in traces.items()},
        final={name: trace.final for name, trace in traces.items()},
        nees={name: trace.nees for name, trace in traces.items()},
        errors={name: np.stack((trace.times, trace.errors)) for name, trace in drawn.items()},
        places={name: trace.places for name, trace in drawn.items()},
    )


def run(
    *,
    runs: int | None = None,
    seed: int = 0,
    out: Path | None = None,
    tell: Callable[[str], None] | None = None,
    settings: Settings | None = None,
    data: Path | None = None,
    noise: float | None = None,
    field: Field | None = None,
    still: bool = False,
    ids: Ids = "given",
    workers: int | None = None,
) -> dict[str, Any]:
    """`runs` drives (40) → the worst and mean average error of each estimator; `out` receives figure and tables.

    `data`: frozen draws instead of the simulator; `noise`: all of eq. 43 times so much; `field`: what is seen of the
    room ("laser"); `still`: ten frames at rest first. Raises BadInput, Unavailable.
    """
    if data is not None and still and not len(frozen(data).still):
        raise BadInput(f"{data.name} has no frames at rest (still_obs).")
    plan = Plan(_draws(settings, seed, data, noise, field, ids), _filter(settings), still)
    count = runs or (RUNS if data is None else min(RUNS, len(frozen(data).speeds)))
    if data is not None and count > len(frozen(data).speeds):
        raise BadInput(f"{data.name} has {len(frozen(data).speeds)} runs; {count} cannot be had from it.")
    done = side_by_side(partial(outcome, plan), count, workers, tell)
    rows = {name: _row(name, done, plan) for name in ("dead_reckoning", *plan.forms)}
    result: dict[str, Any] = {
        "runs": count,
        "seed": seed,
        "setup": _setup(plan),
        "estimators": rows,
        "text": "\n".join(layout(rows, count)),
        "files": {},
    }
    if out is not None:
        result["files"] = save(out, result, done, plan)
    return result


def layout(rows: dict[str, dict[str, Any]], count: int) -> list[str]:
    """The table beside the paper's figures."""
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


def save(out: Path, result: dict[str, Any], done: list[Outcome], plan: Plan) -> dict[str, str]:
    """Figure 16, every run's errors, and the result itself → what lies where. Raises Unavailable."""
    worst = {name: plan.traces(row["worst_run"])[name] for name, row in result["estimators"].items()}
    first = plan.draws.run(0)
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
    drawing = figure_16(panels, first.truth[:, :2], first.landmarks, caption(plan, result))
    files = {
        "figure_16": ("figure_16.svg", drawing),
        "csv": ("dead_reckoning_vs_slam.csv", _table(done)),
        "json": ("dead_reckoning_vs_slam.json", json.dumps(_plain(result), indent=1)),
    }
    return write_all(out, files)


def caption(plan: Plan, result: dict[str, Any]) -> str:
    """The set-up in a line."""
    noise, step = result["setup"], plan.draws.motion.step
    source = plan.draws.data.name if plan.draws.data else f"seed {result['seed']}"
    return (
        f"{noise['speed_m_s']:g} m/s, controls {1 / step:g} Hz, sightings {1 / (EVERY * step):g} Hz  ·  "
        f"Q = diag({noise['speed_sd_m_s']:g} m/s, {noise['steer_sd_deg']:g}°)²  ·  "
        f"R = diag({noise['range_sd_m']:g} m, {noise['bearing_sd_deg']:g}°)²  ·  "
        f"{'ten frames at rest first' if plan.still else 'moving at once'}  ·  "
        f"{plan.ekf.mode} form  ·  {source}"
    )


def _draws(
    settings: Settings | None, seed: int, data: Path | None, noise: float | None, field: Field | None, ids: Ids
) -> Draws:
    if data is not None:
        if noise is not None or field is not None:
            raise BadInput(f"The draws in {data.name} are made; leave out noise and field, or leave out the file.")
        return Draws(seed=seed, data=data, ids=ids)
    settings, factor = settings or Settings(), 1.0 if noise is None else noise
    motion = replace(
        settings.motion,
        model="paper",
        speed_sd=factor * settings.motion.speed_sd,
        steer_sd=factor * settings.motion.steer_sd,
    )
    spread = factor * settings.ekf.range_sd, factor * settings.ekf.bearing_sd
    return Draws(seed=seed, motion=motion, sighting_noise=spread, field=field or "laser", ids=ids)


def _filter(settings: Settings | None) -> EkfSettings:
    """The figure's filter; every sighting brings its own noise."""
    ekf = EkfSettings(mode="paper") if settings is None else settings.ekf
    return replace(ekf, sighting_noise="corner")


def _setup(plan: Plan) -> dict[str, Any]:
    motion, (far, aside) = plan.draws.motion, plan.draws.sighting_noise
    return {
        "data": plan.draws.data.name if plan.draws.data else None,
        "mode": plan.ekf.mode,
        "still_start": plan.still,
        "ids": plan.draws.ids,
        "field": plan.draws.field,
        "speed_m_s": motion.cruise,
        "wheelbase_m": motion.wheelbase,
        "speed_sd_m_s": motion.speed_sd,
        "steer_sd_deg": math.degrees(motion.steer_sd),
        "range_sd_m": far,
        "bearing_sd_deg": math.degrees(aside),
    }


def _row(name: str, done: list[Outcome], plan: Plan) -> dict[str, Any]:
    """The figures of one estimator over all runs."""
    averages = np.array([one.average[name] for one in done])
    worst = int(averages.argmax())
    truth = plan.draws.run(worst).truth[:, :2]
    path = float(np.hypot(*np.diff(truth, axis=0).T).sum())
    row: dict[str, Any] = {
        "worst_average_error_m": float(averages.max()),
        "mean_average_error_m": float(averages.mean()),
        "worst_run": worst,
        "path_m": path,
        "nees_mean": float(np.nanmean([one.nees[name] for one in done])),
        "worst_share_of_path": float(averages.max()) / path,
        "mean_final_error_m": float(np.mean([one.final[name] for one in done])),
    }
    if name in PRINTED:
        row["paper_worst_average_error_m"], row["paper_share_of_path"] = PRINTED[name]
    return row


def _table(done: list[Outcome]) -> str:
    """Every run's figures as CSV."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(("run", "estimator", "average_error_m", "final_error_m", "nees"))
    for number, one in enumerate(done):
        for name in one.average:
            figures = (one.average[name], one.final[name], one.nees[name])
            rows.writerow((number, name, *(f"{figure:.6g}" for figure in figures)))
    return text.getvalue()


def _plain(result: dict[str, Any]) -> dict[str, Any]:
    """The result without its layout."""
    return {name: value for name, value in result.items() if name not in ("text", "files")}
