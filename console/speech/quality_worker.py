"""The worker that measures the recognition of voices: minutes of decoding, and killed when given up."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from console.workers.job import job
from core.geometry import Pose
from core.simulation.settings import MicrophoneSettings
from core.speech.quality.report import QualityRow
from core.speech.settings import SpeechSettings

if TYPE_CHECKING:
    from core.experiments.speech_quality_here import SpeechQualityHere


class QualitySetup(msgspec.Struct, frozen=True):
    """Measurements: every pair of a distance and a ratio, from where the robot stands in the world."""

    world: str
    x_m: float  # world
    y_m: float
    heading_rad: float
    towards_rad: float  # of the world: where people speak
    distances_m: list[float]
    snr_db: list[float]  # a voice at 1 m over the room's noise
    phrases: int


class BegunQuality(msgspec.Struct, frozen=True):
    places: list[QualityRow]  # nothing is measured there yet
    voice: str


class MeasuredQuality(msgspec.Struct, frozen=True):
    row: QualityRow
    page: str  # HTML


class QualityWorker:
    def __init__(self) -> None:
        self._run: SpeechQualityHere | None = None

    @job
    def begin(self, setup: QualitySetup, ears: MicrophoneSettings, speech: SpeechSettings) -> BegunQuality:
        """Prepare a run → the places, and why nobody can speak from some. Raises BadInput, Unavailable."""
        from core.experiments.speech_quality_here import SpeechQualityHere  # late: the console does without

        self._run = SpeechQualityHere(
            setup.world,
            Pose(x=setup.x_m, y=setup.y_m, heading=setup.heading_rad),
            setup.towards_rad,
            setup.distances_m,
            setup.snr_db,
            phrases=setup.phrases,
            ears=ears,
            speech=speech,
        )
        return BegunQuality([one.row for one in self._run.places], self._run.voice)

    @job
    def listen_close(self) -> str:
        """Recognize the text as the person's own microphone hears it."""
        assert self._run is not None
        return self._run.listen_close()

    @job
    def measure(self, number: int) -> MeasuredQuality:
        assert self._run is not None
        return MeasuredQuality(*self._run.measure(self._run.places[number]))
