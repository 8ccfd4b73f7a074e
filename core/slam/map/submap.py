"""One submap: the paper's filter, the occupancy tile and the views that were kept, all in its own frame."""

import math
from dataclasses import dataclass
from typing import Annotated

from core.geometry import Pose
from core.message import Array
from core.sensors import Laser
from core.setting import Meta, Section
from core.slam.bearings.bearing_landmarks import BearingLandmarks, BearingSettings, VoiceLandmarkSettings
from core.slam.ekf_slam import EkfSettings, EkfSlam
from core.slam.map.keyframe import Keyframe
from core.slam.map.occupancy import OccupancyMap, OccupancySettings


@dataclass(frozen=True)
class SubmapSettings(Section):
    """The scan layer's own settings; matching and closures have theirs in their own files.

    Watch:
        size: the map after a loop; lower it for doubled walls
    """

    landmarks: int = 60  # landmarks of a submap from which it is left earlier
    smallest: float = 3.0  # [m] distance from a submap's origin up to which it is never left
    view_distance: float = 0.3  # [m] distance between views that are kept
    view_turn: float = math.radians(15)  # [rad] turn between views that are kept, where the distance is shorter
    alike: int = 3  # views from one place in one direction that are enough
    crowd: int = 6  # views of a submap from about one place that are enough: a map does not grow with time
    crowd_distance: float = 0.5  # [m] distance between such views, at most
    crowd_turn: float = math.radians(45)  # [rad] difference of their headings, at most
    contradiction: float = 0.15  # share of points that two successive views looked through: one is misplaced
    lately: int = 8  # newest views that a scan is matched on
    nearby: int = 14  # nearest views that a scan is matched on, besides the newest
    return_distance: float = 1.0  # [m] distance to a view of a known submap at which it may be entered again
    inside: float = 1.0  # [m] distance from its rim that the robot must then have, so that it does not leave at once
    return_reach: float = 0.4  # [m] distance around the expected place searched then
    return_angle: float = math.radians(6)  # [rad] angle around the expected heading then
    return_score: float = 0.6  # score of the match then, at least
    return_way: float = 30.0  # [m] a submap at the end of a longer way must have been recognised first
    pieces: float = 40.0  # [1/s] pieces of background work per second of robot time
    most_pieces: int = 400  # pieces of background work with one frame, at most
    tie_sd: float = 0.02  # [m] least sd of a filter's place in its submap
    tie_heading_sd: float = math.radians(0.3)  # [rad] least sd of a filter's heading in it
    size: Annotated[float, Meta("m", 1, 50, "distance from a submap's origin at which it is left")] = 6.0


class Submap(EkfSlam):
    """EKF-SLAM in a frame whose origin is where the robot entered first; also by landmarks of bearings alone."""

    def __init__(
        self,
        number: int,
        ekf: EkfSettings | None = None,
        laser: Laser | None = None,
        occupancy: OccupancySettings | None = None,
        edges: BearingSettings | None = None,
        voices: BearingSettings | None = None,
    ) -> None:
        super().__init__(ekf, laser)
        self.id = number
        self.tile = OccupancyMap(occupancy)
        self.edges = BearingLandmarks(self.filter, edges or BearingSettings())
        self.voices = BearingLandmarks(self.filter, voices or VoiceLandmarkSettings())
        self.views: list[Keyframe] = []

    @property
    def anchor(self) -> Keyframe:
        """The view that ties the submap to the graph: its first."""
        return self.views[0]

    def interrupt(self) -> None:
        """The robot leaves, or is elsewhere in here: directions are followed no further."""
        self.edges.interrupt()
        self.voices.interrupt()

    def reset_pose(self, pose: Pose, covariance: Array) -> None:
        """Set the robot's pose in here and its covariance (3, 3): it was found, or it comes back."""
        self.interrupt()
        self.filter.reset_pose(pose, covariance)
