"""Find how the array is turned on the robot: a wizard without a screen listens to claps from known directions."""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from core.errors import BadInput
from core.geometry import Pose, wrap, wrap_all
from core.message import message
from core.perception.sound.direction import Direction
from core.perception.sound.locate import DEFAULT, locate
from core.perception.sound.settings import DirectionFindingSettings
from core.sensors.microphones import MicrophoneArray, Sound

MIN_CLAPS = 3  # claps
MIN_SPREAD_RAD = math.radians(60)  # between the two most distant claps
MAX_RESIDUAL_SDS = 3.0  # standard deviations of a clap that fits
PLACING_SD_RAD = math.radians(3)  # [rad] how exactly a person stands where they are asked to
MOMENT_S = 0.01  # in which loudness is measured
LOUD_SHARE = 0.1  # of the loudest moment's level, from which a clap or a voice has begun
ABOVE_NOISE = 4.0  # times the usual level that the loudest moment reaches
BEFORE_S, AFTER_S = 0.6, 0.8  # around the beginning that are looked at
UNCLEAR = "That clap came from no clear direction; clap again, nearer."
EARLY_S = 0.03  # before the beginning that may already belong to it


@message
class Orientation:
    """The result."""

    yaw: float  # [rad] robot_from_microphones
    yaw_sd: float  # [rad]
    mirrored: bool  # the array is mounted upside down
    residual: float  # [rad] rms


def oriented(array: MicrophoneArray, found: Orientation) -> MicrophoneArray:
    """The array as it is really mounted: turned by `yaw` and, where it hangs upside down, its sides exchanged."""
    flipped = array.positions * (1.0, -1.0, -1.0) if found.mirrored else array.positions
    mounting = Pose(x=array.mounting.x, y=array.mounting.y, heading=found.yaw)
    return replace(array, positions=flipped, mounting=mounting)


def heard_from(sound: Sound, array: MicrophoneArray, settings: DirectionFindingSettings = DEFAULT) -> Direction:
    """Direction of the clap or the word in a recording of some seconds. Raises BadInput when there was none."""
    length = max(1, round(MOMENT_S * sound.rate))
    samples = array.heard(sound)
    if len(samples) < 20 * length:
        raise BadInput("The recording is too short; half a second before the clap is needed.")
    level = samples[: len(samples) // length * length].reshape(-1, length * samples.shape[1]).std(axis=1)
    top = int(np.argmax(level))
    if not level[top] > ABOVE_NOISE * float(np.median(level)):
        raise BadInput("Nothing stood out of the noise; clap louder or nearer.")
    quiet = np.nonzero(level[: top + 1] < LOUD_SHARE * level[top])[0]
    first = int(quiet[-1]) + 1 if len(quiet) else 0
    begin = sound.stamp + first * length / sound.rate - EARLY_S
    part = sound.part(begin - BEFORE_S, begin + AFTER_S)
    found = locate(part, array, speech_from=begin if begin - part.stamp > BEFORE_S / 2 else None, settings=settings)
    if found is None:
        raise BadInput(UNCLEAR)
    return found


@message
class Clap:
    """One clap: where it was asked for, and where the array heard it."""

    asked: float  # [rad] in the robot frame
    heard: float  # [rad] in the array frame
    sd: float  # [rad] of what was heard

    def gap(self, found: Orientation) -> float:
        """Error [rad] of the clap against an orientation."""
        return wrap(self.asked - (-self.heard if found.mirrored else self.heard) - found.yaw)


@dataclass
class OrientationWizard:
    """Asks the operator for claps and gathers them."""

    asked: tuple[float, ...] = (0.0, math.pi / 2, math.pi, -math.pi / 2)  # [rad] in the robot frame
    claps: list[Clap] = field(default_factory=list[Clap])

    @property
    def advice(self) -> str:
        """The next step for the operator, in one sentence."""
        if len(self.claps) < len(self.asked):
            where = math.degrees(self.asked[len(self.claps)])
            return f"Stand about 2 m away at {where:.0f}° (0° is ahead, 90° left) and clap twice."
        return "That is enough; accept the result or clap from one more place."

    def add(self, asked: float, direction: Direction) -> str:
        """A clap at azimuth `asked` [rad] in the robot frame → '' when it is taken, or why it is not."""
        return self.take(Clap(asked=asked, heard=direction.azimuth, sd=direction.azimuth_sd))

    def take(self, clap: Clap) -> str:
        """The same, of a clap that was located already."""
        if clap.sd > math.radians(15):
            return UNCLEAR
        self.claps.append(clap)
        return ""

    def drop(self, number: int) -> None:
        """Forget a clap."""
        del self.claps[number]

    def solve(self) -> Orientation | str:
        """The orientation, or what is still missing."""
        if len(self.claps) < MIN_CLAPS:
            return f"{MIN_CLAPS} claps are needed; {len(self.claps)} were heard."
        asked = np.array([one.asked for one in self.claps])
        if np.max(np.abs(wrap_all(asked[:, None] - asked))) < MIN_SPREAD_RAD:
            return "The claps came all from one side; clap from another one."
        heard = np.array([one.heard for one in self.claps])
        variance = np.array([one.sd**2 + PLACING_SD_RAD**2 for one in self.claps])
        best: Orientation | None = None
        for side in (1.0, -1.0):
            turns = asked - side * heard
            yaw = math.atan2(float(np.sum(np.sin(turns) / variance)), float(np.sum(np.cos(turns) / variance)))
            gaps = wrap_all(turns - yaw)
            residual = float(np.sqrt(np.mean(gaps**2)))
            if best is None or residual < best.residual:
                chi = float(np.sum(gaps**2 / variance)) / (len(gaps) - 1)
                spread = math.sqrt(max(1.0, chi) / float(np.sum(1 / variance)))
                best = Orientation(yaw=wrap(yaw), yaw_sd=spread, mirrored=side < 0, residual=residual)
        assert best is not None
        if best.residual > MAX_RESIDUAL_SDS * float(np.sqrt(variance.mean())):
            return (
                f"The claps do not agree on one orientation ({math.degrees(best.residual):.0f}° apart); "
                "check the order of the recordings and of the channels first."
            )
        return best
