"""Landmarks that turn out to be one: two that lie together, or several that are found again together."""

import math

import numpy as np
import scipy

from core.message import Array
from core.slam.association.associate import AssociationSettings
from core.slam.association.joint_compatibility import Pairs
from core.slam.association.landmark_table import LandmarkTable
from core.slam.consistency import squared_error
from core.slam.ekf.filter import EQUAL_VARIANCE_M2, Filter
from core.slam.ekf.measurement_model import squared_distance


def found_again(pairs: Pairs, apart: Array, spread: Array, *, gate: float, fewest: int, nodes: int) -> Pairs:
    """Find those of K pairs (new, old) that are surely one landmark each.

    `apart` (K, 2): how far the two lie apart, `spread` (2K, 2K): covariance of that, all together. A set of pairs,
    one to one, fits if it is jointly compatible, as sharply as `gate` tests a single one. The result is the pairs in
    which the largest set that fits and all sets at most one pair smaller agree, if they are at least `fewest`, else
    none. None, too, if more than `nodes` branches would have to be looked at.
    """
    chance = math.exp(-gate / 2)
    choices = {new: [k for k, pair in enumerate(pairs) if pair[0] == new] for new, _ in pairs}
    order = sorted(choices, key=lambda new: len(choices[new]))
    largest, visited = 0, 0
    fitting: list[frozenset[int]] = []
    branches: list[tuple[int, tuple[int, ...]]] = [(0, ())]
    while branches:
        depth, held = branches.pop()
        if len(held) + len(order) - depth < max(fewest, largest - 1):
            continue
        if depth == len(order):
            largest = max(largest, len(held))
            fitting.append(frozenset(held))
            continue
        visited += 1
        if visited > nodes:
            return ()
        branches.append((depth + 1, held))
        taken = {pairs[k][1] for k in held}
        for k in choices[order[depth]]:
            longer = (*held, k)
            if pairs[k][1] not in taken and _distance(longer, apart, spread) < scipy.special.chdtri(
                2 * len(longer), chance
            ):
                branches.append((depth + 1, longer))
    rivals = [one for one in fitting if len(one) >= largest - 1]
    whole = [one for one in rivals if not any(one < other for other in rivals)]
    agreed = frozenset.intersection(*whole) if whole else frozenset[int]()
    return tuple(pairs[k] for k in sorted(agreed)) if len(agreed) >= fewest else ()


def _distance(held: tuple[int, ...], apart: Array, spread: Array) -> float:
    """Squared distance of some pairs from being one landmark each."""
    rows = (2 * np.array(held)[:, None] + np.arange(2)).ravel()
    wanted = apart[list(held)].ravel()
    return float(wanted @ np.linalg.solve(spread[np.ix_(rows, rows)] + EQUAL_VARIANCE_M2 * np.eye(len(rows)), wanted))


def join_doubles(state: Filter, table: LandmarkTable, hit: list[int], settings: AssociationSettings) -> None:
    """Landmarks that were just hit join those that they are; two that were seen at once never will."""
    if hit and not _join_found_again(state, table, hit, settings):
        _join_nearest(state, table, hit, settings)


def _join_nearest(state: Filter, table: LandmarkTable, hit: list[int], settings: AssociationSettings) -> None:
    off = state.places - state.places[hit][:, None]
    near = np.einsum("hnk,hnk->hn", off, off) < settings.double_reach**2
    near[np.arange(len(hit)), hit] = False
    for row, b in np.argwhere(near).tolist():
        a = hit[row]
        if b in hit:
            table.part(a, b)
        elif table.may_be_doubles(a, b) and _coincide(state, table, a, b, settings):
            _join(state, table, ((a, b),))
            return


def _join_found_again(state: Filter, table: LandmarkTable, hit: list[int], settings: AssociationSettings) -> bool:
    """Landmarks met since the robot left others behind may together be those.

    It is looked into whenever one of them has been hit a few times more.
    """
    due = [index for index in hit if table.hits(index) % table.settings.probation == 0]
    if not (due and table.new[due].any()):
        return False
    pairs = _candidates(state, table, settings.gate)
    if len({new for new, _ in pairs}) < settings.found_again:
        return False
    apart, spread = state.all_apart(*np.array(pairs).T)
    count = len(pairs)
    own = spread.reshape(count, 2, count, 2)[np.arange(count), :, np.arange(count), :]
    near = np.flatnonzero(squared_distance(apart, own + EQUAL_VARIANCE_M2 * np.eye(2))[0] < settings.gate)
    rows = (2 * near[:, None] + np.arange(2)).ravel()
    found = found_again(
        tuple(pairs[k] for k in near),
        apart[near],
        spread[np.ix_(rows, rows)],
        gate=settings.gate,
        fewest=settings.found_again,
        nodes=settings.joint_nodes,
    )
    _join(state, table, found)
    return bool(found)


def _candidates(state: Filter, table: LandmarkTable, gate: float) -> list[tuple[int, int]]:
    """Pairs (new, old) where the old one was left behind before the new one was met, not hopelessly far apart.

    Hopelessly: beyond `gate` even if the two err against each other, when their spreads add up to twice their sum.
    """
    old, new = np.flatnonzero(table.left_behind & table.believed), np.flatnonzero(table.new)
    if not (len(old) and len(new)):
        return []
    spreads = np.trace(state.place_covariances(), axis1=1, axis2=2)
    off = state.places[new][:, None] - state.places[old]
    near = np.einsum("ijk,ijk->ij", off, off) < 2 * gate * (spreads[new][:, None] + spreads[old])
    pairs: Array = np.column_stack((new[near.nonzero()[0]], old[near.nonzero()[1]]))
    return [(a, b) for a, b in pairs.tolist() if table.precedes(b, a) and table.may_be_doubles(a, b)]


def _coincide(state: Filter, table: LandmarkTable, a: int, b: int, settings: AssociationSettings) -> bool:
    difference, spread = state.apart(a, b)
    if table.left_behind[[a, b]].any() and np.trace(spread) > settings.double_reach**2:
        return False
    return squared_error(difference, spread + EQUAL_VARIANCE_M2 * np.eye(2)) < settings.double


def _join(state: Filter, table: LandmarkTable, pairs: Pairs) -> None:
    if pairs:
        state.join(np.min(pairs, axis=1), np.max(pairs, axis=1))
        for first, second in sorted((sorted(pair) for pair in pairs), key=max, reverse=True):  # the rest keep theirs
            table.join(first, second)
