"""What devices hand on: newest wins, sound is joined, nothing queues without bound."""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import replace

from core.geometry import Pose, arc
from core.sensors import Image, Scan, SensorFrame, Sound, Wheels
from core.sensors.microphones import joined

AHEAD = 0.1  # [s] over which a reading of the wheels is carried on to the frame
WAITING = 4  # scans that may wait for a frame
JUMP, FASTEST = 0.5, 5.0  # [m], [m/s] beyond which the wheels were not rolled: the base was restarted
LONGEST_SOUND = 3.0  # [s] that may wait for a frame


class Readings:
    """Filled by the devices' threads, emptied by the driver's. Stamps are on the robot's clock, see `now`."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock, self._start = clock, clock()
        self._lock = threading.Lock()
        self._scans: deque[Scan] = deque(maxlen=WAITING)
        self._wheels: tuple[float, Wheels] | None = None
        self._place = self._anchor = Pose()  # the newest odometry handed on, and what its own is seen from
        self._image: Image | None = None
        self._sound: Sound | None = None
        self._notes: list[str] = []
        self._contact = False
        self._touched = False  # since the last frame
        self.battery: float | None = None  # 0..1

    def now(self) -> float:
        """The robot's clock [s]: the time since it was connected, by this computer's."""
        return self._clock() - self._start

    def wheels(self, odometry: Pose, speed: float, turn_rate: float, stamp: float | None = None) -> None:
        """How far the wheels have rolled since the start, and [m/s], [rad/s] now.

        A base that was restarted, or jumps, goes on from where it was.
        """
        if not all(map(math.isfinite, (odometry.x, odometry.y, odometry.heading, speed, turn_rate))):
            return
        with self._lock:
            stamp = self.now() if stamp is None else stamp
            place = self._anchor @ odometry
            if self._wheels is None or _jumped(self._place, place, stamp - self._wheels[0]):
                self._anchor = self._place @ odometry.inverse()
                place = self._place
            self._place = place
            self._wheels = (stamp, Wheels(odometry=place, speed=speed, turn_rate=turn_rate))

    def scan(self, scan: Scan) -> None:
        """A turn of a laser's mirror."""
        with self._lock:
            self._scans.append(scan)

    def image(self, image: Image) -> None:
        """A picture."""
        with self._lock:
            self._image = image

    def sound(self, sound: Sound) -> None:
        """Samples that follow those before."""
        with self._lock:
            self._sound = joined(self._sound, sound, LONGEST_SOUND)

    def contact(self, pressed: bool) -> None:
        """The bumper."""
        with self._lock:
            self._contact = pressed
            self._touched = self._touched or pressed

    def note(self, sentence: str) -> None:
        """A sentence for the operator."""
        with self._lock:
            self._notes.append(sentence)

    def forget_wheels(self) -> None:
        """The base is gone; when it is back it goes on from where it was."""
        with self._lock:
            self._wheels = None

    def frame(self) -> SensorFrame:
        """All that came since the last frame, at the present instant; a frame has room for one scan."""
        with self._lock:
            stamp = self.now()
            frame = SensorFrame(
                stamp=stamp,
                wheels=self._carried(stamp),
                scan=self._scans.popleft() if self._scans else None,
                image=self._image,
                sound=self._sound,
                contact=self._contact or self._touched,
                note=" ".join(self._notes),
            )
            self._image = self._sound = None
            self._notes, self._touched = [], False
            return frame

    def _carried(self, stamp: float) -> Wheels | None:
        """The wheels as they stand by now, if they went on as they were."""
        if self._wheels is None:
            return None
        taken, wheels = self._wheels
        ahead = min(max(stamp - taken, 0.0), AHEAD)
        return replace(wheels, odometry=wheels.odometry @ arc(wheels.speed * ahead, wheels.turn_rate * ahead))


def _jumped(last: Pose, now: Pose, elapsed: float) -> bool:
    """Return whether no robot can have come from one place to the other in that time [s]."""
    return last.distance_to(now.x, now.y) > JUMP + FASTEST * max(elapsed, 0.0)
