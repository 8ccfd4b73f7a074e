"""Landmarks that are found again together: several new ones against several old ones."""

from __future__ import annotations

import math

import numpy as np
from scipy.special import chdtri

from core.message import Array
from core.slam.association.joint_compatibility import Pairs
from core.slam.ekf.filter import EQUAL


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
            if pairs[k][1] not in taken and _distance(longer, apart, spread) < chdtri(2 * len(longer), chance):
                branches.append((depth + 1, longer))
    rivals = [one for one in fitting if len(one) >= largest - 1]
    whole = [one for one in rivals if not any(one < other for other in rivals)]
    agreed = frozenset.intersection(*whole) if whole else frozenset[int]()
    return tuple(pairs[k] for k in sorted(agreed)) if len(agreed) >= fewest else ()


def _distance(held: tuple[int, ...], apart: Array, spread: Array) -> float:
    """Squared distance of some pairs from being one landmark each."""
    rows = (2 * np.array(held)[:, None] + np.arange(2)).ravel()
    wanted = apart[list(held)].ravel()
    return float(wanted @ np.linalg.solve(spread[np.ix_(rows, rows)] + EQUAL * np.eye(len(rows)), wanted))
