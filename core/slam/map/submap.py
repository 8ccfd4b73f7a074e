"""One submap: the paper's filter, the occupancy tile and the views that were kept, all in its own frame."""

from __future__ import annotations

from dataclasses import dataclass, field

from core.slam.ekf_slam import EkfSlam
from core.slam.map.keyframe import Keyframe
from core.slam.map.occupancy import OccupancyMap


@dataclass
class Submap:
    """A frame whose origin is where the robot entered first."""

    id: int
    slam: EkfSlam
    tile: OccupancyMap
    views: list[Keyframe] = field(default_factory=list[Keyframe])

    @property
    def anchor(self) -> Keyframe:
        """The view that ties the submap to the graph: its first."""
        return self.views[0]
