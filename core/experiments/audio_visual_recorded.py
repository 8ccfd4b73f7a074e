"""Laser, camera and voice from recordings: each drive is recorded, and estimated from the file with each of them.

The drives are those of `audio_visual`; a row is what `beckon slam DRIVE.mcap --sensors …` makes of the file.
"""

from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TypedDict

import numpy as np

from core.experiments import audio_visual
from core.experiments.audio_visual import PLACES, SENSORS, Place, SteeredDrive, settings_for
from core.experiments.plan import About, ExperimentPlan, RunBatch
from core.experiments.result import ExperimentResult, stored
from core.pipelines.record import RobotRecording
from core.pipelines.slam import slam_log
from core.pipelines.slam_result import PositionErrors
from core.settings import Settings

RECORDED_PLACES = tuple(place for place in PLACES if place.name in ("lab", "corridor", "bare corridor", "glass"))

ABOUT = About(
    title="Laser, camera and voice from recordings",
    reproduces="The abstract's claim, from recordings: drives of the simulated robot, steered by the true pose, are "
    "recorded with pictures and sound, and the files estimated with each sensor left out. The positions are those "
    "of the final map. No public recording at hand has a laser, a camera, microphones and a true way.",
    runs=4,
    seed=40,
    counts="drives in every place",
    base_s=0.0,
    run_s=250.0,
    swept=("places.1.rows.laser.mean_error_m", "places.1.rows.all.mean_error_m"),
)


class RecordedRow(TypedDict):
    """A row over all drives, as JSON."""

    mean_error_m: float
    worst_error_m: float  # mean error of the worst drive
    of_laser: float  # mean error as a share of the laser's


class RecordedPlace(TypedDict):
    """The recordings of one place, as JSON."""

    place: str
    weak: str
    megabytes: float  # of one recording, in the mean
    rows: dict[str, RecordedRow]


class RecordedDrive(TypedDict):
    """One recording: its size, and the errors of every row."""

    megabytes: float
    errors: dict[str, PositionErrors]


class AudioVisualRecorded(ExperimentResult):
    """The result, as JSON."""

    runs: int
    seconds_each: float
    places: list[RecordedPlace]


def record(place: Place, settings: Settings, seed: int, out: Path) -> None:
    """One drive into a file. Raises Unwritable."""
    steered = SteeredDrive(place, settings, seed)
    recording = RobotRecording(steered.robot, out)
    for _ in steered.frames(recording.add):
        pass
    recording.file.finish()


def recorded_drive(places: tuple[Place, ...], base: Settings, seed: int, runs: int, number: int) -> RecordedDrive:
    """Drive, record, and estimate the file with the sensors of every row."""
    place, run = divmod(number, runs)
    settings = settings_for(places[place], base)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "drive.mcap"
        record(places[place], settings, seed + run, path)
        results = {name: slam_log(path, settings, sensors=sensors) for name, sensors in SENSORS.items()}
        errors = {name: error for name, result in results.items() if (error := result.errors) is not None}
        return {"megabytes": path.stat().st_size / 1e6, "errors": errors}


def plan(*, runs: int | None = None, seed: int = 0, settings: Settings | None = None) -> ExperimentPlan:
    """Plan `runs` drives (4) in every place, with seeds from `seed` on."""
    count = runs or ABOUT.runs
    work = partial(recorded_drive, RECORDED_PLACES, settings or Settings(), seed, count)
    batch = RunBatch(work, count * len(RECORDED_PLACES), RecordedDrive)
    return ExperimentPlan((batch,), partial(_result, seed, count))


def _result(seed: int, count: int, out: Path | None, done: list[RecordedDrive]) -> AudioVisualRecorded:
    figures = [_place(place, done[k * count :][:count]) for k, place in enumerate(RECORDED_PLACES)]
    result: AudioVisualRecorded = {
        "runs": count,
        "seed": seed,
        "seconds_each": audio_visual.MAX_DRIVE_S,
        "places": figures,
        "text": table(figures, count, seed),
        "files": {},
    }
    return stored(result, out, "audio_visual_recorded")


def table(figures: list[RecordedPlace], count: int, seed: int) -> str:
    """The places, one a line, and below each the share of the laser's error."""
    lines = [
        f"Position error of {count} recorded drives [m], mean and worst of the drives; seeds from {seed}",
        f"{'':16}" + "".join(f"{name:>18}" for name in SENSORS),
    ]
    for one in figures:
        rows = [one["rows"][name] for name in SENSORS]
        lines.append(
            f"{one['place']:16}" + "".join(f"{row['mean_error_m']:10.3f}{row['worst_error_m']:8.3f}" for row in rows)
        )
        lines.append(f"{'  of the laser':16}" + "".join(f"{100 * row['of_laser']:16.0f} %" for row in rows))
    return "\n".join(lines)


def _place(place: Place, done: list[RecordedDrive]) -> RecordedPlace:
    means = {name: [one["errors"][name]["mean_m"] for one in done] for name in SENSORS}
    rows: dict[str, RecordedRow] = {
        name: {
            "mean_error_m": float(np.mean(errors)),
            "worst_error_m": max(errors),
            "of_laser": float(np.mean(errors) / np.mean(means["laser"])),
        }
        for name, errors in means.items()
    }
    size = float(np.mean([one["megabytes"] for one in done]))
    return {"place": place.name, "weak": place.weak, "megabytes": size, "rows": rows}
