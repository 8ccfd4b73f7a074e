"""The paper's figure 16 on frozen draws: the filter alone, identities given."""

from collections import defaultdict
from pathlib import Path
from typing import Literal

import numpy as np
import pytest

from core.geometry import Pose
from core.perception.landmarks.landmarks import Sighting
from core.slam.ekf_slam import EkfSettings, EkfSlam
from core.slam.motion import Increment, MotionSettings, steered

pytestmark = pytest.mark.real_data

Mode = Literal["invariant", "paper"]
NOISE = np.diag([0.08**2, np.radians(1.0) ** 2])
MOTION = MotionSettings()
RUNS = 40
EVERY_RUN = pytest.mark.campaign


@pytest.fixture(scope="module")
def draws(shared_data: Path) -> dict[str, np.ndarray]:
    with np.load(shared_data / "seed-mc" / "seed_mc40.npz") as archive:
        return dict(archive)


def sightings_of(rows: np.ndarray, given: bool) -> list[Sighting]:
    return [
        Sighting(range=r, bearing=phi, covariance=NOISE, id=int(name) if given else None)
        for name, r, phi in rows[:, -3:]
    ]


def run(
    draws: dict[str, np.ndarray], number: int, mode: Mode, still: bool, given: bool = True
) -> tuple[float, float]:
    """One of the forty runs → mean position error [m] over the sighting times, mean NEES."""
    slam = EkfSlam(EkfSettings(mode=mode, still_every=1, soft_gate=0.0))  # the draws have no outliers to doubt
    frames = draws["still_obs"][draws["still_obs"][:, 0] == number]
    for index in range(10 if still else 0):
        slam.see(sightings_of(frames[frames[:, 1] == index], given))
    seen = defaultdict(list)
    for row in draws["obs"][draws["obs"][:, 0] == number]:
        seen[int(row[1])].append(row)
    errors, squared = [], []
    for step in range(1, 1281):
        speed, steer = draws["v_noisy"][number, step - 1], draws["steer_noisy"][number, step - 1]
        slam.advance(steered(speed, steer, 0.025, MOTION))
        if step % 8 == 0:
            slam.see(sightings_of(np.array(seen[step]).reshape(-1, 5), given))
            truth = Pose(*draws["truth"][step].tolist())
            errors.append(slam.estimate.pose.distance_to(truth.x, truth.y))
            squared.append(slam.nees(truth))
    return float(np.mean(errors)), float(np.mean(squared))


@pytest.mark.parametrize(
    ("runs", "worst", "mean"),
    [(range(6), 0.269, 0.168), pytest.param(range(RUNS), 0.269, 0.1347, marks=EVERY_RUN)],
    ids=["six", "all"],
)
def test_dead_reckoning_errs_as_the_paper_s(
    draws: dict[str, np.ndarray], runs: range, worst: float, mean: float
) -> None:
    averages = []
    for number in runs:
        way, errors = Increment(), []
        for step in range(1280):
            speed, steer = draws["v_noisy"][number, step], draws["steer_noisy"][number, step]
            way = Increment(way.pose @ steered(speed, steer, 0.025, MOTION).pose)
            errors.append(
                np.hypot(way.pose.x - draws["truth"][step + 1, 0], way.pose.y - draws["truth"][step + 1, 1])
            )
        averages.append(np.mean(errors))
    assert max(averages) == pytest.approx(worst, abs=0.002)
    assert np.mean(averages) == pytest.approx(mean, abs=0.001)


@pytest.mark.parametrize(
    "runs", [range(1), pytest.param(range(0, RUNS, 8), marks=EVERY_RUN)], ids=["one", "every_eighth"]
)
def test_unknown_identities_cost_nothing_here(draws: dict[str, np.ndarray], runs: range) -> None:
    given = np.array([run(draws, number, "invariant", still=True) for number in runs])
    hidden = np.array([run(draws, number, "invariant", still=True, given=False) for number in runs])
    assert hidden[:, 0].max() < 1.1 * given[:, 0].max()
