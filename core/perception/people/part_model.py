"""General appearance of a person: for each part the usual cells and the weight of each as evidence.

The numbers are learnt from drawn figures by `python -m tests.benchmarks.teach_people`: no real person is in it.
"""

from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from core.message import Array
from core.perception.people.parts import PARTS, BodySegment

FILE = Path(__file__).with_name("general.npz")


class PartModel(NamedTuple):
    """Classifier of one part: likelihood = logistic(offset + sum of weights · (cells - usual))."""

    part: BodySegment
    usual: Array  # (rows, columns, DIRECTIONS): the mean over people and everything else
    weights: Array  # (rows, columns, DIRECTIONS)
    offset: float


@cache
def general_model() -> tuple[PartModel, ...]:
    """The model of any person, in the order of PARTS."""
    with np.load(FILE) as stored:
        return tuple(
            PartModel(
                part,
                stored[f"{part.name}_usual"].astype(np.float32),
                stored[f"{part.name}_weights"].astype(np.float32),
                float(stored[f"{part.name}_offset"]),
            )
            for part in PARTS
        )


def likelihoods(model: PartModel, cells: Array, valid: Array, rises: range) -> tuple[Array, Array]:
    """Cells (ROWS, C, DIRECTIONS) of a compared view, which of them are in the picture (ROWS, C), by how many cells
    the part may lie higher than the model's (a range that goes up by ones) → the part's log odds for every rise and
    every place along (R, C - columns + 1), and the share of the part that is in the picture, the same shape. What is
    not in the picture says nothing.
    """
    part = model.part
    band = slice(part.top - rises[-1], part.top - rises[0] + part.rows)
    seen = valid[band].astype(np.float32)
    shown = cells[band] * seen[:, :, None]
    size = (part.rows, part.columns)
    windows = np.lib.stride_tricks.sliding_window_view(shown, size, axis=(0, 1))  # (R, P, D, rows, columns)
    here = np.lib.stride_tricks.sliding_window_view(seen, size)  # (R, P, rows, columns)
    many = windows.shape[:2]
    weights = model.weights.transpose(2, 0, 1).ravel()
    usual = (model.usual * model.weights).sum(axis=2).ravel()
    area = here.reshape(*many, -1)
    odds = windows.reshape(*many, -1) @ weights - area @ usual + model.offset
    return odds[::-1], area.mean(axis=2)[::-1]
