"""Random stories of speaking, slow reading, stops, hands, takeovers and closing pages, and what must never happen.

The console's own parts for words are real; the robot, the pilot, the sockets and the reader of words are stand-ins.
What may not move the robot is judged from what the stand-ins saw, by true times, and by nothing of the console's.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import math
import random
import time
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Self
from unittest.mock import patch

import numpy as np

from console.access.logins import Person
from console.access.open_sockets import OpenSockets
from console.api.audio_socket import AudioSocket
from console.control.command_freshness import StateTimes
from console.control.dispatcher import CommandDispatcher
from console.control.history import History
from console.control.lease import Lease
from console.control.notices import Notifications
from console.control.pending_commands import PendingCommand, PendingCommands
from console.control.text_file_commands import TextFileCommands
from console.control.text_files import TextFileCommand
from console.http.problems import Problem
from console.messages import inbound
from console.messages.audio import AUDIO_HEADER, AUDIO_KIND, AUDIO_RATE_HZ
from console.part import Parts
from console.speech.browser_microphone import BrowserMicrophone
from console.speech.robot_voice import RobotVoice
from console.speech.room_transcription import RoomTranscriber
from console.speech.voice_commands import VoiceCommands
from core.commands.command import Command
from core.commands.confirmation_delay import CONFIRMATION_DELAY_S, MAX_OBEYED_AGE_S, MAX_POSTPONED_S
from core.errors import Refused
from core.gate import Twist
from core.gate.status import GateStatus
from core.sensors import Sound
from core.speech.recognition.decision import RecognizedUtterance
from core.speech.understanding.grammar import understand
from tests.core.speech.ears import sure
from tests.stories.virtual_time import WALL, Clock, virtual_time

ANNA, BERT, GUEST = Person("a", "Anna", "operator"), Person("b", "Bert", "operator"), Person("v", "Vera", "viewer")
PIECE = 0.25  # [s] of sound
LATE = 0.1  # [s] that sound is on its way, at most
LENGTH = 9.0  # [s] of a story


@dataclass
class Uttered:
    """What someone said, wrote or typed."""

    words: str
    source: str
    speaker: str
    begun: float  # [s] in truth
    ended: float
    stop: float = math.inf  # [s] when the word stop in it was over
    stop_read: float = math.inf  # [s] when that was read
    taken: float = math.inf  # [s] when the console had it wait


@dataclass
class Seen:
    """What the stand-ins saw: times [s] in truth."""

    uttered: dict[str, Uttered] = field(default_factory=dict[str, Uttered])
    stops: list[float] = field(default_factory=list[float])
    jogs: list[float] = field(default_factory=list[float])
    hands: list[float] = field(default_factory=list[float])  # the driver changed
    closings: list[tuple[float, str]] = field(default_factory=list[tuple[float, str]])
    motions: list[tuple[float, str]] = field(default_factory=list[tuple[float, str]])
    wrong: list[str] = field(default_factory=list[str])


class Reader:
    """Reads words as slowly as it likes: those that `say` put into the sound."""

    def __init__(self, pace: Any) -> None:
        self._pace = pace
        self._said: list[tuple[Uttered, RecognizedUtterance]] = []
        self.alive = self.listens = True

    def say(self, one: Uttered, ahead: float) -> None:
        """In the sound's own time, which is so far `ahead` [s]."""
        if one.stop < math.inf:
            self._said.append((one, told("stop", one.begun + ahead, one.stop + ahead, final=False)))
        self._said.append((one, told(one.words, one.begun + ahead, one.ended + ahead)))

    async def begun(self) -> bool:
        return True

    async def begin(self, *_: Any, **__: Any) -> None:
        self._said = []

    async def feed(self, samples: Any, rate: int, stamp: float) -> list[RecognizedUtterance]:
        until = stamp + len(samples) / rate + 1e-6
        heard = [said for said in self._said if said[1].end <= until]
        self._said = [said for said in self._said if said[1].end > until]
        return await self._read(heard)

    async def finish(self) -> list[RecognizedUtterance]:
        heard, self._said = self._said, []
        return await self._read(heard)

    async def _read(self, heard: list[tuple[Uttered, RecognizedUtterance]]) -> list[RecognizedUtterance]:
        await asyncio.sleep(self._pace())
        for one, known in heard:
            if not known.final:
                one.stop_read = time.monotonic()
        return [known for _, known in heard]

    async def words_so_far(self) -> str:
        await asyncio.sleep(self._pace())
        return ""

    def reject(self, words: str) -> None: ...


def told(words: str, begin: float, end: float, *, final: bool = True) -> RecognizedUtterance:
    return RecognizedUtterance(begin=begin, end=end, decision=sure(words), final=final)


class Waiting(PendingCommands):
    """Notes what begins to wait, and when."""

    seen: Seen

    def _wait(self, pending_command: PendingCommand) -> None:
        super()._wait(pending_command)
        one = self.seen.uttered[pending_command.command.heard_as]
        one.taken = min(one.taken, time.monotonic())


class Story:
    """One console from its start, and what people do to it."""

    def __init__(self, seed: int, folder: Path, loop: asyncio.AbstractEventLoop, clock: Clock) -> None:
        self.chance, self.seen, self._loop, self._clock = random.Random(seed), Seen(), loop, clock
        self._numbers = iter(range(1, 1000))
        self.room_reader, self.page_reader = Reader(self._pace), Reader(self._pace)
        self.frozen = 0.0  # [s] until when nobody reads
        self._epoch, self._armed = 0, 0.0  # [s] when someone last began to drive
        self.slow = self.chance.choice((0.05, 0.3, 2.0, 5.0))
        self.lease, board = Lease(), Notifications()
        history = History(folder, lambda _: None)
        self.dispatcher = CommandDispatcher(self, self.lease, history, board)  # type: ignore[arg-type]
        self.dispatcher.pilot = self  # type: ignore[assignment]
        self.pending_commands = Waiting(self.dispatcher, self.lease, history, board)
        self.pending_commands.seen = self.seen
        self.voice_commands = VoiceCommands(self.dispatcher, self.lease, self.pending_commands, history, board)
        with patch("console.speech.room_transcription.TranscriptionClient", lambda: self.room_reader):
            self.transcriber = RoomTranscriber(self.voice_commands, self.pending_commands, self.dispatcher, board)
        with patch("console.speech.browser_microphone.TranscriptionClient", lambda: self.page_reader):
            self.microphone = BrowserMicrophone()
        self.sockets, self.history, self.state_times = OpenSockets(), history, StateTimes()
        self.parts = Parts()
        for part in (self.transcriber, self.microphone, self.pending_commands, self.voice_commands, RobotVoice()):
            self.parts.add(part)
        self.pages: dict[str, Page] = {}
        self.heard_until = 0.0  # [s]
        self._file: Uttered | None = None
        self.writer_lives = False
        parts = (self.dispatcher, self.lease, history, board)
        self.texts = TextFileCommands(self, *parts, lambda: None)  # type: ignore[arg-type]

    @property
    def now(self) -> float:
        return self._clock.now

    def _pace(self) -> float:
        return max(self.frozen - self.now, 0.0) + self.chance.random() ** 2 * self.slow

    # what the console has of the robot

    profile = SimpleNamespace(drives=True, simulated=False)
    trouble = ""

    @property
    def robot(self) -> Self:
        return self

    def status(self) -> GateStatus:
        return GateStatus(state="armed")

    def link(self) -> tuple[str, float]:
        return "live", 0.0

    def stop(self) -> None:
        self.seen.stops.append(self.now)

    halt = stop

    def send(self, setpoint: Any) -> None:
        if setpoint.source == "jog" and setpoint.v:
            self.seen.jogs.append(self.now)

    def arm(self, epoch: int, owner: str) -> None:
        if epoch != self._epoch:
            self._epoch, self._armed = epoch, self.now

    def cap(self, speed: float | None) -> None: ...

    def disarm(self) -> None:
        self.seen.hands.append(self.now)

    # what the console has of the pilot

    def tell(self, number: int, command: Command, source: str, who: str) -> None:
        if command.name == "stop_moving":
            return
        if self.chance.random() < 0.05:
            raise Refused("Not now.")
        self.judge(self.seen.uttered[command.heard_as], self.now)
        self.seen.motions.append((self.now, command.heard_as))

    def cancel(self, state: str, why: str) -> None: ...

    def judge(self, one: Uttered, now: float) -> None:
        """Whether these words may have the robot move at `now`."""
        if one.source == "typed":
            return
        since, seen = one.ended + LATE, self.seen
        waited = one.taken <= now
        reasons = {
            "too late": min(one.taken, now) - one.ended > MAX_OBEYED_AGE_S + LATE,
            "waited too long": waited and now - one.taken > CONFIRMATION_DELAY_S + MAX_POSTPONED_S + 1.0,
            "a stop came": any(since < at != one.stop_read for at in seen.stops),
            "a hand came": any(since < at for at in seen.jogs),
            "the driver changed": any(since < at for at in seen.hands),
            "the page closed": any(since < at and who == one.speaker for at, who in seen.closings),
            "a newer command came": any(
                since < (at if seen.uttered[words].source == "typed" else seen.uttered[words].ended)
                for at, words in seen.motions
            ),
            "nobody is there": one.source == "voice" and one.speaker not in self.pages,
            "there is no control socket": one.source == "voice"
            and self._armed == now
            and not self.pages[one.speaker].control,
            "it is the rest of a STOP": one.stop < math.inf and not one.words.startswith("stop at"),
        }
        wrong = [reason for reason, true in reasons.items() if true]
        if wrong:
            seen.wrong.append(f"{now:.2f}: {one} moves the robot although {', '.join(wrong)}")

    # what people do

    def utter(self, source: str, speaker: str, length: float, words: str = "") -> Uttered:
        number = next(self._numbers)
        far = self.chance.choice((0.0, 0.0, 2.0))
        heard_as = words or f"continue {0.2 + far + number / 1000:g} meters"
        read = understand(heard_as)
        assert isinstance(read, Command)
        one = Uttered(read.heard_as, source, speaker, self.now, self.now + length)
        if read.name != "stop_moving":
            self.seen.uttered[read.heard_as] = one
        return one

    def sentence(self, source: str, speaker: str) -> Uttered:
        """Something to be spoken: a command, STOP, "stop at …", or STOP whose rest is taken for a command."""
        kind, length = self.chance.random(), self.chance.uniform(0.4, 1.2)
        if kind < 0.15:
            one = self.utter(source, speaker, length, "stop")
        elif kind < 0.25:
            one = self.utter(source, speaker, length, f"stop at 1 and {next(self._numbers) / 1000:g}")
        else:
            one = self.utter(source, speaker, length)
        if kind < 0.35:
            one.stop = one.begun + 0.5 * length
        return one

    async def room(self) -> None:
        """The robot's sound comes, now and then late."""
        array: Any = SimpleNamespace(heard=lambda sound: sound.samples, dimensions=1)
        stalled = 0.0
        while True:
            await asyncio.sleep(PIECE)
            sensed = self.now
            if self.chance.random() < 0.01:
                stalled = self.now + self.chance.uniform(0, 6)
            await asyncio.sleep(max(stalled - self.now, 0.0))
            snapshot: Any = SimpleNamespace(stamp=sensed - 50.0, hearing=None, velocity=Twist(0.0, 0.0))
            rows = round(PIECE * 100)
            sound = Sound(stamp=sensed - 50.0 - PIECE, rate=100, samples=np.zeros((rows, 1)))
            self.transcriber.feed(snapshot, sound, array, sensed)

    async def ticks(self) -> None:
        while True:
            await asyncio.sleep(0.4)
            self.dispatcher.tick(self.now)
            for page in self.pages.values():
                if page.control and not page.hung:
                    self.lease.active(page.who, self.now)

    def look(self, now: float) -> TextFileCommand | None:
        """speech.txt."""
        one, self._file = self._file, None
        return None if one is None else TextFileCommand(one.words, age=now - WALL - one.ended)

    def act(self) -> None:
        """One thing that someone does."""
        who = self.chance.choice((ANNA, ANNA, BERT))
        page = self.pages.get(who.id)
        what = self.chance.choices(ACTS, WEIGHTS)[0]
        self._say(what, who, page)
        self._drive(what, who)
        self._change_page(what, who, page)
        self._answer_pending(what, who)

    def _say(self, what: str, who: Person, page: Page | None) -> None:
        match what:
            case "speak" if page is not None:
                page.speak(self.sentence("voice", who.id))
            case "room" if self.now > self.heard_until:  # the ears hear one utterance after the other
                one = self.sentence("ears", "")
                self.heard_until = one.ended + 0.5
                self.room_reader.say(one, -50.0)
            case "write":
                self._file = self.utter("file", "", 0.0)
            case "type":
                self.dispatcher.submit(self.utter("typed", who.id, 0.0).words, "typed", who)
            case _:
                pass

    def _drive(self, what: str, who: Person) -> None:
        match what:
            case "stop":
                self.dispatcher.stop(GUEST, "rest")
            case "halt":
                self.dispatcher.halt(who, "rest")
            case "jog":
                self._loop.create_task(self._jog(who))
            case "take" | "release" | "acquire" as wish:
                self.dispatcher.change_lease(wish, who)
            case "forget":
                self.dispatcher.forget(who)
            case _:
                pass

    def _change_page(self, what: str, who: Person, page: Page | None) -> None:
        match what:
            case "freeze":
                self.frozen = self.now + self.chance.uniform(1, 10)
            case "hang" if page is not None:
                page.hung = not page.hung
            case "close" if page is not None:
                page.close()
            case "open" if page is None:
                self.pages[who.id] = Page(self, who, control=self.chance.random() < 0.8)
            case _:
                pass

    def _answer_pending(self, what: str, who: Person) -> None:
        match what:
            case "take on":
                self.voice_commands.take_on(who)
            case "drop" if self.pending_commands.waiting is not None:
                self.seen.stops.append(self.now)
                self.pending_commands.drop(self.pending_commands.waiting.id, GUEST)
            case "begin" if self.pending_commands.waiting is not None:
                self.pending_commands.begin(self.pending_commands.waiting.id, who)
            case _:
                pass

    async def _jog(self, who: Person) -> None:
        press = next(self._numbers)
        for seq in range(self.chance.randrange(1, 8)):
            self._try(
                lambda seq=seq: self.dispatcher.drive(
                    inbound.JogMessage(0.1, 0.0, press, seq, 1, self.lease.epoch), who
                )
            )
            await asyncio.sleep(0.05)

    def _try(self, act: Any) -> None:
        with contextlib.suppress(Problem, Refused):
            act()

    async def tell_it(self) -> None:
        """From the beginning to the end."""
        self._running = [self._loop.create_task(one) for one in (self.room(), self.ticks(), self.texts.run())]
        self.pages["a"] = Page(self, ANNA, control=self.chance.random() < 0.8)
        if self.pages["a"].control:
            self._try(lambda: self.voice_commands.take_on(ANNA))
        end = self.now + LENGTH
        while self.now < end:
            self._try(self.act)
            pause = self.chance.choice((0.05, 0.8, 3.0)) * self.chance.random()
            await asyncio.sleep(pause)


class Page:
    """A browser with a microphone, or a program without a `control` socket; its clock is its own."""

    def __init__(self, story: Story, who: Person, *, control: bool) -> None:
        self.who, self.control, self.hung = who, control, False
        self._story, self.ahead = story, story.chance.uniform(0, 1e5)
        self._up: asyncio.Queue[dict[str, Any]] = asyncio.Queue()
        self.heard: list[RecognizedUtterance] = []  # what came down
        self.seen = 0  # number of the newest state
        if control:
            story.lease.connected(who, story.now)
        self._task = asyncio.get_running_loop().create_task(AudioSocket(story, self, who).run())  # type: ignore[arg-type]
        self._speaking: asyncio.Task[None] | None = None

    client = None

    async def accept(self) -> None: ...

    async def close_socket(self, *_: Any) -> None: ...

    async def receive(self) -> dict[str, Any]:
        return await self._up.get()

    async def send_text(self, text: str) -> None:
        self.heard.append(json.loads(text))

    def speak(self, one: Uttered) -> None:
        """Unless someone speaks here already."""
        if self._speaking is None or self._speaking.done():
            self._speaking = asyncio.get_running_loop().create_task(self._speak(one))

    async def _speak(self, one: Uttered) -> None:
        story = self._story
        if story.microphone._turn is not None:
            return
        wish = json.dumps({"kind": "listen", "mode": "held", "seen": self.seen})
        self._up.put_nowait({"type": "websocket.receive", "text": wish})
        await asyncio.sleep(0.001)
        story.page_reader.say(one, self.ahead)
        at = one.begun
        while at < one.ended:
            piece = min(PIECE, one.ended - at)
            await asyncio.sleep(max(at + piece - story.now, 0.0) + LATE * story.chance.random())
            header = AUDIO_HEADER.pack(AUDIO_KIND, 0, 1000 * (at + self.ahead))
            sound = header + bytes(2 * math.ceil(piece * AUDIO_RATE_HZ))
            self._up.put_nowait({"type": "websocket.receive", "bytes": sound})
            at += piece
        self._up.put_nowait({"type": "websocket.receive", "text": '{"kind":"rest"}'})

    def close(self) -> None:
        """Both sockets."""
        story = self._story
        del story.pages[self.who.id]
        story.seen.closings.append((story.now, self.who.id))
        if self._speaking is not None:
            self._speaking.cancel()
        self._up.put_nowait({"type": "websocket.disconnect"})
        if self.control:
            story.lease.disconnected(self.who)
            story.pending_commands.left(self.who)


ACTS, WEIGHTS = zip(
    *{
        "speak": 10, "room": 8, "write": 5, "type": 1, "stop": 1, "halt": 0.3, "jog": 1, "take": 0.7, "release": 0.4,
        "acquire": 0.7, "forget": 0.3, "freeze": 1, "hang": 0.5, "close": 1, "open": 3, "take on": 1.5, "drop": 0.5,
        "begin": 0.5,
    }.items(),
    strict=True,
)  # fmt: skip


def told_story(seed: int, folder: Path) -> Seen:
    """What was seen in the story of this number."""
    with virtual_time(random.Random(seed)) as (loop, clock):
        at_once = "core.speech.recognition.decision.has_said_numbers"  # numbers only tell the commands apart here
        with patch("console.control.text_file_commands.LOOK_PERIOD_S", 0.4), patch(at_once, lambda _: False):
            story = Story(seed, folder, loop, clock)
            loop.run_until_complete(story.tell_it())
        return story.seen
