"""The pilot's thread: for each frame of the robot, step, send the setpoint, publish."""

import logging
import math
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from importlib import import_module

from console.robot.setpoint_sender import SetpointSender
from console.robot.supervisor import RobotSupervisor
from core.gate.scheduling import PILOT_RANK, stay_first
from core.pilot.pilot import Pilot
from core.pilot.recorded_drive import ReplayFrame
from core.sensors import SensorFrame
from core.snapshot import Snapshot

log = logging.getLogger(__name__)

FRAME_WAIT_S = 0.1  # to wait for a frame before looking whether it is over
HUNG_S = 2.0  # without a turn after which the pilot hangs; the gate has the base stand long before
HUNG_SIMULATED_S = 20.0  # the same of a simulated robot, whose time stands meanwhile
MAX_REMEMBERED_STEPS = 400  # steps, ten seconds of them
NEWEST_STEPS = 8  # steps; at 40 Hz at least one of them has a scan
PILOTS_MATHEMATICS = ("linalg", "optimize", "sparse.csgraph", "sparse.linalg", "spatial", "special")  # of scipy


class PilotPace:
    """How often frames come and how long a step takes. The pilot's thread notes, the event loop reads."""

    def __init__(self) -> None:
        self._lock = threading.Lock()  # a deque that grows while it is copied raises RuntimeError
        self._stamp = 0.0  # [s] of the newest frame
        self._arrivals: deque[float] = deque(maxlen=MAX_REMEMBERED_STEPS)
        self._delays: deque[float] = deque(maxlen=MAX_REMEMBERED_STEPS)
        self._steps: deque[float] = deque(maxlen=MAX_REMEMBERED_STEPS)

    def note(self, stamp: float, arrived: float, took: float) -> None:
        """Record a step: when its frame was sensed, when it came and how long it took (ours) [s].

        `stamp` is of the robot's clock; of ours where that of a simulated robot waits for a busy computer.
        """
        with self._lock:
            if stamp < self._stamp:
                self._delays.clear()  # another clock: the robot was started again, or a recording jumped
            self._stamp = stamp
            self._arrivals.append(arrived)
            self._delays.append(arrived - stamp)
            self._steps.append(took)

    def rate(self, now: float) -> float:
        """Frames per second over the last two seconds [Hz]."""
        recent = [moment for moment in self._copy(self._arrivals) if now - moment < 2.0]
        return (len(recent) - 1) / max(recent[-1] - recent[0], 1e-3) if len(recent) > 1 else 0.0

    def measured(self, now: float) -> tuple[float, float | None]:
        """Frames per second [Hz], and the longest of the newest steps [ms]: the one that had most to see."""
        newest = self._copy(self._steps)[-NEWEST_STEPS:]
        return self.rate(now), round(1000 * max(newest), 2) if newest else None

    def step_ms(self, part: float) -> float | None:
        """The time within which `part` (0..1) of the newest steps were done [ms]."""
        return quantile_ms(self._copy(self._steps), part)

    def late_ms(self, part: float) -> float | None:
        """How much later than the quickest of them `part` (0..1) of the newest frames came, at most [ms]."""
        delays = self._copy(self._delays)
        least = min(delays, default=0.0)
        return quantile_ms([delay - least for delay in delays], part)

    def _copy(self, values: deque[float]) -> list[float]:
        with self._lock:
            return list(values)


def quantile_ms(spans: Sequence[float], part: float) -> float | None:
    """The span [s] that `part` (0..1) of them do not exceed, in ms."""
    return round(1000 * sorted(spans)[min(int(part * len(spans)), len(spans) - 1)], 2) if spans else None


def load_mathematics() -> None:
    """Import what a pilot would else import at its first need, in the middle of a drive."""
    for name in PILOTS_MATHEMATICS:
        import_module(f"scipy.{name}")


class PilotThread:
    """Owns one pilot. When the pilot fails the robot is stopped and `failed` is called, once, from this thread."""

    def __init__(
        self,
        robot: RobotSupervisor,
        pilot: Pilot,
        setpoint_sender: SetpointSender,
        publish: Callable[[Snapshot, SensorFrame], None],
        failed: Callable[[str], None],
        deaf: Callable[[float], bool] = lambda _: False,
    ) -> None:
        """`deaf`: tells for a stamp [s] whether sound up to it is not listened to."""
        self.pilot = pilot
        self.pace = PilotPace()
        self._robot = robot
        self._setpoint_sender = setpoint_sender
        self._publish = publish
        self._failed = failed
        self._deaf = deaf
        self._over = threading.Event()
        self._turned = math.inf  # [s] when it last was at the beginning of a turn
        self._thread = threading.Thread(target=self._run, name="pilot", daemon=True)

    @property
    def alive(self) -> bool:
        return self._thread.is_alive() and not self._over.is_set()

    @property
    def is_stepping(self) -> bool:
        """True while it goes on, rather than being caught in a step."""
        hung = HUNG_SIMULATED_S if self._robot.profile.simulated else HUNG_S
        return self.alive and time.monotonic() - self._turned < hung

    def start(self) -> None:
        self._thread.start()

    def close(self) -> None:
        """End; waits at most two seconds."""
        self._over.set()
        if self._thread.is_alive():
            self._thread.join(2.0)

    def _step(self, frame: SensorFrame, deaf: bool) -> tuple[Snapshot, SensorFrame]:
        """One frame → its snapshot and what is used of it; a recording of ours brings the snapshot along."""
        if isinstance(frame, ReplayFrame):
            return frame.shown, frame
        return self.pilot.step(frame, deaf=deaf), self.pilot.frame

    def _run(self) -> None:
        stay_first(PILOT_RANK)
        try:
            load_mathematics()
            while not self._over.is_set():
                self._turned = time.monotonic()
                frame = self._robot.next_frame(FRAME_WAIT_S)
                if frame is None:
                    continue
                arrived = time.monotonic()
                deaf = frame.sound is not None and self._deaf(frame.stamp)
                snapshot, used = self._step(frame, deaf)
                self._setpoint_sender.follow(snapshot)
                self._robot.reach(frame.stamp)
                self._publish(snapshot, used)
                waits = self._robot.profile.simulated and frame.sensed > 0
                self.pace.note(frame.sensed if waits else frame.stamp, arrived, time.monotonic() - arrived)
        except Exception as fault:
            self._over.set()
            self._setpoint_sender.stop()
            log.exception("The pilot failed")
            self._failed(type(fault).__name__)
        finally:
            self._robot.reach(None)
