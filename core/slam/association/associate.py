"""Data association without given identities: one by one where that is clear, jointly where it is not."""

import math
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np

from core.message import Array
from core.perception.landmarks.landmarks import Sighting
from core.setting import Meta, Section
from core.slam.association.joint_compatibility import JointCandidates, Pairs
from core.slam.association.landmark_table import LandmarkTable
from core.slam.association.nearest_neighbour import Assignment, associate, nearest
from core.slam.ekf.filter import Filter
from core.slam.ekf.measurement_model import residual, squared_distance

Fate = Literal["matched", "tentative", "new", "ignored"]


@dataclass
class Observation:
    """M sightings, N landmarks; and what became of the sightings."""

    seen: tuple[Sighting, ...]
    readings: Array  # (M, 2) range [m], bearing [rad]
    noises: Array  # (M, 2, 2)
    expectations: Array  # (N, 2)
    states: Array  # (N, 2, 2): covariance of the expectation, without the sensor's noise
    fates: list[tuple[Fate, int | None]]


@dataclass(frozen=True)
class AssociationSettings(Section):
    """Gates and margins of data association.

    Watch:
        form: wrong matches in a room with repeated doors
        gate: matches per scan, and NIS; lower it for wrong matches
        fresh: two landmarks at one corner (then raise it)
    """

    margin: float = 2.0  # [χ²] an assignment with another one so close is doubtful
    vague: float = 4.0  # ln(|S|/|R|) from which one scan cannot tell which landmark left behind was seen
    found_again: int = 3  # landmarks left behind that must be recognised together
    joint_nodes: int = 300  # branches of one scan's assignments that are searched, at most; 0: each sighting alone
    double: float = 5.99  # [χ²] squared distance below which two landmarks may be one; 95 % at 2 dof
    double_reach: float = 0.25  # [m] distance below which two landmarks may be one
    form: Annotated[
        Literal["unique", "nearest"],
        Meta(meaning="one to one and none where it is doubtful, or the paper's gated nearest neighbour, each alone"),
    ] = "unique"
    gate: Annotated[
        float,
        Meta("χ²", 1, 1000, "squared distance of a match, at most: real ranges have heavier tails than a Gaussian"),
    ] = 22.0
    fresh: Annotated[float, Meta("χ²", 1, 1000, "squared distance of a new landmark from others, at least")] = 20.0


def recognise(look: Observation, state: Filter, table: LandmarkTable, settings: AssociationSettings) -> Assignment:
    """Sightings → landmarks. Believed ones come first; what fits none of them may be one on probation.

    After a long way a robot may know its place no better than to the distance between landmarks. The sightings of one
    scan then cannot tell which of those left behind they are of, nor whether they are of new ones: a few doors fit a
    row of doors in several places. So what is seen there is new at first; together, such landmarks are recognised
    later (`doubles`).
    """
    if not look.seen or not len(table):
        return Assignment((), tuple(range(len(look.seen))))
    distances, sizes = squared_distance(
        residual(look.readings[:, None], look.expectations[None]), look.states[None] + look.noises[:, None]
    )
    if settings.form == "nearest":
        return nearest(distances, settings.gate)
    doubt = sizes - np.log(np.linalg.det(look.noises))[:, None]
    distances = np.where(table.left_behind & (doubt > settings.vague), np.inf, distances)
    alike = table.alike(look.seen, state.pose.heading)
    believed = table.believed
    near = alike & (distances < settings.gate)
    others = ~(near & believed).any(axis=1, keepdims=True) & ~believed

    def choose(allowed: Array) -> Pairs:
        fitting = near & allowed
        rows, columns = fitting.nonzero()
        if not len(rows):
            return ()
        if (
            len(set(rows.tolist())) == len(rows) == len(set(columns.tolist()))
        ):  # no sighting and no landmark has a choice
            alone = tuple(zip(rows.tolist(), columns.tolist(), strict=True))
            return _together(look, state, fitting, columns, settings, alone) if _crowded(state, columns) else alone
        alone = associate(distances, sizes, allowed, gate=settings.gate, fresh=settings.fresh, margin=settings.margin)
        return _together(look, state, fitting, np.unique(columns), settings, alone.matches)

    far = np.where(alike, distances > settings.fresh, distances > settings.gate).all(axis=1)
    matches = (*choose(alike & believed), *choose(alike & others))
    matched = {row for row, _ in matches}
    return Assignment(matches, tuple(row for row in np.flatnonzero(far).tolist() if row not in matched))


def _together(
    look: Observation, state: Filter, allowed: Array, columns: Array, settings: AssociationSettings, alone: Pairs
) -> Pairs:
    """The pairs that the sightings agree on together; those chosen alone where the search would take too long."""
    if settings.joint_nodes == 0:
        return alone
    columns = np.sort(columns)
    candidates = JointCandidates(
        residuals=residual(look.readings[:, None], look.expectations[None, columns]),
        states=state.innovate(columns, look.expectations[columns]).state,
        noises=look.noises,
        allowed=allowed[:, columns],
    )
    joint = candidates.assign(gate=settings.gate, margin=settings.margin, nodes=settings.joint_nodes)
    return alone if joint is None else tuple((row, int(columns[column])) for row, column in joint)


def _crowded(state: Filter, columns: Array) -> bool:
    if len(columns) < 2:
        return False
    covariance, (x, y) = state.pose_covariance(), state.places.T
    away = (x - x[columns, None]) ** 2 + (y - y[columns, None]) ** 2
    away[np.arange(len(columns)), columns] = math.inf
    return bool(4 * (covariance[0, 0] + covariance[1, 1]) > away.min())
