"""The laser's time offset, estimated and corrected: `python -m tests.benchmarks.time_offset [--seeds 5] [--drives]`.

Without `--drives`: bias and sd of the estimate after one turn (360°, or 90° to the left and 90° to the right) in two
simulated places, with wheel noise, stamps shifted by up to 100 ms, and jittering: not at all; by what the minimum
filter of `DeviceClock` leaves of 50 ms and a drift by 20 ppm; by 50 ms without the filter. A jitter only makes stamps
later, so its mean belongs to the offset that is looked for. With `--drives`: the pose error of a drive with turns,
its stamps shifted, over that of the same drive with right stamps, from start to end and after the first turn. With
`--console`: the same through wires and a running console, as the page Connect shows it after one turn to either side.
"""

import itertools
import math
import os
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from core.gate import Twist
from core.geometry import wrap
from core.message import Array
from core.pilot import Pilot
from core.robots.device_clock import DeviceClock
from core.sensors import SensorFrame
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import SimulationSettings
from core.slam.scan_matching.time_offset import TimeOffset, TimeOffsetEstimator, TimeOffsetSettings
from tests.benchmarks.command import print_row, run_command
from tests.benchmarks.real_sessions import obey
from tests.benchmarks.running_console import console
from tests.emulators.robot_process import SHIFT, robot_process

SHIFTS = (-0.1, -0.04, 0.0, 0.04, 0.1)  # [s]
RATES = (0.5, 1.0, 1.5)  # [rad/s]
PLACES = ("lab", "floor")
DRIFT = 20e-6  # of the laser's clock
JITTER = 0.05  # [s] by which stamps are late at most, evenly distributed
BEGAN = 20.0  # [s] for which the clock was filtered before the drive
Leg = tuple[float, float, float]  # [s], [m/s], [rad/s]

WAY: tuple[Leg, ...] = (
    (2.0, 0.0, 0.0),
    (3.0, 0.1, 0.0),
    (0.5, 0.0, 0.0),
    (2 * math.pi, 0.0, 1.0),
    (0.5, 0.0, 0.0),
    (3.0, 0.1, 0.0),
    (1.8, 0.05, 0.9),
    (1.8, 0.0, -1.2),
    (0.5, 0.0, 0.0),
    (1.2, 0.0, 1.4),
    (0.4, 0.0, 0.0),
    (2.0, 0.1, 0.3),
    (3.0, 0.1, -0.5),
    (1.0, 0.0, 0.0),
)
TURNED = 12.0  # [s] of the way after which the first turn is over


def turns(rate: float) -> dict[str, tuple[Leg, ...]]:
    """The turns after which the offset must be known, at `rate` [rad/s]."""
    rest, quarter = (1.0, 0.0, 0.0), math.pi / 2 / rate
    return {
        "360": (rest, (4 * quarter, 0.0, rate), rest),
        "90+90": (rest, (quarter, 0.0, rate), rest, (quarter, 0.0, -rate), rest),
    }


@dataclass
class Stamping:
    """Wrong stamps: what a laser's own clock and its link make of the time."""

    shift: float  # [s] that is added
    jitter: float = 0.0  # [s] at most
    filtered: bool = False  # by DeviceClock; else scans are stamped as they come
    seed: int = 0

    def __post_init__(self) -> None:
        self._rng, self._clock = np.random.default_rng(1000 + self.seed), DeviceClock()
        for stamp in np.arange(-BEGAN, 0.0, 0.1).tolist() if self.filtered else ():
            self._filter(stamp)

    @property
    def offset(self) -> float:
        """What has to be added to the stamps in the mean [s]."""
        return -self.shift - (0.0 if self.filtered else self.jitter / 2)

    def _filter(self, stamp: float) -> float:
        return self._clock.stamp((1 + DRIFT) * stamp, stamp + float(self._rng.uniform(0, self.jitter)))

    def __call__(self, frame: SensorFrame) -> SensorFrame:
        """The frame, its scan stamped so."""
        if frame.scan is None:
            return frame
        stamp = frame.scan.stamp
        late = self._filter(stamp) if self.filtered else stamp + float(self._rng.uniform(0, self.jitter))
        return replace(frame, scan=replace(frame.scan, stamp=late + self.shift))


def frames(place: str, legs: tuple[Leg, ...], stamping: Stamping, seed: int) -> Iterator[SensorFrame]:
    robot = SimulatedRobot(place, seed=seed, settings=SimulationSettings(camera=False))
    for seconds, speed, turn_rate in legs:
        for _ in range(round(seconds * robot.profile.rate)):
            robot.drive(Twist(speed, turn_rate))
            yield stamping(robot.read())


def estimated(place: str, legs: tuple[Leg, ...], stamping: Stamping, seed: int) -> tuple[float, float]:
    """The offset and its sd after a drive [s]; NaN where it is not known."""
    profile = SimulatedRobot(place, settings=SimulationSettings(camera=False)).profile
    estimator = TimeOffsetEstimator(profile.lasers[0], TimeOffsetSettings())
    for frame in frames(place, legs, stamping, seed):
        estimator.update(frame.stamp, frame.wheels, frame.scan)
    found = estimator.newest
    return (math.nan, math.nan) if found is None else (found.offset, math.sqrt(found.variance))


@dataclass(frozen=True)
class Driven:
    """How a drive went."""

    errors: Array  # (F,) [m] of the position
    turned: Array  # (F,) [rad] of the heading
    stamps: Array  # (F,) [s]
    timing: TimeOffset | None
    lost: bool  # the robot believed to have been carried

    def mean(self, since: float = 0.0) -> tuple[float, float]:
        """Mean error of position [m] and heading [rad] from a time [s] on."""
        after = self.stamps > since
        return float(self.errors[after].mean()), float(self.turned[after].mean())


def driven(place: str, stamping: Stamping, seed: int, legs: tuple[Leg, ...] = WAY) -> Driven:
    """A drive with the whole pilot."""
    profile = SimulatedRobot(place, settings=SimulationSettings(camera=False)).profile
    pilot, rows, lost, timing = Pilot(profile), list[tuple[float, float, float]](), False, None
    for frame in frames(place, legs, stamping, seed):
        snapshot, truth = pilot.step(frame), frame.truth
        assert truth is not None
        pose, timing = snapshot.estimate.pose, next(iter(snapshot.timings), None)
        lost = lost or snapshot.floor.lost is not None
        rows.append((pose.distance_to(truth.x, truth.y), abs(wrap(pose.heading - truth.heading)), frame.stamp))
    errors, turned, stamps = np.array(rows).T
    return Driven(errors, turned, stamps, timing, lost)


def report_estimates(seeds: int) -> None:
    """Bias, sd and worst error over places, turn rates, shifts and seeds."""
    kinds = {"none": (0.0, False), "50 ms, filtered": (JITTER, True), "50 ms, raw": (JITTER, False)}
    show("place  turn   jitter           known   bias ms   sd ms  claimed ms  worst ms  > 10 ms")
    for place, (kind, (jitter, filtered)), turn in itertools.product(PLACES, kinds.items(), turns(1.0)):
        rows: list[tuple[float, float]] = []
        for rate, shift, seed in itertools.product(RATES, SHIFTS, range(seeds)):
            stamping = Stamping(shift, jitter, filtered, seed)
            offset, sd = estimated(place, turns(rate)[turn], stamping, seed)
            rows.append((1000 * (offset - stamping.offset), 1000 * sd))
        errors, sds = np.array(rows).T
        known = errors[np.isfinite(errors)]
        show(
            f"{place:6} {turn:6} {kind:16} {len(known):3}/{len(errors):3} {known.mean():8.2f} {known.std():7.2f}"
            f" {np.nanmean(sds):11.2f} {np.abs(known).max():9.2f} {(np.abs(known) > 10).sum():8}"
        )


def report_drives(seeds: int) -> None:
    """Mean pose errors of shifted drives, median and worst of the seeds, and their ratios to right stamps."""
    show("            the whole way                                      after the first turn")
    show("shift ms    position mm           heading deg                  position mm           heading deg      lost")
    right = [driven("lab", Stamping(0.0, seed=seed), seed) for seed in range(seeds)]
    for shift in SHIFTS:
        runs = [driven("lab", Stamping(shift, seed=seed), seed) for seed in range(seeds)]
        line = f"{1000 * shift:8.0f}"
        for since in (0.0, TURNED):
            ours, base = (np.array([run.mean(since) for run in group]) for group in (runs, right))
            for column, unit in ((0, 1000.0), (1, math.degrees(1.0))):
                middle, worst = float(np.median(ours[:, column])), float(ours[:, column].max())
                by = middle / float(np.median(base[:, column])), worst / float(base[:, column].max())
                line += f"  {unit * middle:5.3f} {unit * worst:5.3f} ({by[0]:4.2f} {by[1]:4.2f})"
        show(f"{line}   {sum(run.lost for run in runs)}")


def report_console(wires: tuple[str, ...] = ("foxglove", "zenoh", "rosbridge")) -> None:
    """The offset after `turn left`, and after `turn right`, over real wires."""
    show("                     after turn left                after turn right, too")
    show("wire       shift ms  offset ms  sd ms  applied  offset ms  sd ms  applied  load")
    for wire, shift in itertools.product(wires, (-0.1, 0.0, 0.1)):
        with robot_process(wire, f"{SHIFT}{shift}") as robot, console(auth=True, robot=robot.url) as running:
            time.sleep(3.0)
            line = f"{wire:10} {1000 * shift:8.0f}"
            for words in ("turn left", "turn right"):
                obey(running, words)
                timings = running.get("/api/state")["robot"]["timings"]
                timing = timings[0] if timings else dict.fromkeys(("offset_s", "sd_s", "applied_s"), math.nan)
                line += f"  {1000 * timing['offset_s']:8.1f} {1000 * timing['sd_s']:6.1f}"
                line += f" {1000 * timing['applied_s']:8.1f}"
        show(f"{line}  {os.getloadavg()[0]:.1f}")


def show(line: str) -> None:
    """Write a line of a table."""
    print_row(line)


def main(*, seeds: int = 5, drives: bool = False, console: bool = False) -> None:
    if console:
        report_console()
    else:
        (report_drives if drives else report_estimates)(seeds)


if __name__ == "__main__":
    run_command(main)
