"""Settings of the simulated robot and its rooms, as a settings file says them."""

from dataclasses import dataclass, replace
from typing import Annotated, Literal

from core.geometry import Pose
from core.sensors.microphones import ARRAYS, MicrophoneArray
from core.setting import Meta, Section

WheelNoise = Literal["encoder", "paper", "none"]
LaserNoise = Literal["1%", "3%", "none"]
HardWall = Literal["none", "west", "south", "east", "north"]
LASER_NOISE: dict[LaserNoise, tuple[float, float]] = {"1%": (0.010, 0.01), "3%": (0.030, 0.03), "none": (0.0, 0.0)}
"""Standard deviation of a range: at least the first [m], else the second times the range."""

SILENT_DB = -60.0  # [dB] a noise that low is none


@dataclass(frozen=True)
class MicrophoneSettings(Section):
    """The simulated robot's ears and the room that they are in.

    Watch:
        microphones: directions and words heard
        reverberation: words and directions in Speech quality
        hard_wall: directions that lie at the wall
        murmur: words and false stops in Speech quality
        motor_noise: words heard while driving
        fan_noise: directions that lie at the fan
        turned: the array's turn that Calibrate finds
    """

    microphones: Annotated[
        str, Meta(choices=("none", *ARRAYS), meaning='array on the robot; "none": deaf', common=True)
    ] = "respeaker-odas"
    reverberation: Annotated[float, Meta("s", 0, 0.6, "RT60 of every room", common=True)] = 0.3
    hard_wall: Annotated[
        HardWall, Meta(meaning="wall of every room, x pointing east, whose first echo is as strong as that of glass")
    ] = "none"
    murmur: Annotated[
        float, Meta("dB", SILENT_DB, 20, "level of the room's noise, against a voice at 1 m", common=True)
    ] = -30.0
    motor_noise: Annotated[
        float, Meta("dB", SILENT_DB, 20, "level of the motors at 0.1 m/s at the microphones; -60: none")
    ] = -10.0
    fan_noise: Annotated[
        float, Meta("dB", SILENT_DB, 20, "level of a fan in a corner at 1 m; -60: none", common=True)
    ] = SILENT_DB
    turned: Annotated[
        float, Meta("rad", -7, 7, "angle by which the array really sits on the robot, unknown to its profile")
    ] = 0.0

    @property
    def array(self) -> MicrophoneArray | None:
        """The array on the robot as its profile has it; None: deaf."""
        return None if self.microphones == "none" else ARRAYS[self.microphones]

    @property
    def mounted(self) -> MicrophoneArray | None:
        """The array as it really sits on the robot; None: deaf."""
        return None if self.array is None else replace(self.array, mounting=Pose(heading=self.turned))


@dataclass(frozen=True)
class SimulationSettings(MicrophoneSettings):
    """Noise and equipment of the simulated robot.

    Watch:
        wheel_noise: the pose's error
        laser_noise: NIS, and corners in the scene
        camera: persons found and edges drawn
        camera_rate: load of the processor
        light: edges drawn and persons found
        exposure: edges drawn in turns
        defocus: edges drawn
        cruise: time of a way, and the pose's error
        max_speed: time of a way
        max_turn_rate: time of a turn
    """

    scale_error: float = 0.003  # relative sd of the size of both wheels together
    mismatch: float = 0.0002  # relative sd of one wheel against the other
    wheelbase_error: float = 0.003  # relative sd of the wheelbase
    slip: float = 0.0007  # [m/√m] slip of each wheel
    dropout: float = 0.004  # share of beams that fail at random
    picture_snr: float = 42.0  # [dB] signal to noise of the camera's sensor (section 6)
    second_camera: float = 0.0  # [m] to the right of the camera: another one; 0: none
    response: float = 0.06  # [s] time until the base has followed 63 % of a change of speed
    wheel_noise: Annotated[
        WheelNoise, Meta(meaning="encoder: sizes and slip of wheels; paper: eq. 43", common=True)
    ] = "encoder"
    laser_noise: Annotated[LaserNoise, Meta(meaning="sd of a range as a share of it")] = "1%"
    camera: Annotated[bool, Meta(meaning="whether the robot has a camera")] = True
    camera_rate: Annotated[float, Meta("Hz", 0.1, 40, "pictures per second")] = 10.0
    light: Annotated[float, Meta("", 0.05, 3, "brightness of the pictures")] = 1.0
    exposure: Annotated[float, Meta("s", 0, 0.1, "exposure time of a picture: turning meanwhile smears it")] = 0.0
    defocus: Annotated[float, Meta("pixel", 0, 5, "sd of the lens's blur")] = 0.0
    cruise: Annotated[float, Meta("m/s", 0.01, 1, "speed of commands (section 6.2)", common=True)] = 0.1
    max_speed: Annotated[float, Meta("m/s", 0.01, 1, "highest speed of the base")] = 0.3
    max_turn_rate: Annotated[float, Meta("rad/s", 0.01, 6, "highest turn rate of the base")] = 1.5
