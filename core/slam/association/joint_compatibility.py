"""Joint compatibility: sightings of one scan are given to landmarks all together (Neira and Tardós 2001).

Alone, a sighting between two near landmarks could be either. But the sightings of one scan share the error of the
pose: where one asks for a robot further left, the others must ask for it too.
"""

import math
from dataclasses import dataclass

import numpy as np
import scipy

from core.message import Array

Pairs = tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class Branch:
    """Some sightings given to landmarks, the others still open."""

    pairs: Pairs = ()
    cost: float = 0.0
    distance: float = 0.0  # squared, joint
    root: Array | None = None  # (2k, 2k) lower, of the joint innovation covariance
    solved: Array | None = None  # (2k,): root⁻¹ residual


@dataclass(frozen=True)
class JointCandidates:
    """M sightings and the N landmarks that any of them could be."""

    residuals: Array  # (M, N, 2)
    states: Array  # (2N, 2N): covariance of all expectations together, without the sensor's noise
    noises: Array  # (M, 2, 2)
    allowed: Array  # (M, N) bool: alone compatible, and alike

    def assign(self, *, gate: float, margin: float, nodes: int) -> Pairs | None:
        """The pairs (sighting, landmark) in which all good assignments agree.

        Good: jointly compatible, as sharply as `gate` tests a single pair, and at most `margin` costlier than the
        best. Cost: joint squared distance, ln|S| / |R|, and for a sighting left out that of the worst fit. None if
        more than `nodes` branches would have to be looked at.
        """
        chance = math.exp(-gate / 2)
        rows = sorted(np.flatnonzero(self.allowed.any(axis=1)).tolist(), key=lambda row: int(self.allowed[row].sum()))
        out = {row: gate + self._widest(row) for row in rows}
        good: list[Branch] = []
        best, visited = math.inf, 0
        open_branches = [(0, Branch())]
        while open_branches:
            depth, branch = open_branches.pop()
            if branch.cost > best + margin:
                continue
            if depth == len(rows):
                best = min(best, branch.cost)
                good.append(branch)
                continue
            visited += 1
            if visited > nodes:
                return None
            row = rows[depth]
            further = [Branch(branch.pairs, branch.cost + out[row], branch.distance, branch.root, branch.solved)]
            taken = {column for _, column in branch.pairs}
            for column in np.flatnonzero(self.allowed[row]).tolist():
                if column not in taken:
                    longer = self._extended(branch, row, column)
                    if longer.distance < scipy.special.chdtri(2 * len(longer.pairs), chance):
                        further.append(longer)
            further.sort(key=lambda one: -one.cost)
            open_branches += [(depth + 1, one) for one in further if one.cost <= best + margin]
        agreed = [set(branch.pairs) for branch in good if branch.cost <= best + margin]
        return tuple(sorted(set.intersection(*agreed))) if agreed else ()

    def _extended(self, branch: Branch, row: int, column: int) -> Branch:
        """One pair more: the joint innovation covariance grows by its two rows, and so does its root."""
        own = self.states[2 * column : 2 * column + 2, 2 * column : 2 * column + 2] + self.noises[row]
        wanted = self.residuals[row, column]
        count = 2 * len(branch.pairs)
        root = np.zeros((count + 2, count + 2))
        if branch.root is not None and branch.solved is not None:
            held = [2 * other + k for _, other in branch.pairs for k in (0, 1)]
            shared = np.linalg.solve(branch.root, self.states[held, 2 * column : 2 * column + 2])
            own, wanted = own - shared.T @ shared, wanted - shared.T @ branch.solved
            root[:count, :count], root[count:, :count] = branch.root, shared.T
        low = np.linalg.cholesky(own)
        root[count:, count:] = low
        whitened = np.linalg.solve(low, wanted)
        distance = float(whitened @ whitened)
        size = 2 * math.log(low[0, 0] * low[1, 1]) - math.log(np.linalg.det(self.noises[row]))
        return Branch(
            pairs=(*branch.pairs, (row, column)),
            cost=branch.cost + distance + size,
            distance=branch.distance + distance,
            root=root,
            solved=whitened if branch.solved is None else np.concatenate((branch.solved, whitened)),
        )

    def _widest(self, row: int) -> float:
        """The largest ln|S| / |R| among a sighting's landmarks."""
        noise = self.noises[row]
        blocks = [
            self.states[2 * j : 2 * j + 2, 2 * j : 2 * j + 2] + noise
            for j in np.flatnonzero(self.allowed[row]).tolist()
        ]
        return max(math.log(np.linalg.det(block) / np.linalg.det(noise)) for block in blocks)
