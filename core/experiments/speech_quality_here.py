"""Measure how well a person is understood here: a text spoken at several distances and noise levels around the robot.

The same loop as in `core.experiments.speech_quality`, but in the room that the robot stands in: its walls, its
reverberation, its microphones. One step at a time, so that it can be watched and given up.
"""

import math
from collections.abc import Sequence

import msgspec
import numpy as np

from core.errors import BadInput, Unavailable
from core.experiments.speech_quality import TEXT, SpokenPhrase, close_by, measure, speaker_of, spoken
from core.geometry import Pose
from core.message import Array, message
from core.simulation.acoustics.enclosure import enclosure, in_sight
from core.simulation.acoustics.shoebox import impulse_responses
from core.simulation.microphones import RATE_HZ, SimulatedMicrophones
from core.simulation.settings import MicrophoneSettings
from core.simulation.world import world_named
from core.speech.quality.report import QualityRow, page
from core.speech.recognition.engines import open_dictation
from core.speech.recognition.recognizer import Dictation
from core.speech.settings import SpeechSettings
from core.speech.synthesis import NO_VOICE, can_speak

MOUTH_HEIGHT_M = 1.55  # above the floor
MIN_DISTANCE_M, MAX_DISTANCE_M = 0.3, 12.0  # of a mouth from the robot
MOST_PLACES = 20
MOST_PHRASES = 36


@message
class SpeakingPlace:
    """A place of the speaker, and the noise level of the room."""

    distance: float  # [m] on the floor
    ratio: float  # [dB] a voice at 1 m over the room's noise
    mouth: Array  # (3,) [m] in the world
    refused: str = ""  # why no person can speak from there

    @property
    def row(self) -> QualityRow:
        """Its row, before anything is measured there."""
        return QualityRow(distance_m=self.distance, snr_db=self.ratio, refused=self.refused)


class SpeechQualityHere:
    """One run, from the first phrase to the last place."""

    def __init__(
        self,
        world: str,
        pose: Pose,
        towards: float,
        distances: Sequence[float],
        ratios: Sequence[float],
        *,
        phrases: int = 18,
        seed: int = 0,
        ears: MicrophoneSettings | None = None,
        speech: SpeechSettings | None = None,
    ) -> None:
        """The robot stands at `pose` in the world of that name; people speak `towards` [rad] of the world from it.

        Raises BadInput, and Unavailable where there is no voice, no recognizer, or no microphone.
        """
        _check(distances, ratios, phrases)
        if not can_speak():
            raise Unavailable(NO_VOICE)
        chosen = ears or MicrophoneSettings()
        if chosen.array is None:
            raise Unavailable("This simulated robot is deaf: it has no microphones.")
        self._world, self._pose, self._seed, self._rt60 = world_named(world), pose, seed, chosen.reverberation
        self._ear = SimulatedMicrophones(chosen.array, chosen, np.random.SeedSequence(seed)).ears(pose)[:1]
        self._dictation: Dictation = open_dictation(speech or SpeechSettings())
        texts = [TEXT[number % len(TEXT)] for number in range(phrases)]
        self._said: list[SpokenPhrase] = spoken(np.random.default_rng(seed), texts)
        self.voice = speaker_of(self._said)
        self.places = tuple(self._place(towards, distance, ratio) for ratio in ratios for distance in distances)
        self.person = ""  # what the person's own microphone made of it

    def listen_close(self) -> str:
        """The person's path: the text into a microphone at the mouth → what was read."""
        self.person = close_by(self._dictation, self._said, self._seed)
        return self.person

    def measure(self, place: SpeakingPlace) -> tuple[QualityRow, str]:
        """One place → its figures, and the report page. The person's path comes first."""
        if place.refused:
            return place.row, ""
        quality, similarity = measure(
            self._dictation, self._said, self.person, self._responses(place), place.ratio, self._seed
        )
        assert quality is not None  # there is a recognizer
        measured = {**quality.score, **similarity.figures}
        row = msgspec.structs.replace(
            place.row,
            **{name: value for name, value in measured.items() if name in QualityRow.__struct_fields__},
            words=quality.person.words,
            verdict=quality.verdict,
            commands=len(quality.phrases),
            commands_exact=sum(quality.robot.exact),
        )
        around = {
            "where": f"{self._world.name}, {place.distance:g} m from the robot, {MOUTH_HEIGHT_M:g} m above the floor",
            "noise": f"{place.ratio:g} dB below a voice at 1 m",
            "reverberation": f"RT60 {self._rt60:g} s",
            "voice": self.voice,
        }
        return row, page(quality, similarity, around)

    def _place(self, towards: float, distance: float, ratio: float) -> SpeakingPlace:
        x, y = self._pose.x + distance * math.cos(towards), self._pose.y + distance * math.sin(towards)
        mouth = np.array([x, y, MOUTH_HEIGHT_M])
        refused = ""
        if not self._world.open_air(mouth[None]):
            refused = "A wall or a thing is in the way there."
        elif not in_sight(self._world, self._ear[0], mouth):
            refused = "That is behind a wall of the room that the robot is in."
        return SpeakingPlace(distance=distance, ratio=ratio, mouth=mouth, refused=refused)

    def _responses(self, place: SpeakingPlace) -> Array:
        """Impulse response from a mouth there to the robot's first microphone, (1, L)."""
        box = enclosure(self._world, np.vstack((self._ear, place.mouth)), self._rt60)
        inside = box.inside(np.vstack((place.mouth, self._ear)))
        return impulse_responses(box.room, inside[0], inside[1:], RATE_HZ, np.random.default_rng(1))


def _check(distances: Sequence[float], ratios: Sequence[float], phrases: int) -> None:
    if not distances or not ratios or len(distances) * len(ratios) > MOST_PLACES:
        raise BadInput(
            f"Choose at least one distance and one noise level, and at most {MOST_PLACES} of both together."
        )
    if not all(MIN_DISTANCE_M <= one <= MAX_DISTANCE_M for one in distances):
        raise BadInput(f"Distances must lie between {MIN_DISTANCE_M:g} and {MAX_DISTANCE_M:g} m.")
    if not all(-10 <= one <= 60 for one in ratios):
        raise BadInput("A voice must lie between 10 dB below and 60 dB above the noise.")
    if not 1 <= phrases <= MOST_PHRASES:
        raise BadInput(f"1 to {MOST_PHRASES} phrases can be spoken.")
