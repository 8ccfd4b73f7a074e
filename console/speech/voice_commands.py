"""Words of voices in the room, obeyed: only for an operator who has taken them on, fresh, and whole.

A voice in the room never interrupts a hand on the keys or what was typed or clicked; the last spoken command wins.
What goes far or to a person waits a moment: see `console.control.pending_commands`.
"""

import time

from console.access.logins import Person
from console.control.command_freshness import EARS, SPOKEN_SOURCES, Spoken, StaleWords
from console.control.dispatcher import CommandDispatcher
from console.control.history import History
from console.control.history_store import HistoryEntry
from console.control.lease import Lease
from console.control.notices import Notifications
from console.control.pending_commands import PendingCommand, PendingCommands
from console.http.problems import Problem
from console.part import Part
from console.speech.listener import SpokenOutcome, WordListener
from core.errors import Refused
from core.sentences import Statement
from core.speech.recognition.decision import Decision, RecognizedUtterance

ROOM = Person("room", "a voice in the room", "viewer")
NOT_OBEYED = Statement("speech.shown_only")
NO_LONGER = Statement("speech.no_longer_accepted")
HIGHER = Statement("speech.no_interruption")


class VoiceCommands(WordListener, Part):
    """The listener of the robot's own ears. STOP is obeyed from any voice."""

    def __init__(
        self,
        dispatcher: CommandDispatcher,
        lease: Lease,
        pending_commands: PendingCommands,
        history: History,
        notifications: Notifications,
    ) -> None:
        super().__init__(EARS, ROOM, pending_commands, dispatcher, history)
        self.operator: Person | None = None  # who has taken the words on
        self.at_console = False  # the operator's own microphone is the voice: it may interrupt their other commands
        self._lease, self._notifications = lease, notifications

    def take_on(self, who: Person) -> None:
        """Obey voices in the room in this operator's name from now on. Raises Problem 403, 409."""
        if not who.may("operator"):
            raise Problem(403, Statement("speech.viewers_watch"))
        try:
            if self._lease.held_by(who):
                self._lease.acquire(who, time.monotonic())
            else:
                self._dispatcher.change_lease("acquire", who)
        except Refused as refused:
            raise Problem(409, str(refused)) from None
        self.operator = who

    def release(self) -> None:
        """Words are only shown again."""
        self.operator = None
        self._pending_commands.forget(EARS, Statement("speech.obeyed_no_more"))

    def tick(self, now: float) -> None:
        """Let go of the words when another drives, also where nobody speaks meanwhile."""
        if self.operator is not None and not self._lease.held_by(self.operator):
            self.release()
            self._notifications.tell("info", NO_LONGER)

    def _stop(self, decision: Decision, said: Spoken) -> int | None:
        self._dispatcher.stop(ROOM, EARS)
        return None

    def _obey(self, utterance: RecognizedUtterance, said: Spoken) -> SpokenOutcome:
        if objection := self._objection():
            return self._refuse(utterance, said, objection)
        return super()._obey(utterance, said)

    def _objection(self) -> str:
        """Why no command of a voice is obeyed now, a sentence; "" when it may be."""
        if self.operator is None:
            return NOT_OBEYED
        if not self._lease.held_by(self.operator):
            self.release()
            return NO_LONGER
        busy = not self.at_console and self._dispatcher.busy_besides(SPOKEN_SOURCES)
        return HIGHER if busy else ""

    def _take(self, decision: Decision, said: Spoken) -> HistoryEntry | PendingCommand:
        assert self.operator is not None
        try:
            return self._pending_commands.take(decision, EARS, self.operator, said)
        except Problem as problem:
            if not isinstance(problem, StaleWords):
                self._notifications.tell("warning", problem.detail)
            raise
