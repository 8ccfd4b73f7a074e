"""The filter, fed with the frames of a robot: their wheels, and scans that show what stands in the way."""

from collections.abc import Sequence

from core.perception.landmarks.landmarks import Sighting
from core.sensors import Laser, SensorFrame
from core.slam.association.visibility import VisibilityCheck
from core.slam.ekf_slam import EkfSettings, EkfSlam
from core.slam.estimate import Estimate
from core.slam.motion import MotionSettings, WheelTrack


class FrameSlam(EkfSlam):
    def __init__(
        self, ekf: EkfSettings | None = None, motion: MotionSettings | None = None, laser: Laser | None = None
    ) -> None:
        super().__init__(ekf, laser)
        self._track, self._own_laser = WheelTrack(motion), laser

    def update(self, frame: SensorFrame, sightings: Sequence[Sighting] | None = None) -> Estimate:
        self.advance(self._track.step(frame.stamp, frame.wheels))
        if sightings is not None:
            scan, laser = frame.scan, self._own_laser
            self.see(sightings, None if scan is None or laser is None else VisibilityCheck(scan, laser.mounting))
        return self.estimate
