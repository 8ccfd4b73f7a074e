"""The position by laser and wheels alone, beside the one by all senses: the chapter's reference (abstract)."""

from dataclasses import replace

from core.pilot.landmark_perception import LandmarkPerception
from core.robots import Profile
from core.sensors import SensorFrame
from core.settings import Settings
from core.slam.estimate import Estimate
from core.slam.mapper import Mapper
from core.slam.motion import Motion


class LaserReference:
    """A second estimator in the same world, which sees no picture and hears nothing. Nothing is steered by it."""

    def __init__(self, profile: Profile, settings: Settings, mapper: Mapper) -> None:
        """`mapper`: its own, which has seen nothing yet."""
        self.mapper = mapper
        self._vision = LandmarkPerception(replace(profile, cameras=(), arrays=()), settings)

    def update(self, frame: SensorFrame, motion: Motion, idle: bool) -> Estimate:
        """Take the frame that the pilot takes → the estimate."""
        return self.mapper.update(frame, self._vision.look(replace(frame, image=None), motion, idle), motion)
