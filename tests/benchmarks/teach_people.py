"""Teaches the general model of a person from drawn figures: `python -m tests.benchmarks.teach_people`.

Pictures are made of the simulated storey (never of the laboratory, where the model is measured), with things and
people set down at random; each part is a logistic regression, taught again on what it first took for people.
The same seed gives the same numbers.
"""

import logging
import math
from dataclasses import dataclass
from pathlib import Path
from typing import cast

import numpy as np
from scipy.optimize import minimize

from core.files import check_file, replacing
from core.message import Array
from core.perception.people.brightness import levelled
from core.perception.people.detector import FILE, PartModel, edge_cells, likelihoods
from core.perception.people.parts import (
    CELLS_PER_METRE,
    HIGHEST_SHIFT,
    LOWEST_SHIFT,
    MODEL_HEIGHT_M,
    PARTS,
    BodySegment,
)
from core.perception.people.vertical_plane import VerticalPlanes
from core.simulation.world import FLOOR
from tests.benchmarks.command import run_command
from tests.drawn_people import DrawnScene, Stage

log = logging.getLogger(__name__)

REACH = 0.375 + 0.5  # [m] of a view to either side
MIN_SHOWN_SHARE = 0.35  # share of a part in the picture from which it teaches
STRAY_OFFSETS_M = (0.32, -0.32, 0.45, -0.45)  # to the side of a person: no person stands there
WRONG_DISTANCES = (0.7, 1.4)  # times the true one: no person stands there
LOOK_DISTANCES = 20  # distances at which one picture is searched for mistakes
MISTAKEN = -1.0  # log odds from which something is used as a training sample


@dataclass
class TrainingSamples:
    """Rows of cells of one part, and whether each is a person."""

    rows: list[Array]
    truth: list[float]


def cut_part(part: BodySegment, cells: Array, valid: Array, column: float, shift: int) -> tuple[Array, Array]:
    """The part's cells (rows, columns, DIRECTIONS) around a column [cell], NaN where they are not in the picture."""
    top = part.top - round(part.rise * shift)
    first = round(column - part.columns / 2)
    area = (slice(top, top + part.rows), slice(first, first + part.columns))
    seen = valid[area]
    return np.where(seen[:, :, None], cells[area], np.nan), seen


def teach(seed: int, scenes: int, rounds: int = 3, regularity: float = 3.0) -> tuple[PartModel, ...]:
    """Train the model of any person."""
    rng = np.random.default_rng(seed)
    stage = Stage(FLOOR, rng)
    samples = {part.name: TrainingSamples([], []) for part in PARTS}
    for scene in (stage.scene(people=1, clutter=4) for _ in range(scenes)):
        _learn_from(scene, samples, rng)
    models = tuple(_fitted(part, samples[part.name], regularity) for part in PARTS)
    for _ in range(rounds):
        for scene in (stage.scene(people=0, clutter=8) for _ in range(scenes // 3)):
            _learn_mistakes(scene, models, samples, rng)
        models = tuple(_fitted(part, samples[part.name], regularity) for part in PARTS)
    return models


def _learn_from(scene: DrawnScene, samples: dict[str, TrainingSamples], rng: np.random.Generator) -> None:
    """One person, the places next to them, the wrong distances, and other places."""
    person = scene.people[0]
    boards = VerticalPlanes(levelled(scene.pixels), scene.camera)
    shift = round((person.height - MODEL_HEIGHT_M) * CELLS_PER_METRE)
    shift = min(HIGHEST_SHIFT, max(LOWEST_SHIFT, shift))
    if person.shown > 0.8:
        pixels, valid = boards.cut(person.distance, person.bearing + rng.normal(0, 0.015), REACH)
        cells = edge_cells(pixels)
        _add(samples, cells, valid, cells.shape[1] / 2, shift, 1.0)
        _add(samples, cells[:, ::-1][:, :, _mirrored()], valid[:, ::-1], cells.shape[1] / 2, shift, 1.0)
        for stray in STRAY_OFFSETS_M:
            _add(samples, cells, valid, cells.shape[1] / 2 + stray * CELLS_PER_METRE, shift, 0.0)
        for factor in WRONG_DISTANCES:
            pixels, valid = boards.cut(person.distance * factor, person.bearing, REACH)
            _add(samples, edge_cells(pixels), valid, cells.shape[1] / 2, 0, 0.0)
    for _ in range(2):
        bearing = person.bearing + math.copysign(rng.uniform(0.35, 0.7), -person.bearing)
        distance = float(rng.uniform(0.8, 6.0))
        if abs(math.sin(bearing - person.bearing)) * min(distance, person.distance) > 0.5:
            pixels, valid = boards.cut(distance, bearing, REACH)
            cells = edge_cells(pixels)
            column = cells.shape[1] / 2 + rng.integers(-6, 7)
            _add(samples, cells, valid, column, int(rng.integers(LOWEST_SHIFT, HIGHEST_SHIFT + 1)), 0.0)


def _mirrored() -> Array:
    """Which direction of an edge becomes which in a mirror; bins lie around 10°, 30°, … 170°."""
    return np.arange(9)[::-1]


def _add(
    samples: dict[str, TrainingSamples], cells: Array, valid: Array, column: float, shift: int, truth: float
) -> None:
    for part in PARTS:
        rows, seen = cut_part(part, cells, valid, column, shift)
        if seen.shape == (part.rows, part.columns) and seen.mean() >= MIN_SHOWN_SHARE:
            samples[part.name].rows.append(rows.astype(np.float32))
            samples[part.name].truth.append(truth)


def _learn_mistakes(
    scene: DrawnScene, models: tuple[PartModel, ...], samples: dict[str, TrainingSamples], rng: np.random.Generator
) -> None:
    """Add the places without people that look most like a person."""
    boards = VerticalPlanes(levelled(scene.pixels), scene.camera)
    bearing = float(rng.uniform(-0.42, 0.42))
    for distance in np.geomspace(0.6, 6.0, LOOK_DISTANCES) * rng.uniform(0.95, 1.05):
        pixels, valid = boards.cut(float(distance), bearing, REACH)
        cells = edge_cells(pixels)
        for model in models:
            part = model.part
            rises = range(round(part.rise * LOWEST_SHIFT), round(part.rise * HIGHEST_SHIFT) + 1)
            evidence, share = likelihoods(model, cells, valid, rises)
            odds = np.where(share >= MIN_SHOWN_SHARE, evidence, -np.inf)
            row, column = np.unravel_index(int(odds.argmax()), odds.shape)
            if odds[row, column] > MISTAKEN:
                shift = round(rises[int(row)] / part.rise) if part.rise else 0
                rows, _ = cut_part(part, cells, valid, column + part.columns / 2, shift)
                samples[part.name].rows.append(rows.astype(np.float32))
                samples[part.name].truth.append(0.0)


def _fitted(part: BodySegment, samples: TrainingSamples, regularity: float) -> PartModel:
    """Logistic regression; people and everything else weigh the same."""
    rows = np.array(samples.rows)
    truth = np.array(samples.truth)
    usual = np.nanmean(rows, axis=0)
    table = np.nan_to_num(rows - usual).reshape(len(rows), -1)
    share = np.where(truth > 0, 0.5 / truth.sum(), 0.5 / (1 - truth).sum()) * len(truth)

    def loss(numbers: Array) -> tuple[float, Array]:
        weights, offset = numbers[:-1], numbers[-1]
        odds = table @ weights + offset
        wrong = share * (1 / (1 + np.exp(-np.clip(odds, -30, 30))) - truth)
        value = float((share * (np.logaddexp(0, odds) - truth * odds)).sum() + 0.5 * regularity * weights @ weights)
        return value, np.append(table.T @ wrong + regularity * weights, wrong.sum())

    found = minimize(loss, np.zeros(table.shape[1] + 1), jac=True, method="L-BFGS-B", options={"maxiter": 150})
    numbers = cast(Array, found.x)
    log.info("%s: %d samples, %d of people", part.name, len(truth), int(truth.sum()))
    weights = numbers[:-1].reshape(usual.shape)
    return PartModel(part, usual.astype(np.float32), weights.astype(np.float32), float(numbers[-1]))


def keep_model(models: tuple[PartModel, ...], path: Path) -> None:
    """Write the model as a small file."""
    numbers: dict[str, Array] = {}
    for model in models:
        numbers[f"{model.part.name}_usual"] = model.usual.astype(np.float16)
        numbers[f"{model.part.name}_weights"] = model.weights.astype(np.float16)
        numbers[f"{model.part.name}_offset"] = np.array(model.offset, np.float32)
    with replacing(path) as file:
        np.savez_compressed(file, allow_pickle=False, **numbers)


def main(*, seed: int = 1, scenes: int = 1500, out: Path = FILE) -> None:
    check_file(out)
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    keep_model(teach(seed, scenes), out)


if __name__ == "__main__":
    run_command(main)
