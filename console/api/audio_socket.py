"""The socket `/ws/audio`: a browser's microphone up, transcripts down.

What becomes of the words: see `console.speech.listener`.
"""

import asyncio
import contextlib
import itertools
import math
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import msgspec
import numpy as np
from starlette.websockets import WebSocket, WebSocketDisconnect

from console.access.logins import Person
from console.access.open_sockets import TooMany
from console.access.strict_json import read_json
from console.broadcast import CloseSocket
from console.control.pending_commands import PendingCommand, PendingCommands
from console.http.problems import Problem
from console.http.rate_counter import RateCounter, size_of
from console.messages import audio
from console.runtime import Runtime
from console.speech.browser_microphone import BrowserMicrophone, TalkTurn
from console.speech.listener import SpokenOutcome, WordListener
from console.speech.robot_voice import RobotVoice
from console.speech.room_mouth import RoomMouth
from console.speech.room_transcription import RoomTranscriber
from console.speech.voice_commands import VoiceCommands
from console.workers.tasks import end
from core.errors import BadInput, Refused
from core.sentences import plain
from core.snapshot import Ending, VoiceDirection
from core.speech.recognition.decision import RecognizedUtterance

MOST_PER_SECOND = 250  # messages; pieces of 20 ms are 50, and after a stall of the network they come at once
MOST_BYTES = 2**19  # a second; sound is 32,000, and 15 s of it may come at once
MOST_WAITING = 50  # messages down that may wait for a browser that does not read them
SOURCE = "voice"
PAGES = itertools.count(1)
GONE = CloseSocket(1000, "The browser left.")


class AudioSocket:
    def __init__(self, runtime: Runtime, socket: WebSocket, person: Person) -> None:
        self._runtime, self._socket, self._person = runtime, socket, person
        self._page = next(PAGES)
        self._turn: TalkTurn | None = None
        self._tally, self._volume = RateCounter(), RateCounter()
        self._down: asyncio.Queue[audio.AudioDown] = asyncio.Queue(MOST_WAITING)
        self._closing: CloseSocket | None = None
        self._closed = asyncio.Event()  # it is to close
        self._number = 0
        self._listener = WordListener(
            SOURCE, person, runtime.parts[PendingCommands], runtime.dispatcher, runtime.history
        )
        self._until = math.inf  # [s] when the socket was closed: nothing was said later
        self._mouth: RoomMouth | None = None  # of the person in the simulated room who speaks instead

    async def run(self) -> None:
        try:
            with self._runtime.sockets.room_for(self._person, self._close):
                await self._socket.accept()
                if self._simulated:
                    self._runtime.parts[RoomTranscriber].warm(self._runtime.robot.profile.microphones)
                else:
                    self._runtime.parts[BrowserMicrophone].warm()
                events = self._events
                for subscribers, tell in events:
                    subscribers.append(tell)
                try:
                    await self._converse()
                finally:
                    for subscribers, tell in events:
                        subscribers.remove(tell)
        except TooMany as crowded:
            await self._socket.accept()
            self._close(1013, str(crowded))
        if self._closing is not None and self._closing != GONE:
            with contextlib.suppress(WebSocketDisconnect, RuntimeError):
                await self._socket.close(self._closing.code, self._closing.reason)

    @property
    def _simulated(self) -> bool:
        profile = self._runtime.robot.profile
        return profile.simulated and profile.microphones is not None

    @property
    def _events(self) -> tuple[tuple[list[Any], Callable[..., None]], ...]:
        """Lists of the console's events, and what takes each to this socket while it is open."""
        runtime = self._runtime
        return (
            (runtime.parts[PendingCommands].when_rejected, self._rejected),
            (runtime.dispatcher.when_cancelled, self._cancelled),
            (runtime.parts[RoomTranscriber].when_heard, self._heard_in_room),
        )

    async def _converse(self) -> None:
        speaker, listener = asyncio.create_task(self._send_all()), asyncio.create_task(self._receive_all())
        closed = asyncio.create_task(self._closed.wait())
        try:
            await asyncio.wait({listener, closed}, return_when=asyncio.FIRST_COMPLETED)
            if listener.done():
                listener.result()
        finally:
            self._until = time.monotonic()
            if self._turn is not None:
                self._turn.rest()
            self._end_mouth()
            self._runtime.parts[PendingCommands].left(self._person)
            await end(speaker, listener, closed)

    async def _receive_all(self) -> None:
        """Take messages until the socket closes; one that comes after that is not obeyed."""
        while True:
            message = await self._socket.receive()
            if self._closing is not None:
                return
            if message["type"] == "websocket.disconnect":
                self._close(GONE.code, GONE.reason)
            elif self._tally.add(time.monotonic()) > MOST_PER_SECOND:
                self._close(1008, f"More than {MOST_PER_SECOND} messages a second.")
            elif self._volume.add(time.monotonic(), size_of(message)) > MOST_BYTES:
                self._close(1008, f"More than {MOST_BYTES} bytes a second.")
            elif message.get("bytes") is not None:
                self._take_sound(message["bytes"])
            else:
                self._take_message(message.get("text") or "")

    async def _send_all(self) -> None:
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):
            while True:
                message = await self._down.get()
                await self._socket.send_text(msgspec.json.encode(message, enc_hook=plain).decode())

    def _close(self, code: int, reason: str) -> None:
        self._closing = self._closing or CloseSocket(code, reason)
        self._closed.set()

    def _tell(self, message: audio.AudioDown) -> None:
        if self._down.full():
            self._close(1008, "The browser does not read what is sent to it.")
        else:
            self._down.put_nowait(message)

    # up

    def _take_sound(self, raw: bytes) -> None:
        size = audio.AUDIO_HEADER.size
        if len(raw) > audio.MOST_BYTES or len(raw) < size or len(raw) % 2:
            self._close(1009, f"A piece of sound has {size} bytes of header and at most {audio.MOST_BYTES} in all.")
            return
        kind, _, clock = audio.AUDIO_HEADER.unpack_from(raw)
        if kind != audio.AUDIO_KIND or not 0 <= clock < 1e15:
            self._close(1007, "This is no piece of sound: its header is wrong.")
        elif self._mouth is not None:
            self._mouth.add(np.frombuffer(raw, "<i2", offset=size).astype(float) / 32768)
        elif self._turn is not None and not (self._turn.mode == "open" and self._runtime.parts[RobotVoice].muted):
            samples = np.frombuffer(raw, "<i2", offset=size).astype(float) / 32768
            self._turn.add(samples, clock / 1000)
            if self._turn.mode == "held":
                self._runtime.parts[PendingCommands].hear()

    def _take_message(self, text: str) -> None:
        try:
            message = msgspec.convert(read_json(text), audio.AudioUp)
        except (BadInput, msgspec.ValidationError):
            self._close(1007, "This message has not the form that is asked for.")
            return
        if isinstance(message, audio.Rest):
            if self._turn is not None:
                self._turn.rest()
                self._turn = None
            if self._mouth is not None:
                self._mouth.rest()
            self._tell(audio.ListeningMessage(False))
        else:
            self._begin_turn(message)

    def _begin_turn(self, asked: audio.Listen) -> None:
        if self._turn is not None:
            self._turn.rest()
            self._turn = None
        self._end_mouth()
        if asked.speaker and self._simulated:
            self._speak_in_room(asked.speaker)
            return
        turn = TalkTurn(
            asked.mode,
            self._hear,
            lambda why, on: self._tell(audio.ListeningMessage(on, why)),
            self._page,
            partial(self._runtime.lease.rank, self._person),
            lambda words: self._tell(audio.PartialTranscript(words)),
            lambda: self._tell(audio.AllRead()),
        )
        try:
            self._runtime.parts[BrowserMicrophone].begin(turn)
        except Refused as busy:
            self._tell(audio.ListeningMessage(False, str(busy)))
            return
        now = time.monotonic()
        turn.sent(self._runtime.state_times.oldest(asked.seen, now), now)
        self._turn = turn
        self._listener.reset()
        self._tell(audio.ListeningMessage(True))

    # from a mouth in the simulated room

    def _speak_in_room(self, wanted: str) -> None:
        """The sound that comes is someone's voice in the room, whom the robot obeys in this person's name."""
        runtime = self._runtime
        try:
            runtime.parts[VoiceCommands].take_on(self._person)
        except Problem as refusal:
            self._tell(audio.ListeningMessage(False, refusal.detail))
            return
        self._mouth = RoomMouth(
            wanted, runtime.ask, runtime.parts[RoomTranscriber], runtime.parts[VoiceCommands], self._mouth_trouble
        )
        runtime.parts[RoomTranscriber].when_so_far.append(self._so_far)
        self._tell(audio.ListeningMessage(True))

    def _end_mouth(self) -> None:
        if self._mouth is not None:
            self._mouth.close()
            self._mouth = None
            self._runtime.parts[RoomTranscriber].when_so_far.remove(self._so_far)

    def _mouth_trouble(self, why: str) -> None:
        self._end_mouth()
        self._tell(audio.ListeningMessage(False, why) if why else audio.AllRead())

    def _cancelled(self, _: Ending, why: str, objected: bool) -> None:
        """Stopped: what was said in the room and did not sound yet is not said."""
        if objected and self._mouth is not None:
            self._mouth.hush()
            self._end_mouth()

    def _so_far(self, words: str) -> None:
        self._tell(audio.PartialTranscript(words))

    def _heard_in_room(self, outcome: SpokenOutcome, _: VoiceDirection | None) -> None:
        if self._mouth is None or not self._mouth.awaits_words or not outcome.utterance.final:
            return
        self._show(outcome, max(0.0, time.monotonic() - outcome.said.ended))
        if self._mouth.over:
            self._end_mouth()

    # what was heard

    def _hear(self, utterance: RecognizedUtterance, delay: float) -> None:
        """Act on recognized words, which came so long after their sound [s]."""
        self._show(self._listener.hear(utterance, min(time.monotonic() - delay, self._until)), delay)

    def _show(self, outcome: SpokenOutcome, delay: float) -> None:
        self._number += 1
        self._tell(outcome.transcript(self._number, delay))

    def _rejected(self, pending_command: PendingCommand) -> None:
        if pending_command.source == SOURCE and pending_command.person.id == self._person.id:
            self._runtime.parts[BrowserMicrophone].reject(pending_command.words, self._page)
