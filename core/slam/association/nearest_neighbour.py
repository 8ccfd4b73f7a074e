"""Assignment of sightings to landmarks: one to one, and none where it is doubtful (section 4.1)."""

from dataclasses import dataclass

import numpy as np
import scipy

from core.message import Array

FORBIDDEN_COST = 1e6  # cost of what is not allowed


@dataclass(frozen=True)
class Assignment:
    """The matched and the new sightings; those in neither are best ignored."""

    matches: tuple[tuple[int, int], ...] = ()  # (sighting, landmark)
    fresh: tuple[int, ...] = ()  # sightings far from every landmark


def associate(
    distances: Array, sizes: Array, alike: Array, *, gate: float, fresh: float, margin: float
) -> Assignment:
    """Assign M sightings to N landmarks.

    `distances` (M, N): squared Mahalanobis; `sizes` (M, N): ln|S|, without which uncertain landmarks attract
    everything; `alike` (M, N) bool: whether the two can be the same kind of thing. A pair needs a distance below
    `gate`; a new landmark one above `fresh` to all that are alike. Where another assignment costs at most `margin`
    more, the sighting is left out: skipping costs little, a wrong guess is forever.
    """
    allowed = alike & (distances < gate)
    far = np.where(alike, distances > fresh, distances > gate).all(axis=1)
    costs = np.where(allowed, distances + sizes, FORBIDDEN_COST)
    pairs = _solve(costs, allowed, gate)
    sure = tuple(pair for pair in pairs if not _is_doubtful(pair, pairs, costs, allowed, gate, margin))
    return Assignment(sure, tuple(int(row) for row in np.flatnonzero(far)))


def nearest(distances: Array, gate: float) -> Assignment:
    """The paper's gated nearest neighbour: each sighting alone, to the landmark of the least distance (M, N).

    What lies in no gate is new. Two sightings may go to one landmark.
    """
    if not distances.shape[1]:
        return Assignment(fresh=tuple(range(len(distances))))
    best = distances.argmin(axis=1)
    near = distances.min(axis=1) < gate
    matches = tuple((int(row), int(best[row])) for row in np.flatnonzero(near))
    return Assignment(matches, tuple(int(row) for row in np.flatnonzero(~near)))


def _solve(costs: Array, allowed: Array, gate: float) -> list[tuple[int, int]]:
    """The cheapest unique assignment (Hungarian method); leaving a sighting out costs as much as the worst fit."""
    rows, columns = np.flatnonzero(allowed.any(axis=1)), np.flatnonzero(allowed.any(axis=0))
    if not len(rows):
        return []
    square = costs[np.ix_(rows, columns)]
    if (allowed.sum(axis=1) <= 1).all() and (allowed.sum(axis=0) <= 1).all():
        return [(int(row), int(columns[square[i].argmin()])) for i, row in enumerate(rows)]
    nobody = np.full((len(rows), len(rows)), _leaving_out(costs, allowed, gate))
    picked, chosen = scipy.optimize.linear_sum_assignment(np.hstack((square, nobody)))
    pairs = [(int(rows[i]), int(columns[j])) for i, j in zip(picked, chosen, strict=True) if j < len(columns)]
    return [pair for pair in pairs if allowed[pair]]


def _leaving_out(costs: Array, allowed: Array, gate: float) -> float:
    return gate + float(costs[allowed].max()) if allowed.any() else gate


def _is_doubtful(
    pair: tuple[int, int], pairs: list[tuple[int, int]], costs: Array, allowed: Array, gate: float, margin: float
) -> bool:
    """Return whether the sighting could nearly as well be another landmark, or another sighting this landmark."""
    row, column = pair
    taken = {r for r, _ in pairs}
    rivals = np.flatnonzero(allowed[:, column])
    if any(int(rival) not in taken and costs[rival, column] < costs[pair] + margin for rival in rivals):
        return True
    others = allowed[row].copy()
    others[column] = False
    if not others.any():
        return False
    best = _total(pairs, costs, allowed, gate)
    for other in np.flatnonzero(others):
        if costs[row, other] >= costs[pair] + margin:
            continue
        forced, open_to = costs.copy(), allowed.copy()
        open_to[row], open_to[:, other] = False, False
        forced[~open_to] = FORBIDDEN_COST
        rest = _solve(forced, open_to, gate)
        if _total([*rest, (row, int(other))], costs, allowed, gate) < best + margin:
            return True
    return False


def _total(pairs: list[tuple[int, int]], costs: Array, allowed: Array, gate: float) -> float:
    left = int(allowed.any(axis=1).sum()) - len(pairs)
    return float(sum(costs[pair] for pair in pairs)) + left * _leaving_out(costs, allowed, gate)
