"""Drives of the whole robot in `sim:lab`: corners and edges are really made out, in scans and pictures.

The wheels have the paper's noise, the S is driven by command past its gate, and the robot looks around first as it
always does. It follows its own estimate, so every drive is another one.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from core.errors import Unavailable
from core.experiments.course_draws import FIRST_SEED, SEED_STRIDE
from core.experiments.course_traces import Trace
from core.experiments.drives import FIGURED, PLAIN, DriveSetup, DriveSurroundings
from core.experiments.paper_course import GOALS
from core.experiments.rehearsal import Rehearsal
from core.message import Array
from core.robots.requests import ReadPlan
from core.settings import Settings
from core.slam.consistency import nees
from core.slam.estimate import Estimate
from core.snapshot import Snapshot

PLACE = "sim:lab"
PATH_LENGTH_M = 3.2  # (section 6.2)
MAX_DRIVE_S = 120.0  # after which a drive that does not come on is over
FRAMES_PER_JUDGEMENT = 8  # frames between those that are judged: 5 Hz


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
