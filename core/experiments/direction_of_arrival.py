"""Accuracy of voice directions in rooms, noise and next to a fan: our method and the paper's on the same sounds.

All know the same: when the speech begins, so that half a second before it is noise. With `_alone` nobody knows that.
"""

import math
import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import NotRequired, TypedDict

import numpy as np

from core.experiments.plan import About, ExperimentPlan, RunBatch
from core.experiments.result import ExperimentResult, as_csv, grouped, stored
from core.experiments.talk_in_rooms import PRE_ROLL_S, RATE_HZ, AcousticScene, make_scene
from core.geometry import wrap
from core.message import Array, message
from core.perception.sound.locate import locate, sure
from core.perception.sound.paper import locate_as_printed
from core.perception.sound.settings import DirectionFindingSettings
from core.sensors.microphones import RESPEAKER_ODAS, MicrophoneArray, Sound, tetrahedron
from core.settings import Settings
from core.speech.practice_voice import practice_voice

ARRAYS = {"square": RESPEAKER_ODAS, "tetrahedron": tetrahedron()}
REVERBERATION_TIMES_S = (0.0, 0.2, 0.3, 0.6)
NOISES = (("diffuse", 20.0), ("diffuse", 10.0), ("diffuse", 0.0), ("fan", 10.0), ("fan", 0.0))  # [dB]
SPEECH_S = 2.0  # of every utterance
FIRST_REPORT_S = 0.35  # of speech after which the robot reports a direction
MISLEADING_RAD = math.radians(10)  # beyond, a direction misleads
LOST_ERROR_RAD = math.pi / 2  # the mean error of a guess; counted where nothing was found
DEFAULT = DirectionFindingSettings()

ABOUT = About(
    title="Directions of voices",
    reproduces="Equations 34-40 as printed and ours, on the same voices in rooms, noise and beside a fan. The "
    "chapter prints no figures for them.",
    runs=240,
    counts="utterances",
    base_s=4.0,
    run_s=0.08,
    swept=(
        "estimators.beckon.all.median_deg",
        "estimators.beckon.all.p95_deg",
        "estimators.beckon.all.beyond_10_deg",
        "estimators.beckon.all.declared",
        "estimators.beckon_alone.all.median_deg",
    ),
)

CONDITIONS = "all know when the speech begins and that 0.5 s before it is noise, but for those named _alone"


@message
class DirectionEstimate:
    """The answer of an estimator for one sound."""

    azimuth: float | None  # [rad]
    sd: float | None = None  # [rad]
    declared: bool = True


Estimator = Callable[[Sound, MicrophoneArray], DirectionEstimate]


def ours(sound: Sound, array: MicrophoneArray, settings: DirectionFindingSettings = DEFAULT) -> DirectionEstimate:
    """The default."""
    found = locate(sound, array, speech_from=PRE_ROLL_S, settings=settings)
    if found is None:
        return DirectionEstimate(azimuth=None, declared=False)
    return DirectionEstimate(azimuth=found.azimuth, sd=found.azimuth_sd, declared=sure(found, settings))


def ours_at_once(
    sound: Sound, array: MicrophoneArray, settings: DirectionFindingSettings = DEFAULT
) -> DirectionEstimate:
    """The default, with the first 0.35 s of speech only."""
    return ours(sound.part(0.0, PRE_ROLL_S + FIRST_REPORT_S), array, settings)


def ours_alone(
    sound: Sound, array: MicrophoneArray, settings: DirectionFindingSettings = DEFAULT
) -> DirectionEstimate:
    """The default where nobody knows when the speech begins: the quietest moments are taken for noise."""
    found = locate(sound, array, settings=settings)
    return DirectionEstimate(azimuth=None if found is None else found.azimuth)


def printed(sound: Sound, array: MicrophoneArray, speech_from: float | None = PRE_ROLL_S) -> DirectionEstimate:
    """The paper's way; `speech_from` None: nobody knows when the speech begins."""
    return DirectionEstimate(azimuth=locate_as_printed(sound, array, speech_from).azimuth)


def estimators_with(settings: DirectionFindingSettings) -> dict[str, Estimator]:
    """Every estimator by name, ours with these settings."""
    return {
        "beckon": partial(ours, settings=settings),
        "as_printed": printed,
        "beckon_first_0.35_s": partial(ours_at_once, settings=settings),
        "beckon_alone": partial(ours_alone, settings=settings),
        "as_printed_alone": partial(printed, speech_from=None),
    }


@message
class DirectionTrial:
    """One sound and one answer."""

    estimator: str
    array: str
    rt60: float  # [s]
    noise: str
    ratio: float  # [dB]
    error: float  # [rad]
    sd: float | None  # [rad]
    declared: bool
    took: float  # [s] of the processor for one second of sound


def trials(
    scene: AcousticScene, estimators: Mapping[str, Estimator], noises: Sequence[tuple[str, float]] = NOISES
) -> list[DirectionTrial]:
    """Every estimator on every array and noise of one scene."""
    truth = math.atan2(scene.towards[1], scene.towards[0])
    done: list[DirectionTrial] = []
    for number, (name, array) in enumerate(ARRAYS.items()):
        for noise, ratio in noises:
            sound = scene.sound(number, noise, ratio)
            for estimator, answer in estimators.items():
                began = time.process_time()
                said = answer(sound, array)
                took = (time.process_time() - began) / sound.duration
                error = LOST_ERROR_RAD if said.azimuth is None else abs(wrap(said.azimuth - truth))
                done.append(
                    DirectionTrial(
                        estimator=estimator,
                        array=name,
                        rt60=scene.rt60,
                        noise=noise,
                        ratio=ratio,
                        error=error,
                        sd=said.sd,
                        declared=said.declared,
                        took=took,
                    )
                )
    return done


class DirectionFigures(TypedDict):
    """The figures of some trials, as JSON; those of declared ones only where there are any."""

    utterances: int
    median_deg: float
    p95_deg: float
    beyond_10_deg: float  # share
    real_time_factor: float
    declared: NotRequired[float]  # share
    declared_beyond_10_deg: NotRequired[float]
    within_1_sd: NotRequired[float]
    within_2_sd: NotRequired[float]
    median_sd_deg: NotRequired[float]


class EstimatorTotals(TypedDict):
    """The figures of one estimator, as JSON."""

    all: DirectionFigures
    arrays: dict[str, DirectionFigures]
    noises: dict[str, DirectionFigures]


class DirectionResult(ExperimentResult):
    """The result, as JSON."""

    utterances: int
    voice: str
    conditions: str
    estimators: dict[str, EstimatorTotals]


class DirectionCells(DirectionResult):
    """The same with every cell of the grid, as it is written down."""

    cells: dict[str, dict[str, DirectionFigures]]  # by estimator


def figures(some: Sequence[DirectionTrial]) -> DirectionFigures:
    """Errors [deg] of some trials, and how many declared ones lie within two standard deviations."""
    errors = np.degrees([one.error for one in some])
    result: DirectionFigures = {
        "utterances": len(some),
        "median_deg": float(np.median(errors)),
        "p95_deg": float(np.percentile(errors, 95)),
        "beyond_10_deg": float(np.mean(errors > math.degrees(MISLEADING_RAD))),
        "real_time_factor": float(np.median([one.took for one in some])),
    }
    declared = [(one.error, one.sd) for one in some if one.declared and one.sd is not None]
    if declared:
        ratio = np.array([error / sd for error, sd in declared])
        wrong = np.mean([error > MISLEADING_RAD for error, _ in declared])
        result.update(
            {
                "declared": len(declared) / len(some),
                "declared_beyond_10_deg": float(wrong),
                "within_1_sd": float(np.mean(ratio < 1)),
                "within_2_sd": float(np.mean(ratio < 2)),
                "median_sd_deg": math.degrees(float(np.median([sd for _, sd in declared]))),
            }
        )
    return result


def scenes_for(utterances: int) -> int:
    """The number of rooms that gives at least so many sounds."""
    return max(len(REVERBERATION_TIMES_S), math.ceil(utterances / (len(ARRAYS) * len(NOISES))))


class RoomTrials(TypedDict):
    """All trials in one room, as JSON."""

    trials: list[DirectionTrial]


def in_room(
    seed: int,
    number: int,
    *,
    estimators: Mapping[str, Estimator] | None = None,
    voices: Sequence[Array] = (),
    settings: DirectionFindingSettings = DEFAULT,
) -> RoomTrials:
    """All arrays and noises in the room of that number; reverberations come in turn.

    `voices` (N,) at 16 kHz are drawn from; without any, a voice is made up. `settings` are those of the default.
    """
    rng = np.random.default_rng([seed, number])
    made = practice_voice(rng, SPEECH_S, RATE_HZ)
    voice = voices[int(rng.integers(len(voices)))][: int(SPEECH_S * RATE_HZ)] if voices else made
    scene = make_scene(rng, REVERBERATION_TIMES_S[number % len(REVERBERATION_TIMES_S)], voice, list(ARRAYS.values()))
    return {"trials": trials(scene, estimators or estimators_with(settings))}


def summary(done: Sequence[DirectionTrial]) -> dict[str, EstimatorTotals]:
    """Figures of every estimator: all, per array, and per noise."""
    return {
        estimator: {
            "all": figures(own),
            "arrays": _figures_by(own, lambda one: one.array),
            "noises": _figures_by(own, lambda one: f"{one.noise} {one.ratio:g} dB"),
        }
        for estimator, own in grouped(done, lambda one: one.estimator).items()
    }


def _figures_by(done: Sequence[DirectionTrial], key: Callable[[DirectionTrial], str]) -> dict[str, DirectionFigures]:
    return {name: figures(some) for name, some in grouped(done, key).items()}


def plan(*, runs: int | None = None, seed: int = 0, settings: Settings | None = None) -> ExperimentPlan:
    """Plan `runs` utterances (240) in made-up rooms, with direction.json and direction.csv."""
    work = partial(in_room, seed, settings=DEFAULT if settings is None else settings.direction_finding)
    batch = RunBatch(work, scenes_for(runs or ABOUT.runs), RoomTrials)
    return ExperimentPlan((batch,), partial(_result, seed))


def _result(seed: int, out: Path | None, rooms: list[RoomTrials]) -> DirectionResult:
    done = [one for room in rooms for one in room["trials"]]
    totals = summary(done)
    result: DirectionResult = {
        "utterances": totals["beckon"]["all"]["utterances"],
        "seed": seed,
        "voice": "made up: pulses and hiss through resonances",
        "conditions": CONDITIONS,
        "estimators": totals,
        "files": {},
    }
    cells = {
        name: _figures_by(own, lambda one: f"{one.array} rt60 {one.rt60:g} s {one.noise} {one.ratio:g} dB")
        for name, own in grouped(done, lambda one: one.estimator).items()
    }
    whole: DirectionCells = {**result, "cells": cells}
    result["files"] = stored(whole, out, "direction", {"csv": ("direction.csv", as_csv(rows_of(done)))})["files"]
    return result


def rows_of(done: Sequence[DirectionTrial]) -> list[dict[str, object]]:
    """Every single trial, for a table."""
    return [
        {
            "estimator": one.estimator,
            "array": one.array,
            "rt60_s": one.rt60,
            "noise": one.noise,
            "snr_db": one.ratio,
            "error_deg": f"{math.degrees(one.error):.4g}",
            "sd_deg": "" if one.sd is None else f"{math.degrees(one.sd):.4g}",
            "declared": int(one.declared),
            "real_time_factor": f"{one.took:.3g}",
        }
        for one in done
    ]
