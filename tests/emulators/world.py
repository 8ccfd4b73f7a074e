"""The simulated robot in real time, for emulators: a wire drives it and carries what it senses."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from core.gate import ZERO, Twist
from core.geometry import Pose
from core.sensors import Image, Scan, Sound, Wheels
from core.simulation.robot import SimulatedRobot, SimulationSettings

BEHIND = 0.2  # [s] that are caught up; more is given up


class World:
    """A robot in `sim:lab`, stepped by a thread. The callbacks are called from that thread; they must not wait."""

    def __init__(
        self,
        seed: int = 0,
        place: str = "lab",
        failsafe: float | None = 0.5,
        settings: SimulationSettings | None = None,
    ) -> None:
        """`failsafe` [s]: without a call of `drive` for so long the robot stops by itself; None: never."""
        self.robot = SimulatedRobot(place, seed=seed, settings=settings)
        self.failsafe = failsafe
        self.on_scan: list[Callable[[Scan], None]] = []
        self.on_image: list[Callable[[Image], None]] = []
        self.on_wheels: list[Callable[[Wheels], None]] = []
        self.on_sound: list[Callable[[Sound], None]] = []
        self.speeds: list[tuple[float, float, float]] = []  # time.monotonic(), v [m/s], w [rad/s] as applied
        self.truth = Pose()
        self._twist, self._heard = ZERO, time.monotonic()
        self._lock = threading.Lock()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, name="world", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        self._over.set()
        if self._thread.is_alive():
            self._thread.join(2.0)

    def drive(self, v: float, w: float) -> None:
        """Set the speeds [m/s], [rad/s], which hold until the next call or the failsafe."""
        with self._lock:
            self._heard = time.monotonic()
            self._apply(Twist(v, w))

    def _apply(self, twist: Twist) -> None:
        self._twist = twist
        self.speeds.append((time.monotonic(), twist.v, twist.w))

    def _run(self) -> None:
        period = 1 / self.robot.profile.rate
        due = time.monotonic()
        while not self._over.wait(max(0.0, due - time.monotonic())):
            due = max(due + period, time.monotonic() - BEHIND)
            with self._lock:
                silence = time.monotonic() - self._heard
                if self._twist.moves and self.failsafe is not None and silence > self.failsafe:
                    self._apply(ZERO)
                self.robot.drive(self._twist)
            self._step()

    def _step(self) -> None:
        frame = self.robot.read()
        if frame.truth is not None:
            self.truth = frame.truth
        for value, listeners in (
            (frame.wheels, self.on_wheels),
            (frame.scan, self.on_scan),
            (frame.image, self.on_image),
            (frame.sound, self.on_sound),
        ):
            for listener in listeners if value is not None else ():
                listener(value)
