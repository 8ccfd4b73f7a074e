import itertools
import math

import numpy as np
import pytest
from scipy.special import chdtri

from core.geometry import Pose
from core.perception.landmarks.landmarks import Sighting
from core.slam.association.joint_compatibility import JointCandidates
from core.slam.ekf.filter import Filter
from core.slam.ekf.measurement_model import expected
from core.slam.ekf_slam import EkfSettings, EkfSlam
from core.slam.motion import Increment
from tests.core.slam.filter_states import FORMS, some_filter

SHARP = np.diag([0.02**2, math.radians(0.5) ** 2])
WIDE = np.diag([0.15**2, 0.15**2, 0.05**2])  # [m²], [rad²]: a robot that knows little of where it is
PAIRS = [(3.0, 1.0), (3.0, 1.25), (3.0, -1.0), (3.0, -1.25)]  # two pairs of landmarks, each 25 cm apart
GATE, MARGIN = 13.8, 2.0


def seen_from(pose: Pose, places: list[tuple[float, float]]) -> list[Sighting]:
    return [Sighting(range=pose.distance_to(*p), bearing=pose.bearing_to(*p), covariance=SHARP) for p in places]


def uncertain(**settings: float) -> EkfSlam:
    """A filter that knows four landmarks in two pairs, and then its place less well than they are apart."""
    slam = EkfSlam(EkfSettings(still_every=1, **settings))
    for _ in range(5):
        slam.see(seen_from(Pose(), PAIRS))
    slam.advance(Increment(Pose(1e-3, 0.0, 0.0), WIDE))
    return slam


def candidates(form: type[Filter], seed: int, sightings: int = 3, landmarks: int = 4) -> JointCandidates:
    """Sightings from somewhere within what the filter believes possible."""
    state, rng = some_filter(form, landmarks, seed, size=0.08), np.random.default_rng(seed)
    noises = np.repeat(4e-4 * np.eye(2)[None], sightings, 0)
    expectations = expected(state.pose, state.places)[0]
    seen = expectations[rng.permutation(landmarks)[:sightings]] + rng.normal(0, 0.1, (sightings, 2))
    return JointCandidates(
        seen[:, None] - expectations[None],
        state.innovate(np.arange(landmarks), expectations).state,
        noises,
        np.ones((sightings, landmarks), dtype=bool),
    )


def all_costs(told: JointCandidates) -> dict[tuple[tuple[int, int], ...], float]:
    """Every jointly compatible assignment and its cost, by the whole matrices at once."""
    count, landmarks = told.allowed.shape
    sizes = [
        max(
            math.log(np.linalg.det(told.states[2 * j : 2 * j + 2, 2 * j : 2 * j + 2] + told.noises[i]))
            for j in range(landmarks)
        )
        - math.log(np.linalg.det(told.noises[i]))
        for i in range(count)
    ]
    costs = {}
    for choice in itertools.product([*range(landmarks), None], repeat=count):
        pairs = tuple((i, j) for i, j in enumerate(choice) if j is not None)
        if len({j for _, j in pairs}) < len(pairs):
            continue
        cost = sum(GATE + sizes[i] for i, j in enumerate(choice) if j is None)
        if pairs:
            held = [2 * j + k for _, j in pairs for k in (0, 1)]
            noise = np.kron(np.eye(len(pairs)), told.noises[0])
            spread = told.states[np.ix_(held, held)] + noise
            off = np.concatenate([told.residuals[i, j] for i, j in pairs])
            distance = float(off @ np.linalg.solve(spread, off))
            if distance >= chdtri(2 * len(pairs), math.exp(-GATE / 2)):
                continue
            cost += distance + np.linalg.slogdet(spread)[1] - np.linalg.slogdet(noise)[1]
        costs[pairs] = cost
    return costs


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("seed", range(8))
def test_what_is_found_by_branches_is_what_all_assignments_together_say(form: type[Filter], seed: int) -> None:
    told = candidates(form, seed)
    costs = all_costs(told)
    least = min(costs.values())
    agreed = set.intersection(*(set(pairs) for pairs, cost in costs.items() if cost <= least + MARGIN))
    assert told.assign(gate=GATE, margin=MARGIN, nodes=10_000) == tuple(sorted(agreed))


def test_too_many_branches_are_given_up() -> None:
    assert candidates(FORMS[0], 0, sightings=6, landmarks=8).assign(gate=1e3, margin=1e3, nodes=50) is None


def test_what_is_doubtful_alone_is_clear_together() -> None:
    """Alone, the first fits either of its pair; with the second, only one of them has the robot in one place."""
    truth = Pose(0.001, -0.11, 0.0)
    for nodes, landmarks in ((300, [1, 3]), (0, [None, 3])):
        slam = uncertain(joint_nodes=nodes)
        slam.see(seen_from(truth, [PAIRS[0], PAIRS[2]]))
        assert [association.landmark for association in slam.associations] == landmarks
        assert slam.filter.pose.distance_to(truth.x, truth.y) < 0.11


def test_one_sighting_of_a_pair_stays_unused_while_the_robot_does_not_know_its_place() -> None:
    slam = uncertain()
    before = slam.filter.pose
    slam.see(seen_from(Pose(0.001, -0.11, 0.0), PAIRS[:1]))
    assert slam.associations[0].fate == "ignored"
    assert slam.filter.pose == before
