"""Drives of the paper's course: sightings drawn about the true corners, or made by the whole robot in `sim:lab`.

In the lab, corners and edges are really made out, in scans and pictures. The wheels have the paper's noise, the S is
driven by command past its gate, and the robot looks around first as it always does. It follows its own estimate, so
every drive is another one.
"""

import math
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NotRequired, TypedDict

import numpy as np

from core.errors import BadInput, Unavailable
from core.experiments.paper_course import (
    FIRST_SEED,
    GOALS,
    SEED_STRIDE,
    UPDATES_PER_SIGHTING,
    Draws,
    Field,
    Trace,
    frozen,
    mapped,
    reckoned,
)
from core.experiments.rehearsal import Rehearsal
from core.message import Array
from core.recording import Ids
from core.robots.requests import ReadPlan
from core.settings import Settings
from core.slam.consistency import nees
from core.slam.ekf_slam import EkfSettings
from core.slam.estimate import Estimate
from core.snapshot import Snapshot

PLAIN = "dead_reckoning"
FIGURED = "ekf_slam"
PLACE = "sim:lab"
PATH_LENGTH_M = 3.2  # (section 6.2)
MAX_DRIVE_S = 120.0  # after which a drive that does not come on is over
FRAMES_PER_JUDGEMENT = 8  # frames between those that are judged: 5 Hz


class DriveSetup(TypedDict):
    """The set-up of drives, as JSON."""

    through: str  # "drawn" | "sensors"
    mode: str  # the filter's form
    still_start: bool
    ids: str
    speed_m_s: float
    wheelbase_m: float
    speed_sd_m_s: float
    steer_sd_deg: float
    data: NotRequired[str | None]  # of drawn ones: the file of the draws
    field: NotRequired[str]  # of drawn ones: what is seen of the room
    range_sd_m: NotRequired[float]
    bearing_sd_deg: NotRequired[float]
    place: NotRequired[str]  # through the sensors: the simulated place
    laser_noise: NotRequired[str]  # through the sensors: that of the simulated laser


@dataclass(frozen=True)
class DriveSurroundings:
    """Surroundings to draw in the picture."""

    corners: Array = field(default_factory=lambda: np.zeros((0, 2)))  # (N, 2) [m]
    walls: Array = field(default_factory=lambda: np.zeros((0, 2, 2)))  # (W, 2, 2) [m]: ends


@dataclass(frozen=True)
class DrawnDrives:
    """Draws, and the filter they go through; its other form runs next to it."""

    draws: Draws
    ekf: EkfSettings
    still: bool

    @property
    def rows(self) -> tuple[str, ...]:
        """Dead reckoning, the figure's filter, its other form."""
        return PLAIN, *self._forms

    @property
    def room(self) -> DriveSurroundings:
        """The corners."""
        return DriveSurroundings(corners=self.draws.run(0).landmarks)

    @property
    def setup(self) -> DriveSetup:
        """The set-up, ready for JSON."""
        motion, (far, aside) = self.draws.motion, self.draws.sighting_noise
        return {
            "through": "drawn",
            "data": self.draws.data.name if self.draws.data else None,
            "mode": self.ekf.mode,
            "still_start": self.still,
            "ids": self.draws.ids,
            "field": self.draws.field,
            "speed_m_s": motion.cruise,
            "wheelbase_m": motion.wheelbase,
            "speed_sd_m_s": motion.speed_sd,
            "steer_sd_deg": math.degrees(motion.steer_sd),
            "range_sd_m": far,
            "bearing_sd_deg": math.degrees(aside),
        }

    @property
    def words(self) -> str:
        """The set-up in a line."""
        motion, (far, aside) = self.draws.motion, self.draws.sighting_noise
        parts = (
            f"{motion.cruise:g} m/s, controls {1 / motion.step:g} Hz, "
            f"sightings {1 / (UPDATES_PER_SIGHTING * motion.step):g} Hz",
            f"Q = diag({motion.speed_sd:g} m/s, {math.degrees(motion.steer_sd):g}°)²",
            f"R = diag({far:g} m, {math.degrees(aside):g}°)²",
            "ten frames at rest first" if self.still else "moving at once",
            f"{self.ekf.mode} form",
            self.draws.data.name if self.draws.data else f"seed {self.draws.seed}",
        )
        return "  ·  ".join(parts)

    def traces(self, number: int) -> dict[str, Trace]:
        """One drive through every estimator."""
        run = self.draws.run(number)
        return {PLAIN: reckoned(run)} | {name: mapped(run, ekf, self.still) for name, ekf in self._forms.items()}

    @property
    def _forms(self) -> dict[str, EkfSettings]:
        other = "invariant" if self.ekf.mode == "paper" else "paper"
        return {FIGURED: self.ekf, f"{FIGURED}_{other}": replace(self.ekf, mode=other)}


def drawn_drives(
    settings: Settings | None,
    seed: int,
    data: Path | None = None,
    noise: float | None = None,
    field: Field | None = None,
    still: bool = False,
    ids: Ids = "given",
) -> DrawnDrives:
    """Drives from a seed, or from a file. Without settings the filter has the paper's form. Raises BadInput."""
    ekf = EkfSettings(mode="paper", soft_gate=0.0) if settings is None else settings.ekf  # the paper trusts all alike
    ekf = replace(ekf, sighting_noise="corner")  # every sighting brings its own noise
    if data is not None:
        if noise is not None or field is not None:
            raise BadInput(f"The draws in {data.name} are made; leave out noise and field, or leave out the file.")
        if still and not len(frozen(data).still):
            raise BadInput(f"{data.name} has no frames at rest (still_obs).")
        return DrawnDrives(Draws(seed=seed, data=data, ids=ids), ekf, still)
    chosen, factor = settings or Settings(), 1.0 if noise is None else noise
    motion = replace(
        chosen.motion,
        model="paper",
        speed_sd=factor * chosen.motion.speed_sd,
        steer_sd=factor * chosen.motion.steer_sd,
    )
    spread = factor * chosen.ekf.range_sd, factor * chosen.ekf.bearing_sd
    draws = Draws(seed=seed, motion=motion, sighting_noise=spread, field=field or "laser", ids=ids)
    return DrawnDrives(draws, ekf, still)


@dataclass(frozen=True)
class LabDrives:
    """The same robot on the same way with another luck."""

    settings: Settings
    seed: int

    @property
    def rows(self) -> tuple[str, ...]:
        """Dead reckoning and the filter that drives."""
        return PLAIN, FIGURED

    @property
    def room(self) -> DriveSurroundings:
        """The walls at the laser's height."""
        plan = Rehearsal(PLACE, settings=self.settings).robot.ask(ReadPlan())
        return DriveSurroundings(walls=np.array(plan.segments, float).reshape(-1, 2, 2))

    @property
    def setup(self) -> DriveSetup:
        """The set-up, ready for JSON."""
        simulation, motion = self.settings.simulation, self.settings.motion
        return {
            "through": "sensors",
            "place": PLACE,
            "mode": self.settings.ekf.mode,
            "still_start": True,
            "ids": "hidden",
            "speed_m_s": simulation.cruise,
            "wheelbase_m": motion.wheelbase,
            "speed_sd_m_s": motion.speed_sd,
            "steer_sd_deg": math.degrees(motion.steer_sd),
            "laser_noise": simulation.laser_noise,
        }

    @property
    def words(self) -> str:
        """The set-up in a line."""
        motion = self.settings.motion
        parts = (
            f"{PLACE} by command, {self.settings.simulation.cruise:g} m/s",
            f"Q = diag({motion.speed_sd:g} m/s, {math.degrees(motion.steer_sd):g}°)²",
            f"corners and edges from scans ({self.settings.simulation.laser_noise}) and pictures",
            f"{self.settings.ekf.mode} form",
            f"seed {self.seed}",
        )
        return "  ·  ".join(parts)

    def traces(self, number: int) -> dict[str, Trace]:
        """One drive."""
        rehearsal = Rehearsal(PLACE, seed=FIRST_SEED + SEED_STRIDE * self.seed + number, settings=self.settings)
        drive = DriveRecorder(rehearsal.snapshot)
        for x, y in GOALS:
            number = rehearsal.tell(f"stop at {x} and {y}")
            while (
                rehearsal.ended(number) is None
                and drive.path < PATH_LENGTH_M
                and rehearsal.snapshot.stamp < MAX_DRIVE_S
            ):
                drive.add(rehearsal.step())
        return drive.traces()


class DriveRecorder:
    """Gathers a drive, frame by frame, from the first move on."""

    def __init__(self, first: Snapshot) -> None:
        self.path = 0.0  # [m]
        self._begun = 0.0  # [s]
        self._frames = 0
        self._last = first
        self._truth: list[tuple[float, float, float]] = []  # time [s], x, y [m]
        self._found: dict[str, list[tuple[float, float, float]]] = {PLAIN: [], FIGURED: []}  # x, y [m], NEES

    def add(self, snapshot: Snapshot) -> None:
        """One frame."""
        truth, before = snapshot.truth, self._last.truth
        assert truth is not None and before is not None, "the simulator knows the truth"
        self.path += truth.distance_to(before.x, before.y)
        self._frames += self.path > 0.0
        if not self._frames:
            self._begun = snapshot.stamp
        elif self._frames % FRAMES_PER_JUDGEMENT == 0:
            self._truth.append((snapshot.stamp - self._begun, truth.x, truth.y))
            for name, pose_estimate in ((PLAIN, snapshot.dead_reckoning), (FIGURED, snapshot.estimate)):
                self._found[name].append((pose_estimate.pose.x, pose_estimate.pose.y, nees(pose_estimate, truth)))
        self._last = snapshot

    def traces(self) -> dict[str, Trace]:
        """The results of the drive. Raises Unavailable."""
        if not self._truth:
            raise Unavailable(f"The robot would not move in {PLACE}; do the settings let it?")
        truth = np.array(self._truth).reshape(-1, 3)
        found = {name: np.array(rows).reshape(-1, 3) for name, rows in self._found.items()}
        return {
            PLAIN: self._trace(truth, found[PLAIN], self._last.dead_reckoning),
            FIGURED: replace(self._trace(truth, found[FIGURED], self._last.estimate), landmarks=self._last.landmarks),
        }

    def _trace(self, truth: Array, found: Array, last: Estimate) -> Trace:
        return Trace(
            times=truth[:, 0],
            places=found[:, :2],
            truth=truth[:, 1:],
            path=self.path,
            nees=float(np.nanmean(found[:, 2])),
            last=last,
        )


def lab_drives(settings: Settings | None, seed: int) -> LabDrives:
    """Drives with the paper's wheels. Without settings the filter has the paper's form."""
    chosen = settings or Settings()
    return LabDrives(
        replace(
            chosen,
            simulation=replace(chosen.simulation, wheel_noise="paper"),
            motion=replace(chosen.motion, model="paper"),
            ekf=replace(chosen.ekf, mode="paper") if settings is None else chosen.ekf,
        ),
        seed,
    )
