"""A spoken order that was understood and waits a moment, in which anybody may hold it back.

What is exact and near begins at once. What goes far or to a person, or has numbers that were not heard for sure,
begins by itself after its moment, unless a stop, another order, a hand on the keys, another driver or a press of
Cancel comes before. While somebody speaks it waits on: they may be about to say that it is wrong.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from dataclasses import replace

from console.door import Door
from console.fresh_words import Said
from console.history import History, row_of
from console.intent import Intent
from console.lease import Lease
from console.logins import Person
from console.notice_board import NoticeBoard
from console.problems import Problem
from console.store import Deed
from core.commands.careful import MOMENT, Moment, is_careful
from core.commands.command import Command
from core.perception.people.call import Call
from core.snapshot import Ending, Snapshot
from core.speech.grammar import Refusal, understand

GONE = "No such order waits: it has begun, or it was dropped."


class Intents:
    """At most one waits; the last one wins. Lives on the event loop."""

    def __init__(self, door: Door, lease: Lease, history: History, board: NoticeBoard) -> None:
        self.moment = MOMENT
        self.waiting: Intent | None = None
        self._door, self._lease, self._history, self._board = door, lease, history, board
        self._newest = 0
        self._alarm: asyncio.TimerHandle | None = None
        self.when_held_back: list[Callable[[Intent], None]] = []  # told of what somebody did not want while it waited
        door.when_cancelled.append(self._ended)

    @property
    def command(self) -> Command | None:
        """What waits; from any thread."""
        return None if self.waiting is None else self.waiting.command

    def take(
        self, words: str, source: str, who: Person, said: Said, call: Call | None = None, *, unsure: bool = False
    ) -> Deed | Intent:
        """Spoken words → the deed that is under way, or the order that waits; `said`: when they were spoken; `call`:
        from where; `unsure`: a number may have been another. Raises Problem 403 to 503.
        """
        heard = understand(words)
        if isinstance(heard, Refusal) or not (unsure or is_careful(heard)):
            return self._door.submit(words, source, who, call, said)
        heard = replace(heard, call=call)
        self._door.admit(heard, words, source, who, said)
        why, now = f"“{heard.heard_as}” came after it.", time.monotonic()
        self._end("pre-empted", why)
        self._door.words.void(why, at=said.ended)
        self._newest += 1
        moment = Moment.from_now(now, self.moment)
        taken = replace(said, taken=now)
        self._wait(Intent(self._newest, who, source, words, heard, self.moment, moment, taken, unsure))
        assert self.waiting is not None
        return self.waiting

    def took(self, snapshot: Snapshot) -> None:
        """What the robot's own ears hear."""
        if snapshot.hearing is not None and snapshot.hearing.speaking:
            self.hear()

    def hear(self) -> None:
        """Somebody speaks now: what waits is put off until they can have been understood."""
        if self.waiting is not None:
            self._wait(replace(self.waiting, when=self.waiting.when.while_speaking(time.monotonic())))

    def _wait(self, intent: Intent) -> None:
        self._clear()
        self.waiting = intent
        left = intent.when.begins - time.monotonic()
        self._alarm = asyncio.get_running_loop().call_later(left, self._begin_by_itself)

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
        why = f"Dropped by {who.name}."
        self._door.words.void(why, stop=True)
        self._ended("cancelled", why, objected=True)

    def forget(self, source: str, why: str) -> None:
        """Nothing that came by this way begins any more."""
        if self.waiting is not None and self.waiting.source == source:
            self._end("cancelled", why)

    def left(self, who: Person) -> None:
        """A page of this person closed: nothing that they said before begins."""
        self._door.words.left(who)
        if self.waiting is not None and self.waiting.person.id == who.id:
            self._end("cancelled", f"{who.name} closed the page.")

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
        return self._door.submit(command.heard_as, intent.source, intent.person, command.call, intent.said)

    def _ended(self, state: Ending, why: str, objected: bool) -> None:
        """It ended with what is under way, or alone; `objected`: somebody did not want it."""
        intent = self.waiting
        self._end(state, why)
        if intent is not None and objected:
            for tell in self.when_held_back:
                tell(intent)

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
