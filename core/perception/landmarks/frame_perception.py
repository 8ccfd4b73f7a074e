"""What one frame shows: points, corners and landmarks, in the robot frame of its stamp."""

from __future__ import annotations

from core.message import Array, message
from core.perception.landmarks.edge_pairs import EdgePair
from core.perception.landmarks.landmarks import Sighting


@message
class FramePerception:
    """The points, corners and sightings of one frame."""

    sightings: tuple[Sighting, ...] | None = None  # None: no scan came with this frame
    ends: Array | None = None  # (N, 2) [m] beam ends, NaN where nothing was measured
    hits: Array | None = None  # (N,) bool: ends that are something
    pairs: tuple[EdgePair, ...] = ()  # corners and the edges near them: whether the camera's mount has moved

    @property
    def points(self) -> Array | None:
        """The ends that are something, (M, 2) [m]; None without a scan."""
        return None if self.ends is None or self.hits is None else self.ends[self.hits]
