"""A sweep: an experiment for every setting of a grid, over the same seeds, as one campaign and one table."""

import itertools
import re
import tomllib
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, TypedDict

from core.errors import BadSettings
from core.experiments import EXPERIMENTS
from core.experiments.plan import ExperimentPlan, figure_at
from core.experiments.result import ExperimentResult, as_csv, stored
from core.settings import Settings, changed

MAX_POINTS = 1000
MAX_FOLDER_NAME = 200  # characters of a point's; a longer one begins with the point's number
UNFIT_FOR_NAMES = re.compile(r"[^\w.=,+-]")  # in the name of a point's folder


class SweepPoint(TypedDict):
    """One point of the grid, as JSON."""

    settings: dict[str, Any]  # those that are swept, by name
    figures: dict[str, float | None]  # of the experiment's result; null where it has none
    files: dict[str, str]


class SweepResult(ExperimentResult):
    """The result, as JSON."""

    experiment: str
    points: list[SweepPoint]


def sweep(name: str, given: Sequence[str], options: Mapping[str, Any]) -> ExperimentPlan:
    """Plan an experiment for every combination of `given` ("ekf.gate=3,5,9"), with its other options.

    Raises BadSettings, and what the experiment's plan raises.
    """
    experiment = EXPERIMENTS[name]
    if "settings" not in experiment.options:
        able = ", ".join(one for one in EXPERIMENTS if "settings" in EXPERIMENTS[one].options)
        raise BadSettings(f"{name} has no settings to sweep; those that have are {able}.")
    base = options.get("settings") or Settings()
    points = grid(given)
    plans = [experiment.plan(**{**options, "settings": changed(base, point)}) for point in points]
    finish = partial(_result, name, options["seed"], points, plans)
    return ExperimentPlan(tuple(batch for plan in plans for batch in plan.batches), finish)


def grid(given: Sequence[str]) -> list[dict[str, Any]]:
    """['ekf.gate=3,5', 'ekf.mode=paper'] → every combination by name. Raises BadSettings."""
    axes: dict[str, list[Any]] = {}
    for text in given:
        name, equals, values = text.partition("=")
        if not equals or not name or not values.replace(",", "").strip():
            raise BadSettings("Give settings to sweep as --set SECTION.SETTING=A,B, as --set ekf.gate=3,5,9.")
        if name in axes:
            raise BadSettings(f"--set {name} is given twice; give all its values in one, with commas.")
        axes[name] = [_value(one.strip()) for one in values.split(",")]
    if not axes:
        raise BadSettings("Nothing to sweep: give at least one --set SECTION.SETTING=A,B, as --set ekf.gate=3,5,9.")
    points = [dict(zip(axes, values, strict=True)) for values in itertools.product(*axes.values())]
    if len(points) > MAX_POINTS:
        raise BadSettings(f"{len(points)} combinations are too many; {MAX_POINTS} are the most.")
    return points


def _value(text: str) -> Any:
    """'3' → 3, 'true' → True, 'paper' → 'paper'."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except (ValueError, RecursionError):
        return text


def _result(
    name: str,
    seed: int,
    points: list[dict[str, Any]],
    plans: list[ExperimentPlan],
    out: Path | None,
    *answers: list[Any],
) -> SweepResult:
    rows: list[SweepPoint] = []
    begin = 0
    for number, (point, plan) in enumerate(zip(points, plans, strict=True), 1):
        of_point = [one for part in answers[begin : begin + len(plan.batches)] for one in part]
        begin += len(plan.batches)
        folder = UNFIT_FOR_NAMES.sub("_", ",".join(f"{name}={value}" for name, value in point.items()))
        folder = folder if len(folder) <= MAX_FOLDER_NAME else f"{number},{folder}"[:MAX_FOLDER_NAME]
        result = plan.finish(of_point, None if out is None else out / folder)
        figures = {key: figure_at(result, key) for key in EXPERIMENTS[name].about.swept}
        rows.append({"settings": point, "figures": figures, "files": result["files"]})
    result: SweepResult = {
        "experiment": name,
        "seed": seed,
        "points": rows,
        "text": "\n".join(table(rows)),
        "files": {},
    }
    flat = [{**row["settings"], **row["figures"]} for row in rows]
    return stored(result, out, "sweep", {"csv": ("sweep.csv", as_csv(flat))})


def table(rows: Sequence[SweepPoint]) -> list[str]:
    """Settings and figures in columns."""
    lines = [[*rows[0]["settings"], *_short(list(rows[0]["figures"]))]]
    for row in rows:
        figures = ("-" if one is None else f"{one:.4g}" for one in row["figures"].values())
        lines.append([*map(str, row["settings"].values()), *figures])
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    return ["  ".join(cell.rjust(width) for cell, width in zip(line, widths, strict=True)) for line in lines]


def _short(keys: Sequence[str]) -> list[str]:
    """Keys without the first parts that all have."""
    parts = [key.split(".") for key in keys]
    while parts and all(len(one) > 1 and one[0] == parts[0][0] for one in parts):
        parts = [one[1:] for one in parts]
    return [".".join(one) for one in parts]
