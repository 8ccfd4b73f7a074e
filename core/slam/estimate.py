"""The output of an estimator: the pose, the landmarks, and their covariances."""

from typing import Literal

from core.geometry import Pose
from core.message import Array, message


@message
class Estimate:
    """A pose and how sure it is."""

    pose: Pose
    covariance: Array  # (3, 3) of x, y, heading in the world frame


@message
class Landmark:
    """A row of the paper's table L = (x, y, h, m)."""

    id: int
    position: Array  # (2,) [m], world
    covariance: Array  # (2, 2) [m²]
    hits: int
    misses: int
    kind: str = ""  # "convex" | "concave" | ""


@message
class Association:
    """The association of one sighting in the newest update."""

    position: Array  # (2,) [m], world: where the sighting lies by the present estimate
    landmark: int | None  # whose it is
    fate: Literal["matched", "tentative", "new", "ignored"]


@message
class SlamHealth:
    """The health of the filter."""

    mode: str = ""  # "invariant" | "paper" | "dead_reckoning"
    updates: int = 0
    nis: float | None = None  # normalised innovation squared per degree of freedom, running mean; ideal 1
    matched: int = 0  # in the newest update
    ignored: int = 0
    tentative: int = 0
    update_ms: float | None = None
    looking_around: bool = False  # the still start: motion waits
    slipping: bool = False  # the newest sightings say together that the robot is not where its wheels say
