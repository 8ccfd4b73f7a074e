"""The corridor loop: odometry increments with covariance, and sightings among clutter.

`odo` (K, 3): increments x, y [m], heading [rad] in the robot frame; `odo_cov` (K, 6): xx xy xt yy yt tt; `obs`
(M, 4): step k (seen after increment k, the first is 0), id (-1: clutter), range [m], bearing [rad].
"""

import math

import numpy as np

from core.errors import BadInput
from core.geometry import Pose
from core.recording.npz import Archive
from core.recording.read_report import ReadReport
from core.recording.recording import SightingRecording
from core.recording.sightings import MOST_ROWS, Ids, SightingSteps, grouped
from core.slam.motion import Increment

STEP_S = 0.2  # between steps: 5 Hz
SIGHTING_NOISE = 0.03, math.radians(0.6)  # [m], [rad]
UPPER = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])  # where the six columns stand in a covariance


def read(archive: Archive, ids: Ids) -> SightingRecording:
    """The whole log; step k is stamped (k + 1) · 0.2 s. With given ids, clutter is left out. Raises BadInput."""
    increments, covariances, rows = archive.floats("odo", 3), archive.floats("odo_cov", 6), archive.floats("obs", 4)
    if len(increments) != len(covariances) or len(increments) > MOST_ROWS:
        raise BadInput(f"odo and odo_cov in {archive.path.name} do not fit together.")
    tally = ReadReport(archive.path)
    by_step = grouped(rows[:, 0], rows[:, 1:])
    beyond = [k for k in by_step if not 0 <= k < len(increments)]
    tally.skip("its step is not one of the log", count=sum(len(by_step.pop(k)) for k in beyond))
    moved = Increment()
    steps = SightingSteps(SIGHTING_NOISE, ids, tally)
    for k, (increment, covariance) in enumerate(zip(increments.tolist(), covariances, strict=True)):
        moved = moved.then(Increment(Pose(*increment), covariance[UPPER]))
        if k in by_step:
            steps.add((k + 1) * STEP_S, moved, by_step[k])
            moved = Increment()
    tally.topics = ["odo: odometry", "obs: sightings"]
    return steps.finish(archive.path, "corridor loop")
