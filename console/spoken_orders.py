"""Words of voices in the room, obeyed: only for a driver who has taken them on, fresh, whole, and after a moment.

What goes far or to a person waits a moment in which anybody may stop it. A spoken order never interrupts a hand on
the keys or what was typed or clicked; the last spoken one wins.
"""

from __future__ import annotations

import asyncio
import math
import time

from console.door import Door
from console.hearing import Ears, Utterance
from console.history import History
from console.lease import Lease
from console.logins import Person
from console.notice_board import NoticeBoard
from console.problems import Problem
from core.commands.command import Command
from core.errors import Refused
from core.perception.people.call import Call
from core.speech.grammar import Refusal, understand

SOURCE = "ears"
SPOKEN = (SOURCE, "voice")  # what a voice may interrupt
OBEYED_WITHIN = 2.0  # [s] after their end that words are still obeyed
MOMENT = 1.5  # [s] in which an order may be stopped before it begins
CAREFUL = ("come_here", "follow_me", "stop_at")
FAR = 2.0  # [m]
NOT_YOURS = "Whoever took the words on drives no more; voices in the room are shown again."
HIGHER = "Somebody drives by hand or by the page; a voice does not interrupt that. Only stop does."


class SpokenOrders:
    """Lives on the event loop."""

    def __init__(self, ears: Ears, door: Door, lease: Lease, history: History, board: NoticeBoard) -> None:
        self.driver: Person | None = None  # who has taken the words on
        self._ears, self._door, self._lease, self._history, self._board = ears, door, lease, history, board
        self._waiting: asyncio.TimerHandle | None = None
        door.when_cancelled.append(self._drop)

    def take_on(self, who: Person) -> None:
        """From now on what is said in the room is obeyed in this driver's name. Raises Problem 403, 409."""
        if not who.may("operator"):
            raise Problem(403, "Viewers watch and may stop the robot; an operator takes words on.")
        try:
            self._lease.acquire(who, time.monotonic()) if self._lease.held_by(who) else self._door.wish(
                "acquire", who
            )
        except Refused as refused:
            raise Problem(409, str(refused)) from None
        self.driver, self._ears.obey = who, self._obey

    def let_go(self) -> None:
        """Words are only shown again."""
        self.driver = self._ears.obey = None
        self._drop()

    def _obey(self, words: str, said: Utterance, call: Call | None) -> str:
        """Begin, or wait a moment and begin → "", or why not."""
        who = self.driver
        if who is None or not self._lease.held_by(who):
            self.let_go()
            return NOT_YOURS
        age = self._ears.stamp - said.t1_s
        if age > OBEYED_WITHIN:
            return f"The words were understood {age:.1f} s after they were spoken, which is too late to act on them."
        command = understand(words, spoken=True)
        if isinstance(command, Refusal):
            return command.reason
        if self._door.busy_above(SPOKEN):
            return HIGHER
        self._drop()
        if not _is_careful(command):
            self._begin(command.heard_as, who, call)
            return ""
        self._board.tell("info", f"I heard “{command.heard_as}” and begin in {MOMENT:g} s. Stop holds me back.")
        loop = asyncio.get_running_loop()
        self._waiting = loop.call_later(MOMENT, self._begin, command.heard_as, who, call)
        return ""

    def _begin(self, words: str, who: Person, call: Call | None) -> None:
        self._waiting = None
        if not self._lease.held_by(who) or self._door.busy_above(SPOKEN):
            self._board.tell("info", HIGHER if self._lease.held_by(who) else NOT_YOURS)
            return
        try:
            self._door.submit(words, SOURCE, who, call)
        except Problem as problem:
            self._board.tell("warning", problem.detail)

    def _drop(self) -> None:
        """Nothing waits any more."""
        if self._waiting is not None:
            self._waiting.cancel()
            self._waiting = None


def _is_careful(command: Command) -> bool:
    """Whether an order waits a moment."""
    return command.name in CAREFUL or math.fabs(command.numbers.get("distance_m", 0.0)) > FAR
