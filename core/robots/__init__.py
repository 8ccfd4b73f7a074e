"""Robots: one file per kind of link, one protocol for all, `connect(url)` to reach one; `core.simulation` is one."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal, Protocol

from core.commands.command import CommandSpec
from core.gate import Twist
from core.message import message
from core.robots.requests import AnswerT, Requests, RobotRequest
from core.robots.urdf import BodyShape
from core.sensors import Camera, Laser, SensorFrame
from core.sensors.microphones import MicrophoneArray

RobotKind = Literal["SIM", "LOG", "LIVE"]
Capability = Literal["drive", "simulate", "replay", "results", "navigate"]
"""drive: it takes speeds; simulate: its world is made up and can be changed; replay: it can be paused and sought;
results: what it shows is computed where it is read, or was when it was recorded;
navigate: it has a map, a pose on it or goals of its own, see `ReadNavigation`.
"""


@message
class Profile:
    """The profile of a robot: body, limits, sensors and their mountings."""

    name: str
    url: str
    radius: float = 0.09  # [m] of the round footprint
    wheelbase: float = 0.10  # [m] (section 6)
    cruise: float = 0.1  # [m/s] (section 6)
    max_speed: float = 0.3  # [m/s]
    max_turn_rate: float = 1.5  # [rad/s]
    rate: float = 40.0  # [Hz] of frames (section 6: control updates)
    lasers: tuple[Laser, ...] = ()
    cameras: tuple[Camera, ...] = ()  # landmarks and people are looked for with the first
    arrays: tuple[MicrophoneArray, ...] = ()  # voices are located with the first
    shapes: tuple[BodyShape, ...] = ()  # its looks; none: a round body is drawn
    notices: tuple[str, ...] = ()  # sentences about what of its description could not be used
    odometry: bool = True  # it says how far its wheels have rolled
    failsafe: str = ""  # what the base does by itself when nobody speaks to it, a sentence; "": not known
    lock: str = ""  # topic of the lock of its own that is closed while it is to stand; "": none
    capabilities: frozenset[Capability] = frozenset({"drive"})
    duration: float | None = None  # [s] of a recording
    gaps: tuple[tuple[float, float], ...] = ()  # [s] from its start: from and to where it has no scans

    @property
    def drives(self) -> bool:
        """True unless it cannot be commanded, as a recording."""
        return "drive" in self.capabilities

    @property
    def dry_run(self) -> bool:
        """True where nothing drives and a camera looks: COME HERE and FOLLOW ME show what they would do."""
        return not self.drives and bool(self.cameras) and "results" not in self.capabilities

    def refusal(self, kind: CommandSpec | None = None) -> str:
        """Return why a command of this kind, or any motion, cannot be obeyed here, a sentence; "" where it can."""
        if self.drives or (kind is not None and self.dry_run and (kind.target == "person" or not kind.moves)):
            return ""
        what = "This is a recording; it" if "replay" in self.capabilities else "Nothing here has wheels: it"
        dry = " COME HERE and FOLLOW ME show what they would do." if self.dry_run else ""
        return f"{what} cannot be driven.{dry}"

    @property
    def simulated(self) -> bool:
        """True where its world is made up."""
        return "simulate" in self.capabilities

    @property
    def kind(self) -> RobotKind:
        """A word for people."""
        return "SIM" if self.simulated else "LOG" if "replay" in self.capabilities else "LIVE"

    @property
    def laser(self) -> Laser | None:
        """The first laser."""
        return self.lasers[0] if self.lasers else None

    @property
    def camera(self) -> Camera | None:
        """The first camera."""
        return self.cameras[0] if self.cameras else None

    def first_view(self, frame: SensorFrame) -> SensorFrame:
        """The frame without a picture of another camera than the first, through which the robot looks."""
        first, image = self.camera, frame.image
        if first is None or image is None or image.camera in ("", first.name):
            return frame
        return replace(frame, image=None)

    @property
    def microphones(self) -> MicrophoneArray | None:
        """The first microphone array."""
        return self.arrays[0] if self.arrays else None

    def with_camera(self, camera: Camera) -> Profile:
        """The profile with another first camera."""
        return replace(self, cameras=(camera, *self.cameras[1:]))

    def with_microphones(self, array: MicrophoneArray) -> Profile:
        """The profile with another first array."""
        return replace(self, arrays=(array, *self.arrays[1:]))


class Robot(Protocol):
    """A robot as its driver sees it. One thread owns it; nothing here waits on a clock.

    `read` returns the next frame at once: the simulator advances its own time by one frame (1/rate),
    a recording steps to its next reading. The caller decides whether that happens in real time.
    """

    @property
    def profile(self) -> Profile:
        """The profile of this robot."""
        ...

    def drive(self, twist: Twist) -> None:
        """Set the speed that holds until the next call (the base stops by itself after 0.5 s without one)."""
        ...

    def read(self) -> SensorFrame:
        """The next frame; its stamp never goes backwards but after a seek."""
        ...

    @property
    def requests(self) -> Requests:
        """The requests that this robot takes; a driver's own may be declared beside it."""
        ...

    def ask(self, request: RobotRequest[AnswerT]) -> AnswerT:
        """One of `requests` → its answer. Raises BadInput (also for any other request) or Refused with a sentence."""
        ...

    def close(self) -> None:
        """Let go of everything."""
        ...
