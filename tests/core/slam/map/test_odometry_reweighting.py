"""Wheels that err alike at every turn do not bend what the walls tell, and count where these tell nothing."""

import math

import numpy as np

from core.geometry import Pose
from core.slam.map.map_graph import reweighted
from core.slam.map.pose_graph import EdgeTable, GraphEdge, solve
from tests.core.slam.map.test_pose_graph import whole

WHEELS = np.diag([0.004**2, 0.004**2, math.radians(0.2) ** 2])
WALLS = np.diag([0.01**2, 0.01**2, math.radians(0.2) ** 2])
CORRIDOR = np.diag([0.5**2, 0.01**2, math.radians(0.2) ** 2])
STEP = Pose(0.2, 0.0, math.radians(30))
ASIDE = Pose(0.05, 0.0, 0.0)  # robot_from_laser: the wheels tell of the robot, the walls of the laser


def driven(count: int, error: Pose = ASIDE) -> tuple[list[Pose], list[GraphEdge]]:
    """Where the laser goes, and the robot's steps taken for its own."""
    poses, edges = [Pose()], list[GraphEdge]()
    for k in range(count):
        poses.append(poses[-1] @ (error.inverse() @ STEP @ error))
        edges.append(GraphEdge(k, k + 1, STEP, WHEELS))
    return poses, edges


def measured(poses: list[Pose], covariance: np.ndarray, reach: int = 3) -> list[GraphEdge]:
    """Every pose from the `reach` ones before it, without an error."""
    pairs = [(a, b) for b in range(len(poses)) for a in range(max(0, b - reach), b)]
    return [GraphEdge(a, b, poses[a].inverse() @ poses[b], covariance, doubted=True) for a, b in pairs]


def test_a_systematic_error_of_the_wheels_does_not_bend_the_map() -> None:
    poses, coarse = driven(20)
    truth, fine = np.array([pose.vector for pose in poses]), EdgeTable.of(measured(poses, WALLS))

    def off(edges: EdgeTable) -> float:
        found = whole(solve(truth, edges + fine, 3.0)).poses
        return float(np.hypot(*(found - truth)[:, :2].T).max())

    assert off(EdgeTable.of(coarse)) > 0.04
    assert off(reweighted(EdgeTable.of(coarse), fine, truth[:, 2])) < 0.005


def test_along_a_bare_corridor_the_wheels_keep_their_say() -> None:
    poses = [Pose(0.5 * k, 0.0, 0.0) for k in range(10)]
    coarse = [GraphEdge(k, k + 1, Pose(0.5, 0.0, 0.0), 9.0 * WHEELS) for k in range(9)]
    found = reweighted(EdgeTable.of(coarse), EdgeTable.of(measured(poses, CORRIDOR)), np.zeros(10))
    assert len(found) == 9
    for covariance in found.covariances:
        along, aside, turn = np.sqrt(np.diag(covariance))
        assert along < 0.02
        assert aside > 0.2
        assert turn > math.radians(5)


def test_what_no_way_along_fine_edges_leads_to_is_held_as_before() -> None:
    poses, coarse = driven(9)
    before, fine = EdgeTable.of(coarse), EdgeTable.of(measured(poses[:5], WALLS))
    found = reweighted(before, fine, np.array([pose.heading for pose in poses]))
    assert np.array_equal(found.covariances[4:], before.covariances[4:])
    assert (found.covariances[:4, 0, 0] > 100 * WHEELS[0, 0]).all()
    for now, then in ((found.a, before.a), (found.b, before.b), (found.moves, before.moves)):
        assert np.array_equal(now, then)
    assert reweighted(before, EdgeTable.of([]), np.zeros(10)) is before


def test_a_way_that_nobody_measured_stays_unknown() -> None:
    poses, coarse = driven(4)
    coarse[1] = GraphEdge(1, 2, STEP, np.diag([1e4, 1e4, 1e2]))
    measurements = EdgeTable.of(measured(poses, WALLS))
    found = reweighted(EdgeTable.of(coarse), measurements, np.array([pose.heading for pose in poses]))
    assert np.array_equal(found.covariances[1], coarse[1].covariance)
    assert found.covariances[0, 0, 0] > 100 * WHEELS[0, 0]
