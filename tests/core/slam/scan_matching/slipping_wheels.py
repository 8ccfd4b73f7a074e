"""The course of a drive, and what wheels that slip by a few percent say of it."""

from collections.abc import Iterator

import numpy as np

from core.geometry import Pose, arc

PERIOD_S = 0.2  # from scan to scan
LEGS_S_M_S_RAD_S = (
    (2, 0, 0),
    (12, 0.2, 0.1),
    (7, 0.05, 0.6),
    (10, 0.25, -0.12),
    (6, 0.05, -0.7),
    (8, 0.25, 0.15),
    (2, 0, 0),
)  # how long, how fast, how quickly turning


def slipping_wheels(rng: np.random.Generator) -> Iterator[tuple[float, float, Pose, Pose]]:
    """Speed [m/s], turn rate [rad/s], true pose and that of the wheels, a period after the other."""
    truth, rolled = Pose(), Pose()
    for lasts, speed, rate in LEGS_S_M_S_RAD_S:
        for _ in range(round(lasts / PERIOD_S)):
            way, turn = speed * PERIOD_S, rate * PERIOD_S
            truth = truth @ arc(way, turn)
            rolled = rolled @ arc(1.02 * way + 0.02 * way * rng.normal(), 0.98 * turn + 0.03 * turn * rng.normal())
            yield speed, rate, truth, rolled
