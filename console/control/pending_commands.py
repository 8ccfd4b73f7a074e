"""A spoken command that was understood and waits a moment, in which anybody may hold it back.

What is exact and near begins at once. What goes far or to a person, or has numbers that were not heard for sure,
begins by itself after its delay, unless a stop, another command, a hand on the keys, another operator or a press of
Cancel comes before. While someone speaks it waits on: they may be about to say that it is wrong.
"""

import asyncio
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

from console.access.logins import Person
from console.control.command_freshness import Spoken, StaleWords
from console.control.dispatcher import CommandDispatcher
from console.control.history import History, row_of
from console.control.history_store import HistoryEntry
from console.control.lease import Lease
from console.control.notices import Notifications
from console.http.problems import Problem
from console.part import Part
from core.commands.command import Command
from core.commands.confirmation_delay import CONFIRMATION_DELAY_S, ConfirmationDelay
from core.sensors import SensorFrame
from core.sentences import Statement
from core.snapshot import Ending, Snapshot
from core.speech.recognition.decision import Decision


@dataclass(frozen=True)
class PendingCommand:
    id: int
    person: Person  # in whose name it begins
    source: str
    command: Command
    decision: Decision  # by which it waits
    delay: float  # [s] that it waits in all
    when: ConfirmationDelay  # it begins, on the monotonic clock
    said: Spoken  # its words

    @property
    def words(self) -> str:
        return self.command.heard_as


@dataclass(frozen=True)
class LateCommand:
    """A spoken command that was refused for nothing but its age: it begins where a person confirms it."""

    id: int
    person: Person  # in whose name it was said
    source: str
    command: Command
    until: float  # [s] monotonic, until which it is offered


LATE_OFFER_S = 20.0  # [s] for which a late command is offered


class PendingCommands(Part):
    """At most one waits; the last one wins. Lives on the event loop."""

    def __init__(
        self, dispatcher: CommandDispatcher, lease: Lease, history: History, notifications: Notifications
    ) -> None:
        self.delay = CONFIRMATION_DELAY_S
        self.waiting: PendingCommand | None = None
        self._dispatcher, self._lease, self._history, self._notifications = dispatcher, lease, history, notifications
        self._newest = 0
        self._late: LateCommand | None = None
        self._alarm: asyncio.TimerHandle | None = None
        # called with each command that was dropped while it waited
        self.when_rejected: list[Callable[[PendingCommand], None]] = []
        dispatcher.when_cancelled.append(self._ended)

    @property
    def command(self) -> Command | None:
        """The command that waits; from any thread."""
        return None if self.waiting is None else self.waiting.command

    @property
    def late(self) -> LateCommand | None:
        """The command that came too late and may be confirmed; nothing else began or was stopped since."""
        if self._late is not None and time.monotonic() > self._late.until:
            self._late = None
        return self._late

    def take(self, decision: Decision, source: str, who: Person, said: Spoken) -> HistoryEntry | PendingCommand:
        """Take what was decided about spoken words → the active command's entry, or the pending command; `said`: when
        it was spoken. Raises Problem 403 to 503, 422 for rejected words.
        """
        command = decision.command
        if command is None:
            raise Problem(422, decision.reason)
        words = command.heard_as
        try:
            if not decision.waits:
                return self._dispatcher.dispatch(command, source, who, said)
            self._dispatcher.admit(command, words, source, who, said)
        except StaleWords as stale:
            if stale.late:
                self._newest += 1
                self._late = LateCommand(self._newest, who, source, command, time.monotonic() + LATE_OFFER_S)
            raise
        why, now = Statement("command.pre_empted", words=words), time.monotonic()
        self._end("pre-empted", why)
        self._dispatcher.freshness.void(why, at=said.ended)
        self._newest += 1
        begins = ConfirmationDelay.from_now(now, self.delay)
        taken = replace(said, taken=now)
        self._wait(PendingCommand(self._newest, who, source, command, decision, self.delay, begins, taken))
        assert self.waiting is not None
        return self.waiting

    def on_snapshot(self, snapshot: Snapshot, frame: SensorFrame) -> None:
        if snapshot.hearing is not None and snapshot.hearing.speaking:
            self.hear()

    def hear(self) -> None:
        """A person speaks now: the pending command is put off until the words can have been understood."""
        if self.waiting is not None:
            self._wait(replace(self.waiting, when=self.waiting.when.while_speaking(time.monotonic())))

    def _wait(self, pending_command: PendingCommand) -> None:
        self._clear()
        self.waiting = pending_command
        left = pending_command.when.begins - time.monotonic()
        self._alarm = asyncio.get_running_loop().call_later(left, self._begin_by_itself)

    def begin(self, number: int, who: Person) -> HistoryEntry:
        """Begin at once what waits or came too late; the operator only. Raises Problem 403 to 503."""
        if not who.may("operator"):
            raise Problem(403, Statement("command.begin_by_operator"))
        late = self.late
        if late is not None and late.id == number:
            self._late = None
            return self._dispatcher.dispatch(late.command, late.source, who, Spoken.now())
        pending_command = self._find(number)
        if not self._lease.held_by(who):
            raise Problem(409, Statement("command.begin_by_driver"))
        return self._begin(pending_command)

    def drop(self, number: int, who: Person) -> None:
        """Drop the pending command; anyone who may stop the robot may do this. Raises Problem 404."""
        self._find(number)
        why = Statement("command.dropped_by", name=who.name)
        self._dispatcher.freshness.void(why, objector=who)
        self._ended("cancelled", why, objected=True)

    def forget(self, source: str, why: str) -> None:
        """Nothing that came by this way begins any more."""
        if self.waiting is not None and self.waiting.source == source:
            self._end("cancelled", why)

    def left(self, who: Person) -> None:
        """A page of this person closed: nothing that they said before begins."""
        self._dispatcher.freshness.left(who)
        if self._late is not None and self._late.person.id == who.id:
            self._late = None
        if self.waiting is not None and self.waiting.person.id == who.id:
            self._end("cancelled", Statement("command.closed_the_page", name=who.name))

    def _find(self, number: int) -> PendingCommand:
        if self.waiting is None or self.waiting.id != number:
            raise Problem(404, Statement("command.pending_gone"))
        return self.waiting

    def _begin_by_itself(self) -> None:
        if self.waiting is None:
            return
        try:
            self._begin(self.waiting)
        except Problem as problem:
            self._notifications.tell("warning", problem.detail)

    def _begin(self, pending_command: PendingCommand) -> HistoryEntry:
        self._clear()
        return self._dispatcher.dispatch(
            pending_command.command, pending_command.source, pending_command.person, pending_command.said
        )

    def _ended(self, state: Ending, why: str, objected: bool) -> None:
        """The pending command ended with the active command, or alone; `objected`: a person did not want it."""
        pending_command, self._late = self.waiting, None
        self._end(state, why)
        if pending_command is not None and objected:
            for tell in self.when_rejected:
                tell(pending_command)

    def _end(self, state: Ending, why: str) -> None:
        """End the pending command before it begins; the history says why."""
        pending_command = self.waiting
        self._clear()
        if pending_command is not None:
            fields = row_of(pending_command.command, pending_command.words, pending_command.source)
            self._history.add(
                "command",
                pending_command.person,
                state=state,
                remark=Statement("command.not_begun", why=why),
                **fields,
            )

    def _clear(self) -> None:
        self.waiting = None
        if self._alarm is not None:
            self._alarm.cancel()
            self._alarm = None
