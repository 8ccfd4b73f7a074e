"""Age and state of every sensor of the robot, each by its own rate."""

import math
from dataclasses import replace

from core.robots import Profile
from core.sensors import Fault, SensorFrame
from core.sensors.checks import MAX_AGE_S, time_fault
from core.sentences import Statement
from core.snapshot import SensorKind, SensorState, SensorStatus

STALE_PERIODS, LOST_PERIODS = 3.0, 6.0  # periods without a reading
STALE_AT_LEAST, LOST_AT_LEAST = 0.25, 0.5  # [s] without a reading, at least
STEERING_PERIODS = 1.5  # of slow odometry, over which it is carried on before nothing is steered by it
ANY_FRAME_RATE_HZ = 10.0  # at which sound has to come, though it comes with every frame, and what has no known rate

LOST_SENSOR: dict[SensorKind, str] = {
    "wheels": "sensor.no_odometry",
    "laser": "sensor.no_scan",
    "camera": "sensor.no_picture",
    "microphones": "sensor.no_sound",
}  # codes of sentences
SENSOR_BACK: dict[SensorKind, str] = {
    "wheels": "sensor.odometry_back",
    "laser": "sensor.laser_back",
    "camera": "sensor.camera_back",
    "microphones": "sensor.microphones_back",
}


class SensorWatch:
    """Ages of the sensors that the profile promises. One that never came is waited for from the first frame on."""

    def __init__(self, profile: Profile, start: float) -> None:
        self._rates: dict[tuple[SensorKind, str], float] = {}
        if profile.drives:
            if profile.odometry:
                self._rates["wheels", ""] = ANY_FRAME_RATE_HZ
            self._rates |= {("laser", laser.name): laser.rate or ANY_FRAME_RATE_HZ for laser in profile.lasers}
            self._rates |= {("camera", camera.name): camera.rate or ANY_FRAME_RATE_HZ for camera in profile.cameras}
            if not profile.simulated:  # whose ears may be closed on purpose
                self._rates |= {("microphones", array.name): ANY_FRAME_RATE_HZ for array in profile.arrays[:1]}
        self._offsets = {laser.name: laser.time_offset for laser in profile.lasers}  # [s] of their stamps
        self._newest = dict.fromkeys(self._rates, start)
        self._stamp = start
        self._drives, self._has_odometry = profile.drives, profile.odometry
        self._steered = False  # odometry has come
        self._untimely: dict[SensorKind, dict[str, Fault]] = {}  # by name: whose newest reading was not of its time
        self.blind_since: float | None = None  # [s] since when odometry that came before is too old to steer by

    def untimely(self, kind: SensorKind, name: str | None = None) -> str:
        """Why the newest reading of a sensor (None: of any of its kind) steers nothing, a sentence; "": it may."""
        found = self._untimely.get(kind, {})
        return next((fault.statement for own, fault in found.items() if name in (None, own)), "")

    def believed(self, frame: SensorFrame) -> SensorFrame:
        """The frame without a scan or a picture of the future: nobody knows when it was taken."""
        scan, image = frame.scan, frame.image
        if scan is not None and self._is_ahead("laser", scan.laser):
            frame = replace(frame, scan=None)
        if image is not None and self._is_ahead("camera", image.camera):
            frame = replace(frame, image=None)
        return frame

    def _is_ahead(self, kind: SensorKind, name: str) -> bool:
        found = self._untimely.get(kind, {}).get(self._own_name(kind, name))
        return found is not None and not found.used

    def _own_name(self, kind: SensorKind, name: str) -> str:
        """The name of a sensor; an only one may leave it out."""
        return name or next((own for known, own in self._rates if known == kind), "")

    def update(self, frame: SensorFrame) -> tuple[SensorStatus, ...]:
        """Take one frame → the status of every sensor."""
        if math.isinf(self._stamp):
            self._newest = dict.fromkeys(self._rates, frame.stamp)
        self._stamp = frame.stamp
        here: dict[SensorKind, str | None] = {
            "wheels": None if frame.wheels is None else "",
            "laser": None if frame.scan is None else frame.scan.laser,
            "camera": None if frame.image is None else frame.image.camera,
            "microphones": None if frame.sound is None else "",
        }
        for kind, name in self._rates:
            if here[kind] in ("", name):
                self._newest[kind, name] = frame.stamp
        self._update_wheels(frame)
        if self._drives:
            self._date(frame)
        return tuple(self._status(kind, name) for kind, name in self._rates)

    def _date(self, frame: SensorFrame) -> None:
        scan, image, sound = frame.scan, frame.image, frame.sound
        if scan is not None:
            offset = self._offsets.get(self._own_name("laser", scan.laser), 0.0)
            self._judge("laser", "scan", scan.laser, scan.oldest + offset, scan.newest + offset)
        if image is not None:
            self._judge("camera", "picture", image.camera, image.stamp, image.stamp)
        if sound is not None:
            self._judge("microphones", "sound", "", sound.newest, sound.newest)

    def _judge(self, kind: SensorKind, subject: str, name: str, oldest: float, newest: float) -> None:
        name = self._own_name(kind, name)
        found = time_fault(subject, name or f"the {kind}", self._stamp, oldest, newest)
        self._untimely.setdefault(kind, {}).pop(name, None)
        if found is not None:
            self._untimely[kind][name] = found

    def _update_wheels(self, frame: SensorFrame) -> None:
        """Carried wheels are as old as their reading; the quickest they came is their rate."""
        wheels, known = frame.wheels, self._rates.get(("wheels", ""))
        if self._has_odometry and self._steered:
            old = wheels is None or wheels.age > max(MAX_AGE_S, STEERING_PERIODS / (wheels.rate or ANY_FRAME_RATE_HZ))
            self.blind_since = None if not old else frame.stamp if self.blind_since is None else self.blind_since
        self._steered = self._steered or wheels is not None
        if wheels is None or known is None:
            return
        self._newest["wheels", ""] = frame.stamp - wheels.age
        if wheels.rate is not None:
            self._rates["wheels", ""] = wheels.rate if known == ANY_FRAME_RATE_HZ else max(known, wheels.rate)

    def _status(self, kind: SensorKind, name: str) -> SensorStatus:
        rate, age = self._rates[kind, name], self._stamp - self._newest[kind, name]
        state: SensorState = "live"
        if age > max(LOST_PERIODS / rate, LOST_AT_LEAST):
            state = "lost"
        elif age > max(STALE_PERIODS / rate, STALE_AT_LEAST) or self.untimely(kind, name):
            state = "stale"
        return SensorStatus(kind=kind, name=name, state=state, age=age, rate=rate)


def loss(status: SensorStatus, alone: bool) -> str:
    """A sentence on a sensor that is lost; `alone`: there is no other one of its kind."""
    return _named(LOST_SENSOR[status.kind], status, alone)


def recovery(status: SensorStatus, alone: bool) -> str:
    """A sentence on a sensor that is back."""
    return _named(SENSOR_BACK[status.kind], status, alone)


def _named(code: str, status: SensorStatus, alone: bool) -> Statement:
    if alone or not status.name or status.kind not in ("laser", "camera"):
        return Statement(code)
    return Statement(f"{code}_of", name=status.name)
