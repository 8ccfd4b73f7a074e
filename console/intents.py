"""A spoken order that was understood and waits a moment, in which anybody may hold it back.

What is exact and near begins at once. What goes far or to a person begins by itself after its moment, unless a stop,
another order, a hand on the keys, another driver or a press of Cancel comes before.
"""

from __future__ import annotations

import asyncio
import math
import time
from dataclasses import replace

from console.door import Door
from console.history import History, row_of
from console.intent import Intent
from console.lease import Lease
from console.logins import Person
from console.notice_board import NoticeBoard
from console.problems import Problem
from console.store import Deed
from core.commands.command import Command
from core.perception.people.call import Call
from core.snapshot import Ending
from core.speech.grammar import Refusal, understand

MOMENT = 2.0  # [s] in which an order may be held back before it begins
CAREFUL = ("come_here", "follow_me", "stop_at")
FAR = 2.0  # [m]
GONE = "No such order waits: it has begun, or it was dropped."


class Intents:
    """At most one waits; the last one wins. Lives on the event loop."""

    def __init__(self, door: Door, lease: Lease, history: History, board: NoticeBoard) -> None:
        self.moment = MOMENT
        self.waiting: Intent | None = None
        self._door, self._lease, self._history, self._board = door, lease, history, board
        self._newest = 0
        self._alarm: asyncio.TimerHandle | None = None
        door.when_cancelled.append(self._end)

    @property
    def command(self) -> Command | None:
        """What waits; from any thread."""
        return None if self.waiting is None else self.waiting.command

    def take(self, words: str, source: str, who: Person, call: Call | None = None) -> Deed | Intent:
        """Spoken words → the deed that is under way, or the order that waits; `call`: from where they were spoken.

        Raises Problem 403 to 503.
        """
        heard = understand(words)
        if isinstance(heard, Refusal) or not is_careful(heard):
            return self._door.submit(words, source, who, call)
        self._door.admit(heard, words, source, who)
        self._end("pre-empted", f"“{heard.heard_as}” came after it.")
        self._newest += 1
        begins = time.monotonic() + self.moment
        intent = Intent(self._newest, who, source, words, replace(heard, call=call), self.moment, begins)
        self.waiting = intent
        self._alarm = asyncio.get_running_loop().call_later(self.moment, self._begin_by_itself)
        return intent

    def begin(self, number: int, who: Person) -> Deed:
        """Begin at once instead of waiting on; the driver only. Raises Problem 403 to 503."""
        intent = self._find(number)
        if not who.may("operator"):
            raise Problem(403, "Viewers watch and may stop the robot; the driver begins an order.")
        if not self._lease.held_by(who):
            raise Problem(409, "Only who drives may begin this order; you may drop it.")
        return self._begin(intent)

    def drop(self, number: int, who: Person) -> None:
        """It does not begin; whoever may stop the robot may do this. Raises Problem 404."""
        self._find(number)
        self._end("cancelled", f"Dropped by {who.name}.")

    def forget(self, source: str, why: str) -> None:
        """Nothing that came by this way begins any more."""
        if self.waiting is not None and self.waiting.source == source:
            self._end("cancelled", why)

    def _find(self, number: int) -> Intent:
        if self.waiting is None or self.waiting.id != number:
            raise Problem(404, GONE)
        return self.waiting

    def _begin_by_itself(self) -> None:
        if self.waiting is None:
            return
        try:
            self._begin(self.waiting)
        except Problem as problem:
            self._board.tell("warning", problem.detail)

    def _begin(self, intent: Intent) -> Deed:
        self._clear()
        command = intent.command
        return self._door.submit(command.heard_as, intent.source, intent.person, command.call)

    def _end(self, state: Ending, why: str) -> None:
        """What waits does not begin, and the history says why."""
        intent = self.waiting
        self._clear()
        if intent is not None:
            told = row_of(intent.command, intent.words, intent.source)
            self._history.add("command", intent.person, state=state, remark=f"It had not begun: {why}", **told)

    def _clear(self) -> None:
        self.waiting = None
        if self._alarm is not None:
            self._alarm.cancel()
            self._alarm = None


def is_careful(command: Command) -> bool:
    """Whether an order waits a moment when it was spoken."""
    return command.name in CAREFUL or math.fabs(command.numbers.get("distance_m", 0.0)) > FAR
