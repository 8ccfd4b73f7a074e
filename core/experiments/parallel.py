"""Gain of parallel computing: steps of calibration, localization and hearing on 1, 2, 4 … workers.

The chapter tries parallel computing to reach real time and prints no figures. A step has parts that do not wait for
each other, or it has one part, and then no number of workers makes it faster. Inputs are made beforehand and sent to
the workers, which is counted; the start of the workers is not, and stands beside.

The gain is given by the clock, on a computer that may be busy with other things, and by the work: the processor time
of all parts over that of the worker that had most of it, which is what idle processors would allow.
"""

import hashlib
import json
import os
import platform
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypedDict

import numpy as np

from core.calibration.board.chessboard import find_board
from core.calibration.camera.intrinsics import ViewCorners, calibrate
from core.calibration.practice import held, picture
from core.experiments.camera_table import BOARD
from core.experiments.direction_of_arrival import ARRAYS
from core.experiments.paper_course import Draws, Run, mapped
from core.experiments.plan import About, ExperimentPlan, RunBatch
from core.experiments.result import ExperimentResult, stored
from core.experiments.talk_in_rooms import PRE_ROLL_S, RATE_HZ, make_scene
from core.experiments.workers import Workers
from core.message import Array
from core.optics import TABLE_3
from core.perception.landmarks.corners import find_corners
from core.perception.landmarks.deskew import deskew
from core.perception.sound.locate import locate
from core.sensors import Laser, SensorFrame
from core.sensors.microphones import Sound
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import SimulationSettings
from core.slam.ekf_slam import EkfSettings
from core.speech.practice_voice import practice_voice

LEAST_MOST = 4  # workers that are tried at least
PICTURE_COUNT, SCAN_COUNT, DRIVE_COUNT, SOUND_COUNT = 16, 128, 4, 16
SCANS_TOGETHER = 16  # of one part: a scan alone takes less time than its way to a worker
BUSY_SHARE = 0.5  # of the processors, above which the load of others makes times worthless

ABOUT = About(
    title="What runs in parallel, and what it gains",
    reproduces="The abstract's trial of parallel computing for calibration, localization and hearing, on this "
    "computer's processors. The chapter prints no figures.",
    runs=3,
    counts="measurements of every step",
    base_s=3.0,
    run_s=30.0,
)


@dataclass(frozen=True)
class ParallelStep:
    """A step of a room: its parts made from a seed, and the work on one of them → an answer as JSON."""

    room: str
    name: str
    parts: Callable[[int], Sequence[Any]]
    work: Callable[[Any], Any]
    why: str  # its parts wait for each other, or do not


class StepTimes(TypedDict):
    """One measurement of one step, as JSON."""

    step: str
    parts: int
    seconds: dict[str, float]  # by the clock, by the number of workers
    busiest: dict[str, float]  # [s] of processor time of the worker that had most of it
    checksums: dict[str, str]  # of the answers


class Measurement(TypedDict):
    """One measurement of all steps, as JSON."""

    load: float  # programs that wanted a processor before it began
    starts: dict[str, float]  # [s] that workers take to begin, by their number
    steps: list[StepTimes]


class WorkersFigures(TypedDict):
    """A step on some workers, as JSON."""

    seconds: float  # the median
    speed_up: float  # by the clock
    efficiency: float  # of them
    speed_up_by_work: float


class StepFigures(TypedDict):
    """A step, as JSON."""

    room: str
    step: str
    parts: int
    why: str
    workers: dict[str, WorkersFigures]
    serial_share: float | None  # s of Amdahl's law, fitted; None: one part
    identical: bool  # the answers on every number of workers


class ParallelResult(ExperimentResult):
    """The result, as JSON."""

    runs: int
    processors: int  # that this process may use
    load: float  # the largest before a measurement
    quiet: bool  # so little load that the times tell something
    starts_s: dict[str, float]
    steps: list[StepFigures]


def pictures(seed: int) -> list[Array]:
    """Pictures (H, W) of a board."""
    rng = np.random.default_rng((seed, 1))
    return [picture(rng, TABLE_3, held(rng, 1, TABLE_3, BOARD), BOARD) for _ in range(PICTURE_COUNT)]


def board_corners(grey: Array) -> list[list[float]] | None:
    """The corners of the board in a picture."""
    found = find_board(grey, BOARD)
    return None if found is None else found.corners.tolist()


def all_views(seed: int) -> list[list[Array]]:
    """The corners of all pictures: one part."""
    found = (find_board(grey, BOARD) for grey in pictures(seed))
    return [[one.corners for one in found if one is not None]]


def intrinsics(views: Sequence[Array]) -> float:
    """The residual of a calibration [px]."""
    seen = [ViewCorners(name=str(number), corners=corners) for number, corners in enumerate(views)]
    return calibrate(seen, BOARD, (TABLE_3.width, TABLE_3.height)).rms


def scans(seed: int) -> list[tuple[Laser, list[SensorFrame]]]:
    """Frames with a scan of the laboratory, some together."""
    robot = SimulatedRobot("lab", seed=seed, settings=SimulationSettings(camera=False))
    laser = robot.profile.laser
    assert laser is not None
    frames: list[SensorFrame] = []
    while len(frames) < SCAN_COUNT:
        frame = robot.read()
        frames += [frame] if frame.scan is not None else []
    return [(laser, frames[begin : begin + SCANS_TOGETHER]) for begin in range(0, SCAN_COUNT, SCANS_TOGETHER)]


def corners_of(part: tuple[Laser, list[SensorFrame]]) -> list[list[list[float]]]:
    """The corners in some scans."""
    laser, frames = part
    found: list[list[list[float]]] = []
    for frame in frames:
        assert frame.scan is not None
        corners = find_corners(frame.scan, laser, *deskew(frame.scan, laser, frame.wheels, frame.stamp))
        found.append([one.position.tolist() for one in corners])
    return found


def drives(seed: int) -> list[Run]:
    """Drives of figure 16."""
    return [Draws(seed=seed).run(number) for number in range(DRIVE_COUNT)]


def estimated(drive: Run) -> float:
    """The average error [m] of EKF-SLAM over a drive, whose updates wait for each other."""
    return mapped(drive, EkfSettings(), still=False).average


def sounds(seed: int) -> list[Sound]:
    """A voice in rooms, as an array of microphones hears it."""
    heard: list[Sound] = []
    for number in range(SOUND_COUNT):
        rng = np.random.default_rng((seed, 2, number))
        scene = make_scene(rng, 0.3, practice_voice(rng, 2.0, RATE_HZ), [ARRAYS["square"]])
        heard.append(scene.sound(0, "diffuse", 20.0))
    return heard


def azimuth(sound: Sound) -> float | None:
    """The direction of a voice [rad]."""
    found = locate(sound, ARRAYS["square"], speech_from=PRE_ROLL_S)
    return None if found is None else found.azimuth


STEPS = (
    ParallelStep("calibration", "find the board", pictures, board_corners, "a picture does not wait for another"),
    ParallelStep("calibration", "solve the camera", all_views, intrinsics, "one fit over all pictures: one part"),
    ParallelStep("localization", "find corners", scans, corners_of, "a scan does not wait for another"),
    ParallelStep(
        "localization",
        "estimate one drive",
        lambda seed: drives(seed)[:1],
        estimated,
        "an update waits for the one before: one part",
    ),
    ParallelStep("localization", "estimate many drives", drives, estimated, "a drive does not wait for another"),
    ParallelStep("hearing", "find the direction", sounds, azimuth, "an utterance does not wait for another"),
)


def plan(*, runs: int | None = None, seed: int = 0, workers: int | None = None, cluster: str = "") -> ExperimentPlan:
    """Plan `runs` measurements (3) with 1, 2, 4 … `workers`, which it starts itself, here or on a cluster."""
    most = workers or max(len(os.sched_getaffinity(0)), LEAST_MOST)
    counts = tuple(sorted({most, *(2**power for power in range(most.bit_length()))}))
    batch = RunBatch(partial(measure, seed, counts, cluster), runs or ABOUT.runs, Measurement)
    return ExperimentPlan((batch,), partial(_result, seed))


def measure(seed: int, counts: Sequence[int], cluster: str, number: int) -> Measurement:
    """One measurement of every step on every number of workers."""
    load = os.getloadavg()[0]
    steps: list[StepTimes] = []
    prepared = [(step, step.parts(seed + number)) for step in STEPS]
    for step, parts in prepared:
        steps.append({"step": step.name, "parts": len(parts), "seconds": {}, "busiest": {}, "checksums": {}})
    starts: dict[str, float] = {}
    for count in counts:
        with Workers(count, cluster, runs=max(counts)) as pool:
            began = time.monotonic()
            _all(pool.executor, board_corners, prepared[0][1][:count])
            starts[str(count)] = time.monotonic() - began
            for (step, parts), times in zip(prepared, steps, strict=True):
                _all(pool.executor, step.work, parts[:1])  # its libraries are loaded
                began = time.monotonic()
                answers, busy = _all(pool.executor, step.work, parts)
                times["seconds"][str(count)] = time.monotonic() - began
                times["busiest"][str(count)] = max(busy.values())
                times["checksums"][str(count)] = hashlib.sha256(json.dumps(answers).encode()).hexdigest()[:16]
    return {"load": load, "starts": starts, "steps": steps}


def _all(
    executor: Executor, work: Callable[[Any], Any], parts: Sequence[Any]
) -> tuple[list[Any], dict[tuple[str, int], float]]:
    """The answers for all parts, and the processor time [s] of every worker."""
    futures = [executor.submit(_part, work, part) for part in parts]
    done = [future.result() for future in futures]
    busy: dict[tuple[str, int], float] = {}
    for _, worker, seconds in done:
        busy[worker] = busy.get(worker, 0.0) + seconds
    return [answer for answer, _, _ in done], busy


def _part(work: Callable[[Any], Any], part: Any) -> tuple[Any, tuple[str, int], float]:
    began = time.process_time()
    answer = work(part)
    return answer, (platform.node(), os.getpid()), time.process_time() - began


def _result(seed: int, out: Path | None, done: list[Measurement]) -> ParallelResult:
    counts = list(done[0]["starts"])
    steps: list[StepFigures] = []
    for place, step in enumerate(STEPS):
        times = [one["steps"][place] for one in done]
        median = {count: float(np.median([one["seconds"][count] for one in times])) for count in counts}
        gains = {count: median["1"] / median[count] for count in counts}
        works = {
            count: float(np.median([one["busiest"]["1"] / one["busiest"][count] for one in times]))
            for count in counts
        }
        steps.append(
            {
                "room": step.room,
                "step": step.name,
                "parts": times[0]["parts"],
                "why": step.why,
                "workers": {
                    count: {
                        "seconds": median[count],
                        "speed_up": gain,
                        "efficiency": gain / int(count),
                        "speed_up_by_work": works[count],
                    }
                    for count, gain in gains.items()
                },
                "serial_share": serial_share(gains) if times[0]["parts"] > 1 else None,
                "identical": all(len(set(one["checksums"].values())) == 1 for one in times),
            }
        )
    load, processors = max(one["load"] for one in done), len(os.sched_getaffinity(0))
    result: ParallelResult = {
        "runs": len(done),
        "seed": seed,
        "processors": processors,
        "load": load,
        "quiet": load <= BUSY_SHARE * processors,
        "starts_s": {count: float(np.median([one["starts"][count] for one in done])) for count in counts},
        "steps": steps,
        "files": {},
    }
    result["text"] = "\n".join(table(result))
    return stored(result, out, "parallel")


def serial_share(gains: dict[str, float]) -> float | None:
    """The s of Amdahl's law 1 / (s + (1 - s) / p) that fits speed-ups by p, 0 … 1; None with one worker alone."""
    shares = [(1 / gain - 1 / int(count)) / (1 - 1 / int(count)) for count, gain in gains.items() if count != "1"]
    return float(np.clip(np.mean(shares), 0.0, 1.0)) if shares else None


def table(result: ParallelResult) -> list[str]:
    """Steps down, workers across; the reason under every step."""
    counts = list(result["starts_s"])
    named = ("1 worker" if count == "1" else f"{count} workers" for count in counts)
    lines = [f"{'':34}{'parts':>6}" + "".join(f"{one:>31}" for one in named) + f"{'serial':>9}"]
    for step in result["steps"]:
        cells = "".join(
            f"{one['seconds']:9.2f} s{one['speed_up']:7.2f} x ({one['speed_up_by_work']:.2f} x)"
            for one in step["workers"].values()
        )
        share = "" if step["serial_share"] is None else f"{100 * step['serial_share']:7.0f} %"
        lines.append(f"{step['room'] + ': ' + step['step']:34}{step['parts']:6}{cells}{share}".rstrip())
        lines.append(f"    {step['why']}" + ("" if step["identical"] else "; THE ANSWERS DIFFER"))
    starts = ", ".join(f"{count}: {seconds:.1f} s" for count, seconds in result["starts_s"].items())
    quiet = "" if result["quiet"] else "; others were busy here, so that the gains are too small"
    return [
        *lines,
        "speed-up by the clock, and in brackets by the work: what idle processors would allow",
        f"start of the workers, not counted: {starts}",
        f"{result['processors']} processors; load before: {result['load']:.1f}{quiet}",
    ]
