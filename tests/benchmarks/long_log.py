"""An hour of driving through a storey: `OMP_NUM_THREADS=1 python -m tests.benchmarks.long_log [--scans 20000]`.

A storey of corridors around blocks, with niches in the walls and pilasters before them, drawn from a seed; a robot
goes at random from crossing to crossing at 0.3 m/s, with a laser of 360 beams all around and wheels that err. Every
scan goes through the pilot itself, as in `beckon slam`. Told is the processor time of a scan and the memory of the
process, by blocks: with a map that grows and a way that goes on, times should stay as they began; memory should go
with the place and not with the time (`--columns 1 --rows 1` is a ring that is known after 1,000 scans).
"""

import json
import math
import os
import sys
import time
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import numpy as np

from core.geometry import Pose, arc
from core.message import Array
from core.pilot import Pilot
from core.robots import Profile
from core.sensors import Laser, Scan, SensorFrame, Wheels
from core.simulation.world.plan import Rect, outline
from core.simulation.world.ray_casting import Surfaces, cast
from tests.benchmarks.command import print_row, run_command

PERIOD, STRIDE, BEND = 0.18, 0.054, 0.6  # [s], [m], [m] radius of the arcs at crossings
LASER = Laser(
    beams=360, angle_min=-math.pi, angle_step=2 * math.pi / 360, range_max=10.0, rate=1 / PERIOD, time_step=0.0
)
RANGE_SD = 0.01  # [m]
WAY_SD, TURN_SD = 0.01, math.radians(0.5)  # of the wheels, per root metre: share of the way, [rad]
WAYS = ((1, 0), (0, 1), (-1, 0), (0, -1))  # east, north, west, south


class Storey:
    """Corridors in a lattice, drawn from a seed."""

    def __init__(self, seed: int, columns: int = 4, rows: int = 3) -> None:
        rng = np.random.default_rng((seed, 3))
        self.width = float(rng.uniform(1.6, 2.4))
        self.xs = np.concatenate(([0.0], np.cumsum(rng.uniform(6.0, 11.0, columns)))) + 0.5 * self.width
        self.ys = np.concatenate(([0.0], np.cumsum(rng.uniform(6.0, 9.0, rows)))) + 0.5 * self.width
        half, free, solid = 0.5 * self.width, list[Rect](), list[Rect]()
        for x in self.xs.tolist():
            free.append(Rect(x - half, 0.0, x + half, float(self.ys[-1]) + half))
        for y in self.ys.tolist():
            free.append(Rect(0.0, y - half, float(self.xs[-1]) + half, y + half))
        for lines, others, upright in ((self.xs, self.ys, True), (self.ys, self.xs, False)):
            for line in lines.tolist():
                for low, high in zip(others.tolist(), others[1:].tolist(), strict=False):
                    for side in (-1, 1):
                        self._furnish(
                            rng, line + side * half, side, (low + half, high - half), upright, (free, solid)
                        )
        self.walls = outline(free, solid)

    @staticmethod
    def _furnish(
        rng: np.random.Generator,
        wall: float,
        side: int,
        span: tuple[float, float],
        upright: bool,
        onto: tuple[list[Rect], list[Rect]],
    ) -> None:
        """Niches into a wall and pilasters before it, between two crossings."""
        at = span[0] + rng.uniform(0.4, 1.5)
        while at < span[1] - 1.5:
            long, deep, out = rng.uniform(0.4, 1.1), rng.uniform(0.12, 0.35), rng.random() < 0.7
            first, last = sorted((wall, wall + side * deep * (1 if out else -1)))
            rect = Rect(first, at, last, at + long) if upright else Rect(at, first, at + long, last)
            onto[0 if out else 1].append(rect)
            at += long + rng.uniform(0.5, 2.0)

    def route(self, rng: np.random.Generator) -> Iterator[Pose]:
        """Poses a stride apart, from crossing to crossing without turning back, for ever."""
        column, row, way = 0, 0, 0
        pose = Pose(float(self.xs[0]), float(self.ys[0]), 0.0)
        yield pose
        lead = 0.0  # [m] of the next corridor that the arc before has covered
        while True:
            dx, dy = WAYS[way]
            length = abs(float(self.xs[column + dx] - self.xs[column])) + abs(float(self.ys[row + dy] - self.ys[row]))
            column, row = column + dx, row + dy
            open_ways = [
                turn
                for turn in (0, 1, -1)
                if 0 <= column + WAYS[(way + turn) % 4][0] < len(self.xs)
                and 0 <= row + WAYS[(way + turn) % 4][1] < len(self.ys)
            ]
            turn = int(rng.choice(open_ways))
            straight = length - lead - (BEND if turn else 0.0)
            moves = [(straight, 0.0)] + ([(0.5 * math.pi * BEND, 0.5 * math.pi * turn)] if turn else [])
            for forward, angle in moves:
                count = max(1, round(forward / STRIDE))
                for _ in range(count):
                    pose = pose @ arc(forward / count, angle / count)
                    yield pose
            way, lead = (way + turn) % 4, BEND if turn else 0.0


def frames(seed: int, storey: Storey | None = None) -> Iterator[SensorFrame]:
    """What the robot senses, for ever; the truth is the pose seen from where it began."""
    rng, storey = np.random.default_rng((seed, 4)), storey or Storey(seed)
    surfaces = Surfaces(faces=storey.walls, posts=np.zeros((0, 3)))
    odometry, start, last = Pose(), None, None
    for number, pose in enumerate(storey.route(rng)):
        if start is None or last is None:
            start = last = pose
        odometry, last = odometry @ _felt(last.inverse() @ pose, rng), pose
        yield SensorFrame(
            stamp=PERIOD * number,
            wheels=Wheels(odometry=odometry, speed=STRIDE / PERIOD, turn_rate=0.0),
            scan=_scan(pose, surfaces, PERIOD * number, rng),
            truth=start.inverse() @ pose,
        )


def _felt(driven: Pose, rng: np.random.Generator) -> Pose:
    """A step as the wheels tell it."""
    way = math.hypot(driven.x, driven.y)
    share = 1 + WAY_SD * rng.standard_normal()
    return Pose(share * driven.x, share * driven.y, driven.heading + math.sqrt(way) * TURN_SD * rng.standard_normal())


def _scan(pose: Pose, surfaces: Surfaces, stamp: float, rng: np.random.Generator) -> Scan:
    angles = pose.heading + LASER.angle_min + LASER.angle_step * np.arange(LASER.beams)
    rays = np.column_stack((np.cos(angles), np.sin(angles)))
    ranges: Array = cast(np.array([pose.x, pose.y]), rays, surfaces, LASER.range_max).distance
    ranges = ranges + RANGE_SD * rng.standard_normal(len(ranges))
    return Scan(
        stamp=stamp,
        ranges=np.where(ranges < LASER.range_max, ranges, np.inf),
        angle_min=LASER.angle_min,
        angle_step=LASER.angle_step,
        range_max=LASER.range_max,
    )


def memory_mb() -> float:
    """What this process has of the memory [MB]."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return round(pages * os.sysconf("SC_PAGE_SIZE") / 1e6, 1)


def main(
    *,
    scans: int = 20_000,
    block: int = 1000,  # scans of one line
    seed: int = 0,
    columns: int = 4,  # of blocks
    rows: int = 3,
) -> None:
    pilot = Pilot(Profile(name="long log", url="", lasers=(LASER,), capabilities=frozenset({"replay"})))
    sensed, blocks = frames(seed, Storey(seed, columns, rows)), list[tuple[float, float, float]]()
    for first in range(0, scans, block):
        spent, off = np.zeros(block), 0.0
        for k, frame in enumerate(islice(sensed, block)):
            began = time.process_time()
            pilot.step(frame)
            spent[k] = 1000 * (time.process_time() - began)
            assert frame.truth is not None
            pose = pilot.where(pilot.anchored_pose)
            off = max(off, pose.distance_to(frame.truth.x, frame.truth.y))
        blocks.append((float(np.median(spent)), float(spent.mean()), float(np.percentile(spent, 99))))
        row = dict(zip(("median_ms", "mean_ms", "p99_ms"), (round(one, 2) for one in blocks[-1]), strict=True))
        row |= {"most_ms": round(float(spent.max()), 1), "error_at_most_m": round(off, 3), "memory_mb": memory_mb()}
        print_row(f"scans {first} to {first + block}: {json.dumps(row)}")
    ratio = np.array(blocks[-1]) / np.array(blocks[0])
    sys.stdout.write("last block beside the first: median {:.2f}, mean {:.2f}, p99 {:.2f} times\n".format(*ratio))


if __name__ == "__main__":
    run_command(main)
