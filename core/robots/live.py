"""A real robot: one device or several, each in a thread of its own that connects again by itself."""

import logging
import random
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, TypeVar, cast

from msgspec.structs import replace as replace_struct

from core.errors import BeckonError, Unavailable
from core.gate.twist import ZERO, Twist
from core.robots import Profile
from core.robots.connection import FoundPart, ReadConnection, ReadRobotFile, describe
from core.robots.device import ClockOffset, Device, Equipment
from core.robots.device_clock import LONG_AGO_S
from core.robots.readings import Names, Readings
from core.robots.requests import AnswerT, ListeningState, Requests, RobotRequest, SetListening, not_taken
from core.robots.robot_file import RobotFile
from core.sensors import Camera, Laser, SensorFrame
from core.sensors.checks import distinct
from core.sensors.microphones import MicrophoneArray

Sensor = TypeVar("Sensor", Laser, Camera, MicrophoneArray)

log = logging.getLogger(__name__)

MIN_RETRY_PAUSE_S, MAX_RETRY_PAUSE_S = 0.25, 5.0  # until the next try to connect
OPENING_TIMEOUT_S = 20.0  # that the devices may take at first
PAUSE_SPREAD_SHARE = 0.3  # share by which the pauses differ, so that devices do not all knock at once


class DeviceLink:
    """One device and its thread: open, run, and again."""

    def __init__(self, name: str, device: Device, readings: Readings) -> None:
        self.name, self.device = name, device
        self.equipment: Equipment | None = None
        self.trouble: BeckonError | None = None  # why it was not there at the first try
        self.up = False
        self.times_up = 0  # how often the link came up
        self.opening = threading.Lock()  # held while it comes up, and while speeds are handed on
        self.settled = threading.Event()  # the first try is over
        self.named = threading.Event()  # its sensors have their names: readings before that would lack them
        self._names: Names = {}  # of its sensors on this robot, where another device took theirs
        self._readings = readings.renaming(self._names)
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, name=f"device-{name}", daemon=True)

    def start(self) -> None:
        """Connect for the first time; `settled` tells when."""
        self._thread.start()

    def close(self, patience: float = 1.0) -> None:
        """Let go."""
        self._over.set()
        self.named.set()
        self._close_device()
        self._thread.join(patience)

    def named_apart(self, taken: set[str]) -> Equipment:
        """Its equipment; a sensor whose name is taken gets another one, and so do its readings."""
        assert self.equipment is not None

        def apart(sensor: Sensor) -> Sensor:
            name, number = sensor.name, 2
            while name in taken:
                name, number = f"{sensor.name}-{number}", number + 1
            taken.add(name)
            self._names[type(sensor), sensor.name] = name
            return replace(sensor, name=name)

        found = self.equipment
        renamed = replace(
            found,
            lasers=tuple(map(apart, found.lasers)),
            cameras=tuple(map(apart, found.cameras)),
            microphones=tuple(map(apart, found.microphones)),
        )
        for alone in (renamed.lasers, renamed.cameras):
            if len(alone) == 1:
                self._names[type(alone[0]), ""] = alone[0].name  # readings of an only one may leave its name out
        self.named.set()
        return renamed

    def found(self, equipment: Equipment) -> FoundPart:
        """Return the findings on the device; `equipment`: with its sensors' names on this robot."""
        findings = self.device.findings()
        own = {name: renamed for (_, name), renamed in self._names.items() if name}
        return FoundPart(
            name=self.name,
            up=self.up,
            drives=equipment.base is not None,
            lasers=tuple(one.name for one in equipment.lasers),
            cameras=tuple(one.name for one in equipment.cameras),
            microphones=tuple(one.name for one in equipment.microphones),
            findings=replace_struct(
                findings,
                placed=tuple(own.get(name, name) for name in findings.placed),
                clocks=tuple(map(self._dated, findings.clocks)),
                faults=distinct((*findings.faults, *self._readings.faults)),
            ),
        )

    def _dated(self, clock: ClockOffset) -> ClockOffset:
        """A clock's offset, compared with the time of day where it tells one."""
        tells = self._readings.now() - clock.offset_s
        return replace_struct(clock, ahead_s=round(tells - time.time(), 4)) if tells > LONG_AGO_S else clock

    def _run(self) -> None:
        pause = MIN_RETRY_PAUSE_S
        while not self._over.is_set():
            began = time.monotonic()
            why = self._live()
            self.up = False
            if self.equipment is not None and self.equipment.base is not None:
                self._readings.forget_base()
            if self._over.is_set() or (self.equipment is None and self.settled.is_set()):
                return
            if time.monotonic() - began > MAX_RETRY_PAUSE_S:
                pause = MIN_RETRY_PAUSE_S
            self._readings.note(why)
            self._over.wait(pause * random.uniform(1 - PAUSE_SPREAD_SHARE, 1 + PAUSE_SPREAD_SHARE))
            pause = min(2 * pause, MAX_RETRY_PAUSE_S)

    def _live(self) -> str:
        """Connect and run until the end → a sentence why it ended."""
        known = self.equipment is not None
        try:
            with self.opening:
                equipment = self.device.open()
                if self._over.is_set():  # closed meanwhile; the device was not there yet to hear of it
                    return ""
                self.equipment = self.equipment or equipment
                self.times_up += 1
                self.up = True
            self.settled.set()
            if known:
                self._readings.note(f"{self.name} is back.")
            self.named.wait()
            if self._over.is_set():
                return ""
            self.device.run(self._readings)
            return f"{self.name} was lost; it is looked for."
        except BeckonError as trouble:
            self.trouble = trouble
            return f"{self.name}: {trouble}" if not known else f"{self.name} was lost; it is looked for."
        except OSError as trouble:
            self.trouble = Unavailable(f"{self.name} cannot be reached: {trouble.strerror or trouble}.")
            return f"{self.name} was lost; it is looked for."
        except Exception as fault:
            log.exception("The driver of %s failed", self.name)
            self.trouble = Unavailable(
                f"The driver of {self.name} failed ({type(fault).__name__}); the log says more."
            )
            return str(self.trouble)
        finally:
            self.settled.set()
            self._close_device()

    def _close_device(self) -> None:
        try:
            self.device.close()
        except Exception:
            log.exception("%s could not be closed", self.name)


class LiveRobot:
    """Devices behind one profile, as `core.robots.Robot` has it. Only the first device with a base drives."""

    def __init__(
        self,
        devices: Sequence[tuple[str, Device]],
        shape: Callable[[tuple[Equipment, ...]], Profile],
        clock: Callable[[], float] = time.monotonic,
        file: RobotFile | None = None,
    ) -> None:
        """`devices`: each with the name that the operator reads; `file`: what the robot is made by.

        Raises Unavailable or BadInput with a sentence.
        """
        self._file = file or RobotFile()
        self._readings = Readings(clock, self._file.lasers)
        self._base: DeviceLink | None = None
        self._links = [DeviceLink(name, device, self._readings) for name, device in devices]
        for link in self._links:
            link.start()
        deadline = time.monotonic() + OPENING_TIMEOUT_S
        for link in self._links:
            if not link.settled.wait(max(0.0, deadline - time.monotonic())):
                link.trouble = Unavailable(f"{link.name} did not answer within {OPENING_TIMEOUT_S:g} s.")
        missing = next((link for link in self._links if link.equipment is None), None)
        if missing is not None:
            self.close()
            raise missing.trouble or Unavailable(f"{missing.name} did not answer.")
        taken: set[str] = set()
        self._equipment = equipment = tuple(link.named_apart(taken) for link in self._links)
        try:
            self.profile = shape(equipment)
        except BaseException:
            self.close()
            raise
        self._base = next((link for link in self._links if link.equipment and link.equipment.base), None)
        for sentence in self.profile.notices:
            self._readings.note(sentence)
        self._times_up = self._base.times_up if self._base else 0
        self._neutral = True  # zero was asked for since the base came back

    def drive(self, twist: Twist) -> None:
        """Hand the speeds on to the base. After the link was down, nothing moves before zero was asked for."""
        base = self._base
        if base is None or not base.opening.acquire(blocking=False):
            self._neutral = False
            return
        try:
            self._hand_on(twist, base)
        finally:
            base.opening.release()

    def _hand_on(self, twist: Twist, base: DeviceLink) -> None:
        """Send the speeds by the connection that they were meant for; none comes up meanwhile."""
        if not base.up:
            self._neutral = False
            return
        if base.times_up != self._times_up:  # it was lost and is back since the last call
            self._times_up, self._neutral = base.times_up, False
        self._neutral = self._neutral or not twist.moves
        try:
            base.device.drive(twist if self._neutral else ZERO)
        except OSError:
            base.device.close()  # its thread finds that out and connects again

    def read(self) -> SensorFrame:
        """All that came since the last frame."""
        up = self._base is None or self._base.up
        frame = self._readings.frame()
        return frame if up else replace(frame, trouble=f"{self._base.name if self._base else ''} does not answer.")

    @property
    def requests(self) -> Requests:
        """Requests for its findings and robot file, to listen, which it always does, and those of its devices."""
        own = (ReadConnection, ReadRobotFile, SetListening)
        return (*own, *(kind for link in self._links for kind in link.device.requests))

    def ask(self, request: RobotRequest[AnswerT]) -> AnswerT:
        """One of `requests` → its answer. Raises BadInput for any other, Refused or Unavailable."""
        request_any: RobotRequest[Any] = request
        match request_any:
            case ReadConnection():
                parts = tuple(link.found(one) for link, one in zip(self._links, self._equipment, strict=True))
                return cast(AnswerT, describe(self.profile, parts, self._equipment, self._file))
            case ReadRobotFile():
                return cast(AnswerT, self._file)
            case SetListening():
                return cast(AnswerT, ListeningState(on=True))
            case _:
                taker = next((link.device for link in self._links if type(request) in link.device.requests), None)
                if taker is None:
                    raise not_taken(self.requests)
                return taker.ask(request)

    def close(self) -> None:
        """Stop, and let go of every device."""
        for link in self._links:
            if link is self._base and link.up:
                self.drive(ZERO)
            link.close()
