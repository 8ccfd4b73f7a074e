"""The pose graph: its derivatives by differences, and that it bends to measurements and not to nonsense."""

import math
from collections.abc import Generator
from typing import TypeVar

import numpy as np
import pytest

from core.geometry import Pose, wrap_all
from core.slam.map.pose_graph import (
    EdgeTable,
    Equations,
    GraphEdge,
    GraphSolution,
    Marginals,
    compose_covariance,
    edge_errors,
    edge_jacobians,
    solve,
    whitening,
)

T = TypeVar("T")
SURE = np.diag([0.02**2, 0.03**2, math.radians(0.5) ** 2])


def whole(labour: Generator[None, None, T]) -> T:
    """All pieces at once."""
    while True:
        try:
            next(labour)
        except StopIteration as end:
            return end.value


def ring(rng: np.random.Generator, count: int = 40) -> tuple[list[Pose], np.ndarray, list[GraphEdge]]:
    """Poses on a circle, dead reckoning along it, and what was measured from each to the next."""
    turn = 2 * math.pi / count
    truth, reckoned, edges = [Pose()], [Pose()], list[GraphEdge]()
    root = np.linalg.cholesky(SURE)
    for k in range(count - 1):
        step = Pose(1.0, 0.0, turn)
        noisy = Pose(*(step.vector + root @ rng.normal(size=3)).tolist())
        truth.append(truth[-1] @ step)
        reckoned.append(reckoned[-1] @ noisy)
        edges.append(GraphEdge(k, k + 1, noisy, SURE))
    return truth, np.array([pose.vector for pose in reckoned]), edges


def test_the_jacobians_are_those_of_differences() -> None:
    rng = np.random.default_rng(1)
    poses = rng.normal(size=(6, 3)) * (3.0, 3.0, 2.0)
    a, b, moves = np.array([0, 3, 5]), np.array([1, 2, 4]), rng.normal(size=(3, 3))
    for own, jacobian in zip((a, b), edge_jacobians(poses, a, b), strict=True):
        for axis in range(3):
            ahead, behind = poses.copy(), poses.copy()
            ahead[own, axis] += 1e-6
            behind[own, axis] -= 1e-6
            apart = edge_errors(ahead, a, b, moves) - edge_errors(behind, a, b, moves)
            apart[:, 2] = wrap_all(apart[:, 2])
            assert jacobian[:, :, axis] == pytest.approx(apart / 2e-6, abs=1e-6)


def test_white_errors_have_the_unit_for_their_covariance() -> None:
    mixed = np.random.default_rng(7).normal(size=(20, 3, 3))
    covariances = mixed @ mixed.transpose(0, 2, 1) + SURE
    roots = whitening(covariances)
    white = roots @ covariances @ roots.transpose(0, 2, 1)
    assert white == pytest.approx(np.broadcast_to(np.eye(3), (20, 3, 3)), abs=1e-8)


def test_a_closed_circle_comes_back_to_where_it_began() -> None:
    truth, reckoned, edges = ring(np.random.default_rng(2))
    closing = GraphEdge(0, 39, truth[39], SURE, doubted=True)
    solved = whole(solve(reckoned, EdgeTable.of([*edges, closing]), 3.0))
    places = np.array([pose.vector[:2] for pose in truth])
    before = np.hypot(*(reckoned[:, :2] - places).T)
    after = np.hypot(*(solved.poses[:, :2] - places).T)
    assert after[39] < 0.1 < before[39]
    assert after.mean() < 0.5 * before.mean()
    assert solved.weights[-1] > 0.5


def test_one_wrong_closure_among_right_ones_is_not_believed() -> None:
    truth, reckoned, edges = ring(np.random.default_rng(3))
    right = [GraphEdge(k, 39 - k, truth[k].inverse() @ truth[39 - k], SURE, doubted=True) for k in range(3)]
    wrong = GraphEdge(5, 25, Pose(0.3, 0.2, 1.0), SURE, doubted=True)
    solved = whole(solve(reckoned, EdgeTable.of([*edges, *right, wrong]), 3.0))
    places = np.array([pose.vector[:2] for pose in truth])
    assert np.hypot(*(solved.poses[:, :2] - places).T).max() < 0.5
    assert solved.squared[-1] > 30 > solved.squared[-4:-1].max()
    assert solved.weights[-1] < 0.05


def test_without_closures_nothing_moves() -> None:
    _, reckoned, edges = ring(np.random.default_rng(4))
    solved: GraphSolution = whole(solve(reckoned, EdgeTable.of(edges), 3.0))
    assert solved.poses == pytest.approx(reckoned, abs=1e-9)


def test_marginals_are_blocks_of_the_dense_inverse() -> None:
    truth, _, edges = ring(np.random.default_rng(5), 8)
    edges.append(GraphEdge(0, 7, truth[7], SURE))
    poses = np.array([pose.vector for pose in truth])
    whole_information = np.zeros((24, 24))
    for edge in edges:
        of_a, of_b = (one[0] for one in edge_jacobians(poses, np.array([edge.a]), np.array([edge.b])))
        jacobian = np.zeros((3, 24))
        jacobian[:, 3 * edge.a : 3 * edge.a + 3], jacobian[:, 3 * edge.b : 3 * edge.b + 3] = of_a, of_b
        whole_information += jacobian.T @ np.linalg.solve(edge.covariance, jacobian)
    inverse = np.linalg.inv(whole_information[3:, 3:])
    equations = Equations(EdgeTable.of(edges), 8)
    marginals = Marginals(equations.order, equations.at(poses)[0])
    told = np.array([marginals.at(node) for node in (0, 3, 7)])
    assert not told[0].any()
    assert told[1] == pytest.approx(inverse[6:9, 6:9], rel=1e-5, abs=1e-12)
    assert told[2] == pytest.approx(inverse[18:21, 18:21], rel=1e-5, abs=1e-12)


def test_a_pose_in_an_uncertain_submap_is_as_uncertain_as_draws_of_both() -> None:
    rng = np.random.default_rng(6)
    base, local = Pose(3.0, -2.0, 0.7), Pose(4.0, 1.0, -0.4)
    spread, inner = 0.01 * SURE, 0.02 * SURE
    draws = np.array(
        [
            (
                Pose(*rng.multivariate_normal(base.vector, spread).tolist())
                @ Pose(*rng.multivariate_normal(local.vector, inner).tolist())
            ).vector
            for _ in range(4000)
        ]
    )
    told = compose_covariance(base, spread, local, inner)
    assert np.cov(draws.T) == pytest.approx(told, rel=0.12, abs=0.06 * np.abs(told).max())
