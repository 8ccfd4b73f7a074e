"""The content of one frame: beams, corners and landmarks, in the robot frame of its stamp."""

from __future__ import annotations

from core.geometry import Pose
from core.message import Array, message
from core.perception.landmarks.edge_pairs import EdgePair
from core.perception.landmarks.landmarks import Sighting


@message
class Beams:
    """A scan without the robot's motion in it."""

    ends: Array  # (N, 2) [m], NaN where nothing was measured
    hits: Array  # (N,) bool: ends that are something
    viewpoint: Pose = Pose()  # robot_from_laser of the laser that took it

    @property
    def points(self) -> Array:
        """The ends that are something, (M, 2) [m]."""
        return self.ends[self.hits]


@message
class FramePerception:
    """Beams, sightings and edge pairs of one frame."""

    beams: Beams | None = None  # None: no scan came with this frame
    sightings: tuple[Sighting, ...] | None = None  # of landmarks; None: no scan came
    pairs: tuple[EdgePair, ...] = ()  # corners and the edges near them: whether the camera's mount has moved
