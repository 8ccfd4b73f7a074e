"""The simulated robot, living in real time: what an emulator puts on its wire, and what its wire moves."""

import threading
import time
from collections.abc import Callable
from dataclasses import replace

from core.gate import ZERO, Twist
from core.geometry import Pose
from core.robots.requests import AnswerT, RobotRequest, SetListening
from core.sensors import Image, Scan, Sound, Wheels
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import SimulationSettings

BEHIND = 0.5  # [s] that may be caught up
NEVER = float("-inf")


class World:
    """`sim:<place>` stepped by a thread; the callbacks are called from it."""

    def __init__(
        self,
        seed: int = 0,
        place: str = "lab",
        failsafe: float | None = 0.5,
        *,
        listening: bool = False,
        scan_shift: float = 0.0,
    ) -> None:
        """`failsafe` [s]: without `drive` for so long, the wheels stop; None: they never do.

        `listening`: the microphones hear the room all the time, else only who speaks. `scan_shift` [s]: what is added
        to the stamps of scans, on wires that carry some.
        """
        self.on_scan: list[Callable[[Scan], None]] = []
        self.on_image: list[Callable[[Image], None]] = []
        self.on_wheels: list[Callable[[Wheels], None]] = []
        self.on_sound: list[Callable[[Sound], None]] = []
        self.on_contact: list[Callable[[bool], None]] = []
        self.speeds: list[tuple[float, float, float]] = []  # time.monotonic(), v, w: changes of what was applied
        self.truth = Pose()
        self.robot: SimulatedRobot | None = None
        self._seed, self._place, self._failsafe = seed, place, failsafe
        self._listening, self._scan_shift = listening, scan_shift
        self._lock, self._stepping = threading.Lock(), threading.Lock()
        self._wanted, self._wanted_at = ZERO, NEVER
        self.left_out = 0.0  # [s] that the computer was too slow for: not simulated
        self._began = 0.0  # time.monotonic() of the simulator's stamp 0
        self._over = threading.Event()
        self._thread: threading.Thread | None = None

    def instant(self, stamp: float) -> float:
        """The simulator's time [s] → time.monotonic() at which it was due: what a real sensor would have stamped."""
        return self._began + stamp

    def start(self) -> None:
        """Begin to live. The camera is simulated where someone looks at its pictures."""
        settings = SimulationSettings(camera=bool(self.on_image))
        self.robot = SimulatedRobot(self._place, seed=self._seed, settings=settings)
        if self._listening:
            self.robot.ask(SetListening(on=True))
        self._over.clear()
        self._thread = threading.Thread(target=self._live, args=(self.robot,), name="world", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        self._over.set()
        if self._thread is not None:
            self._thread.join(5.0)

    def ask(self, request: RobotRequest[AnswerT]) -> AnswerT:
        """Put someone into the room, let them speak, read the floor plan: a request to the simulator."""
        assert self.robot is not None
        with self._stepping:
            return self.robot.ask(request)

    def drive(self, v: float, w: float) -> None:
        """Set speeds [m/s], [rad/s], which hold until the next call or the failsafe."""
        with self._lock:
            self._wanted, self._wanted_at = Twist(v, w), time.monotonic()
            self._log(self._wanted)

    def _log(self, twist: Twist) -> None:
        if not self.speeds or self.speeds[-1][1:] != (twist.v, twist.w):
            self.speeds.append((time.monotonic(), twist.v, twist.w))

    def _live(self, robot: SimulatedRobot) -> None:
        period, due = 1 / robot.profile.rate, time.monotonic()
        self._began = due - period
        while not self._over.wait(max(0.0, due - time.monotonic())):
            now = time.monotonic()
            left_out = max(0.0, now - BEHIND - due - period)
            self.left_out += left_out
            self._began += left_out
            due += period + left_out
            with self._lock:
                if self._failsafe is not None and now - self._wanted_at > self._failsafe:
                    self._wanted = ZERO
                    self._log(ZERO)
                robot.drive(self._wanted)
            self._step(robot)

    def _step(self, robot: SimulatedRobot) -> None:
        with self._stepping:
            frame = robot.read()
        if frame.truth is not None:
            self.truth = frame.truth
        for value, callbacks in (
            (frame.wheels, self.on_wheels),
            (self._stamped(frame.scan), self.on_scan),
            (frame.image, self.on_image),
            (frame.sound, self.on_sound),
        ):
            for callback in callbacks if value is not None else ():
                callback(value)  # type: ignore[arg-type]
        for callback in self.on_contact:
            callback(frame.contact)

    def _stamped(self, scan: Scan | None) -> Scan | None:
        return None if scan is None else replace(scan, stamp=scan.stamp + self._scan_shift)
