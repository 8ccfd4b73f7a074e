"""Readings of devices: newest wins, sound is joined, nothing queues without bound."""

import math
import threading
import time
from collections import defaultdict, deque
from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Self

import numpy as np

from core.geometry import Pose
from core.message import Array
from core.sensors import Camera, Fault, Image, Laser, Scan, SensorFrame, Sound, Wheels
from core.sensors.checks import UnusableReading, are_finite, distinct, fault, time_fault
from core.sensors.microphones import joined
from core.sensors.publishers import PublisherWatch, odometry_watch, scan_watch, sector_ranges
from core.sensors.scan_gate import RangeUnit
from core.sensors.wheels import BaseSpeeds, is_restart

if TYPE_CHECKING:
    from core.robots.robot_file import LaserTable  # which knows devices, and those know readings

MAX_WHEELS_AGE_S = 0.5  # over which a reading of the wheels is carried on to the frame; then nothing is known of them
MAX_WAITING_SCANS = 4  # scans that may wait for a frame
RATE_WINDOW_S = 3.0  # over which readings of the wheels are counted for their rate
MIN_COUNTED_S = 2.0  # [s] that they have come before they are counted: a few that waited come all at once
MAX_WAITING_SOUND_S = 3.0  # [s] that may wait for a frame
FAULT_AGAIN_S = 5.0  # [s] after which a fault that lasts is said again
JUDGED_MESSAGES, MIN_UNREADABLE = 100, 8  # the newest of a sensor, and how many of them are unreadable on a bad line
MIXED_HELD_S = 2.0  # for which nothing is driven after readings of two robots


Names = dict[tuple[type, str], str]


@dataclass
class Waiting:
    """Readings since the last frame, and states that last."""

    scans: deque[Scan] = field(default_factory=lambda: deque[Scan](maxlen=MAX_WAITING_SCANS))
    wheels: tuple[float, Wheels] | None = None  # with their stamp [s]
    rolled: deque[float] = field(default_factory=deque[float])  # [s] when readings came
    place: Pose = field(default_factory=Pose)  # newest odometry handed on
    anchor: Pose = field(default_factory=Pose)  # what the base's own odometry is seen from
    image: Image | None = None
    undecoded: Callable[[], Image | None] | None = None  # a newer picture than that
    sound: Sound | None = None
    notes: list[str] = field(default_factory=list[str])
    faults: list[Fault] = field(default_factory=list[Fault])  # since the last frame
    contact: bool = False
    touched: bool = False  # since the last frame
    battery: float | None = None  # 0..1


class Readings:
    """Filled by the devices' threads, emptied by the driver's. Stamps are on the robot's clock, see `now`.

    The one way of every device's readings: what is malformed is left out, and its fault said.
    """

    def __init__(
        self, clock: Callable[[], float] = time.monotonic, lasers: "Mapping[str, LaserTable] | None" = None
    ) -> None:
        """`lasers`: by name, as the robot file describes them."""
        self._clock, self._start = clock, clock()
        self._lasers = lasers or {}
        self._lock, self._here = threading.Lock(), Waiting()
        self._names: Names = {}
        self._found: dict[tuple[str, str], tuple[float, Fault]] = {}  # of one device, with when it was last said [s]
        self._watch()
        self._mixed: dict[str, tuple[float, Fault]] = {}  # by sensor, with when that was last seen [s]

    def renaming(self, names: Names) -> Self:
        """The same readings for a device whose sensors are called otherwise on the robot.

        `names`: by kind and the device's own name; it may be filled later.
        """
        other = copy(self)
        other._names, other._found = names, {}
        other._watch()
        return other

    def _watch(self) -> None:
        """Watch for two publishers under one name, of this device alone: others may have the same names at first."""
        self._units: dict[str, RangeUnit] = {}  # of the ranges, by laser
        self._scanners: defaultdict[str, PublisherWatch[Array]] = defaultdict(scan_watch)
        self._base, self._speeds = odometry_watch(), BaseSpeeds()
        self._unreadable: defaultdict[str, deque[bool]] = defaultdict(lambda: deque[bool](maxlen=JUDGED_MESSAGES))

    def now(self) -> float:
        """The robot's clock [s]: the time since it was connected, by this computer's."""
        return self._clock() - self._start

    def wheels(
        self, odometry: Pose, speed: float, turn_rate: float, stamp: float | None = None, source: str = ""
    ) -> None:
        """How far the wheels have rolled since the start, and [m/s], [rad/s] now; `source`: who says so.

        A base that was restarted, or jumps, goes on from where it was.
        """
        stamp = self.now() if stamp is None else stamp
        if not are_finite(odometry.x, odometry.y, odometry.heading, speed, turn_rate, stamp):
            self.fault("odometry.malformed", what="a value is no finite number")
            return
        if self._base.take(odometry, self.now(), source):
            self.forget_wheels()
            self._mix("the odometry")
            return
        if untimely := time_fault("odometry", "", self.now(), stamp, stamp):
            self._find(untimely)
            return
        speed, turn_rate, false = self._speeds.take(stamp, odometry, speed, turn_rate)
        if false:
            ways, turns = self._speeds.fit.ratios
            self.fault("odometry.speeds", "the base", used=True, ways=f"{ways:.2g}", turns=f"{turns:.2g}")
        with self._lock:
            if self._here.wheels is not None and stamp < self._here.wheels[0]:
                return  # another overtook it
            place = self._here.anchor @ odometry
            last = self._here.wheels[0] if self._here.wheels is not None else None
            raw = self._here.anchor.inverse() @ self._here.place  # as the base had it
            restarted = last is not None and is_restart(raw, odometry, stamp - last)
            if restarted or last is None:
                self._here.anchor = self._here.place @ odometry.inverse()
                place = self._here.place
            if restarted:
                at = f"{stamp:.1f}"
                self._here.faults.append(fault("odometry.restarted", "the base", used=True, count=1, at=at))
            self._here.place = place
            self._here.wheels = (stamp, Wheels(odometry=place, speed=speed, turn_rate=turn_rate))
            self._count(self.now())

    def scan(self, scan: Scan, source: str = "", *, overtaken: bool = False) -> None:
        """A turn of a laser's mirror; `source`: who says so. One that was `overtaken` is only compared."""
        name = self._names.get((Laser, scan.laser), scan.laser)
        if scan.malformation:
            self.fault("scan.malformed", name or "the laser", what=scan.malformation)
            return
        try:
            scan = self._units.setdefault(name, RangeUnit(name or "the laser", self)).of_scan(scan)
        except UnusableReading as refused:
            for one in refused.faults:
                self._find(one)
            return
        table = self._lasers.get(name)
        scan, offset = (scan, 0.0) if table is None else (_limited(scan, table), table.time_offset)
        stamp = scan.stamp + offset
        if self._scanners[name].take(sector_ranges(scan, self._heading(stamp)), self.now(), source):
            self._mix(name or "the laser")
            return
        if overtaken:
            return
        now = self.now() - offset  # by the laser's clock
        if untimely := time_fault("scan", name or "the laser", now, scan.oldest, scan.newest):
            self._find(untimely, said=False)
        with self._lock:
            self._here.scans.append(replace(scan, laser=name))

    def image(self, image: Image) -> None:
        """A picture."""
        name = self._names.get((Camera, image.camera), image.camera)
        if image.malformation:
            self.fault("picture.malformed", name or "the camera", what=image.malformation)
            return
        with self._lock:
            self._here.image = replace(image, camera=name)
            self._here.undecoded = None

    def undecoded(self, decode: Callable[[], Image | None]) -> None:
        """A picture that is still to be decoded; None: it cannot be.

        Decoded at once where the one before was taken, which is always so where someone drives by the pictures. Else
        it waits for the next frame, and is left out where another one comes first.
        """
        with self._lock:
            if self._here.image is not None or self._here.undecoded is not None:
                self._here.undecoded = decode
                return
        image = decode()
        if image is not None:
            self.image(image)

    def sound(self, sound: Sound) -> None:
        """Samples that follow those before."""
        if sound.malformation:
            self.fault("sound.malformed", what=sound.malformation)
            return
        with self._lock:
            self._here.sound = joined(self._here.sound, sound, MAX_WAITING_SOUND_S)

    def contact(self, pressed: bool) -> None:
        """The bumper."""
        with self._lock:
            self._here.contact = pressed
            self._here.touched = self._here.touched or pressed

    def battery(self, share: float) -> None:
        """How full the battery is, 0..1."""
        if not are_finite(share) or not 0.0 <= share <= 1.0:
            self.fault("battery.malformed", what=f"{share}")
            return
        with self._lock:
            self._here.battery = share

    def arrived(self, sensor: str, *, readable: int = 0, unreadable: int = 0) -> None:
        """So many messages of a sensor came; those that could not be read are left out, and said where they are many.

        `sensor`: its name, or the topic.
        """
        newest = self._unreadable[sensor]
        newest.extend([False] * min(readable, JUDGED_MESSAGES) + [True] * min(unreadable, JUDGED_MESSAGES))
        if unreadable and (bad := sum(newest)) >= MIN_UNREADABLE:
            self.fault("link.unreadable", sensor, used=True, bad=bad, all=len(newest))

    def doubt(self, found: Fault) -> None:
        """A fault of which the device itself knows when it is over."""
        with self._lock:
            self._here.faults.append(found)

    def note(self, sentence: str) -> None:
        """A sentence for the operator."""
        with self._lock:
            self._here.notes.append(sentence)

    @property
    def faults(self) -> tuple[Fault, ...]:
        """The newest fault of each kind and sensor since the start; of this device alone."""
        with self._lock:
            return tuple(one for _, one in self._found.values())

    def forget_wheels(self) -> None:
        """The base is gone; when it is back it goes on from where it was."""
        with self._lock:
            self._here.wheels = None
            self._here.rolled.clear()

    def forget_base(self) -> None:
        """The base is gone with its bumper and its battery."""
        self.forget_wheels()
        with self._lock:
            self._here.contact, self._here.battery = False, None

    def frame(self) -> SensorFrame:
        """All that came since the last frame, at the present instant; a frame has room for one scan."""
        with self._lock:
            waiting, self._here.undecoded = self._here.undecoded, None
        image = waiting() if waiting is not None else None
        if image is not None:
            self.image(image)
        with self._lock:
            stamp = self.now()
            frame = SensorFrame(
                stamp=stamp,
                wheels=self._carried(stamp),
                scan=self._here.scans.popleft() if self._here.scans else None,
                image=self._here.image,
                sound=self._here.sound,
                contact=self._here.contact or self._here.touched,
                battery=self._here.battery,
                trouble=self._mixture(stamp),
                faults=distinct(self._here.faults),
                notes=tuple(dict.fromkeys(self._here.notes)),
            )
            self._here.image = self._here.sound = None
            self._here.notes, self._here.faults, self._here.touched = [], [], False
            return frame

    def _heading(self, stamp: float) -> float:
        with self._lock:
            known = self._here.wheels
        return 0.0 if known is None else known[1].odometry.heading + known[1].turn_rate * (stamp - known[0])

    def _mix(self, sensor: str) -> None:
        """Readings of two robots come under this name: what waits of them is of either."""
        found = fault("robots.mixed", sensor)
        self._find(found, said=False)
        with self._lock:
            self._mixed[sensor] = self.now(), found
            self._here.scans.clear()

    def _mixture(self, now: float) -> str:
        """Why the robot cannot be driven: readings of two robots came lately; "": none did."""
        return next((one.statement for at, one in self._mixed.values() if now - at < MIXED_HELD_S), "")

    def fault(self, code: str, sensor: str = "", *, used: bool = False, **values: object) -> None:
        """Add what a check found in readings of this device."""
        self._find(fault(code, sensor, used=used, **values))

    def _find(self, found: Fault, *, said: bool = True) -> None:
        """Keep a fault; the operator reads it the first time, and again now and then while it lasts.

        Not `said`: the frame shows it as long as it lasts.
        """
        with self._lock:
            now, last = self.now(), self._found.get((found.code, found.sensor))
            if last is None or now - last[0] >= FAULT_AGAIN_S:
                self._found[found.code, found.sensor] = now, found
                self._here.faults += [found] * said

    def _carried(self, stamp: float) -> Wheels | None:
        """The wheels as they stand by now, if they went on as they were."""
        if self._here.wheels is None:
            return None
        taken, wheels = self._here.wheels
        if stamp - taken > MAX_WHEELS_AGE_S:
            return None
        return replace(wheels.carried(max(stamp - taken, 0.0)), rate=self._rate())

    def _count(self, now: float) -> None:
        came = self._here.rolled
        came.append(now)
        while came[0] < now - RATE_WINDOW_S:
            came.popleft()

    def _rate(self) -> float | None:
        """How many readings of the wheels come a second [Hz]; None: they have not come for long enough."""
        came = self._here.rolled
        spread = came[-1] - came[0] if came else 0.0
        return (len(came) - 1) / spread if spread >= MIN_COUNTED_S else None


def _limited(scan: Scan, table: "LaserTable") -> Scan:
    """The scan within the limits of range of the robot file, too; what was measured beyond them leaves all free."""
    near, far = max(scan.range_min, table.range_min or 0.0), min(scan.range_max, table.range_max or math.inf)
    beyond = (scan.ranges > far) & (scan.ranges <= scan.range_max)
    return replace(scan, ranges=np.where(beyond, np.inf, scan.ranges), range_min=near, range_max=far)
