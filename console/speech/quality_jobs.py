"""Jobs of the worker that measures the recognition of voices, and its answers."""

import msgspec

from console.workers.job import Job
from core.simulation.settings import MicrophoneSettings
from core.speech.quality.report import QualityRow
from core.speech.settings import SpeechSettings


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


class BeginQuality(Job[BegunQuality], frozen=True):
    """Prepare a run. Raises BadInput, Unavailable."""

    setup: QualitySetup
    ears: MicrophoneSettings
    speech: SpeechSettings


class ListenClose(Job[str], frozen=True):
    """Recognize the text as the person's own microphone hears it."""


class MeasureQuality(Job[MeasuredQuality], frozen=True):
    number: int
