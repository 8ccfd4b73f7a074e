"""The robot's own ears: its sound goes to the worker that reads words, and the words are shown.

What becomes of them, and whether they move the robot: see `console.speech.voice_commands`.
"""

import asyncio
import logging
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from console.control.command_freshness import EARS
from console.control.dispatcher import CommandDispatcher
from console.control.notices import Notifications
from console.control.pending_commands import PendingCommand, PendingCommands
from console.messages.hearing import TranscriptionStatus
from console.part import Part
from console.speech.listener import SpokenOutcome
from console.speech.transcription_client import TranscriptionClient
from console.speech.voice_commands import VoiceCommands
from console.workers.tasks import end
from console.workers.worker import WorkerLost
from core.errors import BeckonError
from core.geometry import wrap
from core.navigation.places import NamedPlace
from core.sensors import SensorFrame, Sound
from core.sensors.microphones import MicrophoneArray, joined, usable
from core.snapshot import VOICE_AFTER, Snapshot, VoiceDirection, voice_between
from core.speech.recognition.decision import RecognizedUtterance, Verdict
from core.speech.settings import MAX_WAITING_S, PIECE_S, SpeechSettings
from core.speech.transcription.piece_length import PieceLength

log = logging.getLogger(__name__)

MOST_LOSSES = 3  # of the worker, one after the other
MAX_REMEMBERED_UTTERANCES = 50  # utterances
OFFER_TIME_S = 15.0  # that commands are offered that rejected words most likely were
CREEP_SPEED = 0.01  # [m/s], [rad/s] up to which the robot's own motors are not heard
MAX_UNREAD_S = 0.5  # of sound that may wait unread before a simulated robot's clock waits for it
SoundSource = Callable[[SensorFrame], tuple[Sound | None, MicrophoneArray | None]]


@dataclass(frozen=True)
class RoomUtterance:
    """An utterance near the robot."""

    id: int
    t0_s: float  # robot clock
    t1_s: float
    words: str
    accepted: bool
    command: str | None  # as it was understood, in words
    reason: str
    azimuth_rad: float | None  # robot frame, as the robot stood when it heard it
    sd_rad: float | None
    verdict: Verdict
    confidence: float  # 0 to 1
    suggested_commands: tuple[str, ...] = ()  # that rejected words most likely were


class RoomTranscriber(Part):
    """Lives on the event loop."""

    def __init__(
        self,
        voice_commands: VoiceCommands,
        pending_commands: PendingCommands,
        dispatcher: CommandDispatcher,
        notifications: Notifications,
        settings: SpeechSettings | None = None,
        source: SoundSource = lambda frame: (frame.sound, None),
    ) -> None:
        """`source`: the sound of a frame that words are read from, and the array that heard it."""
        self.settings = settings or SpeechSettings()
        self.stamp = 0.0  # [s] robot clock of the newest snapshot
        self.trouble = ""  # why words are not read
        self.utterances: deque[RoomUtterance] = deque(maxlen=MAX_REMEMBERED_UTTERANCES)
        self.when_heard: list[Callable[[SpokenOutcome, VoiceDirection | None], None]] = []
        """Called with what became of every utterance, and of every STOP at once, and with the voice."""
        self.when_so_far: list[Callable[[str], None]] = []  # called with the words of the sentence under way
        self.keep_up: Callable[[float | None], None] = lambda _: None
        """Called with the stamp [s] up to which words are read, while sound waits for it; None: none waits."""
        self.read_to = -np.inf  # [s] robot clock, up to which words were read
        self._reading: float | None = None  # [s] robot clock, begin of the sound that is being read
        self._kept_up: float | None = None  # with which `keep_up` was called last
        self._voice_commands, self._time, self._notifications = (
            voice_commands,
            dispatcher.freshness.time,
            notifications,
        )
        pending_commands.when_rejected.append(self.reject)
        self._worker = TranscriptionClient()
        self._array: MicrophoneArray | None = None  # of which a beam can be made
        self._waiting: Sound | None = None
        self._piece = PieceLength()
        self._voices: tuple[VoiceDirection, ...] = ()
        self._task: asyncio.Task[None] | None = None
        self._newest = 0
        self._source = source
        self._drove = (-np.inf, -np.inf)  # [s] from when to when the robot moved last
        self._losses = 0  # of the worker, one after the other

    def on_snapshot(self, snapshot: Snapshot, frame: SensorFrame) -> None:
        self.feed(snapshot, *self._source(frame), frame.sensed)

    def feed(
        self, snapshot: Snapshot, sound: Sound | None, array: MicrophoneArray | None, sensed: float = 0.0
    ) -> None:
        """Take the sound of this snapshot; words are read from the array's beam towards the voice.

        `sensed`: when the robot's driver had it, in our monotonic clock [s]; 0: nobody knows, so it counts from now.
        """
        if snapshot.stamp < self.stamp:  # another clock: the robot was started again
            self._drove = (-np.inf, -np.inf)
            self._voice_commands.reset()
            self.read_to = -np.inf
        self.stamp = snapshot.stamp
        self._piece.follow(self.stamp, snapshot.hearing is not None and snapshot.hearing.speaking)
        self._time.note(self.stamp, sensed or time.monotonic())
        if abs(snapshot.velocity.v) > CREEP_SPEED or abs(snapshot.velocity.w) > CREEP_SPEED:
            since, until = self._drove
            self._drove = (since if self.stamp - until < VOICE_AFTER else self.stamp, self.stamp)
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
        self._waiting = joined(self._waiting, one, MAX_WAITING_S)
        if self._task is None and self._waiting is not None and self._waiting.duration >= self._piece.seconds:
            self._task = asyncio.get_running_loop().create_task(self._read())
        self._tell_behind()

    def warm(self, array: MicrophoneArray | None) -> None:
        """Start what reads the words, and load its model: someone is about to speak to this array."""
        if array is not None and self._task is None and not self.trouble and not self._worker.listens:
            self._array = array if array.dimensions >= 2 else None
            self._task = asyncio.get_running_loop().create_task(self._read())

    def _tell_behind(self) -> None:
        """Have a simulated robot wait while its sound waits to be read."""
        oldest = self._reading
        if oldest is None and self._task is not None and self._waiting is not None:
            oldest = self._waiting.stamp
        behind = None if oldest is None else oldest + MAX_UNREAD_S
        if behind != self._kept_up:
            self._kept_up = behind
            self.keep_up(behind)

    def reject(self, pending_command: PendingCommand) -> None:
        if pending_command.source == EARS:
            self._worker.reject(pending_command.words)

    def learn(self, places: tuple[NamedPlace, ...]) -> None:
        self._worker.learn(places)

    async def close(self) -> None:
        await end(self._task)
        self._worker.kill()
        await self._worker.gone()

    @property
    def status(self) -> TranscriptionStatus:
        newest = self.utterances[-1] if self.utterances else None
        fresh = newest is not None and 0 <= self.stamp - newest.t1_s < OFFER_TIME_S
        offered = newest.suggested_commands if newest is not None and fresh else ()
        return TranscriptionStatus(starting=not self.trouble and not self._worker.listens, suggested_commands=offered)

    @property
    def engine(self) -> str:
        """Which engine reads the words, and why, in a sentence; "": none has begun."""
        return self._worker.engine

    def shown(self) -> list[RoomUtterance]:
        """The newest utterances, newest first."""
        return list(reversed(self.utterances))

    async def _read(self) -> None:
        try:
            await self._begin()
            while self._waiting is not None and self._waiting.duration >= self._piece.seconds:
                sound, self._waiting = self._waiting, None
                self._reading = sound.stamp
                for utterance in await self._words(sound):
                    self._hear(utterance)
                self._losses, self._reading = 0, None
                if not self._time.is_former(sound.stamp):
                    self.read_to = sound.stamp + sound.duration
                self._tell_behind()
                await self._read_so_far()
        except WorkerLost as lost:
            log.warning("The worker that reads words was lost: %s", lost)
            self._losses += 1
            if self._losses == MOST_LOSSES:
                self._give_up("What reads the words broke again and again; the log says more.")
        except BeckonError as refusal:
            self._give_up(str(refusal))
        finally:
            self._task = self._reading = None
            self._tell_behind()

    async def _begin(self) -> None:
        if not await self._worker.begun():
            await self._worker.begin(self.settings, array=self._array)
            log.info("%s", self._worker.engine)

    async def _read_so_far(self) -> None:
        """Show the words of the sentence under way to those who want them, where no sound waits for it."""
        waits = self._time.simulated  # then the robot's clock does, and no word is late by this
        late = not waits and self._waiting is not None and self._waiting.duration > PIECE_S
        if not self.when_so_far or late:
            return
        words = await self._worker.words_so_far()
        for show in self.when_so_far if words else ():
            show(words)

    def _give_up(self, why: str) -> None:
        self.trouble = why
        self._notifications.tell("warning", f"The robot's ears hear no words: {why}")

    async def _words(self, sound: Sound) -> list[RecognizedUtterance]:
        await self._begin()
        return await self._worker.feed(sound.samples, sound.rate, sound.stamp)

    def _hear(self, utterance: RecognizedUtterance) -> None:
        voice, decision = voice_between(self._voices, utterance.begin, utterance.end), utterance.decision
        if decision.command is not None and not decision.stops:
            call = None if voice is None else voice.call
            command = replace(decision.command, call=call, said=utterance.said)
            utterance = replace(utterance, decision=replace(decision, command=command))
        motors = self._is_of_motors(utterance)
        outcome = self._voice_commands.hear(utterance, self._time.ours(utterance.end), maybe_noise=motors)
        if self._time.is_former(utterance.end):
            self._voice_commands.reset()
        if utterance.final:
            self.utterances.append(self._utterance(outcome.utterance, voice))
        if decision.words or not motors:
            for tell in tuple(self.when_heard):
                tell(outcome, voice)

    def _is_of_motors(self, utterance: RecognizedUtterance) -> bool:
        since, until = self._drove
        return utterance.begin <= until and utterance.end >= since

    def _utterance(self, utterance: RecognizedUtterance, best: VoiceDirection | None) -> RoomUtterance:
        decision, command = utterance.decision, utterance.decision.command
        self._newest += 1
        return RoomUtterance(
            id=self._newest,
            t0_s=round(utterance.begin, 3),
            t1_s=round(utterance.end, 3),
            words=decision.words,
            accepted=command is not None,
            command=None if command is None else command.heard_as,
            reason=decision.reason,
            azimuth_rad=None if best is None else round(wrap(best.azimuth), 4),
            sd_rad=None if best is None else round(best.sd_heard, 4),
            verdict=decision.verdict,
            confidence=round(decision.confidence, 3),
            suggested_commands=decision.offered,
        )
