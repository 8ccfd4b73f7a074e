"""One file per sensor: its reading and how it is mounted. `core.simulation` makes such readings."""

from core.geometry import Pose
from core.message import message
from core.sensors.camera import Camera, Image
from core.sensors.checks import Fault
from core.sensors.laser import Laser, Scan
from core.sensors.microphones import Sound
from core.sensors.wheels import Wheels

__all__ = ["Camera", "Fault", "Image", "Laser", "Scan", "SensorFrame", "Sound", "Wheels"]


@message
class SensorFrame:
    """All that the robot sensed at one instant; a sensor with nothing new is None."""

    stamp: float  # [s], the robot's own clock
    sensed: float = 0.0  # [s] of this computer's monotonic clock when the driver had it; 0: not recorded
    nonce: int = 0  # the gate's newest nonce when this was sensed; a setpoint made from it returns the nonce
    wheels: Wheels | None = None
    scan: Scan | None = None
    image: Image | None = None
    sound: Sound | None = None  # since the last frame; None: no sound was recorded
    contact: bool = False  # the bumper is pressed
    battery: float | None = None  # 0..1; None: not known
    truth: Pose | None = None  # simulator only: the true pose in the world frame. For scoring, never for an estimator
    trouble: str = ""  # why the base cannot be driven now, a sentence; what is under way ends with it
    faults: tuple[Fault, ...] = ()  # what the checks of readings found since the last frame
    notes: tuple[str, ...] = ()  # what the driver wants the operator to know: "the recording ends here"
    pace: float = 1.0  # share of real time at which the robot's clock runs; less: its computer is too slow for it
    running: bool = True  # False: the driver is paused or at its end; time does not advance
    progress: float | None = None  # recordings: 0..1, how much has been played
