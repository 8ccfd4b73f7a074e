"""Effect of eyes and ears beside the laser: SLAM with each of them, on the same drives (abstract, sections 2 and 4).

Every drive is one of the simulated robot, steered along a fixed way by its true pose, so that no estimator changes
what the others see. Every row takes its own sensors from the same frames through the whole pilot. The places were
chosen before there were results; all of them are printed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np

from core.experiments.drawing import render
from core.experiments.plan import About, ExperimentPlan, RunBatch
from core.experiments.result import ExperimentResult, stored
from core.gate import Twist
from core.geometry import Pose
from core.message import message
from core.pilot import Pilot
from core.pipelines.slam import ChosenSensors
from core.robots.requests import Speak
from core.sensors import SensorFrame
from core.settings import Settings
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import WheelNoise
from core.slam.consistency import nees

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ABOUT = About(
    title="What eyes and ears add to the laser",
    reproduces="The abstract's claim that hearing and sight make the position better than the laser alone; it has no "
    "figures. The drives are steered by the true pose, round and round for 75 s; bearings as landmarks, off by "
    "default, are on.",
    runs=4,
    seed=20,
    counts="drives in every place",
    base_s=0.0,
    run_s=840.0,
    swept=("places.0.rows.laser.mean_error_m", "places.0.rows.all.mean_error_m", "places.1.rows.all.mean_error_m"),
)
REST_BEFORE_S = 2.5  # at rest before the drive
FIRST_CALL_S = 1.25  # when the person begins to call
DRIVE_SPEED_M_S, DRIVE_TURN_RAD_S = 0.25, 1.0  # of the drive
GOAL_RADIUS_M = 0.25  # from a goal, the next one is steered for
FRAMES_PER_JUDGEMENT = 8  # frames between those that are judged
CALL_PAUSE_S = 3.0  # between the ends of a person's calls
WORDS = "come here please, I am standing over here"
MAX_DRIVE_S = 75.0  # of a drive, round and round: what drifts does so with the way
EARLY_PART_S = 38.0  # at its beginning, of which the error is given besides
SIZE_PX = (1240, 560)  # [px]
ROW_COLOURS = ("#435567", "#c8671b", "#0b7fb0", "#7a5ea8", "#2f8f5b")


@dataclass(frozen=True)
class Place:
    """A place in which the robot drives, and the laser's shortcomings there."""

    name: str
    world: str
    goals: tuple[tuple[float, float], ...]  # [m]
    speaker: tuple[float, float]  # [m] where a person stands who calls
    weak: str = ""  # what makes the laser weak; "": it is not
    reach: float = math.inf  # [m] of the laser
    dropout: float = 0.004  # share of beams that fail
    wheels: WheelNoise = "paper"


AROUND_LAB = ((2.0, 0.0), (3.0, 1.5), (2.4, 2.4), (0.8, 2.2), (-0.6, 1.2), (0.2, 0.0))
TO_AND_FRO = ((4.5, 0.2), (1.0, -0.2), (4.5, 0.2))
AROUND_HALL = ((3.0, -1.5), (4.0, 0.5), (2.5, 1.6), (0.0, 1.2), (0.3, -0.5))
THROUGH_FLOOR = ((3.0, 0.0), (7.3, 0.0), (3.0, 0.2))
PERSON_PLACE_M = (3.0, 0.7)  # beside the way along the corridor
PLACES = (
    Place("lab", "lab", AROUND_LAB, (3.0, 2.8), wheels="encoder"),
    Place("floor", "floor", THROUGH_FLOOR, (3.4, 0.5), wheels="encoder"),
    Place("lab, paper's wheels", "lab", AROUND_LAB, (3.0, 2.8)),
    Place("corridor", "corridor", TO_AND_FRO, PERSON_PLACE_M, "no corners"),
    Place("bare corridor", "bare", TO_AND_FRO, PERSON_PLACE_M, "no corners, nothing on the walls"),
    Place("glass", "glass", AROUND_HALL, (2.0, 0.3), "walls of glass"),
    Place("corridor, 1.5 m", "corridor", TO_AND_FRO, PERSON_PLACE_M, "no corners, a laser of 1.5 m", reach=1.5),
    Place("lab, 1.5 m", "lab", AROUND_LAB, (3.0, 2.8), "a laser of 1.5 m", reach=1.5),
    Place("lab, 10 % dropped", "lab", AROUND_LAB, (3.0, 2.8), "10 % of the beams dropped", dropout=0.1),
)
SENSORS = {
    "laser": ChosenSensors(True, 0, False),
    "camera": ChosenSensors(False, 1, False),
    "laser + camera": ChosenSensors(True, 1, False),
    "laser + voice": ChosenSensors(True, 0, True),
    "all": ChosenSensors(True, 1, True),
}
"""The sensors of every row."""


@message
class RowErrors:
    """One row's errors on one drive."""

    mean: float  # [m] over the drive
    early: float  # [m] mean over its beginning
    final: float  # [m]
    nees: float  # mean; ideal 3
    apart: float  # [m] mean distance from the position by the laser alone


class RowFigures(TypedDict):
    """A row over all runs, as JSON."""

    mean_error_m: float
    worst_error_m: float
    early_error_m: float
    final_error_m: float
    nees: float
    from_laser_m: float
    of_laser: float  # mean error as a share of the laser's


class AudioVisualPlace(TypedDict):
    """A place, as JSON."""

    place: str
    weak: str
    wheels: str
    path_m: float
    rows: dict[str, RowFigures]


class AudioVisual(ExperimentResult):
    """The result, as JSON."""

    runs: int
    places: list[AudioVisualPlace]


def settings_for(place: Place, base: Settings) -> Settings:
    """The robot and its filter in a place: it uses all bearings, and knows the size of its wheels' noise."""
    simulation = replace(base.simulation, wheel_noise=place.wheels, dropout=place.dropout, cruise=DRIVE_SPEED_M_S)
    motion = replace(base.motion, model="paper" if place.wheels == "paper" else "encoder", cruise=DRIVE_SPEED_M_S)
    return replace(
        base,
        simulation=simulation,
        motion=motion,
        edge_landmarks=replace(base.edge_landmarks, used=True),
        voice_landmarks=replace(base.voice_landmarks, used=True),
    )


def seen_by(frame: SensorFrame, sensors: ChosenSensors, reach: float) -> SensorFrame:
    """The part of a frame that these sensors deliver."""
    seen = sensors.within(frame)
    if seen.scan is None or not math.isfinite(reach):
        return seen
    ranges = np.where(seen.scan.ranges <= reach, seen.scan.ranges, np.nan)
    return replace(seen, scan=replace(seen.scan, ranges=ranges))


def steer(pose: Pose, goal: tuple[float, float]) -> Twist:
    """Twist from a pose towards a goal: on the spot first, where it lies aside."""
    off = pose.bearing_to(*goal)
    turn = max(-DRIVE_TURN_RAD_S, min(DRIVE_TURN_RAD_S, 2.0 * off))
    return Twist(DRIVE_SPEED_M_S if abs(off) < math.radians(40) else 0.0, turn)


class SteeredDrive:
    """One drive of the simulated robot along a place's way, by its true pose, beside a person who calls."""

    def __init__(self, place: Place, settings: Settings, seed: int) -> None:
        self._place = place
        self.robot = SimulatedRobot(place.world, seed=seed, settings=settings.simulation)

    def frames(self, read: Callable[[], SensorFrame], calls: float = FIRST_CALL_S) -> Iterator[SensorFrame]:
        """Every frame, as `read` gets it of the robot, until the end; a person calls from `calls` [s] on."""
        place, goal = self._place, 0
        while (frame := read()).stamp <= MAX_DRIVE_S:
            truth = frame.truth or Pose()
            if frame.stamp >= calls:
                said = self.robot.ask(Speak(text=WORDS, x_m=place.speaker[0], y_m=place.speaker[1], id="person"))
                calls = frame.stamp + said.seconds + CALL_PAUSE_S
            yield frame
            if frame.stamp < REST_BEFORE_S:
                continue
            if truth.distance_to(*place.goals[goal]) < GOAL_RADIUS_M:
                goal = (goal + 1) % len(place.goals)
            self.robot.drive(steer(truth, place.goals[goal]))


def drive(
    place: Place,
    base: Settings,
    seed: int,
    rows: Sequence[str],
    begun: Callable[[dict[str, Pilot]], None] = lambda _: None,
) -> dict[str, RowErrors | float]:
    """One drive through every row, and under `path` its length [m].

    `begun` is given the rows' pilots once, when they have taken the first frame: for bounds, which know more.
    """
    settings = settings_for(place, base)
    steered = SteeredDrive(place, settings, seed)
    robot = steered.robot
    pilots = {name: Pilot(SENSORS[name].of(robot.profile), settings) for name in rows}
    calls = FIRST_CALL_S if any(SENSORS[name].microphones for name in rows) else math.inf
    found: dict[str, list[tuple[float, float, float, float, float]]] = {name: [] for name in rows}
    path, before = 0.0, Pose()
    for number, frame in enumerate(steered.frames(robot.read, calls), 1):
        truth = frame.truth or Pose()
        snapshots = {name: pilot.step(seen_by(frame, SENSORS[name], place.reach)) for name, pilot in pilots.items()}
        if number == 1:
            begun(pilots)
        path, before = path + truth.distance_to(before.x, before.y), truth
        if frame.stamp >= REST_BEFORE_S and number % FRAMES_PER_JUDGEMENT == 0:
            for name, snapshot in snapshots.items():
                pose = snapshot.estimate.pose
                off = truth.distance_to(pose.x, pose.y)
                found[name].append((pose.x, pose.y, off, nees(snapshot.estimate, truth), frame.stamp))
    return {"path": path} | errors_of(found)


def errors_of(found: Mapping[str, Sequence[tuple[float, float, float, float, float]]]) -> dict[str, RowErrors]:
    """Every row's x, y, error [m], NEES and time [s] at the moments that are judged → its errors."""
    table = {name: np.array(one) for name, one in found.items()}
    laser = table.get("laser")
    errors: dict[str, RowErrors] = {}
    for name, one in table.items():
        gap = np.full(len(one), np.nan) if laser is None else np.hypot(*(one[:, :2] - laser[:, :2]).T)
        errors[name] = RowErrors(
            mean=float(one[:, 2].mean()),
            early=float(one[one[:, 4] <= EARLY_PART_S, 2].mean()),
            final=float(one[-1, 2]),
            nees=float(np.nanmean(one[:, 3])),
            apart=float(gap.mean()),
        )
    return errors


def plan(
    *, runs: int | None = None, seed: int = 0, settings: Settings | None = None, places: tuple[Place, ...] = PLACES
) -> ExperimentPlan:
    """Plan `runs` drives (2) in every place, with seeds from `seed` on; figure and table."""
    count = runs or ABOUT.runs
    work = partial(_work, places, settings or Settings(), seed, count)
    batch = RunBatch(work, count * len(places), dict[str, RowErrors | float])
    return ExperimentPlan((batch,), partial(_result, places, seed))


def _work(
    places: tuple[Place, ...], settings: Settings, seed: int, runs: int, number: int
) -> dict[str, RowErrors | float]:
    place, run = divmod(number, runs)
    return drive(places[place], settings, seed + run, tuple(SENSORS))


def _result(
    places: tuple[Place, ...], seed: int, out: Path | None, done: list[dict[str, RowErrors | float]]
) -> AudioVisual:
    count = len(done) // len(places)
    figures = [_place(place, done[k * count : (k + 1) * count]) for k, place in enumerate(places)]
    result: AudioVisual = {
        "runs": count,
        "seed": seed,
        "places": figures,
        "text": table(figures, count, seed),
        "files": {},
    }
    return stored(
        result,
        out,
        "audio_visual",
        figures=lambda: {"figure": ("audio_visual.svg", audio_visual_figure(figures, count))},
    )


def _place(place: Place, done: list[dict[str, RowErrors | float]]) -> AudioVisualPlace:
    rows: dict[str, RowFigures] = {}
    for name in SENSORS:
        errors = [one for each in done if isinstance(one := each[name], RowErrors)]
        mean = float(np.mean([one.mean for one in errors]))
        rows[name] = {
            "mean_error_m": mean,
            "worst_error_m": max(one.mean for one in errors),
            "early_error_m": float(np.mean([one.early for one in errors])),
            "final_error_m": float(np.mean([one.final for one in errors])),
            "nees": float(np.mean([one.nees for one in errors])),
            "from_laser_m": float(np.mean([one.apart for one in errors])),
            "of_laser": mean / rows["laser"]["mean_error_m"] if rows else 1.0,
        }
    path = float(np.mean([float(one["path"]) for one in done if isinstance(one["path"], float)]))
    return {"place": place.name, "weak": place.weak, "wheels": place.wheels, "path_m": path, "rows": rows}


def table(figures: list[AudioVisualPlace], count: int, seed: int) -> str:
    """The table; below every place its conditions."""
    lines = [
        f"Position error over the drive [m], mean and worst of {count} drives, NEES (ideal 3); seeds from {seed}",
        f"{'':22}" + "".join(f"{name:>24}" for name in SENSORS),
    ]
    for one in figures:
        cells = (one["rows"][name] for name in SENSORS)
        lines.append(
            f"{one['place']:22}"
            + "".join(f"{row['mean_error_m']:10.3f}{row['worst_error_m']:8.3f}{row['nees']:6.1f}" for row in cells)
        )
        weak = one["weak"] or "laser not weak"
        shares = "".join(f"{100 * (one['rows'][name]['of_laser'] - 1):+23.0f} %"[-24:] for name in SENSORS)
        lines.append(f"{'  against the laser':22}{shares}")
        early = "".join(f"{one['rows'][name]['early_error_m']:10.3f}{'':14}" for name in SENSORS)
        lines.append(f"{f'  first {EARLY_PART_S:.0f} s [m]':22}{early}".rstrip())
        lines.append(f"    {weak}; {one['wheels']} wheels; {one['path_m']:.1f} m")
    return "\n".join(lines)


def audio_visual_figure(places: Sequence[Any], runs: int) -> bytes:
    """Places with their rows → an SVG file. Raises Unavailable without matplotlib."""

    def draw(figure: Figure) -> None:
        axes = figure.add_subplot()
        names = list(places[0]["rows"])
        width = 0.8 / len(names)
        at = np.arange(len(places))
        for k, (name, colour) in enumerate(zip(names, ROW_COLOURS, strict=True)):
            mean, worst = (
                np.array([place["rows"][name][key] for place in places]) for key in ("mean_error_m", "worst_error_m")
            )
            reach = np.vstack((np.zeros(len(at)), worst - mean))
            axes.bar(at + width * (k - (len(names) - 1) / 2), mean, width, yerr=reach, color=colour, label=name)
        axes.set_xticks(at, [place["place"] for place in places], rotation=15)
        axes.set_yscale("log")
        axes.set_ylabel("mean position error [m]")
        axes.legend(ncols=len(names), loc="upper center")

    conditions = f"mean of {runs} drives; the line above a bar ends at the worst"
    return render("svg", SIZE_PX, "What eyes and ears add to the laser", conditions, draw)
