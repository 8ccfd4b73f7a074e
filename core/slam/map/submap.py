"""One submap: the paper's filter, the occupancy tile and the views that were kept, all in its own frame."""

from core.geometry import Pose
from core.message import Array
from core.sensors import Laser
from core.slam.bearings.bearing_landmarks import BearingLandmarks, BearingSettings, VoiceLandmarkSettings
from core.slam.ekf_slam import EkfSettings, EkfSlam
from core.slam.map.keyframe import Keyframe
from core.slam.map.occupancy import OccupancyMap, OccupancySettings


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
