"""Words of voices in the room, obeyed: only for an operator who has taken them on, fresh, and whole.

A voice in the room never interrupts a hand on the keys or what was typed or clicked; the last spoken command wins.
What goes far or to a person waits a moment: see `console.control.pending_commands`.
"""

from __future__ import annotations

import time
from dataclasses import replace

from console.access.logins import Person
from console.control.command_freshness import SPOKEN_SOURCES
from console.control.dispatcher import CommandDispatcher
from console.control.lease import Lease
from console.control.notices import Notifications
from console.control.pending_commands import PendingCommands
from console.http.problems import Problem
from console.part import Part
from console.speech.room_transcription import RoomTranscriber, RoomUtterance
from core.errors import Refused
from core.perception.people.voice_bearing import VoiceBearing
from core.speech.recognition.decision import Decision

SOURCE = "ears"
NOT_YOURS = "The person who accepted voice commands no longer drives; voices in the room are only shown again."
HIGHER = "Someone drives by hand or by the page; a voice does not interrupt that. Only stop does."


class VoiceCommands(Part):
    """Lives on the event loop."""

    def __init__(
        self,
        ears: RoomTranscriber,
        dispatcher: CommandDispatcher,
        lease: Lease,
        pending_commands: PendingCommands,
        notifications: Notifications,
    ) -> None:
        self.operator: Person | None = None  # who has taken the words on
        self.at_console = False  # the operator's own microphone is the voice: it may interrupt their other commands
        pending_commands.when_rejected.append(ears.reject)
        self._ears, self._dispatcher, self._lease, self._pending_commands, self._notifications = (
            ears,
            dispatcher,
            lease,
            pending_commands,
            notifications,
        )

    def take_on(self, who: Person) -> None:
        """Obey voices in the room in this operator's name from now on. Raises Problem 403, 409."""
        if not who.may("operator"):
            raise Problem(403, "Viewers watch and may stop the robot; an operator takes words on.")
        try:
            self._lease.acquire(who, time.monotonic()) if self._lease.held_by(who) else self._dispatcher.change_lease(
                "acquire", who
            )
        except Refused as refused:
            raise Problem(409, str(refused)) from None
        self.operator, self._ears.obey = who, self._obey

    def let_go(self) -> None:
        """Words are only shown again."""
        self.operator = self._ears.obey = None
        self._pending_commands.forget(SOURCE, "Voices in the room are obeyed no more.")

    def _obey(self, decision: Decision, said: RoomUtterance, call: VoiceBearing | None) -> str:
        """Begin, or wait a moment and begin → "", or why not."""
        who, command = self.operator, decision.command
        if who is None or not self._lease.held_by(who):
            self.let_go()
            return NOT_YOURS
        when = self._ears.said(said)
        late = self._dispatcher.words.why_not(when, SOURCE, who)
        if command is not None:
            command = replace(command, call=call, said=decision.said or (said.t0_s, said.t1_s))
        if late or command is None:
            if command is not None and self._dispatcher.words.why_late(when, SOURCE):
                self._pending_commands.offer_late(command, SOURCE)
            return late or decision.reason
        if not self.at_console and self._dispatcher.busy_above(SPOKEN_SOURCES):
            return HIGHER
        try:
            self._pending_commands.take(replace(decision, command=command), SOURCE, who, when)
        except Problem as problem:
            self._notifications.tell("warning", problem.detail)
        return ""
