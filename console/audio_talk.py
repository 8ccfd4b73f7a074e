"""The socket `/ws/audio`: a browser's microphone up, transcripts down.

What was heard goes through the same door as typed words. STOP is obeyed before the sentence is over.
"""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import math
import time
from functools import partial
from typing import Any

import msgspec
import numpy as np
from starlette.websockets import WebSocket, WebSocketDisconnect

from console import wire_audio as wire
from console.fresh_words import Said
from console.intent import Intent
from console.latest import Closing
from console.logins import Person
from console.microphone import Turn
from console.prattle import Prattle
from console.problems import Problem
from console.runtime import Runtime
from console.sockets import TooMany
from console.spoken_stops import STOPPED, SpokenStops
from console.strict_json import read_json
from console.tally import Tally, size_of
from console.tasks import end
from console.words_worker import Told
from core.errors import BadInput, Refused

MOST_PER_SECOND = 250  # messages; pieces of 20 ms are 50, and what a stalled network held back comes at once
MOST_BYTES = 2**19  # a second; sound is 32,000, and 15 s of it may come at once
MOST_WAITING = 50  # messages down that may wait for a browser that does not read them
SOURCE = "voice"
PAGES = itertools.count(1)
GONE = Closing(1000, "The browser left.")


class AudioTalk:
    """One browser's microphone."""

    def __init__(self, runtime: Runtime, socket: WebSocket, person: Person) -> None:
        self._runtime, self._socket, self._person = runtime, socket, person
        self._page = next(PAGES)
        self._turn: Turn | None = None
        self._tally, self._volume = Tally(), Tally()
        self._down: asyncio.Queue[wire.AudioDown] = asyncio.Queue(MOST_WAITING)
        self._closing: Closing | None = None
        self._number = 0
        self._stops = SpokenStops()
        self._until = math.inf  # [s] when the socket was closed: nothing was said later
        self._prattle = Prattle(runtime.history)

    async def run(self) -> None:
        """From the handshake to the end."""
        try:
            with self._runtime.sockets.room_for(self._person, self._close):
                await self._socket.accept()
                self._runtime.microphone.warm()
                self._runtime.intents.when_held_back.append(self._held_back)
                try:
                    await self._converse()
                finally:
                    self._runtime.intents.when_held_back.remove(self._held_back)
        except TooMany as crowded:
            await self._socket.accept()
            self._close(1013, str(crowded))
        if self._closing is not None and self._closing != GONE:
            with contextlib.suppress(WebSocketDisconnect, RuntimeError):
                await self._socket.close(self._closing.code, self._closing.reason)

    async def _converse(self) -> None:
        speaker = asyncio.create_task(self._speak())
        try:
            while self._closing is None:
                message = await self._socket.receive()
                if message["type"] == "websocket.disconnect":
                    self._closing = GONE
                elif self._tally.add(time.monotonic()) > MOST_PER_SECOND:
                    self._close(1008, f"More than {MOST_PER_SECOND} messages a second.")
                elif self._volume.add(time.monotonic(), size_of(message)) > MOST_BYTES:
                    self._close(1008, f"More than {MOST_BYTES} bytes a second.")
                elif message.get("bytes") is not None:
                    self._take_sound(message["bytes"])
                else:
                    self._take_words(message.get("text") or "")
        finally:
            self._until = time.monotonic()
            if self._turn is not None:
                self._turn.rest()
            self._runtime.intents.left(self._person)
            await end(speaker)

    async def _speak(self) -> None:
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):
            while True:
                message = await self._down.get()
                await self._socket.send_text(msgspec.json.encode(message).decode())

    def _close(self, code: int, reason: str) -> None:
        """Before the next message is taken."""
        self._closing = self._closing or Closing(code, reason)

    def _tell(self, message: wire.AudioDown) -> None:
        if self._down.full():
            self._close(1008, "The browser does not read what is sent to it.")
        else:
            self._down.put_nowait(message)

    # up

    def _take_sound(self, raw: bytes) -> None:
        size = wire.AUDIO_HEADER.size
        if len(raw) > wire.MOST_BYTES or len(raw) < size or len(raw) % 2:
            self._close(1009, f"A piece of sound has {size} bytes of header and at most {wire.MOST_BYTES} in all.")
            return
        kind, _, clock = wire.AUDIO_HEADER.unpack_from(raw)
        if kind != wire.AUDIO_KIND or not 0 <= clock < 1e15:
            self._close(1007, "This is no piece of sound: its header is wrong.")
        elif self._turn is not None and not (self._turn.mode == "open" and self._runtime.voice.muted):
            samples = np.frombuffer(raw, "<i2", offset=size).astype(float) / 32768
            self._turn.add(samples, clock / 1000)
            if self._turn.mode == "held":
                self._runtime.intents.hear()

    def _take_words(self, text: str) -> None:
        try:
            message = msgspec.convert(read_json(text), wire.AudioUp)
        except (BadInput, msgspec.ValidationError):
            self._close(1007, "This message has not the form that is asked for.")
            return
        if isinstance(message, wire.Rest):
            if self._turn is not None:
                self._turn.rest()
                self._turn = None
            self._tell(wire.Listening(False))
        else:
            self._listen(message)

    def _listen(self, wish: wire.Listen) -> None:
        if self._turn is not None:
            self._turn.rest()
        turn = Turn(
            wish.mode,
            self._hear,
            lambda why, on: self._tell(wire.Listening(on, why)),
            self._page,
            partial(self._runtime.lease.rank, self._person),
        )
        try:
            self._runtime.microphone.begin(turn)
        except Refused as busy:
            self._tell(wire.Listening(False, str(busy)))
            return
        now = time.monotonic()
        turn.sent(self._runtime.states.oldest(wish.seen, now), now)
        self._turn = turn
        self._stops.another_clock()
        self._tell(wire.Listening(True))

    # what was heard

    def _hear(self, told: Told, delay: float) -> None:
        """Words with how long after their sound they came [s]."""
        heard = self._stops.hear(told)
        became: dict[str, Any] = {}
        if heard == "stopped":
            told = {**told, **STOPPED}
        elif heard == "stop":
            became = {"deed": self._obey(told, delay).get("deed")}
            self._stops.obeyed(self._runtime.door.words)
        elif told["final"] and told["name"] is not None:
            became = self._obey(told, delay)
        elif told["final"]:
            became = {"deed": self._refuse(told)}
        reason: str = became.get("reason", told["reason"])
        accepted = told["name"] is not None and not reason
        self._number += 1
        self._tell(
            wire.Transcript(
                id=self._number,
                words=told["words"],
                final=told["final"],
                accepted=accepted,
                heard_as=told["heard_as"],
                reason=reason,
                suggestions=told["suggestions"],
                seconds=round(told["end"] - told["begin"], 2),
                delay_s=round(delay, 3),
                deed=became.get("deed"),
                intent=became.get("intent"),
            )
        )

    def _obey(self, told: Told, delay: float) -> dict[str, Any]:
        """What became of words: the deed, the order that waits, or the reason why there is neither."""
        ended = min(time.monotonic() - delay, self._until)
        said = self._stops.said(told, Said(ended - (told["end"] - told["begin"]), ended))
        try:
            taken = self._runtime.intents.take(told["heard_as"], SOURCE, self._person, said, unsure=told["unsure"])
            return {"intent" if isinstance(taken, Intent) else "deed": taken.id}
        except Problem as problem:
            return {"reason": problem.detail}

    def _held_back(self, intent: Intent) -> None:
        """An order of this person's waited and was held back."""
        if intent.source == SOURCE and intent.person.id == self._person.id:
            self._runtime.microphone.hold_back(intent.words, self._page)

    def _refuse(self, told: Told) -> int | None:
        """Into the history."""
        given = {"source": SOURCE, "remark": told["reason"]}
        if not told["words"]:
            deed = self._prattle.tell(self._person, **given)
            return None if deed is None else deed.id
        given |= {"words": told["words"], "state": "refused"}
        return self._runtime.history.add("command", self._person, **given).id
