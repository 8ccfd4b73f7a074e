"""Jobs of the worker that measures the recognition of voices, and its answers."""

from __future__ import annotations

import msgspec

from console.workers.job import Job
from core.simulation.microphones import MicrophoneSettings
from core.speech.settings import SpeechSettings


class QualityWish(msgspec.Struct, frozen=True):
    """What is measured: every pair of a distance and a ratio, from where the robot stands in the world."""

    world: str
    x_m: float  # world
    y_m: float
    heading_rad: float
    towards_rad: float  # of the world: where people speak
    distances_m: list[float]
    snr_db: list[float]  # a voice at 1 m over the room's noise
    phrases: int


class QualityPlace(msgspec.Struct, frozen=True):
    """A place of the speaker, and why nobody can speak from there or ""."""

    distance_m: float
    snr_db: float
    refused: str


class BegunQuality(msgspec.Struct, frozen=True):
    """A run that is prepared."""

    places: list[QualityPlace]
    voice: str


class QualityFigures(QualityPlace, frozen=True):
    """The figures of a place."""

    stoi: float | None
    estoi: float | None
    si_sdr_db: float | None
    words: int
    erroneous_words_person: int
    erroneous_words_robot: int
    osqe_d: int
    osqe_r: float | None
    reason: str
    verdict: str
    commands: int
    commands_exact: int


class MeasuredQuality(msgspec.Struct, frozen=True):
    """A place that was measured."""

    row: QualityFigures
    page: str  # HTML


class BeginQuality(Job[BegunQuality], frozen=True):
    """Prepare a run. Raises BadInput, Unavailable."""

    wish: QualityWish
    ears: MicrophoneSettings
    speech: SpeechSettings


class ListenClose(Job[str], frozen=True):
    """Recognize the text as the person's own microphone hears it."""


class MeasureQuality(Job[MeasuredQuality], frozen=True):
    """Measure one of the places."""

    number: int
