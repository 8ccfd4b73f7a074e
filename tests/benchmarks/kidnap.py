"""Carried away and found again: `python -m tests.benchmarks.kidnap [--where intel|floor|both] [--kidnaps 100]`.

intel: the map is made of every second scan of the Intel Research Lab at its reference poses, the scans between them
are what a carried robot sees (or the other way round); nothing tells where they were taken. A fifth of the kidnaps
goes to parts of the building that were left out of the map. The log holds one scan every 0.7 m or 3.4 s, so views
are further apart than those of a robot that turns on the spot; how far it moved is told beside.
floor: the simulated robot (1 % laser) is put at a random place of `sim:floor` by hand, notices it, turns on the spot.

Right: within 0.3 m and 5 degrees. Everything else that is believed is wrong, also at places that are not on the map.
"""

import math
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

import numpy as np

from core.gate import Twist
from core.geometry import Pose, wrap
from core.message import Array
from core.perception.landmarks.deskew import beam_ends
from core.perception.landmarks.frame_perception import Beams
from core.robots.requests import CarryRobot
from core.sensors import SensorFrame
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import SimulationSettings
from core.simulation.world import world_named
from core.slam.map.keyframe import thinned
from core.slam.map.occupancy import OccupancyGrid, OccupancyMap
from core.slam.relocalization.kidnap_detector import KidnapDetector, LocalizationEvidence, WidenedWalls
from core.slam.relocalization.recovery import RecoveredPose, Recovery
from core.slam.relocalization.search_pyramid import ScanView
from core.slam.scan_matching.field_matching import match_scan
from core.slam.scan_matching.likelihood_field import LikelihoodField
from tests.benchmarks.command import run_command

DATA = Path(__file__).resolve().parents[3] / "shared" / "data" / "intel-lab" / "intel.npz"
NEAR, TURNED = 0.3, math.radians(5)
SECONDS, WAY = 3.0, 1.0
RATE = 40.0  # [Hz]
VIEWS = 4  # of the log that follow a kidnap, at most
FARTHEST = 20.0  # [m] of a beam that is drawn


@dataclass
class Outcome:
    """How one kidnap ended."""

    on_map: bool
    found: bool = False
    right: bool = False
    seconds: float = 0.0  # since it was noticed
    noticed: float = 0.0  # [s] since it was carried
    way: float = 0.0  # [m]
    views: int = 0
    error: float = 0.0  # [m]
    error_heading: float = 0.0  # [rad]
    work: float = 0.0  # [s] of the processor, in all
    piece: float = 0.0  # [s] of the processor, the longest piece


class Watch:
    """The processor's time of every piece."""

    def __init__(self, outcome: Outcome) -> None:
        self._outcome = outcome

    def step(
        self, finding: Recovery, stamp: float, odometry: Pose, view: ScanView | None, may_turn: bool
    ) -> RecoveredPose | None:
        start = time.process_time()
        found = finding.step(stamp, odometry, view, may_turn)
        spent = time.process_time() - start
        self._outcome.work += spent
        self._outcome.piece = max(self._outcome.piece, spent)
        return found


def compare(outcome: Outcome, found: RecoveredPose, truth: Pose) -> None:
    outcome.found = True
    outcome.error = truth.distance_to(found.pose.x, found.pose.y)
    outcome.error_heading = abs(wrap(found.pose.heading - truth.heading))
    outcome.right = outcome.error < NEAR and outcome.error_heading < TURNED


class Intel:
    """The log, and maps of parts of it."""

    def __init__(self, path: Path) -> None:
        log = np.load(path)
        self.usual = 1.0  # share of a scan's points at walls of the map that was made of it
        self.poses = [Pose(*row) for row in log["pose_gmapping"].tolist()]
        self.odometry = [Pose(*row) for row in log["odo_raw"].tolist()]
        self.stamps = log["t"] - log["t"][0]
        ranges = log["scan_cm"] / 100.0
        ranges[log["scan_cm"] >= 8100] = np.nan
        ranges[ranges > FARTHEST] = np.nan
        angles = np.radians(np.arange(-90, 90))
        self.ends = np.stack((ranges * np.cos(angles), ranges * np.sin(angles)), axis=-1)

    def mapped(self, first: int, keep: Callable[[Pose], bool]) -> tuple[OccupancyGrid, Array]:
        """The map of every second scan from `first` on that is kept."""
        drawn, points = OccupancyMap(), list[Array]()
        for number in range(first, len(self.poses), 2):
            pose, ends = self.poses[number], self.ends[number]
            if keep(pose):
                hits = np.isfinite(ends[:, 0])
                drawn.insert(pose, pose.apply(ends), hits)
                points.append(pose.apply(ends[hits]))
        if len(points) == len(range(first, len(self.poses), 2)):
            own = [WidenedWalls().agreement(drawn.grid(), one) for one in points[::20]]
            self.usual = float(np.mean([share for share in own if share is not None]))
        return drawn.grid(), np.vstack(points)

    def cut(self, rng: np.random.Generator) -> Callable[[Pose], bool]:
        """Which poses stay on the map when 30 to 60 % are left out, all on one side of a random line."""
        angle = float(rng.uniform(-math.pi, math.pi))
        c, s = math.cos(angle), math.sin(angle)
        edge = float(np.quantile([c * pose.x + s * pose.y for pose in self.poses], rng.uniform(0.4, 0.7)))
        return lambda pose: c * pose.x + s * pose.y < edge

    def view(self, number: int) -> ScanView:
        ends = self.ends[number]
        stamp, odometry = float(self.stamps[number]), self.odometry[number]
        return ScanView.of_beams(stamp, odometry, Beams(ends=ends, hits=np.isfinite(ends[:, 0])))

    def kidnap(self, first: int, chart: tuple[OccupancyGrid, Array], on_map: bool) -> Outcome:
        """Woken at scan `first`, with the scans that follow as further views."""
        outcome = Outcome(on_map)
        watch, finding = Watch(outcome), Recovery(0.0, "it was carried", *chart, usual=self.usual)
        further_on = iter(range(first, min(first + 2 * VIEWS, len(self.poses)), 2))
        number, stamp, quiet = next(further_on), 0.0, 0
        view: ScanView | None = self.view(number)
        while True:
            outcome.views += view is not None
            found = watch.step(finding, stamp, self.odometry[number], view, False)
            stamp, view, quiet = stamp + 1 / RATE, None, quiet + 1 if finding.waiting else 0
            if found is not None:
                compare(outcome, found, self.poses[number])
                break
            if quiet > 1:
                further = next(further_on, None)
                if further is None:
                    break
                before, number, quiet = self.poses[number], further, 0
                outcome.way += before.distance_to(self.poses[number].x, self.poses[number].y)
                view = self.view(number)
        outcome.seconds = stamp
        return outcome


def intel(kidnaps: int, rng: np.random.Generator) -> list[Outcome]:
    """Four of five kidnaps on the whole map, the fifth into a part that was left out."""
    log = Intel(DATA)
    whole, starts = [log.mapped(first, lambda pose: True) for first in (0, 1)], list(range(len(log.poses) - 2))
    told = [log.kidnap(first, whole[1 - first % 2], True) for first in drawn(starts, kidnaps - kidnaps // 5, rng)]
    cuts = max(1, kidnaps // 50)
    for number in range(cuts):
        keep = log.cut(rng)
        part = log.mapped(number % 2, keep)
        away = [first for first in starts if first % 2 != number % 2 and not keep(log.poses[first])]
        told += [log.kidnap(first, part, False) for first in drawn(away, kidnaps // 5 // cuts, rng)]
    return told


def drawn(starts: list[int], count: int, rng: np.random.Generator) -> list[int]:
    """So many of the places, each as seldom as possible."""
    order: list[int] = []
    while len(order) < count:
        order += rng.permutation(starts).tolist()
    return order[:count]


class Floor:
    """The simulated storey and its map."""

    def __init__(self, seed: int) -> None:
        self.robot = SimulatedRobot("floor", seed=seed, settings=SimulationSettings(camera=False))
        self.world = world_named("floor")
        self._rng = np.random.default_rng(seed)
        self._laser = self.robot.profile.laser
        self.frame = self.robot.read()

    def anywhere(self, clearance: float = 0.2) -> Pose:
        bounds = self.world.bounds
        while True:
            x, y = self._rng.uniform((bounds.x0, bounds.y0), (bounds.x1, bounds.y1)).tolist()
            if self.world.free(x, y, clearance):
                return Pose(x, y, float(self._rng.uniform(-math.pi, math.pi)))

    def carry(self, pose: Pose) -> None:
        self.robot.ask(CarryRobot(x_m=pose.x, y_m=pose.y, heading_rad=pose.heading))

    def beams(self, frame: SensorFrame) -> tuple[Array, Array] | None:
        if frame.scan is None or self._laser is None:
            return None
        return beam_ends(frame.scan, self._laser, frame.wheels, frame.stamp)

    def mapped(self, keep: Callable[[Pose], bool], places: int = 700) -> OccupancyGrid:
        """A map drawn from so many places with their true poses."""
        drawn, mounting = OccupancyMap(), self._laser.mounting if self._laser else Pose()
        for _ in range(places):
            pose = self.anywhere()
            if not keep(pose):
                continue
            self.carry(pose)
            beams = None
            for _ in range(12):
                beams = self.beams(self.robot.read()) or beams
            if beams is not None:
                drawn.insert(pose @ mounting, pose.apply(beams[0]), beams[1])
        return drawn.grid()

    def kidnap(self, grid: OccupancyGrid, on_map: bool) -> Outcome:
        """Stand somewhere known, be carried, notice it, look around."""
        outcome, alarm, walls = Outcome(on_map), KidnapDetector(), WidenedWalls()
        finding: Recovery | None = None
        before, place = self.anywhere(), self.anywhere()
        self.carry(before)
        beams = None
        while beams is None:
            beams = self.beams(self.robot.read())
        seen = LikelihoodField(before.apply(beams[0][beams[1]]))
        self.carry(place)
        start = self.robot.read()
        odometry = start.wheels.odometry if start.wheels else Pose()
        believed, watch, began = before @ odometry.inverse(), Watch(outcome), start.stamp
        while True:
            frame = self.robot.read()
            here = frame.wheels.odometry if frame.wheels else Pose()
            beams, view = self.beams(frame), None
            if beams is not None:
                view = ScanView.of_beams(frame.stamp, here, Beams(ends=beams[0], hits=beams[1]))
                outcome.views += finding is not None
            if finding is None:
                if beams is not None:
                    points = beams[0][beams[1]]
                    agreement = walls.agreement(grid, (believed @ here).apply(points))
                    match = match_scan(seen, thinned(points), believed @ here, 0.1, math.radians(3)).score
                    if alarm.observe(LocalizationEvidence(frame.stamp, match, agreement)):
                        before = None if alarm.carried else believed
                        finding = Recovery(frame.stamp, alarm.doubt, grid, before=before)
                        outcome.noticed, began = frame.stamp - began, frame.stamp
                if frame.stamp - began > 5.0:
                    break
                continue
            found = watch.step(finding, frame.stamp, here, view, True)
            self.robot.drive(Twist(0.0, finding.turn))
            outcome.seconds = frame.stamp - began
            if found is not None and frame.truth is not None:
                compare(outcome, found, frame.truth)
            if found is not None or outcome.seconds > 15.0:
                break
        self.robot.drive(Twist())
        return outcome


def floor(kidnaps: int, seed: int) -> list[Outcome]:
    """Four of five kidnaps on the whole map, the fifth anywhere on a map of the western part only."""
    storey = Floor(seed)
    told = [storey.kidnap(grid, True) for grid in [storey.mapped(lambda pose: True)] for _ in range(kidnaps * 4 // 5)]
    west = storey.mapped(lambda pose: pose.x < 4.0)
    return told + [storey.kidnap(west, False) for _ in range(kidnaps // 5)]


def figures(told: list[Outcome]) -> dict[str, object]:
    """What to print of many kidnaps."""
    on, off = [o for o in told if o.on_map], [o for o in told if not o.on_map]
    right = [o for o in on if o.right]
    quick = [o for o in right if o.seconds <= SECONDS and o.way <= WAY]
    part = {
        "seconds": [o.seconds for o in right],
        "seconds_since_carried": [o.seconds + o.noticed for o in right],
        "way_m": [o.way for o in right],
        "views": [o.views for o in right],
        "error_m": [o.error for o in right],
        "error_deg": [math.degrees(o.error_heading) for o in right],
        "work_s": [o.work for o in told],
        "longest_piece_ms": [1000 * o.piece for o in told],
    }
    return {
        "kidnaps_on_the_map": len(on),
        "recovered": len(right),
        "recovered_within_3_s_and_1_m": len(quick),
        "kidnaps_off_the_map": len(off),
        "found_there_rightly_at_its_edge": sum(o.right for o in off),
        "wrong_recoveries_accepted": sum(o.found and not o.right for o in told),
        **{
            key: {str(p): round(float(np.percentile(values, p)), 3) for p in (50, 95, 100)}
            for key, values in part.items()
            if values
        },
    }


def main(
    *,
    where: Annotated[str, ("intel", "floor", "both")] = "both",
    kidnaps: int = 100,
    seed: int = 0,
    every: bool = False,  # keep every single outcome in the report
) -> object:
    report: dict[str, object] = {}
    for place in ("intel", "floor"):
        if where not in (place, "both"):
            continue
        if place == "intel" and not DATA.exists():
            report[place] = "The Intel Lab log is not here: shared/data is expected beside the repository."
            continue
        started = time.process_time()
        rng = np.random.default_rng(seed)
        told = intel(kidnaps, rng) if place == "intel" else floor(kidnaps, seed)
        report[place] = figures(told) | {"processor_s": round(time.process_time() - started, 1)}
        if every:
            report[f"{place}_outcomes"] = [asdict(outcome) for outcome in told]
    return {k: v for k, v in report.items() if not k.endswith("_outcomes")}


if __name__ == "__main__":
    run_command(main)
