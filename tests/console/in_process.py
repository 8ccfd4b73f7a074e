"""A robot and its gate in this very process: the real simulator, the real gate. Nothing is mocked.

The gate's clock runs no further than the robot's frames, and the robot waits for a late console: a busy machine
trips nothing here and no turn goes too far. How gate, driver and console fare in real time is tested with their own
processes.
"""

import threading
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from core.gate.gate import TICK_S, Gate
from core.gate.limits import Limits
from core.gate.requests import ReachingPart
from core.gate.setpoint import Setpoint
from core.gate.status import GateStatus
from core.gate.trace import TraceWriter, check
from core.robots import Profile
from core.robots.connect import connect
from core.robots.frame_sender import merged
from core.robots.nearness import NearField, show
from core.robots.requests import AnswerT, RobotRequest
from core.sensors import SensorFrame
from core.settings import Settings

PATIENCE = 1.0  # [s] that the robot waits for its last frame to be taken
HEARTBEAT = 0.6  # [s] that the gate waits for the console: here one interpreter does the work of three processes


class InProcessRobot:
    """The console's RobotSupervisor without processes, for tests that need a robot behind the console."""

    def __init__(
        self, url: str = "sim:lab", *, seed: int = 0, settings: Settings | None = None, pace: float = 1.0
    ) -> None:
        """`pace`: seconds that pass for the robot within one of ours."""
        self.settings = settings or Settings()
        self.robot = connect(url, seed=seed, settings=self.settings)
        self.writer = TraceWriter()
        self.gate = Gate(Limits(heartbeat=HEARTBEAT), trace=self.writer)
        self._near_field = NearField(self.robot.profile.lasers)
        self.cut = False  # the link is lost
        self.trouble = ""
        self.alarm: Callable[[str], None] = print
        self.stuck = ""  # why a halt cannot be lifted; "" when it can
        self.deaf = False  # there is no gate that could be told of a reset
        self.orders: list[Setpoint] = []
        self._now = 1.0  # [s] of the gate's clock
        self._pace = pace
        self._ahead = 0.0  # [s] that it may still run before the next frame
        self._lock = threading.RLock()
        self._news = threading.Condition()
        self._frame: SensorFrame | None = None
        self._frame_at = 0.0
        self._over = threading.Event()
        self._threads = [threading.Thread(target=run, daemon=True) for run in (self._drive, self._tick)]

    @property
    def profile(self) -> Profile:
        return self.robot.profile

    def start(self) -> None:
        for thread in self._threads:
            thread.start()

    @property
    def now(self) -> float:
        """The gate's clock [s]."""
        return self._now

    def leave_soon(self) -> None:
        pass  # nothing of it is a process of its own

    def close(self) -> None:
        self._over.set()
        for thread in self._threads:
            if thread.is_alive():
                thread.join()
        self.robot.close()

    def next_frame(self, timeout: float) -> SensorFrame | None:
        with self._news:
            if self._frame is None:
                self._news.wait(timeout)
            frame, self._frame = self._frame, None
            self._news.notify_all()
            return None if self.cut else frame

    def send(self, setpoint: Setpoint) -> None:
        with self._lock:
            self.orders.append(setpoint)
            self.gate.accept(setpoint, self._now)

    def stop(self) -> None:
        with self._lock:
            self.gate.stop(self._now)

    def halt(self) -> None:
        with self._lock:
            self.gate.halt(self._now)

    def halt_is_latched(self) -> bool:
        return self.status().state == "halted"

    def latch_halt(self) -> None: ...

    def reset(self) -> bool:
        with self._lock:
            if self.stuck:
                self.gate.remark(self.stuck)
            elif not self.deaf:
                self.gate.reset(self._now)
        return not self.deaf

    def arm(self, epoch: int, owner: str) -> None:
        with self._lock:
            self.gate.arm(epoch, owner, self._now)

    def cap(self, speed: float | None) -> None:
        with self._lock:
            self.gate.cap(speed)

    def disarm(self) -> None:
        with self._lock:
            self.gate.disarm(self._now)

    def beat(self) -> None:
        with self._lock:
            self.gate.heartbeat(self._now)

    def reach(self, stamp: float | None, part: ReachingPart = "pilot") -> None: ...

    def rest(self, rests: bool) -> None: ...

    def status(self) -> GateStatus:
        with self._lock:
            return self.gate.status()

    def ask(self, request: RobotRequest[AnswerT], timeout: float = 2.0) -> AnswerT:
        with self._lock:
            return self.robot.ask(request)

    def link(self) -> tuple[Any, float]:
        age = time.monotonic() - self._frame_at
        return ("connecting" if not self._frame_at else "lost" if self.cut else "live"), (
            age if self._frame_at else 0.0
        )

    def _drive(self) -> None:
        due = time.monotonic()
        while not self._over.is_set():
            with self._lock:
                self.robot.drive(self.gate.twist)
                frame = replace(self.robot.read(), nonce=self.gate.status().nonce)
                self._ahead = 1.2 / self.profile.rate
                show(self.gate, self._near_field, frame, self._now)
            with self._news:
                self._frame = frame if self._frame is None else merged(self._frame, frame)
                self._frame_at = time.monotonic()
                self._news.notify_all()
                self._news.wait_for(lambda: self._frame is None or self._over.is_set(), PATIENCE)
            due = max(due + 1 / (self._pace * self.profile.rate), time.monotonic())
            self._over.wait(due - time.monotonic())

    def _tick(self) -> None:
        before = time.monotonic()
        while not self._over.wait(TICK_S):
            with self._lock:
                elapsed, before = time.monotonic() - before, time.monotonic()
                passed = min(elapsed, 1.5 * TICK_S, self._ahead)
                self._now, self._ahead = self._now + passed, self._ahead - passed
                self.gate.tick(self._now)

    def faults(self) -> list[str]:
        """What the trace checker has to say; empty when everything was in order."""
        with self._lock:
            return check(self.writer.rows, self.gate.limits)


class SteppedClock:
    """Seconds that pass only when a robot is stepped: `time.monotonic` of a console faster than real time."""

    def __init__(self) -> None:
        self.now = time.monotonic()

    def __call__(self) -> float:
        return self.now


class SteppedRobot(InProcessRobot):
    """The same in lock step with its console: each frame comes when the pilot asks, once the event loop is done with
    the frame before. As fast as the processor can; nothing depends on how fast that is.
    """

    def __init__(self, url: str, *, clock: SteppedClock, share: float = 1.0, **options: Any) -> None:
        """`clock`: moved on with each frame; `share`: of a processor that all may take."""
        super().__init__(url, **options)
        self._threads = []
        self._clock, self._share = clock, share
        self._worked = time.process_time(), time.perf_counter()
        self.loop_done: Callable[[], None] = lambda: None  # waits until the console has done what it has to do

    def next_frame(self, timeout: float) -> SensorFrame | None:
        """The next frame, or none while the link is cut; time passes all the same."""
        self.loop_done()
        self._keep_to_share()
        with self._lock:
            self.robot.drive(self.gate.twist)
            frame = replace(self.robot.read(), nonce=self.gate.status().nonce)
            show(self.gate, self._near_field, frame, self._now)
            end = self._now + 1 / self.profile.rate
            while self._now < end - 1e-9:
                passed = min(TICK_S, end - self._now)
                self._now += passed
                self._clock.now += passed
                self.gate.tick(self._now)
        if self.cut:
            return None
        self._frame_at = self._clock.now
        return frame

    def _keep_to_share(self) -> None:
        """Leave the rest of the processor to others."""
        work, real = time.process_time() - self._worked[0], time.perf_counter() - self._worked[1]
        if work / self._share > real:
            time.sleep(min(0.1, work / self._share - real))
        if real > 10.0:
            self._worked = time.process_time(), time.perf_counter()
