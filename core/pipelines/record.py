"""A robot's readings, frame by frame, into one MCAP; and samples: short drives of the simulated robot."""

from dataclasses import dataclass
from pathlib import Path

from msgspec import Raw

from core.files import unfinished
from core.gate import Twist
from core.recording.frame_record import FrameRecord, RobotRecord
from core.recording.mcap_writing import McapRecording, RecordedFile
from core.recording.ros_writing import RosEncoder
from core.robots import Robot
from core.robots.connect import connect
from core.robots.profile_json import profile_to_json
from core.robots.requests import PlaceThing
from core.sensors import SensorFrame
from core.sensors.recordable import recordable


class RobotRecording:
    """Reads a robot and writes what it senses."""

    def __init__(self, robot: Robot, out: Path, part: Path | None = None) -> None:
        """`part`: the name until it is finished, as for `McapRecording`. Raises Unwritable."""
        described = Raw(profile_to_json(robot.profile))
        self._robot = robot
        self._card: RobotRecord | None = RobotRecord(built=described, used=described)  # None: it was written
        self._encoder = RosEncoder(robot.profile.lasers, robot.profile.cameras)
        self.file = McapRecording(out, part)

    def add(self, logged: float | None = None) -> SensorFrame:
        """Write the next frame, received at `logged` [s] Unix time or at its own stamp → it. Raises Unwritable."""
        frame, encoder, card = self._robot.read(), self._encoder, self._card
        first = [] if card is None else [*encoder.fixed(frame.stamp), encoder.robot(frame.stamp, card)]
        self._card = None
        frame = recordable(frame)
        written = [encoder.frame(FrameRecord.of(frame)), *encoder.readings(frame)]
        self.file.add([*first, *written], frame.stamp if logged is None else logged)
        return frame


@dataclass(frozen=True)
class Sample:
    """A drive: what the wheels do in a simulated place, and who stands there."""

    place: str  # URL
    moves: tuple[tuple[float, float, float], ...]  # speed [m/s], turn rate [rad/s], how long [s]
    people: tuple[PlaceThing, ...] = ()


ANN = PlaceThing(what="person", x_m=2.0, y_m=0.9, id="Ann", clothes="red/blue")
BOB = PlaceThing(what="person", x_m=1.6, y_m=-0.9, id="Bob", clothes="green/black")
SAMPLES = {
    "room": Sample("sim:lab", ((0.2, 0.0, 5.0), (0.0, 0.8, 8.0), (0.2, 0.3, 5.0))),
    "floor": Sample("sim:floor", ((0.25, 0.0, 8.0), (0.0, -0.8, 4.0), (0.2, 0.0, 4.0))),
    "people": Sample("sim:lab", ((0.0, 0.4, 2.0), (0.0, -0.4, 4.0), (0.12, 0.1, 6.0)), (ANN, BOB)),
}


def record_sample(name: str, out: Path) -> RecordedFile:
    """Drive a sample as fast as this computer simulates it. Raises Unwritable."""
    sample = SAMPLES[name]
    robot = connect(sample.place, seed=1)
    for person in sample.people:
        robot.ask(person)
    recording = RobotRecording(robot, out, unfinished(out))  # half a sample is none: it is made again
    try:
        for speed, turn_rate, seconds in sample.moves:
            for _ in range(round(seconds * robot.profile.rate)):
                robot.drive(Twist(speed, turn_rate))
                recording.add()
        return recording.file.finish()
    except BaseException:
        recording.file.discard()
        raise
    finally:
        robot.close()
