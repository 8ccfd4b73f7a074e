"""Words of voices in the room, obeyed: only for a driver who has taken them on, fresh, and whole.

A voice in the room never interrupts a hand on the keys or what was typed or clicked; the last spoken order wins. What
goes far or to a person waits a moment: see `console.intents`.
"""

from __future__ import annotations

import time

from console.door import Door
from console.fresh_words import SPOKEN
from console.hearing import Ears, Utterance
from console.intents import Intents
from console.lease import Lease
from console.logins import Person
from console.notice_board import NoticeBoard
from console.problems import Problem
from core.errors import Refused
from core.perception.people.call import Call
from core.speech.grammar import Refusal, understand

SOURCE = "ears"
NOT_YOURS = "Whoever took the words on drives no more; voices in the room are shown again."
HIGHER = "Somebody drives by hand or by the page; a voice does not interrupt that. Only stop does."


class SpokenOrders:
    """Lives on the event loop."""

    def __init__(self, ears: Ears, door: Door, lease: Lease, intents: Intents, board: NoticeBoard) -> None:
        self.driver: Person | None = None  # who has taken the words on
        intents.when_held_back.append(ears.hold_back)
        self._ears, self._door, self._lease, self._intents, self._board = ears, door, lease, intents, board

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
        self._intents.forget(SOURCE, "Voices in the room are obeyed no more.")

    def _obey(self, words: str, said: Utterance, call: Call | None) -> str:
        """Begin, or wait a moment and begin → "", or why not."""
        who = self.driver
        if who is None or not self._lease.held_by(who):
            self.let_go()
            return NOT_YOURS
        when = self._ears.said(said)
        late = self._door.words.why_not(when, SOURCE, who)
        if late:
            return late
        command = understand(words, spoken=True)
        if isinstance(command, Refusal):
            return command.reason
        if self._door.busy_above(SPOKEN):
            return HIGHER
        try:
            self._intents.take(command.heard_as, SOURCE, who, when, call, unsure=said.unsure)
        except Problem as problem:
            self._board.tell("warning", problem.detail)
        return ""
