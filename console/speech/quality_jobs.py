"""Jobs of the worker that measures the recognition of voices, and its answers."""

import msgspec

from console.workers.job import Job
from core.simulation.settings import MicrophoneSettings
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


class QualityRow(msgspec.Struct, frozen=True, kw_only=True):
    """The figures of one place; those that are unset were not measured."""

    distance_m: float
    snr_db: float
    refused: str  # why nobody can speak from there
    stoi: float | msgspec.UnsetType | None = msgspec.UNSET
    estoi: float | msgspec.UnsetType | None = msgspec.UNSET
    si_sdr_db: float | msgspec.UnsetType | None = msgspec.UNSET
    words: int | msgspec.UnsetType = msgspec.UNSET
    erroneous_words_person: int | msgspec.UnsetType = msgspec.UNSET
    erroneous_words_robot: int | msgspec.UnsetType = msgspec.UNSET
    osqe_d: float | msgspec.UnsetType | None = msgspec.UNSET
    osqe_r: float | msgspec.UnsetType | None = msgspec.UNSET
    reason: str | msgspec.UnsetType | None = msgspec.UNSET  # why a figure is undefined
    verdict: str | msgspec.UnsetType | None = msgspec.UNSET
    commands: int | msgspec.UnsetType = msgspec.UNSET
    commands_exact: int | msgspec.UnsetType = msgspec.UNSET


class BegunQuality(msgspec.Struct, frozen=True):
    """A run that is prepared."""

    places: list[QualityRow]  # nothing is measured there yet
    voice: str


class MeasuredQuality(msgspec.Struct, frozen=True):
    """A place that was measured."""

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
    """Measure one of the places."""

    number: int
