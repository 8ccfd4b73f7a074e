"""Dead reckoning: the pose by the wheels alone."""

from __future__ import annotations

from collections.abc import Sequence

from core.geometry import Pose
from core.perception.landmarks.landmarks import Sighting
from core.sensors import SensorFrame
from core.slam.estimate import Estimate
from core.slam.motion import Increment, MotionSettings, WheelTrack


class DeadReckoning:
    """Adds up the wheels' moves (eq. 20, 21). Its uncertainty only grows."""

    def __init__(self, motion: MotionSettings | None = None) -> None:
        self._track = WheelTrack(motion)
        self._way = Increment()

    def update(
        self, frame: SensorFrame, sightings: Sequence[Sighting] | None = None, increment: Increment | None = None
    ) -> Estimate:
        """Take one frame; sightings change nothing. `increment`: a move that does not come from the wheels."""
        step = self._track.step(frame) if increment is None else increment
        if not step.still:
            self._way = self._way.then(step)
        return self.estimate

    @property
    def pose(self) -> Pose:
        """The pose now."""
        return self._way.pose

    @property
    def estimate(self) -> Estimate:
        """The pose and its covariance in the world's axes."""
        return Estimate(pose=self._way.pose, covariance=self._way.covariance)
