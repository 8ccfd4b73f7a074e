"""One submap: the paper's filter, the occupancy tile and the views that were kept, all in its own frame."""

from __future__ import annotations

from dataclasses import dataclass, field

from core.slam.bearings.bearing_landmarks import BearingLandmarks
from core.slam.bearings.settings import BearingSettings, VoiceLandmarkSettings
from core.slam.ekf_slam import EkfSlam
from core.slam.map.keyframe import Keyframe
from core.slam.map.occupancy import OccupancyMap


@dataclass
class Submap:
    """A frame whose origin is where the robot entered first."""

    @staticmethod
    def of(
        number: int, slam: EkfSlam, tile: OccupancyMap, edges: BearingSettings, voices: VoiceLandmarkSettings
    ) -> Submap:
        """Make a submap whose filter also has landmarks of which only bearings are measured."""
        return Submap(number, slam, tile, BearingLandmarks(slam.filter, edges), BearingLandmarks(slam.filter, voices))

    id: int
    slam: EkfSlam
    tile: OccupancyMap
    edges: BearingLandmarks
    voices: BearingLandmarks
    views: list[Keyframe] = field(default_factory=list[Keyframe])

    @property
    def anchor(self) -> Keyframe:
        """The view that ties the submap to the graph: its first."""
        return self.views[0]
