"""Poses held together by relative measurements: robust least squares in the plane."""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse import linalg

from core.geometry import Pose, wrap_all
from core.message import Array

ROUNDS = 12  # of Gauss-Newton, at most
ENOUGH = 1e-4  # [m] and [rad]: no pose moves further than this any more
SETTLED = 1e-9  # damping that keeps the equations solvable


@dataclass(frozen=True, eq=False)
class Edge:
    """Pose `b` as measured from pose `a`."""

    a: int
    b: int
    move: Pose  # a_from_b
    covariance: Array  # (3, 3) of x [m], y [m], heading [rad] in the frame of a
    doubted: bool = False  # may be wrong altogether: weighs less the more it contradicts


@dataclass(frozen=True)
class Solution:
    """Where the measurements want the poses."""

    poses: Array  # (N, 3)
    weights: Array  # (E,) 0..1: how far each edge was believed
    squared: Array  # (E,) squared Mahalanobis distance that is left; 3 degrees of freedom


class _Edges:
    """Edges side by side in arrays."""

    def __init__(self, edges: Sequence[Edge]) -> None:
        self.a = np.array([edge.a for edge in edges])
        self.b = np.array([edge.b for edge in edges])
        self.moves = np.array([edge.move.vector for edge in edges])
        self.doubted = np.array([edge.doubted for edge in edges])
        covariances = np.array([edge.covariance for edge in edges])
        self.roots = np.linalg.inv(np.linalg.cholesky(covariances))  # (E, 3, 3): whiten an error


def edge_errors(poses: Array, a: Array, b: Array, moves: Array) -> Array:
    """Poses (N, 3), edges a (E,) → b (E,) measured as moves (E, 3) → errors (E, 3) in the frames of a."""
    dx, dy = (poses[b, :2] - poses[a, :2]).T
    c, s = np.cos(poses[a, 2]), np.sin(poses[a, 2])
    turn = wrap_all(poses[b, 2] - poses[a, 2] - moves[:, 2])
    return np.column_stack((c * dx + s * dy - moves[:, 0], -s * dx + c * dy - moves[:, 1], turn))


def edge_jacobians(poses: Array, a: Array, b: Array) -> tuple[Array, Array]:
    """Change of the errors (E, 3, 3) with the poses a and with the poses b."""
    dx, dy = (poses[b, :2] - poses[a, :2]).T
    c, s = np.cos(poses[a, 2]), np.sin(poses[a, 2])
    none, one = np.zeros_like(c), np.ones_like(c)
    of_a = np.array([[-c, -s, -s * dx + c * dy], [s, -c, -c * dx - s * dy], [none, none, -one]])
    of_b = np.array([[c, s, none], [-s, c, none], [none, none, one]])
    return of_a.transpose(2, 0, 1), of_b.transpose(2, 0, 1)


def solve(poses: Array, edges: Sequence[Edge], doubt: float) -> Generator[None, None, Solution]:
    """Poses (N, 3), the first of which stays → where the edges want them; one round with every `next`.

    Gauss-Newton with Cauchy weights 1 / (1 + d² / doubt²) on the doubted edges (Huber 1981; as in Kümmerle et al.,
    g2o, ICRA 2011), d² the squared Mahalanobis distance.
    """
    held, poses = _Edges(edges), poses.copy()
    squared, weights = _weigh(poses, held, doubt)
    for _ in range(ROUNDS):
        step = _step(poses, held, weights)
        poses[1:] += step
        poses[:, 2] = wrap_all(poses[:, 2])
        squared, weights = _weigh(poses, held, doubt)
        if np.abs(step).max(initial=0.0) < ENOUGH:
            break
        yield
    return Solution(poses, weights, squared)


class Marginals:
    """How sure each of the poses (N, 3) is, in the axes of the first, which is certain; factored once for all."""

    def __init__(self, poses: Array, edges: Sequence[Edge]) -> None:
        held = _Edges(edges)
        self.count = len(poses)
        self._factor = _factor(_normal_equations(poses, held, np.ones(len(held.a)))[0])

    def at(self, node: int) -> Array:
        """Covariance (3, 3) of that pose."""
        if not node:
            return np.zeros((3, 3))
        columns = np.zeros((3 * self.count - 3, 3))
        columns[3 * node - 3 : 3 * node] = np.eye(3)
        block = self._factor.solve(columns)[3 * node - 3 : 3 * node]
        return 0.5 * (block + block.T)


def _weigh(poses: Array, held: _Edges, doubt: float) -> tuple[Array, Array]:
    whitened = np.einsum("eij,ej->ei", held.roots, edge_errors(poses, held.a, held.b, held.moves))
    squared = (whitened**2).sum(axis=1)
    return squared, np.where(held.doubted, 1.0 / (1.0 + squared / doubt**2), 1.0)


def _step(poses: Array, held: _Edges, weights: Array) -> Array:
    """One round's change of all poses but the first (N - 1, 3)."""
    system, slope = _normal_equations(poses, held, weights)
    return _factor(system).solve(-slope).reshape(-1, 3)


def _normal_equations(poses: Array, held: _Edges, weights: Array) -> tuple[Any, Array]:
    """The sparse JᵀWJ and Jᵀ W e over all poses but the first."""
    rows = np.arange(3)
    weigh = np.sqrt(weights)[:, None, None] * held.roots
    of_a, of_b = (weigh @ jacobian for jacobian in edge_jacobians(poses, held.a, held.b))
    errors = np.einsum("eij,ej->ei", weigh, edge_errors(poses, held.a, held.b, held.moves))
    size = 3 * len(poses)
    slope = np.zeros(size)
    values, at, to = [], [], []
    for one, first in ((of_a, held.a), (of_b, held.b)):
        np.add.at(slope, 3 * first[:, None] + rows, np.einsum("eki,ek->ei", one, errors))
        for other, second in ((of_a, held.a), (of_b, held.b)):
            values.append(np.einsum("eki,ekj->eij", one, other).ravel())
            at.append(np.broadcast_to(3 * first[:, None, None] + rows[:, None], (len(first), 3, 3)).ravel())
            to.append(np.broadcast_to(3 * second[:, None, None] + rows[None, :], (len(first), 3, 3)).ravel())
    entries = (np.concatenate(values), (np.concatenate(at), np.concatenate(to)))
    system: Any = sparse.coo_matrix(entries, shape=(size, size)).tocsc()
    return system[3:, 3:] + SETTLED * sparse.identity(size - 3, format="csc"), slope[3:]


def _factor(system: Any) -> Any:
    options = {"SymmetricMode": True}
    return linalg.splu(system, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)


def compose_covariance(base: Pose, spread: Array, local: Pose, inner: Array) -> Array:
    """A pose seen from an uncertain base → its covariance (3, 3) in the outer axes.

    `spread` (3, 3) of the base in the outer axes, `inner` (3, 3) of the local pose in the base's axes.
    """
    c, s = math.cos(base.heading), math.sin(base.heading)
    carry, onto = np.eye(3), np.eye(3)
    carry[:2, 2] = -(s * local.x + c * local.y), c * local.x - s * local.y
    onto[:2, :2] = [[c, -s], [s, c]]
    return carry @ spread @ carry.T + onto @ inner @ onto.T
