"""The robot's driver and its gate as the console sees them: started, supervised, spoken to.

Each has a process of its own, so that neither rendering nor thinking can make the gate late. When one dies it is
started again, disarmed; three deaths within a minute are the last. Nothing here beats by itself: whoever owns the
console's life calls `beat` every 50 ms, so that a frozen console is a silent one.
"""

from __future__ import annotations

import logging
import select
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any, Literal

from console.driver_process import DriverProcess
from console.gate_process import GateProcess, limits_of
from console.halt_wish import HaltWish
from console.mailbox import Mailbox
from core.errors import BeckonError, Unavailable
from core.gate import GateStatus, Limits, Setpoint
from core.gate.limits import is_number
from core.robots import Profile
from core.robots.connect import excerpt
from core.robots.letters import Answer, Opening, Trouble
from core.sensors import SensorFrame
from core.settings import load

log = logging.getLogger(__name__)

LOOK = 0.05  # [s] between looks after the processes
STALE, LOST = 0.5, 3.0  # [s], age of the newest frame
GATE_FROZEN = 1.0  # [s] without a word of the gate, then it is replaced
DRIVER_FROZEN = 10.0  # [s] without a frame, then the driver is replaced
CRASHES, CRASH_WINDOW = 3, 60.0  # that many within so many seconds are the last
PAUSE = 0.5  # [s] more before each further start
ENDING = 0.4  # [s] to end when asked


class RobotProcess:
    """One robot. `start` raises what the driver says; afterwards a fault shows in `link`, `status` and `trouble`."""

    driver_module = "core.robots.process"

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
        self.alarm: Callable[[str], None] = log.debug  # told of every loss of driver or gate, from any thread
        self._opening = Opening(url, seed, excerpt(url, settings))
        self._limits = limits or settings.limits
        self._halt, self._home, self._trace = HaltWish(home), home, gate_trace
        self._profile: Profile | None = None
        self._driver: DriverProcess | None = None
        self._gate: GateProcess | None = None
        self._switching = threading.RLock()  # held while the gate is replaced
        self._status = GateStatus()
        self._presses: dict[str, int] = {}  # newest moving press of each source: over for a gate that comes after
        self._mail = Mailbox()
        self._frame_at: float | None = None
        self._crashes: deque[float] = deque(maxlen=CRASHES)
        self._again_at = 0.0  # when what is missing is started again
        self._last_words = ""  # of a driver that failed
        self._over = threading.Event()
        self._thread: threading.Thread | None = None

    # life

    def start(self) -> None:
        """Bring up driver and gate. Raises BadInput or Unavailable with the driver's sentence."""
        try:
            self._start()
        except BeckonError:
            self.close()
            raise
        self._thread = threading.Thread(target=self._run, name="robot", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Zero, then end both within a second; harmless when done twice."""
        self._over.set()
        self._mail.shut()
        if self._thread is not None:
            self._thread.join()
        self._end_gate(ENDING)
        self._end_driver(ENDING)

    # what the console asks

    @property
    def profile(self) -> Profile:
        """What this robot is; known after `start`."""
        if self._profile is None:
            raise Unavailable("The robot has not been started yet.")
        return self._profile

    @property
    def pids(self) -> dict[str, int]:
        """Which processes run now: driver, gate."""
        running = {"driver": self._driver, "gate": self._gate}
        return {name: one.child.pid for name, one in running.items() if one is not None}

    def next_frame(self, timeout: float) -> SensorFrame | None:
        """The newest frame that nobody took yet, or None when none comes within `timeout` [s]."""
        return self._mail.take_frame(timeout)

    def send(self, setpoint: Setpoint) -> None:
        """An order for the gate to judge."""
        if setpoint.v or setpoint.w:
            self._presses[setpoint.source] = setpoint.press
        speeds = {name: value if is_number(value) else None for name, value in (("v", setpoint.v), ("w", setpoint.w))}
        self._send({"kind": "set", **asdict(setpoint), **speeds})

    def beat(self) -> None:
        """The console is alive: call every 50 ms from whatever must be alive for the robot to move."""
        self._send({"kind": "beat"})

    def stop(self) -> None:
        """Zero at once; a new press may move."""
        self._insist("stop")

    def halt(self) -> None:
        """Zero at once, latched. Raises Unavailable when there is no gate and the latch cannot be kept either."""
        with self._switching:
            self._halt.asked = True
            if not self._insist("halt"):
                self._halt.keep()

    def reset(self) -> bool:
        """Lift the halt; never moves → whether the gate was told."""
        with self._switching:
            sent = self._send({"kind": "reset"})
            self._halt.asked = self._halt.asked and not sent
        return sent

    def arm(self, epoch: int, owner: str) -> None:
        """Obey the holder of this lease from now on."""
        self._send({"kind": "arm", "epoch": epoch, "owner": owner})

    def disarm(self) -> None:
        """Obey nobody."""
        self._insist("disarm")

    def status(self) -> GateStatus:
        """The gate as it last told."""
        return self._status

    def link(self) -> tuple[Literal["connecting", "live", "stale", "lost"], float]:
        """State of the link, and the age [s] of the newest frame (of the start, before the first)."""
        if self._frame_at is None:
            return ("lost" if self.trouble else "connecting"), 0.0
        age = time.monotonic() - self._frame_at
        if self.trouble or age > LOST:
            return "lost", age
        return ("live" if age <= STALE else "stale"), age

    def ask(self, request: dict[str, Any], timeout: float = 2.0) -> dict[str, Any]:
        """A request to the driver → its answer. Raises BadInput, Refused or Unavailable with a sentence."""
        ref, driver = self._mail.open_question(), self._driver
        if driver is None or not driver.ask(ref, request):
            self._mail.take_answer(ref, 0.0)
            raise Unavailable("The robot cannot be asked now.")
        answer = self._mail.take_answer(ref, timeout)
        if answer is None:
            raise Unavailable(f"The robot did not answer within {timeout:g} s.")
        if isinstance(answer, Trouble):
            raise answer.error
        return answer

    def _send(self, packet: dict[str, Any]) -> bool:
        gate = self._gate
        return gate is not None and gate.send(packet)

    def _insist(self, kind: str) -> bool:
        """Tell the gate to stand → whether it heard; one that does not listen is killed, then the base stops."""
        heard = self._send({"kind": kind})
        if not heard and (gate := self._gate) is not None:
            gate.child.kill()
        return heard

    # starting, watching, ending; from one thread at a time

    def _start(self) -> None:
        """Both, or whichever is missing. Raises BadInput or Unavailable."""
        if self._driver is None:
            self._driver = DriverProcess(self.driver_module, self._opening)
            self._profile = self._driver.hello(self._over.is_set)
        with self._switching:
            if self._over.is_set():
                raise Unavailable("The robot was let go.")
            limits = limits_of(self.profile, self._limits)
            spent, halted = self._presses, self._halt.asked
            self._gate = GateProcess(self._driver, limits, self._home, trace=self._trace, spent=spent, halted=halted)

    def _run(self) -> None:
        """Read what comes and look after the processes, until it is over."""
        looked = time.monotonic()
        while not self._over.is_set():
            watched = select.poll()
            hear: dict[int, Callable[[], None]] = {}
            if self._driver is not None:
                hear[self._driver.stream.fileno()] = self._hear_driver
            if self._gate is not None:
                hear[self._gate.orders.fileno()] = self._hear_gate
            for descriptor in hear:
                watched.register(descriptor, select.POLLIN)
            for descriptor, _ in watched.poll(1000 * LOOK):
                hear[descriptor]()
            now = time.monotonic()
            asleep, looked = now - looked > 0.5 * GATE_FROZEN, now
            if not asleep:
                self._look_after(now)

    def _hear_driver(self) -> None:
        if self._driver is None:
            return
        messages = self._driver.read()
        if messages is None:
            self._bury(self._last_words or "The robot's driver has ended.", driver=True)
            return
        for message in messages:
            if isinstance(message, SensorFrame):
                self._mail.put_frame(message)
                self._frame_at = time.monotonic()
            elif isinstance(message, Answer):
                self._mail.put_answer(message)
            elif isinstance(message, Trouble):
                self._last_words = message.sentence
                log.error("%s\n%s", message.sentence, message.details)

    def _hear_gate(self) -> None:
        if self._gate is None:
            return
        statuses, there = self._gate.read()
        if statuses:
            self._status = statuses[-1]
        if not there:
            self._bury("The gate has ended.", driver=False)

    def _look_after(self, now: float) -> None:
        """Replace what is frozen or gone. A console that was frozen itself does not judge others by it."""
        if self._gate is not None and now - self._gate.heard > GATE_FROZEN:
            self._bury("The gate did not answer any more.", driver=False)
        if self._driver is not None and self._frame_at is not None and now - self._frame_at > DRIVER_FROZEN:
            self._bury("The robot's driver did not answer any more.", driver=True)
        if self._gate is None and now >= self._again_at:
            try:
                self._start()
                self.trouble = ""
            except BeckonError as trouble:
                self._bury(str(trouble), driver=True)

    def _bury(self, words: str, *, driver: bool) -> None:
        """One of them is no use any more: end it, say so, and start again soon, unless that happens too often."""
        if self._over.is_set():
            return
        now = time.monotonic()
        log.error(words)
        self._end_gate(0.0)
        self._crashes.append(now)
        often = len(self._crashes) == CRASHES and now - self._crashes[0] < CRASH_WINDOW
        self._again_at = float("inf") if often else now + PAUSE * (len(self._crashes) - 1)
        last = "That was the third time within a minute, so it stays off: restart the console."
        words = f"{words} {last if often else 'It is started again.'}"
        state = "halted" if self._halt.stands else "disarmed"
        self._status = GateStatus(state=state, reason=words, need_neutral=True)
        self.trouble, self._last_words = words, ""
        self.alarm(words)
        if driver:
            self._end_driver(0.0)
            self._frame_at = None

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
