"""Dead reckoning: the pose by the wheels alone."""

from core.geometry import Pose
from core.slam.estimate import Estimate
from core.slam.motion import Increment


class DeadReckoning:
    """Adds up the wheels' moves (eq. 20, 21). Its uncertainty only grows."""

    def __init__(self) -> None:
        self._way = Increment()

    def update(self, increment: Increment) -> Estimate:
        """Take the move since the frame before."""
        if not increment.still:
            self._way = self._way.then(increment)
        return self.estimate

    @property
    def pose(self) -> Pose:
        """The pose now."""
        return self._way.pose

    @property
    def estimate(self) -> Estimate:
        """The pose and its covariance in the world's axes."""
        return Estimate(pose=self._way.pose, covariance=self._way.covariance)
