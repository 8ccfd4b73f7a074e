"""A tour of the laboratory by commands only: error of the estimate, compared with dead reckoning."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import NotRequired, TypedDict

import numpy as np

from core.experiments.plan import About, ExperimentPlan, RunBatch
from core.experiments.rehearsal import Rehearsal
from core.experiments.result import ExperimentResult, stored
from core.geometry import Pose
from core.message import Array
from core.settings import Settings
from core.slam.consistency import nees
from core.slam.estimate import Estimate
from core.snapshot import Snapshot

DEFAULT_MINUTES = 5.0

ABOUT = About(
    title="A tour of the laboratory by commands only",
    reproduces="The chapter's claim that the map keeps the robot where dead reckoning loses it. It prints no figures "
    "for such a drive.",
    runs=1,
    counts="tours",
    base_s=0.0,
    run_s=110.0,
    swept=(
        "estimators.ekf_slam.mean_error_m",
        "estimators.ekf_slam.worst_error_m",
        "estimators.ekf_slam.nees_mean",
        "contacts",
    ),
)
ROUTE = (
    "turn left",
    "turn right",
    "stop at 2 and 0",
    "stop at 3 and 1.5",
    "stop at 2.4 and 3",
    "turn left",
    "stop at 0.8 and 2.2",
    "stop at -0.6 and 1.2",
    "stop at -1.8 and 0.4",
    "turn right",
    "stop at -1 and -1.5",
    "stop at 1.5 and -2",
    "turn left",
    "continue 0.5 meters",
    "stop at 0 and 0",
)
"""Sentences that lead once around `sim:lab`; said again from the start until the time is up."""


class TourErrors(TypedDict):
    """The errors of one estimator, as JSON."""

    mean_error_m: float
    worst_error_m: float
    nees_mean: NotRequired[float]  # 3 degrees of freedom: ideal 3


class TourEstimators(TypedDict):
    """Both estimators, as JSON."""

    ekf_slam: TourErrors
    dead_reckoning: TourErrors


class ScoreFigures(TypedDict):
    """Errors against the truth, as JSON."""

    path_m: float
    estimators: TourEstimators


class TourFigures(ScoreFigures):
    """One tour, as JSON; `contacts` and `faults` (what the trace checker says) ought to be 0 and empty."""

    seed: int
    duration_s: float
    commands: int
    ends: dict[str, int]  # how many commands ended in which state
    landmarks: int
    contacts: int
    faults: list[str]


class TourResult(ExperimentResult):
    """The result, as JSON."""

    runs: int
    estimators: TourEstimators
    contacts: int
    faults: list[str]
    tours: list[TourFigures]


def tour(seed: int, minutes: float = DEFAULT_MINUTES, settings: Settings | None = None) -> TourFigures:
    """One tour → its figures."""
    rehearsal = Rehearsal("sim:lab", seed=seed, settings=settings)
    score = TourScore()
    ends: dict[str, int] = {}
    sentences = 0
    while rehearsal.snapshot.stamp < 60 * minutes:
        number = rehearsal.tell(ROUTE[sentences % len(ROUTE)])
        sentences += 1
        while rehearsal.ended(number) is None and rehearsal.snapshot.stamp < 60 * minutes:
            score.add(rehearsal.step())
    for ended in rehearsal.endings:
        ends[ended.state] = ends.get(ended.state, 0) + 1
    return {
        "seed": seed,
        "duration_s": rehearsal.snapshot.stamp,
        "commands": sentences,
        "ends": ends,
        **score.figures(),
        "landmarks": len(rehearsal.snapshot.landmarks),
        "contacts": rehearsal.contacts,
        "faults": rehearsal.faults(),
    }


class TourScore:
    """Gathers errors against the truth, frame by frame."""

    def __init__(self) -> None:
        self._errors: list[tuple[float, float]] = []
        self._nees: list[float] = []
        self._path = 0.0
        self._last: Pose | None = None

    def add(self, snapshot: Snapshot) -> None:
        """One frame."""
        truth = snapshot.truth
        if truth is None:
            return
        self._errors.append((_gap(snapshot.estimate, truth), _gap(snapshot.dead_reckoning, truth)))
        self._nees.append(nees(snapshot.estimate, truth))
        if self._last is not None:
            self._path += truth.distance_to(self._last.x, self._last.y)
        self._last = truth

    def figures(self) -> ScoreFigures:
        """Errors [m] of both estimators, mean NEES, path [m]."""
        errors = np.array(self._errors)
        return {
            "path_m": self._path,
            "estimators": {
                "ekf_slam": {**_errors(errors[:, 0]), "nees_mean": float(np.nanmean(self._nees))},
                "dead_reckoning": _errors(errors[:, 1]),
            },
        }


def _gap(estimate: Estimate, truth: Pose) -> float:
    return truth.distance_to(estimate.pose.x, estimate.pose.y)


def _errors(gaps: Array) -> TourErrors:
    return {"mean_error_m": float(gaps.mean()), "worst_error_m": float(gaps.max())}


def _over(tours: Sequence[TourErrors]) -> TourErrors:
    both: TourErrors = {
        "mean_error_m": float(np.mean([one["mean_error_m"] for one in tours])),
        "worst_error_m": max(one["worst_error_m"] for one in tours),
    }
    if nees_means := [one["nees_mean"] for one in tours if "nees_mean" in one]:
        both["nees_mean"] = float(np.mean(nees_means))
    return both


def plan(
    *, runs: int | None = None, seed: int = 0, settings: Settings | None = None, minutes: float = DEFAULT_MINUTES
) -> ExperimentPlan:
    """Plan `runs` tours (1) with seeds from `seed` on, and tour.json."""
    batch = RunBatch(partial(_work, seed, minutes, settings), runs or 1, TourFigures)
    return ExperimentPlan((batch,), partial(_result, seed))


def _work(seed: int, minutes: float, settings: Settings | None, number: int) -> TourFigures:
    return tour(seed + number, minutes, settings)


def _result(seed: int, out: Path | None, tours: list[TourFigures]) -> TourResult:
    both: TourEstimators = {
        "ekf_slam": _over([one["estimators"]["ekf_slam"] for one in tours]),
        "dead_reckoning": _over([one["estimators"]["dead_reckoning"] for one in tours]),
    }
    result: TourResult = {
        "runs": len(tours),
        "seed": seed,
        "estimators": both,
        "contacts": sum(one["contacts"] for one in tours),
        "faults": [fault for one in tours for fault in one["faults"]],
        "tours": tours,
        "files": {},
    }
    return stored(result, out, "tour")
