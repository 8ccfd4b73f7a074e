"""Gain of each difference from the printed direction finding: ours, each time without one of them.

The sounds are those of `direction-of-arrival` with the same seed. What comes in piece by piece stands beside itself
with and without tracking.
"""

import math
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from core.experiments.direction_of_arrival import (
    CONDITIONS,
    DEFAULT,
    DirectionEstimate,
    Estimator,
    EstimatorTotals,
    RoomTrials,
    in_room,
    ours,
    scenes_for,
    summary,
)
from core.experiments.plan import About, ExperimentPlan, RunBatch
from core.experiments.result import ExperimentResult, stored
from core.experiments.talk_in_rooms import PRE_ROLL_S
from core.perception.sound.doa_stream import DoaStream
from core.perception.sound.locate import direction_of
from core.perception.sound.settings import DirectionFindingSettings
from core.perception.sound.spectra import noise_of, quiet_frames, spectra
from core.perception.sound.tracking import VoiceTracker
from core.sensors.microphones import MicrophoneArray, Sound

PIECE_S = 0.1  # of sound at a time, as it comes in

ABOUT = About(
    title="Directions of voices, part by part",
    reproduces="Equations 34-40: what the mask, the whitening, the judgement of misfit and the tracking each gain "
    "over leaving them out. The chapter prints no figures for them.",
    runs=240,
    counts="utterances",
    base_s=4.0,
    run_s=0.25,
)


class AblationResult(ExperimentResult):
    """The result, as JSON."""

    utterances: int
    conditions: str
    estimators: dict[str, EstimatorTotals]


def ours_without_mask(sound: Sound, array: MicrophoneArray, settings: DirectionFindingSettings) -> DirectionEstimate:
    """The default in which every cell of the speech counts alike, and no noise is taken away."""
    seen = spectra(array.heard(sound), sound.rate, settings)
    noise = noise_of(seen, quiet_frames(seen, settings, PRE_ROLL_S), settings)
    speech = np.ones((len(seen.frequencies), 1)) * (seen.times > PRE_ROLL_S)
    found = direction_of(seen, speech, replace(noise, cross=0 * noise.cross), array, 0.0, settings)
    return DirectionEstimate(azimuth=None if found is None else found.azimuth)


def ours_while_heard(
    sound: Sound, array: MicrophoneArray, settings: DirectionFindingSettings, tracked: bool
) -> DirectionEstimate:
    """The default while the sound comes in: its last report, or the tracked voice then."""
    stream, tracker = DoaStream(array, settings), VoiceTracker()
    azimuth: float | None = None
    for begin in np.arange(0.0, sound.duration, PIECE_S).tolist():
        for heard in stream.feed(sound.part(begin, begin + PIECE_S)):
            voices = tracker.update(heard.directions, begin)
            if tracked and voices:
                azimuth = voices[0].bearing
            elif heard.directions and not tracked:
                azimuth = heard.directions[0].azimuth
    return DirectionEstimate(azimuth=azimuth)


def ablated() -> dict[str, Estimator]:
    """Ours, and ours without one of its differences from the print each."""
    return {
        "beckon": partial(ours, settings=DEFAULT),
        "without_mask": partial(ours_without_mask, settings=DEFAULT),
        "phases_alone": partial(ours, settings=replace(DEFAULT, whitening=1.0)),
        "any_misfit": partial(ours, settings=replace(DEFAULT, declared_misfit=math.inf)),
        "last_report": partial(ours_while_heard, settings=DEFAULT, tracked=False),
        "tracked": partial(ours_while_heard, settings=DEFAULT, tracked=True),
    }


def plan(*, runs: int | None = None, seed: int = 0) -> ExperimentPlan:
    """Plan `runs` utterances (240) in made-up rooms."""
    work = partial(in_room, seed, estimators=ablated())
    return ExperimentPlan((RunBatch(work, scenes_for(runs or ABOUT.runs), RoomTrials),), partial(_result, seed))


def _result(seed: int, out: Path | None, rooms: list[RoomTrials]) -> AblationResult:
    totals = summary([one for room in rooms for one in room["trials"]])
    result: AblationResult = {
        "utterances": totals["beckon"]["all"]["utterances"],
        "seed": seed,
        "conditions": CONDITIONS,
        "estimators": totals,
        "files": {},
    }
    return stored(result, out, "direction_ablation")
