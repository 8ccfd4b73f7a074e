"""Poses held together by relative measurements: robust least squares in the plane."""

from __future__ import annotations

import math
from collections.abc import Generator, Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
import scipy

from core.geometry import Pose, wrap_all
from core.message import Array

MAX_ROUNDS = 12  # of Gauss-Newton, at most
CONVERGED_STEP = 1e-4  # [m] and [rad]: no pose moves further than this any more
MIN_DAMPING = 1e-9  # damping that keeps the equations solvable


@dataclass(frozen=True, eq=False)
class GraphEdge:
    """Pose `b` as measured from pose `a`."""

    a: int
    b: int
    move: Pose  # a_from_b
    covariance: Array  # (3, 3) of x [m], y [m], heading [rad] in the frame of a
    doubted: bool = False  # may be wrong altogether: weighs less the more it contradicts

    @cached_property
    def row(self) -> Array:
        """The same as a row of numbers (EdgeTable.COLUMNS,)."""
        move = self.move
        return np.array(
            (self.a, self.b, move.x, move.y, move.heading, *self.covariance.ravel().tolist(), self.doubted),
            np.float64,
        )


@dataclass(frozen=True)
class GraphSolution:
    """The poses that fit the measurements best."""

    poses: Array  # (N, 3)
    weights: Array  # (E,) 0..1: how far each edge was believed
    squared: Array  # (E,) squared Mahalanobis distance that is left; 3 degrees of freedom


@dataclass(frozen=True, eq=False)
class EdgeTable:
    """Edges side by side."""

    COLUMNS: ClassVar[int] = 15  # of an edge as a row: a, b, move, covariance, doubted

    a: Array  # (E,) int
    b: Array  # (E,) int
    moves: Array  # (E, 3)
    covariances: Array  # (E, 3, 3)
    doubted: Array  # (E,) bool

    @staticmethod
    def of(edges: Iterable[GraphEdge]) -> EdgeTable:
        """Single edges, in their order."""
        return EdgeTable.of_rows(
            np.concatenate([np.zeros(0), *(edge.row for edge in edges)]).reshape(-1, EdgeTable.COLUMNS)
        )

    @staticmethod
    def of_rows(rows: Array) -> EdgeTable:
        """Edges as rows (E, COLUMNS)."""
        covariances = rows[:, 5:14].reshape(-1, 3, 3)
        return EdgeTable(rows[:, 0].astype(int), rows[:, 1].astype(int), rows[:, 2:5], covariances, rows[:, 14] > 0)

    def __len__(self) -> int:
        return len(self.a)

    def __add__(self, more: EdgeTable) -> EdgeTable:
        """These edges, then those."""
        return EdgeTable(
            np.concatenate((self.a, more.a)),
            np.concatenate((self.b, more.b)),
            np.concatenate((self.moves, more.moves)),
            np.concatenate((self.covariances, more.covariances)),
            np.concatenate((self.doubted, more.doubted)),
        )

    def where(self, chosen: Array) -> EdgeTable:
        """The chosen (E,) bool of these edges."""
        each = (self.a, self.b, self.moves, self.covariances, self.doubted)
        return EdgeTable(*(column[chosen] for column in each))

    def believed(self, covariances: Array) -> EdgeTable:
        """The same measurements with other covariances (E, 3, 3)."""
        return replace(self, covariances=covariances)


def whitening(covariances: Array) -> Array:
    """Covariances (E, 3, 3) → the inverse of their Cholesky factors (E, 3, 3): they make an error white."""
    (a, _, _), (b, c, _), (d, e, f) = np.linalg.cholesky(covariances).transpose(1, 2, 0)
    roots = np.zeros_like(covariances)
    roots[:, 0, 0], roots[:, 1, 1], roots[:, 2, 2] = 1 / a, 1 / c, 1 / f
    roots[:, 1, 0], roots[:, 2, 1] = -b / (a * c), -e / (c * f)
    roots[:, 2, 0] = (b * e - c * d) / (a * c * f)
    return roots


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


def solve(poses: Array, edges: EdgeTable, doubt: float) -> Generator[None, None, GraphSolution]:
    """Poses (N, 3), the first of which stays → where the edges want them; half a round with every `next`.

    Gauss-Newton with Cauchy weights 1 / (1 + d² / doubt²) on the doubted edges (Huber 1981; as in Kümmerle et al.,
    g2o, ICRA 2011), d² the squared Mahalanobis distance.
    """
    equations, poses = Equations(edges, len(poses)), poses.copy()
    squared, weights = equations.weigh(poses, doubt)
    yield
    for _ in range(MAX_ROUNDS):
        system, slope = equations.at(poses, weights)
        yield
        step = equations.by_pose(_factor(system, "NATURAL").solve(-slope))
        poses[1:] += step
        poses[:, 2] = wrap_all(poses[:, 2])
        squared, weights = equations.weigh(poses, doubt)
        if np.abs(step).max(initial=0.0) < CONVERGED_STEP:
            break
        yield
    return GraphSolution(poses, weights, squared)


class Equations:
    """The normal equations JᵀWJ and JᵀWe over all poses but the first; where their blocks lie is found once for all.

    The blocks are ordered so that the factors stay sparse: by minimum degree on the poses, of which there are a third
    as many as unknowns.
    """

    def __init__(self, edges: EdgeTable, count: int) -> None:
        self._edges = edges
        self._roots = whitening(edges.covariances)
        self._size = size = count - 1
        self.order = _order(edges, count)  # (N,) from pose to block; -1: the first pose, which stays
        a, b, every = self.order[edges.a], self.order[edges.b], np.arange(size)
        rows, columns = np.concatenate((a, b, a, b, every)), np.concatenate((a, b, b, a, every))
        kept = np.flatnonzero((rows >= 0) & (columns >= 0))
        keys, slot = np.unique(rows[kept] * size + columns[kept], return_inverse=True)
        self._indices, self._indptr = keys % size, np.searchsorted(keys, size * np.arange(size + 1))
        self._gather = scipy.sparse.csr_matrix((np.ones(len(kept)), (slot, kept)), shape=(len(keys), len(rows)))

    def weigh(self, poses: Array, doubt: float) -> tuple[Array, Array]:
        """Poses (N, 3) → squared Mahalanobis distance (E,) and weight (E,) of every edge."""
        edges = self._edges
        errors = edge_errors(poses, edges.a, edges.b, edges.moves)
        squared = (np.einsum("eij,ej->ei", self._roots, errors) ** 2).sum(axis=1)
        return squared, np.where(edges.doubted, 1.0 / (1.0 + squared / doubt**2), 1.0)

    def by_pose(self, change: Array) -> Array:
        """Reorder the solution of the equations (3N - 3,) → the change of all poses but the first (N - 1, 3)."""
        return change.reshape(-1, 3)[self.order[1:]]

    def at(self, poses: Array, weights: Array | None = None) -> tuple[Any, Array]:
        """Poses (N, 3), weights (E,) → JᵀWJ (3N - 3, 3N - 3), sparse, and JᵀWe (3N - 3,), both block by block.

        Without weights, every edge is believed.
        """
        edges, size = self._edges, self._size
        weigh = self._roots if weights is None else np.sqrt(weights)[:, None, None] * self._roots
        of_a, of_b = (weigh @ jacobian for jacobian in edge_jacobians(poses, edges.a, edges.b))
        errors = np.einsum("eij,ej->ei", weigh, edge_errors(poses, edges.a, edges.b, edges.moves))
        slope = np.zeros((size + 1, 3))  # the last row takes what would move the first pose
        for one, first in ((of_a, edges.a), (of_b, edges.b)):
            np.add.at(slope, self.order[first], np.einsum("eki,ek->ei", one, errors))
        mixed = of_a.transpose(0, 2, 1) @ of_b
        own = (one.transpose(0, 2, 1) @ one for one in (of_a, of_b))
        settled = np.broadcast_to(MIN_DAMPING * np.eye(3), (size, 3, 3))
        parts = np.concatenate((*own, mixed, mixed.transpose(0, 2, 1), settled)).reshape(-1, 9)
        blocks = (self._gather @ parts).reshape(-1, 3, 3)
        whole: Any = scipy.sparse.bsr_matrix(
            (blocks, self._indices, self._indptr), shape=(3 * size, 3 * size)
        ).tocsr()
        entries = (whole.data, whole.indices, whole.indptr)  # by rows, which are the columns too
        return scipy.sparse.csc_matrix(entries, whole.shape), slope[:-1].ravel()


class Marginals:
    """How sure each of N poses is, in the axes of the first, which is certain; factored once for all."""

    def __init__(self, order: Array, system: Any) -> None:
        """`system` JᵀWJ (3N - 3, 3N - 3), sparse, and the `order` (N,) of its blocks: from Equations."""
        self._order, self._factor = order, _factor(system, "NATURAL")

    @property
    def count(self) -> int:
        """Number of the poses, N."""
        return len(self._order)

    def at(self, node: int) -> Array:
        """Covariance (3, 3) of that pose."""
        if not node:
            return np.zeros((3, 3))
        columns, place = np.zeros((3 * self.count - 3, 3)), 3 * int(self._order[node])
        columns[place : place + 3] = np.eye(3)
        block = self._factor.solve(columns)[place : place + 3]
        return 0.5 * (block + block.T)


def _order(edges: EdgeTable, count: int) -> Array:
    """Edges between `count` poses → place of every pose's block (N,); -1: the first pose."""
    ends = (np.concatenate((edges.a, edges.b)), np.concatenate((edges.b, edges.a)))
    linked: Any = scipy.sparse.coo_matrix((np.full(len(ends[0]), -1.0), ends), shape=(count, count)).tocsc()[1:, 1:]
    degrees = 1.0 - np.asarray(linked.sum(axis=0)).ravel()
    order = np.full(count, -1)
    order[1:] = _factor(linked + scipy.sparse.diags(degrees, format="csc"), "MMD_AT_PLUS_A").perm_c
    return order


def _factor(system: Any, order: str) -> Any:
    """`relax` 1: blocks of single columns are not merged into larger ones with zeros, as the order leaves few."""
    options = {"SymmetricMode": True}
    return scipy.sparse.linalg.splu(system, permc_spec=order, diag_pivot_thresh=0.0, relax=1, options=options)


def compose_covariance(base: Pose, spread: Array, local: Pose, inner: Array) -> Array:
    """A pose seen from an uncertain base → its covariance (3, 3) in the outer axes.

    `spread` (3, 3) of the base in the outer axes, `inner` (3, 3) of the local pose in the base's axes.
    """
    c, s = math.cos(base.heading), math.sin(base.heading)
    carry, onto = np.eye(3), np.eye(3)
    carry[:2, 2] = -(s * local.x + c * local.y), c * local.x - s * local.y
    onto[:2, :2] = [[c, -s], [s, c]]
    return carry @ spread @ carry.T + onto @ inner @ onto.T
