"""A robot and people in one simulated place: what they say goes through the air, the microphones and the recognizer.

Sound leaves a mouth, comes with its echoes to the robot's array, is located and read from the beam towards it, and
what is understood goes to the pilot, as in the console. Nothing keeps real time, but reading takes the robot's time.
"""

import dataclasses
import math
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from core.commands import spec_of
from core.commands.command import Command
from core.commands.confirmation_delay import (
    CONFIRMATION_DELAY_S,
    MAX_OBEYED_AGE_S,
    MAX_POSTPONED_S,
    ConfirmationDelay,
)
from core.commands.stop_moving import STOP_MOVING
from core.errors import BadInput, Refused
from core.experiments.rehearsal import Rehearsal
from core.geometry import Pose, wrap
from core.message import Array, message
from core.perception.people.voice_bearing import VoiceBearing
from core.robots.requests import PlaceThing, ReadPlan, SetListening, Speak
from core.sensors import SensorFrame
from core.sensors.microphones import Sound, joined
from core.settings import Settings
from core.simulation.world import World, world_named
from core.snapshot import Snapshot, VoiceDirection, voice_between
from core.speech.practice_voice import practice_voice
from core.speech.recognition.decision import RecognizedUtterance
from core.speech.recognition.engines import open_engine
from core.speech.recognition.recognizer import Recognizer, StreamingRecognizer
from core.speech.settings import MAX_WAITING_S, RATE_HZ
from core.speech.synthesis import PERSONS_VOICE, VoiceSettings, speak
from core.speech.synthesis import pcm as pcm_of
from core.speech.transcription.array_transcriber import ArrayTranscriber
from core.speech.transcription.piece_length import PieceLength
from core.speech.understanding.grammar import Refusal, understand

NOISE_BEFORE_S = 1.0  # of sound before listening starts that are read too: the noise before the words is known


class TimedListening:
    """Neither the robot nor the room is known here: a room that is left goes at once, with all that it heard."""

    def __init__(self, recognizer: StreamingRecognizer, reading_share: float | None = None) -> None:
        """`reading_share`: time of reading a sound, of its duration; None: the processor time that it takes here."""
        self._recognizer, self._share = recognizer, reading_share
        self._waiting: Sound | None = None
        self._piece = PieceLength()
        self._pending: Sequence[RecognizedUtterance] = ()  # what will be known at the end of the newest reading
        self._readings: list[tuple[float, float]] = []  # [s] robot's clock, from when to when

    def keep(self, frame: SensorFrame) -> None:
        """The sound of one frame; ears are never shut."""
        if frame.sound is not None:
            self._waiting = joined(self._waiting, frame.sound, MAX_WAITING_S)

    def begin(self) -> None:
        """Listen from now on; what was heard long before is forgotten."""
        sound, self._readings, self._pending = self._waiting, self._readings[-1:], ()
        if sound is not None:
            now = sound.stamp + sound.duration
            self._waiting = sound.part(now - NOISE_BEFORE_S, now)

    def heard(self, now: float, speaking: bool) -> tuple[RecognizedUtterance, ...]:
        """Return the words that became known by `now` [s]; call it once for every frame.

        `speaking`: the robot hears a voice.
        """
        self._piece.follow(now, speaking)
        if self._readings and now < self._readings[-1][1]:
            return ()
        known, self._pending = self._pending, ()
        sound = self._waiting
        if sound is not None and sound.duration >= self._piece.seconds:
            self._waiting, begun = None, time.process_time()
            self._pending = self._recognizer.feed(sound)
            took = time.process_time() - begun if self._share is None else self._share * sound.duration
            self._readings.append((now, now + took))
        return tuple(known)

    def reading(self, begin: float, end: float) -> float:
        """Time [s] that recognition was busy between two moments [s] since `begin`."""
        return sum(max(min(end, until) - max(begin, since), 0.0) for since, until in self._readings)


BODY = np.array([[aside, up] for aside in (-0.12, 0.0, 0.12) for up in (0.5, 0.9, 1.3)])
"""[m] (9, 2) points on a body, to the side of its middle and above the floor, that are checked for visibility."""
SEEN = 2 / 3  # of them, at least
SIGHT_STEP_M = 0.05  # between places of a line of sight
LISTEN_S = 2.6  # after a voice without words began
MAX_READING_S = 8.0  # in which a spoken command must be understood, or it is said again
REST_S = 3.0  # of the sentence that begins with STOP, of silence behind it, and of reading it
REACTION_TIME_S = 1.0  # after which who is misunderstood says STOP
FAINT_SHARE = 0.02  # of the loudest sample, below which a voice has ended
CLOTHES = ("red", "blue", "green", "black", "white", "grey", "brown", "yellow")
SPEEDS_WORDS_MIN = (130, 140, 150)  # [words/min] at which people speak to a robot
ANN = "Ann"
Watch = Callable[[Snapshot], None]  # sees every frame
SENSES = ("laser_m", "camera_rad", "sound_rad", "fused_m")


@message
class SentenceOutcome:
    """The outcome of a sentence."""

    number: int | None  # of the command; None: it was not understood, or refused
    call: VoiceBearing | None  # from where it was heard
    said: tuple[float, float] | None = None  # [s] robot's clock: from when to when its words were heard
    why: str = ""  # a sentence where there is no command
    tries: int = 1  # how often it was said
    wrong: tuple[str, ...] = ()  # commands that were understood instead, and begun
    rescued: tuple[str, ...] = ()  # those that only the speaker's STOP kept from beginning
    ended: float = 0.0  # [s] robot's clock: when the voice truly had said its words
    understood: float = 0.0  # [s] the same: when they were
    begun: float = 0.0  # [s] the same: when it was begun; a pending command waits for confirmation
    read: float = 0.0  # [s] of the time until it was understood, in which sound was being read


class SpokenRoom:
    """One robot, its people, one seed. `words`: said and read; else they are typed with a voice without words."""

    def __init__(
        self,
        world: str,
        seed: int,
        *,
        words: bool = True,
        start: Pose | None = None,
        settings: Settings | None = None,
        recognizer: Recognizer | None = None,
        voice: VoiceSettings | None = None,
        reading_share: float | None = None,
    ) -> None:
        """`voice`: Ann's; None: the usual one at an easy pace. `reading_share`: of a sound's duration that its
        reading takes; None: as long as it takes here, so that no run is like another.

        Raises Unavailable where words are to be read and nothing reads them.
        """
        self._voice = voice
        self.chance = np.random.default_rng(seed)
        self.robot = Rehearsal(f"sim:{world}", seed=seed, start=start, settings=settings)
        self.errors: dict[str, list[float]] = {sense: [] for sense in SENSES}
        self.world: World = world_named(world)
        self._ears: TimedListening | None = None
        array = self.robot.robot.profile.microphones
        if words and array is not None:
            chosen = self.robot.settings
            reads = recognizer or open_engine(chosen.speech).recognizer
            self._ears = TimedListening(
                ArrayTranscriber(array, chosen.speech, chosen.direction_finding, recognizer=reads), reading_share
            )
            self.robot.when_stepped.append(self._ears.keep)
        self.robot.robot.ask(SetListening(on=True))
        self.robot.run(2.0)

    def place(
        self, nearest: float = 1.0, farthest: float = 3.8, *, off: Sequence[tuple[float, float]] = (), **more: Any
    ) -> tuple[float, float]:
        """Set Ann down somewhere in sight of the robot, a metre from every place of `off` → where (x, y) [m]."""
        here = self.robot.truth
        for _ in range(10_000):
            away, angle = self.chance.uniform(nearest, farthest), self.chance.uniform(-math.pi, math.pi)
            x, y = float(here.x + away * math.cos(angle)), float(here.y + away * math.sin(angle))
            shirt, trousers = (str(self.chance.choice(CLOTHES)) for _ in range(2))
            place = {"x_m": x, "y_m": y, "heading_rad": float(self.chance.uniform(-3, 3))}
            if self.hidden(here, x, y) or any(math.hypot(x - u, y - v) < 1.0 for u, v in off):
                continue
            try:
                self.put(ANN, clothes=f"{shirt}/{trousers}", **place, **more)
            except BadInput:
                continue
            return x, y
        raise Refused("There is no room for a person near the robot.")

    def put(self, name: str, **fields: Any) -> None:
        """Put a person there, or move them. Raises BadInput."""
        self.robot.robot.ask(PlaceThing(what="person", id=name, **fields))

    def where(self, name: str) -> tuple[float, float]:
        """Position of a person now (x, y) [m]."""
        things = self.robot.robot.ask(ReadPlan()).things
        one = next(thing for thing in things if thing.id == name)
        return one.x_m, one.y_m

    def hidden(self, here: Pose, x: float, y: float) -> bool:
        """Return whether walls or things hide a person there from the low camera: it comes only to visible people."""
        camera = self.robot.robot.profile.camera
        eye = np.array([here.x, here.y, 0.0 if camera is None else camera.mounting.translation[2]])
        way = np.array([x - here.x, y - here.y])
        across = np.array([-way[1], way[0]]) / math.hypot(*way)
        body = np.column_stack((np.array([x, y]) + BODY[:, :1] * across, BODY[:, 1]))
        along = np.linspace(0.0, 1.0, max(int(math.hypot(*way) / SIGHT_STEP_M), 2))[1:, None]
        return float(np.mean([self.world.open_air(eye + along * (place - eye)) for place in body])) < SEEN

    def command(
        self, words: str, tries: int = 1, *, watch: Watch = lambda _: None, pcm: bytes | None = None
    ) -> SentenceOutcome:
        """Ann says it, again while nothing is understood → the outcome; `watch` sees every frame until then.

        `pcm`: a recording of the words, 16-bit samples at 16 kHz, instead of a synthetic voice.
        """
        if self._ears is None:
            return self._typed(words, watch, pcm)
        intended = understand(words, spoken=True)
        if isinstance(intended, Refusal):
            raise Refused(intended.reason)
        wrong: list[str] = []
        rescued: list[str] = []
        why = ""
        call: VoiceBearing | None = None
        for attempt in range(1, tries + 1):
            ended = self._say(words) if pcm is None else self._utter(pcm)
            said, voices = self._hear(MAX_READING_S, watch, early=intended.name == STOP_MOVING.name)
            if said is None or said.decision.command is None:
                why = "not understood"
                continue
            call = call_of(voices, said.begin, said.end)
            decision, command, now = said.decision, said.decision.command, self.robot.snapshot.stamp
            if not decision.stops and now - said.end > MAX_OBEYED_AGE_S:
                why = f"understood {now - said.end:.1f} s after it was said"
                continue
            right = (command.name, command.numbers) == (intended.name, intended.numbers)
            read = self._ears.reading(ended, now)
            heard = SentenceOutcome(
                number=None, call=call, said=said.said, tries=attempt, ended=ended, understood=now, read=read
            )
            if not right:
                why = f"heard “{decision.echo}”"
                if not spec_of(command.name).moves:
                    continue  # it stands: no wrong motion
            if decision.waits and self._rejects(right, watch):
                rescued += [] if right else [decision.echo]
                continue
            if not right:
                wrong.append(decision.echo)
                break
            return self._obey(dataclasses.replace(heard, rescued=tuple(rescued)), command)
        missed = SentenceOutcome(number=None, call=call, why=why, tries=tries)
        return dataclasses.replace(missed, wrong=tuple(wrong), rescued=tuple(rescued))

    def _typed(self, words: str, watch: Watch, pcm: bytes | None) -> SentenceOutcome:
        """A voice is heard, and its words are typed."""
        command = understand(words)
        if isinstance(command, Refusal):
            raise Refused(command.reason)
        voice = 8000 * practice_voice(self.chance, 1.2, RATE_HZ)
        begun = self.robot.snapshot.stamp
        ended = self._utter(voice.clip(-32768, 32767).astype("<i2").tobytes() if pcm is None else pcm)
        _, voices = self._hear(max(LISTEN_S, ended + LISTEN_S / 2 - begun), watch)
        call, now = call_of(voices, begun, ended), self.robot.snapshot.stamp
        heard = SentenceOutcome(number=None, call=call, said=(begun, ended), ended=ended, understood=now)
        return self._obey(heard, command)

    def _obey(self, heard: SentenceOutcome, command: Command) -> SentenceOutcome:
        heard = dataclasses.replace(heard, begun=self.robot.snapshot.stamp)
        command = dataclasses.replace(command, call=heard.call, said=heard.said)
        try:
            number = self.robot.begin(command, "ears")
        except Refused as refused:
            return dataclasses.replace(heard, why=str(refused))
        return dataclasses.replace(heard, number=number)

    def _rejects(self, right: bool, watch: Watch) -> bool:
        """Wait until the command begins → whether a STOP was heard: Ann says it when the command is wrong."""
        now = self.robot.snapshot.stamp
        objects, moment = now + REACTION_TIME_S, ConfirmationDelay.from_now(now)
        for snapshot, spoken in self.overheard(CONFIRMATION_DELAY_S + MAX_POSTPONED_S):
            watch(snapshot)
            if not right and snapshot.stamp >= objects:
                self._say(STOP_MOVING.words[0])
                objects = math.inf
            if any(one.decision.stops for one in spoken):
                for _ in self.overheard(REST_S):
                    pass
                return True
            if snapshot.hearing is not None and snapshot.hearing.speaking:
                moment = moment.while_speaking(snapshot.stamp)
            if snapshot.stamp >= moment.begins:
                break
        return False

    def _say(self, words: str) -> float:
        """Ann says it with a synthetic voice → when [s] she will have said it."""
        easy = VoiceSettings(voice=PERSONS_VOICE, speed=int(self.chance.choice(SPEEDS_WORDS_MIN)))
        sound = speak(words, self._voice or easy)
        return self._utter(pcm_of(sound), sound.rate)

    def _utter(self, pcm: bytes, rate: int = RATE_HZ) -> float:
        """Sound out of Ann's mouth, 16-bit samples → when [s] the last of it that is not faint will have left it."""
        length = length_of_words(pcm, rate)
        self.robot.robot.ask(Speak(id=ANN, pcm=pcm, rate_hz=rate))
        return self.robot.snapshot.stamp + length

    def _hear(
        self, seconds: float, watch: Watch = lambda _: None, *, early: bool = False
    ) -> tuple[RecognizedUtterance | None, tuple[VoiceDirection, ...]]:
        """Listen for so long, or until a command was understood → it, and the voices of the last moments; what was
        heard just before is listened to, too.

        `early`: a STOP before the end of the sentence is enough. Else it stops what stands, and listening goes on.
        """
        voices = dict[int, VoiceDirection]()
        if self._ears is not None:
            self._ears.begin()
        for snapshot, spoken in self.overheard(seconds):
            watch(snapshot)
            heard = snapshot.hearing.voices if snapshot.hearing else ()
            voices |= {voice.id: voice for voice in heard}
            for said in spoken:
                if said.decision.command is not None and (said.final or early):
                    return said, tuple(voices.values())
        return None, tuple(voices.values())

    def overheard(self, seconds: float) -> Iterator[tuple[Snapshot, tuple[RecognizedUtterance, ...]]]:
        """The frames of the next so many seconds, each with what became of words that were understood in it."""
        for snapshot in self.robot.frames(seconds):
            speaking = snapshot.hearing is not None and snapshot.hearing.speaking
            yield snapshot, () if self._ears is None else self._ears.heard(snapshot.stamp, speaking)

    def measure(self, x: float, y: float) -> Watch:
        """Return a watcher that records the errors of every sense against the person's true position."""

        def watch(snapshot: Snapshot) -> None:
            person, truth = snapshot.person, snapshot.truth
            if person is None or truth is None or snapshot.stamp - person.stamp > 0.05:
                return
            known: Pose = snapshot.estimate.pose
            place: Array = known.apply(truth.inverse().apply(np.array([[x, y]])))[0]
            if person.laser is not None and "laser" in person.used:
                self.errors["laser_m"].append(float(np.hypot(*(person.laser - place))))
            if person.camera is not None and "camera" in person.used:
                ray = person.camera
                self.errors["camera_rad"].append(wrap(ray.azimuth - math.atan2(place[1] - ray.y, place[0] - ray.x)))
            self.errors["fused_m"].append(float(np.hypot(*(person.position - place))))

        return watch


def call_of(voices: Sequence[VoiceDirection], begin: float, end: float) -> VoiceBearing | None:
    """From where words came that were spoken from `begin` to `end` [s]."""
    voice = voice_between(voices, begin, end)
    return None if voice is None else voice.call


def length_of_words(pcm: bytes, rate: int) -> float:
    """16-bit samples → how long [s] until the last of them that is not faint. Raises BadInput for silence."""
    loud = np.abs(np.frombuffer(pcm, "<i2").astype(float))
    if not loud.any():
        raise BadInput("There is nothing to be heard in this sound; record the words again.")
    return float(np.flatnonzero(loud > FAINT_SHARE * loud.max())[-1] + 1) / rate
