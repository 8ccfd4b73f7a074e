"""Age and state of every sensor of the robot, each by its own rate."""

from __future__ import annotations

import math

from core.robots import Profile
from core.sensors import SensorFrame
from core.snapshot import SensorKind, SensorState, SensorStatus

STALE, LOST = 3.0, 6.0  # periods without a reading …
STALE_AT_LEAST, LOST_AT_LEAST = 0.25, 0.5  # [s] … and no sooner than this
ANY_FRAME = 10.0  # [Hz] at which sound has to come, though it comes with every frame, and wheels of unknown rate


class SensorWatch:
    """Ages of the sensors that the profile promises. One that never came is waited for from the first frame on."""

    def __init__(self, profile: Profile, start: float) -> None:
        self._rates: dict[tuple[SensorKind, str], float] = {}
        if profile.drives:
            if profile.odometry:
                self._rates["wheels", ""] = ANY_FRAME
            self._rates |= {("laser", laser.name): laser.rate for laser in profile.lasers}
            self._rates |= {("camera", camera.name): camera.rate for camera in profile.cameras}
            if not profile.simulated:  # whose ears may be closed on purpose
                self._rates |= {("microphones", array.name): ANY_FRAME for array in profile.arrays[:1]}
        self._newest = dict.fromkeys(self._rates, start)
        self._stamp = start

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
        return tuple(self._status(kind, name) for kind, name in self._rates)

    def _update_wheels(self, frame: SensorFrame) -> None:
        """Carried wheels are as old as their reading; the quickest they came is their rate."""
        wheels, known = frame.wheels, self._rates.get(("wheels", ""))
        if wheels is None or known is None:
            return
        self._newest["wheels", ""] = frame.stamp - wheels.age
        if wheels.rate is not None:
            self._rates["wheels", ""] = wheels.rate if known == ANY_FRAME else max(known, wheels.rate)

    def _status(self, kind: SensorKind, name: str) -> SensorStatus:
        rate, age = self._rates[kind, name], self._stamp - self._newest[kind, name]
        state: SensorState = "live"
        if age > max(LOST / rate, LOST_AT_LEAST):
            state = "lost"
        elif age > max(STALE / rate, STALE_AT_LEAST):
            state = "stale"
        return SensorStatus(kind=kind, name=name, state=state, age=age, rate=rate)


def loss(status: SensorStatus, alone: bool) -> str:
    """A sentence on a sensor that is lost; `alone`: there is no other one of its kind."""
    name = "" if alone or not status.name else f" {status.name}"
    return {
        "wheels": "No odometry comes from the base.",
        "laser": f"No scan comes from the laser{name}.",
        "camera": f"No picture comes from the camera{name}.",
        "microphones": "No sound comes from the microphones.",
    }[status.kind]


def recovery(status: SensorStatus, alone: bool) -> str:
    """A sentence on a sensor that is back."""
    name = "" if alone or not status.name else f" {status.name}"
    return {
        "wheels": "The odometry is back.",
        "laser": f"The laser{name} is back.",
        "camera": f"The camera{name} is back.",
        "microphones": "The microphones are back.",
    }[status.kind]
