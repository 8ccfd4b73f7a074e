"""The robot's own ears: its sound goes to the worker that reads words, and what comes back is shown.

STOP is obeyed, whoever said it and before the sentence is over. Anything else that is understood is shown, and moves
the robot only where somebody who drives has taken the words on: see `console.spoken_orders`.
"""

from __future__ import annotations

import asyncio
import logging
import time
from collections import deque
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from console.door import Door
from console.fresh_words import Said
from console.hearing_portrait import Words
from console.history import History
from console.intent import Intent
from console.logins import Person
from console.notice_board import NoticeBoard
from console.prattle import Prattle
from console.spoken_stops import STOPPED, SpokenStops
from console.tasks import end
from console.words_worker import Told, WordsWorker
from console.workers import Lost
from core.errors import BeckonError
from core.geometry import wrap
from core.perception.people.call import Call
from core.sensors import Sound
from core.sensors.microphones import MicrophoneArray, joined, usable
from core.snapshot import Snapshot, VoiceDirection
from core.speech.settings import MOST_WAITING, PIECE, SpeechSettings

log = logging.getLogger(__name__)

MOST_LOSSES = 3  # of the worker, one after the other
REMEMBERED = 50  # utterances
OFFERED = 15.0  # [s] that a command is offered whose words were heard with a doubt
CREEPS = 0.01  # [m/s], [rad/s] up to which the robot's own motors are not heard
KNOWN = 30.0  # [s] for which the robot's clock is known in ours
FRESH = 1.5  # [s] by which a direction may be older than the end of the words that it belongs to
ROOM = Person("room", "a voice in the room", "viewer")
NOT_OBEYED = "Voices in the room are shown; nobody who drives has taken them on."


@dataclass(frozen=True)
class Utterance:
    """What somebody said near the robot."""

    id: int
    t0_s: float  # robot clock
    t1_s: float
    words: str
    accepted: bool
    command: str | None  # as it was understood, in words
    reason: str
    azimuth_rad: float | None  # robot frame, as the robot stood when it heard it
    sd_rad: float | None
    meant: str = ""  # the command that the words would be, had they been heard without a doubt
    unsure: bool = False  # a number in it may have been another


class Ears:
    """Lives on the event loop."""

    def __init__(self, door: Door, history: History, board: NoticeBoard) -> None:
        self.settings = SpeechSettings()
        self.stamp = 0.0  # [s] robot clock of the newest snapshot
        self.trouble = ""  # why words are not read
        self.utterances: deque[Utterance] = deque(maxlen=REMEMBERED)
        self.obey: Callable[[str, Utterance, Call | None], str] | None = None  # takes words on, or tells why not
        self._door, self._history, self._board = door, history, board
        self._worker = WordsWorker()
        self._array: MicrophoneArray | None = None  # of which a beam can be made
        self._waiting: Sound | None = None
        self._voices: tuple[VoiceDirection, ...] = ()
        self._task: asyncio.Task[None] | None = None
        self._stops = SpokenStops()
        self._moments: deque[tuple[float, float]] = deque()  # [s] by the robot's clock, and by ours
        self._newest = 0
        self._drove = (-np.inf, -np.inf)  # [s] from when to when the robot moved last
        self._prattle = Prattle(history)
        self._losses = 0  # of the worker, one after the other

    def took(
        self, snapshot: Snapshot, sound: Sound | None, array: MicrophoneArray | None, sensed: float = 0.0
    ) -> None:
        """What the robot heard up to this snapshot; words are read from the array's beam towards the voice.

        `sensed`: when the robot's driver had it, in our monotonic clock [s]; 0: nobody knows, so it counts from now.
        """
        if snapshot.stamp < self.stamp:  # another clock: the robot was started anew
            self._drove = (-np.inf, -np.inf)
            self._stops.another_clock()
            self._moments.clear()
        self.stamp = snapshot.stamp
        self._moments.append((self.stamp, sensed or time.monotonic()))
        while self._moments[0][0] < self.stamp - KNOWN:
            self._moments.popleft()
        if abs(snapshot.velocity.v) > CREEPS or abs(snapshot.velocity.w) > CREEPS:
            since, until = self._drove
            self._drove = (since if self.stamp - until < FRESH else self.stamp, self.stamp)
        if snapshot.hearing is not None:
            self._voices = snapshot.hearing.voices or self._voices
        if sound is None or array is None or self.trouble or not usable(sound.samples):
            return  # a piece that is no numbers is a gap; the pilot says that it came
        try:
            heard = array.heard(sound)
            self._array = array if array.dimensions >= 2 else None  # a line of microphones has no directions
            one = replace(sound, samples=heard if self._array is not None else heard[:, :1])
        except BeckonError as misfit:
            self._give_up(str(misfit))
            return
        self._waiting = joined(self._waiting, one, MOST_WAITING)
        if self._task is None and self._waiting is not None and self._waiting.duration >= PIECE:
            self._task = asyncio.get_running_loop().create_task(self._read())

    def hold_back(self, intent: Intent) -> None:
        """An order from here waited and was held back."""
        if intent.source == "ears":
            self._worker.hold_back(intent.words)

    def said(self, one: Utterance) -> Said:
        """When an utterance was said, by our own clock."""
        at, sensed = next((known for known in self._moments if known[0] >= one.t1_s), self._moments[-1])
        ended = sensed - max(at - one.t1_s, 0.0)
        return self._stops.said({"begin": one.t0_s}, Said(ended - (one.t1_s - one.t0_s), ended))

    async def close(self) -> None:
        """Read no more."""
        await end(self._task)
        self._worker.kill()
        await self._worker.gone()

    @property
    def words(self) -> Words:
        """How it is with them."""
        newest = self.utterances[-1] if self.utterances else None
        fresh = newest is not None and 0 <= self.stamp - newest.t1_s < OFFERED
        offered = newest.meant if newest is not None and fresh else ""
        return Words(waking=not self.trouble and not self._worker.ready, meant=offered)

    def shown(self) -> list[dict[str, Any]]:
        """The newest utterances, newest first."""
        return [asdict(one) for one in reversed(self.utterances)]

    async def _read(self) -> None:
        try:
            while self._waiting is not None and self._waiting.duration >= PIECE:
                sound, self._waiting = self._waiting, None
                for told in await self._words(sound):
                    self._hear(told)
                self._losses = 0
        except Lost as lost:
            log.warning("The worker that reads words was lost: %s", lost)
            self._losses += 1
            if self._losses == MOST_LOSSES:
                self._give_up("What reads the words broke again and again; the log says more.")
        except BeckonError as refusal:
            self._give_up(str(refusal))
        finally:
            self._task = None

    def _give_up(self, why: str) -> None:
        self.trouble = why
        self._board.tell("warning", f"The robot's ears hear no words: {why}")

    async def _words(self, sound: Sound) -> list[Told]:
        """One piece to the worker, which is told first how to listen when it was started anew."""
        if not await self._worker.begun():
            await self._worker.begin(self.settings, array=self._array)
        return await self._worker.feed(sound.samples, sound.rate, sound.stamp)

    def _hear(self, told: Told) -> None:
        """One utterance, or a STOP within one that is not over."""
        heard = self._stops.hear(told)
        if heard == "stop":
            self._door.stop(ROOM, "ears")
            self._stops.obeyed(self._door.words)
        if not told["final"]:
            return
        voice = self._voice(told)
        one = self._utterance({**told, **STOPPED} if heard != "words" else told, voice)
        self.utterances.append(one)
        if heard != "words":
            return
        if not one.words:
            if not self._motors(one):
                self._prattle.tell(ROOM, source="ears", remark=one.reason)
            return
        reason = NOT_OBEYED if one.accepted else one.reason
        if one.accepted and self.obey is not None:
            reason = self.obey(told["heard_as"], one, None if voice is None else voice.call)
            if not reason:
                return
        self._history.add(
            "command",
            ROOM,
            state="refused",
            source="ears",
            words=one.words,
            heard_as=told["heard_as"],
            remark=reason,
        )

    def _motors(self, prattle: Utterance) -> bool:
        """Whether the robot moved while it heard that: then it is its own motors, most likely."""
        since, until = self._drove
        return prattle.t0_s <= until and prattle.t1_s >= since

    def _voice(self, told: Told) -> VoiceDirection | None:
        """Whose words these are: the surest voice that was heard while they were spoken."""
        near = [one for one in self._voices if told["begin"] - PIECE <= one.stamp <= told["end"] + FRESH]
        return max(near, key=lambda one: one.strength, default=None)

    def _utterance(self, told: Told, best: VoiceDirection | None) -> Utterance:
        self._newest += 1
        return Utterance(
            id=self._newest,
            t0_s=round(told["begin"], 3),
            t1_s=round(told["end"], 3),
            words=told["words"],
            accepted=told["name"] is not None,
            command=told["heard_as"] or None,
            reason=told["reason"],
            azimuth_rad=None if best is None else round(wrap(best.azimuth), 4),
            sd_rad=None if best is None else round(best.sd_heard, 4),
            meant=told["meant"],
            unsure=told["unsure"],
        )
