"""The robot as the console speaks to it, and its two processes, driver and gate: started, supervised, ended.

Frames come, setpoints, stops and requests go. Driver and gate have a process of their own each, so that neither
rendering nor thinking can make the gate late. When one dies it is started again, disarmed; three deaths within a
minute are the last. Nothing here beats by itself: the owner of the console's life calls `beat` every 50 ms, so that a
frozen console is a silent one.
"""

import contextlib
import logging
import math
import select
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Literal

from console.robot.driver_process import DriverProcess, FrameBuffer
from console.robot.gate_process import GateProcess, HaltRequest, limits_of
from core.errors import BeckonError, Unavailable
from core.gate import GateStatus, Limits, Setpoint
from core.gate.limits import is_number
from core.gate.requests import ReachingPart
from core.gate.suspend import SleepWatch, time_asleep
from core.robots import Profile
from core.robots.connect import excerpt
from core.robots.ipc_messages import DriverTrouble, OpenRequest, RobotAnswer
from core.robots.requests import AnswerT, RobotRequest, read_answer
from core.sensors import SensorFrame
from core.sentences import Statement
from core.settings import load

# Retry and backoff: when a process that died is started again, and when it is not.

MAX_CRASHES, CRASH_WINDOW_S = 3, 60.0  # that many within so many seconds are the last
RESTART_PAUSE_S = 0.5  # more before each further start
RETRY_S = 2.0  # after a start for which the system had no means


class Restarts:
    """Counts deaths; `due` when the next start is."""

    def __init__(self) -> None:
        self._deaths: deque[float] = deque(maxlen=MAX_CRASHES)
        self._again_at = 0.0  # [s]

    def due(self, now: float) -> bool:
        return now >= self._again_at

    def died(self, now: float) -> str:
        """Another death at `now` [s] → the consequence, a sentence."""
        self._deaths.append(now)
        if len(self._deaths) == MAX_CRASHES and now - self._deaths[0] < CRASH_WINDOW_S:
            self._again_at = math.inf
            return "That was the third time within a minute, so it stays off: restart the console."
        self._again_at = now + RESTART_PAUSE_S * (len(self._deaths) - 1)
        return "It is started again."

    def forgive(self, now: float) -> str:
        """Handle a process that ended through no fault of its own → the consequence, a sentence."""
        self._again_at = now
        return "It is started again."

    def postpone(self, now: float) -> str:
        """The start failed for want of memory, descriptors or processes → the consequence, a sentence."""
        self._again_at = now + RETRY_S
        return f"It is tried again every {RETRY_S:g} seconds."


log = logging.getLogger(__name__)

LOOK_PERIOD_S = 0.05  # between looks after the processes
GATE_FROZEN_S = 1.0  # without a word of the gate, then it is replaced
GATE_STARTING_S = 5.0  # that a new gate may take to say its first
DRIVER_FROZEN_S = 10.0  # without a frame, then the driver is replaced
AWAKENING_S = 2.0  # after a sleep of the machine in which a death is nobody's fault
STALE_AGE_S, LOST_AGE_S = 0.5, 3.0  # [s], age of the newest frame
SIMULATED_PATIENCE = 6.0  # times as long a simulated robot and its gate may keep silent: its time waits for others
END_TIMEOUT_S = 0.4  # to end when asked
LEAVING_NEWS_S = 0.5  # that the console's own signal may come after one of its processes'


class RobotSupervisor:
    """One robot. `start` raises what the driver says; afterwards a fault shows in `link`, `status` and `trouble`."""

    driver_module = "core.robots.process"
    asleep = staticmethod(time_asleep)  # how long the machine has slept [s]

    def __init__(
        self,
        url: str,
        *,
        home: Path,
        seed: int = 0,
        limits: Limits | None = None,
        gate_trace: Path | None = None,
        settings_file: Path | None = None,
    ) -> None:
        """Raises BadInput for an unknown kind of robot or unusable settings; nothing is started yet."""
        settings = load(settings_file)
        self.trouble = ""  # why there is no robot, a sentence; "" when there is one
        self.alarm: Callable[[str], None] = log.debug  # called at every loss of driver or gate, from any thread
        self._opening = OpenRequest(url, seed, excerpt(url, settings), home / "driver.lock")
        self._limits = limits or settings.limits
        self._halt, self._home, self._trace = HaltRequest(home), home, gate_trace
        self._profile: Profile | None = None
        self._driver: DriverProcess | None = None
        self._gate: GateProcess | None = None
        self._switching = threading.RLock()  # held while the gate is replaced
        self._status = GateStatus()
        self._presses: dict[str, int] = {}  # newest moving press of each source: over for a gate that comes after
        self._mail = FrameBuffer()
        self._frame_at: float | None = None
        self._restarts = Restarts()
        self._sleep = SleepWatch(self.asleep)
        self._woke_at = -math.inf  # [s] when this process went on after a sleep or a stop of its own
        self._last_words = ""  # of a driver that failed
        self._leaving, self._over = threading.Event(), threading.Event()
        self._thread: threading.Thread | None = None

    # life

    def launch(self) -> None:
        """Let the driver begin to open the robot; `start` waits for it. Raises Unavailable."""
        try:
            self._driver = DriverProcess(self.driver_module, self._opening)
        except (OSError, MemoryError) as trouble:
            raise Unavailable(f"The robot could not be started: {reason_of(trouble)}.") from None

    def start(self) -> None:
        """Bring up driver and gate. Raises BadInput or Unavailable with the driver's sentence."""
        try:
            self._start()
        except (OSError, MemoryError) as trouble:
            self.close()
            raise Unavailable(f"The robot could not be started: {reason_of(trouble)}.") from None
        except BeckonError:
            self.close()
            raise
        self._thread = threading.Thread(target=self._run, name="robot", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Zero, then end both within a second; harmless when done twice."""
        self.leave_soon()
        self._over.set()
        self._mail.shut()
        if self._thread is not None:
            self._thread.join()
        self._end_gate(END_TIMEOUT_S)
        self._end_driver(END_TIMEOUT_S)

    def leave_soon(self) -> None:
        """The console was asked to end, perhaps with all its processes: one that ends now is none that failed."""
        self._leaving.set()

    @property
    def profile(self) -> Profile:
        """The robot's profile; known after `start`."""
        if self._profile is None:
            raise Unavailable(Statement("robot.not_started"))
        return self._profile

    @property
    def pids(self) -> dict[str, int]:
        """Which processes run now: driver, gate."""
        running = {"driver": self._driver, "gate": self._gate}
        return {name: one.child.pid for name, one in running.items() if one is not None}

    # what comes, what goes

    def next_frame(self, timeout: float) -> SensorFrame | None:
        """The newest frame that nobody took yet, or None when none comes within `timeout` [s]."""
        return self._mail.take_frame(timeout)

    def send(self, setpoint: Setpoint) -> None:
        if setpoint.v or setpoint.w:
            self._presses[setpoint.source] = setpoint.press
        speeds = {name: value if is_number(value) else None for name, value in (("v", setpoint.v), ("w", setpoint.w))}
        self._send({"kind": "set", **asdict(setpoint), **speeds})

    def beat(self) -> None:
        """Report that the console is alive: call every 50 ms from the loop without which the robot must not move."""
        self._send({"kind": "beat"})

    def reach(self, stamp: float | None, part: ReachingPart = "pilot") -> None:
        """Let a simulated robot live on: this part of the console has worked on what it sensed up to this stamp [s].

        None: the robot need not wait for it.
        """
        if self.profile.simulated and self._gate is not None and self._gate.started:
            self._send({"kind": "reach", "stamp": stamp, "part": part})

    def rest(self, rests: bool) -> None:
        """Let frames come less often: the robot stands, nothing is under way and nobody looks. False: no more."""
        if (driver := self._driver) is not None and driver.ready:
            driver.rest(rests)

    def stop(self) -> None:
        """Zero at once; a new press may move."""
        self._insist("stop")

    def halt(self) -> None:
        """Zero at once. The gate latches it; `halt_is_latched` tells when it has."""
        with self._switching:
            self._insist("halt", number=self._halt.ask())

    def halt_is_latched(self) -> bool:
        """True if the newest halt is on disk and has not been reset."""
        return self._halt.is_latched(self._status.latched)

    def latch_halt(self) -> None:
        """Latch the newest halt from here, where the gate does not; waits for the disk. Raises Unavailable."""
        with self._switching:
            if self._halt.asked and not self.halt_is_latched():
                self._halt.keep()

    def reset(self) -> bool:
        """Lift the halt; never moves → whether the request reached the gate."""
        with self._switching:
            sent = self._send({"kind": "reset"})
            self._halt.asked = self._halt.asked and not sent
        return sent

    def arm(self, epoch: int, owner: str) -> None:
        self._send({"kind": "arm", "epoch": epoch, "owner": owner})

    def disarm(self) -> None:
        self._insist("disarm")

    def cap(self, speed: float | None) -> None:
        """Move no faster than this [m/s] until another cap comes; None: as the gate's limits say."""
        self._send({"kind": "cap", "speed": speed})

    def status(self) -> GateStatus:
        return self._status

    def link(self) -> tuple[Literal["connecting", "live", "stale", "lost"], float]:
        """State of the link, and the age [s] of the newest frame (of the start, before the first)."""
        frame_at = self._frame_at  # the robot's thread may forget it meanwhile
        if frame_at is None:
            return ("lost" if self.trouble else "connecting"), 0.0
        age = time.monotonic() - frame_at
        patience = self._patience
        if self.trouble or age > patience * LOST_AGE_S:
            return "lost", age
        return ("live" if age <= patience * STALE_AGE_S else "stale"), age

    @property
    def _patience(self) -> float:
        return SIMULATED_PATIENCE if self._profile is not None and self._profile.simulated else 1.0

    def ask(self, request: RobotRequest[AnswerT], timeout: float = 2.0) -> AnswerT:
        """A request to the driver → its answer. Raises BadInput, Refused or Unavailable with a sentence."""
        ref, driver = self._mail.open_question(), self._driver
        if driver is None or not driver.ask(ref, request):
            self._mail.take_answer(ref, 0.0)
            raise Unavailable(Statement("robot.cannot_be_asked"))
        answer = self._mail.take_answer(ref, timeout)
        if answer is None:
            raise Unavailable(Statement("robot.no_answer", seconds=f"{timeout:g}"))
        if isinstance(answer, DriverTrouble):
            raise answer.error
        return read_answer(answer, request)

    def _send(self, packet: Mapping[str, object]) -> bool:
        gate = self._gate
        return gate is not None and gate.send(packet)

    def _insist(self, kind: str, **more: int) -> None:
        """Tell the gate to stand; one that does not listen is killed, then the base stops."""
        heard = self._send({"kind": kind, **more})
        if not heard and (gate := self._gate) is not None:
            gate.child.kill()

    # starting, watching, ending; from one thread at a time

    def _start(self) -> None:
        """Both, or whichever is missing. Raises BadInput or Unavailable."""
        driver = self._driver = self._driver or DriverProcess(self.driver_module, self._opening)
        if not driver.ready:
            try:
                self._profile = driver.hello(self._over.is_set)
            except (OSError, MemoryError):
                self._end_driver(0.0)
                raise
        with self._switching:
            if self._over.is_set():
                raise Unavailable("The robot was let go.")
            limits = limits_of(self.profile, self._limits)
            spent, halted = self._presses, self._halt.asked
            self._gate = GateProcess(
                driver,
                limits,
                self._home,
                trace=self._trace,
                spent=spent,
                halted=halted,
                simulated=1 / self.profile.rate if self.profile.simulated else None,
            )

    def _run(self) -> None:
        while not self._over.is_set():
            try:
                self._supervise()
            except (OSError, MemoryError) as trouble:  # the system has no means for it now
                log.exception("The robot's supervision was interrupted: %s", reason_of(trouble))
                self._over.wait(LOOK_PERIOD_S)
            except Exception as fault:
                log.exception("The robot's supervision failed")
                self._give_up(f"The robot's supervision failed ({type(fault).__name__}): restart the console.")
                return

    def _supervise(self) -> None:
        watched = select.poll()
        hear: dict[int, Callable[[], None]] = {}
        if self._driver is not None:
            hear[self._driver.stream.fileno()] = self._hear_driver
        if self._gate is not None:
            hear[self._gate.requests.fileno()] = self._hear_gate
        for descriptor in hear:
            watched.register(descriptor, select.POLLIN)
        waited_from = time.monotonic()
        events = watched.poll(1000 * LOOK_PERIOD_S)
        now = time.monotonic()
        slept = self._sleep.woke()
        if slept:
            self._insist("stop")
            self.alarm(Statement("robot.machine_slept", seconds=f"{slept:.0f}"))
        if slept or now - waited_from > 0.5 * GATE_FROZEN_S:
            self._woke_at = now
        for descriptor, _ in events:
            hear[descriptor]()
        self._look_after(time.monotonic())

    def _hear_driver(self) -> None:
        if self._driver is None:
            return
        messages = self._driver.read()
        if messages is None:
            self._ended(self._last_words or "The robot's driver has ended.", driver=True)
            return
        for message in messages:
            if isinstance(message, SensorFrame):
                self._mail.put_frame(message)
                self._frame_at = time.monotonic()
            elif isinstance(message, RobotAnswer):
                self._mail.put_answer(message)
            elif isinstance(message, DriverTrouble):
                self._last_words = message.sentence
                log.error("%s\n%s", message.sentence, message.details)

    def _hear_gate(self) -> None:
        if self._gate is None:
            return
        status, there = self._gate.read()
        self._status = status or self._status
        if not there:
            self._ended("The gate has ended.", driver=False)

    def _look_after(self, now: float) -> None:
        """Replace frozen or ended processes. A console that was frozen itself does not judge others by that time."""
        if (gate := self._gate) is not None:
            patience = self._patience * GATE_FROZEN_S if gate.started else GATE_STARTING_S
            if now - max(gate.heard, self._woke_at) > patience:
                self._bury("The gate did not answer any more.", driver=False)
        frame_at = self._frame_at
        if (
            self._driver is not None
            and frame_at is not None
            and now - max(frame_at, self._woke_at) > self._patience * DRIVER_FROZEN_S
        ):
            self._bury("The robot's driver did not answer any more.", driver=True)
        if self._gate is None and self._restarts.due(now):
            try:
                self._start()
                self.trouble = ""
            except BeckonError as trouble:
                self._bury(str(trouble), driver=True)
            except (OSError, MemoryError) as trouble:
                why = f"The robot's processes could not be started: {reason_of(trouble)}."
                self._tell_trouble(f"{why} {self._restarts.postpone(now)}")

    def _ended(self, words: str, *, driver: bool) -> None:
        """One of them ended. A service that is stopped tells all its processes at once: then nothing is amiss."""
        if self._leaving.wait(LEAVING_NEWS_S):
            self._over.wait()
        self._bury(words, driver=driver)

    def _bury(self, words: str, *, driver: bool) -> None:
        """One of them is no use any more: end it, say so, and start again soon, unless that happens too often."""
        if self._over.is_set():
            return
        now = time.monotonic()
        log.error(words)
        self._end_gate(0.0)
        excused = now - self._woke_at < AWAKENING_S
        outcome = self._restarts.forgive(now) if excused else self._restarts.died(now)
        self._tell_trouble(f"{words} {outcome}")
        self._last_words = ""
        if driver:
            self._end_driver(0.0)
            self._frame_at = None

    def _tell_trouble(self, words: str) -> None:
        state = "halted" if self._halt.stands else "disarmed"
        self._status = GateStatus(state=state, reason=words, need_neutral=True)
        if words != self.trouble:
            self.trouble = words
            self.alarm(words)

    def _give_up(self, words: str) -> None:
        """Nobody looks after the processes any more: end both, so that the robot stands."""
        with contextlib.suppress(OSError, MemoryError):
            self._end_gate(0.0)
            self._end_driver(0.0)
        self._tell_trouble(words)

    def _end_gate(self, patience: float) -> None:
        with self._switching:
            gate, self._gate = self._gate, None
            if gate is not None:
                gate.end(patience)
                self._halt.outlast()

    def _end_driver(self, patience: float) -> None:
        driver, self._driver = self._driver, None
        if driver is not None:
            driver.end(patience)


def reason_of(trouble: OSError | MemoryError) -> str:
    """Return what the system lacks, in words."""
    return (trouble.strerror if isinstance(trouble, OSError) else "") or "not enough memory"
