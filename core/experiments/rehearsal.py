"""The whole robot on simulated time, as fast as it goes: read → step → accept → tick → drive, and a checked trace."""

import itertools
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace

from core.commands.command import Command
from core.errors import Refused
from core.gate import TICK_S, Gate, Setpoint, TraceRow, TraceWriter, check
from core.geometry import Pose
from core.perception.people.engines import open_detector
from core.perception.people.looking import ImmediateLook
from core.pilot import Pilot
from core.robots.connect import connect
from core.robots.nearness import NearField, show
from core.robots.requests import CarryRobot
from core.sensors import SensorFrame
from core.settings import Settings
from core.snapshot import ActiveCommandStatus, Snapshot
from core.speech.understanding.grammar import Refusal, understand

EPOCH_NUMBER = 1


class Rehearsal:
    """One robot, its gate and its pilot, obeying sentences. What it did stays in `trace`."""

    def __init__(
        self, url: str = "sim:lab", *, seed: int = 0, start: Pose | None = None, settings: Settings | None = None
    ) -> None:
        """`start`: where in the simulated world it begins, instead of at its origin. Raises BadInput in a wall."""
        self.settings = settings or Settings()
        self.robot = connect(url, seed=seed, settings=self.settings)
        if start is not None:
            self.robot.ask(CarryRobot(x_m=start.x, y_m=start.y, heading_rad=start.heading))
        self.pilot = Pilot(self.robot.profile, self.settings)
        if self.settings.people.engine == "pose":  # "auto" is the embedded one: the same on every machine
            self.pilot.find_people_with(ImmediateLook(open_detector(self.settings.people)))
        self._writer = TraceWriter()
        self.gate = Gate(self.settings.limits, trace=self._writer)
        self.gate.arm(EPOCH_NUMBER, "rehearsal", 0.0)
        self._near_field = NearField(self.robot.profile.lasers)
        self.endings: list[ActiveCommandStatus] = []
        self.when_stepped: list[Callable[[SensorFrame], None]] = []  # called with every frame
        self.around_step: Callable[[], AbstractContextManager[None]] = nullcontext  # entered for every step
        self.contacts = 0
        self._touching = False
        self._ticks = itertools.count()
        self._next_tick = 0.0
        self._seq = itertools.count(1)
        self._ids = itertools.count(1)
        self.snapshot = self.step()

    @property
    def truth(self) -> Pose:
        """The true pose of the robot, in the world frame."""
        assert self.snapshot.truth is not None
        return self.snapshot.truth

    @property
    def trace(self) -> list[TraceRow]:
        """The log of the wheels' setpoints."""
        return self._writer.rows

    def faults(self) -> list[str]:
        """Faults found by the trace checker; empty when everything was in order."""
        return check(self.trace, self.settings.limits)

    def step(self) -> Snapshot:
        """One frame further."""
        self.frame = frame = replace(self.robot.read(), nonce=self.gate.status().nonce)
        now = frame.stamp
        self.gate.heartbeat(now)
        show(self.gate, self._near_field, frame, now)
        self.contacts += frame.contact and not self._touching
        self._touching = frame.contact
        with self.around_step():
            self.snapshot = self.pilot.step(frame)
        self.endings += self.snapshot.endings
        self._request(self.snapshot, now)
        self._tick_until(now + 1 / self.robot.profile.rate)
        self.robot.drive(self.gate.twist)
        for tell in self.when_stepped:
            tell(frame)
        return self.snapshot

    def _request(self, snapshot: Snapshot, now: float) -> None:
        twist, press = snapshot.setpoint, snapshot.setpoint_command_id
        setpoint = Setpoint(EPOCH_NUMBER, next(self._seq), "goal", press, twist.v, twist.w, snapshot.nonce)
        self.gate.accept(setpoint, now)

    def _tick_until(self, end: float) -> None:
        while self._next_tick < end - 1e-9:
            self.gate.tick(self._next_tick)
            self._next_tick = next(self._ticks) * TICK_S

    def frames(self, seconds: float) -> Iterator[Snapshot]:
        """The frames of the next so many seconds."""
        end = self.snapshot.stamp + seconds
        while self.snapshot.stamp < end - 1e-9:
            yield self.step()

    def run(self, seconds: float) -> Snapshot:
        """Let time pass."""
        for _ in self.frames(seconds):
            pass
        return self.snapshot

    def tell(self, words: str) -> int:
        """Give a command and do not wait → its id. Raises Refused for words that are not understood."""
        heard = understand(words)
        if isinstance(heard, Refusal):
            raise Refused(heard.reason)
        return self.begin(heard)

    def begin(self, command: Command, source: str = "typed") -> int:
        """Give a command that was understood → its id. Raises Refused."""
        number = next(self._ids)
        self.pilot.tell(number, command, source, "rehearsal")
        return number

    def say(
        self, words: str, *, seconds: float = 300.0, watch: Callable[[Snapshot], None] = lambda _: None
    ) -> ActiveCommandStatus:
        """Give a command, wait for its end; `watch` sees every frame. Raises Refused, or TimeoutError."""
        ended = self.wait(self.tell(words), seconds, watch)
        if ended is None:
            raise TimeoutError(f"“{words}” did not end within {seconds:g} s.")
        return ended

    def wait(
        self, number: int, seconds: float, watch: Callable[[Snapshot], None] = lambda _: None
    ) -> ActiveCommandStatus | None:
        """Wait for a command's end; `watch` sees every frame. None: it has not ended."""
        for snapshot in self.frames(seconds):
            watch(snapshot)
            if (ended := self.ended(number)) is not None:
                return ended
        return None

    def ended(self, number: int) -> ActiveCommandStatus | None:
        """The result of a command, or None while it runs."""
        return next((ended for ended in self.endings if ended.id == number), None)
