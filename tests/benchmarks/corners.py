"""Corners in simulated URG scans beside the truth: `python -m tests.benchmarks.corners [--trials 300]`.

First single corners with walls of 1.2 m, the laser used to 4 m: over distances, both kinds, two noises. Then scans
from all over the laboratory, furniture included: there a corner is true where two faces meet, and false where none is
near. NEES(2) of the found corners by the covariance that the corner tells; ideal 2.
"""

import json
import math
import time
from dataclasses import dataclass, field

import numpy as np

from core.geometry import Pose
from core.message import Array
from core.perception.landmarks.corners import Corner, CornerSettings, find_corners
from core.perception.landmarks.deskew import deskew
from core.perception.landmarks.landmarks import sight
from core.sensors import Laser, Scan
from core.simulation.laser import SimulatedLaser
from core.simulation.world import LAB, World
from tests.benchmarks.command import print_row, run_command
from tests.core.perception.corner_room import LASER, scan_of, two_walls

NEAR = 0.25  # [m]: a corner found nearer than this to a true one is that one
DISTANCES = (1.0, 2.0, 3.0, 3.8)  # [m]
REACH = 4.0  # [m] to which the laser is used


@dataclass
class Score:
    """Corners found among the true ones."""

    looked: int = 0  # scans
    there: int = 0  # true corners that could have been found
    errors: list[float] = field(default_factory=list[float])  # [m]
    squared: list[float] = field(default_factory=list[float])  # NEES(2) by the corner's covariance
    sighted: list[float] = field(default_factory=list[float])  # NEES(2) by the sighting's, inflation and floor in it
    false: int = 0
    spent: list[float] = field(default_factory=list[float])  # [s] per scan

    def count(self, found: tuple[Corner, ...], places: Array, there: int) -> None:
        """One scan's corners against true places (K, 2), all in the robot frame."""
        self.looked += 1
        self.there += there
        for corner in found:
            off = places - corner.position
            nearest = int(np.hypot(*off.T).argmin())
            error = off[nearest]
            if np.hypot(*error) > NEAR:
                self.false += 1
                continue
            self.errors.append(float(np.hypot(*error)))
            self.squared.append(float(error @ np.linalg.solve(corner.covariance, error)))
            (sighting,), _ = sight((corner,))
            reach, angle = sighting.range, sighting.bearing
            c, s = math.cos(angle), math.sin(angle)
            slope = np.array([[c, -reach * s], [s, reach * c]])
            self.sighted.append(float(error @ np.linalg.solve(slope @ sighting.covariance @ slope.T, error)))

    def told(self) -> dict[str, float]:
        if not self.errors:
            return {"detected": 0.0, "false_per_scan": round(self.false / self.looked, 3)}
        return {
            "rms_mm": round(1000 * math.sqrt(float(np.mean(np.square(self.errors)))), 1),
            "detected": round(len(self.errors) / self.there, 3) if self.there else math.nan,
            "false_per_scan": round(self.false / self.looked, 3),
            "nees_mean": round(float(np.mean(self.squared)), 2),
            "nees_median": round(float(np.median(self.squared)), 2),
            "sighting_nees_mean": round(float(np.mean(self.sighted)), 2),
            "ms_median": round(1000 * float(np.median(self.spent)), 2),
        }


def find(scan: Scan, laser: Laser, settings: CornerSettings | None, score: Score) -> tuple[Corner, ...]:
    """Corners of a scan, the time written down."""
    points, beams = deskew(scan, laser, None, scan.stamp)
    began = time.perf_counter()
    found = find_corners(scan, laser, points, beams, settings)
    score.spent.append(time.perf_counter() - began)
    return found


def single(distance: float, convex: bool, noise: float, trials: int) -> Score:
    """So many single corners, `noise` as a share of the range and of 1 m."""
    rng, score = np.random.default_rng(5), Score()
    settings = CornerSettings(noise_floor=noise, noise_ratio=noise)
    for _ in range(trials):
        place, walls = two_walls(distance, convex, rng)
        scan = scan_of(walls, rng, floor=noise, share=noise, range_max=REACH)
        score.count(find(scan, LASER, settings, score), place[None], 1)
    return score


def true_corners(world: World, height: float) -> Array:
    """Where two faces meet at `height` [m], as (K, 2) [m]."""
    faces = world.surfaces(height).faces
    return np.unique(np.round(np.vstack((faces[:, :2], faces[:, 2:])), 6), axis=0)


def laboratory(scans: int) -> Score:
    """Scans from random poses at rest in the laboratory. What could have been found is not counted there."""
    rng, score, laser = np.random.default_rng(8), Score(), Laser()
    sensor, places = SimulatedLaser(laser, rng), true_corners(LAB, laser.height)
    area = LAB.bounds
    while score.looked < scans:
        x, y = rng.uniform(area.x0, area.x1), rng.uniform(area.y0, area.y1)
        if not LAB.free(x, y, 0.25):
            continue
        pose = Pose(x, y, rng.uniform(-np.pi, np.pi))
        scan = sensor.scan(LAB, 0.0, np.zeros(1), pose.vector[None])
        found = find(scan, laser, None, score)
        score.count(found, pose.inverse().apply(places), 0)
    return score


def main(*, trials: int = 300) -> None:
    for noise in (0.01, 0.03):
        for convex in (False, True):
            for distance in DISTANCES:
                kind = "convex" if convex else "concave"
                row = single(distance, convex, noise, trials).told()
                print_row(f"{100 * noise:.0f} % noise, {kind}, {distance} m: {json.dumps(row)}")
    print_row(f"laboratory: {json.dumps(laboratory(trials).told())}")


if __name__ == "__main__":
    run_command(main)
