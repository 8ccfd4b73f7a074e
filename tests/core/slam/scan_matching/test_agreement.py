"""Wheels against scans: each way in which they can contradict each other is named, and sound ones never are."""

import itertools
import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from core.geometry import Pose, arc, wrap
from core.sensors import Laser, Scan, SensorFrame, Wheels
from core.simulation.laser import SimulatedLaser
from core.simulation.world import world_named
from core.slam.motion import MotionSettings
from core.slam.odometry import Odometry
from core.slam.scan_matching.agreement import LATES_S, find_lateness
from core.slam.scan_matching.scan_odometry import ScanOdometrySettings
from tests.core.slam.scan_matching.slipping_wheels import PERIOD_S, slipping_wheels

LASER = Laser(beams=181, angle_min=-math.pi / 2 * 1.33, angle_step=math.radians(1.33), time_step=0.0, rate=5.0)


@dataclass(frozen=True)
class Member:
    """One scan with the wheels, both as they claim to be."""

    scan: Scan
    wheels: Pose
    truth: Pose


Making = Callable[[Laser, list[Member]], tuple[Laser, list[Member]]]


def sound_drive(world: str, sweep_s: float = 0.0) -> list[Member]:
    """A drive whose wheels slip by a few percent; each scan takes `sweep_s` from its stamp on."""
    rng = np.random.default_rng(3)
    laser = SimulatedLaser(replace(LASER, time_step=sweep_s / LASER.beams), rng)
    place, found = world_named(world), list[Member]()
    for speed, rate, truth, rolled in slipping_wheels(rng):
        stamp = PERIOD_S * len(found)
        ahead = truth @ arc(speed * sweep_s, rate * sweep_s)
        course = np.array([truth.vector, (ahead.x, ahead.y, truth.heading + rate * sweep_s)])
        scan = laser.scan(place, stamp, np.array([stamp, stamp + (sweep_s or 1.0)]), course)
        found.append(Member(scan, rolled, truth))
    return found


def by_moves(change: Callable[[float, Pose], Pose]) -> Making:
    """Wheels that make something else of every move, at a time [s]."""

    def make(laser: Laser, drive: list[Member]) -> tuple[Laser, list[Member]]:
        claimed, made = Pose(), [drive[0]]
        for before, now in itertools.pairwise(drive):
            claimed = claimed @ change(now.scan.stamp, before.wheels.inverse() @ now.wheels)
            made.append(replace(now, wheels=claimed))
        return laser, made

    return make


def scaled(way: float, turn: float) -> Making:
    return by_moves(lambda _, move: Pose(way * move.x, way * move.y, wrap(turn * move.heading)))


def stuck(start: float, lasts: float) -> Making:
    return by_moves(lambda at, move: Pose() if start <= at < start + lasts else move)


def mounted(degrees: float) -> Making:
    return lambda laser, drive: (replace(laser, mounting=Pose(0.0, 0.0, math.radians(degrees))), drive)


def mirrored(laser: Laser, drive: list[Member]) -> tuple[Laser, list[Member]]:
    last = LASER.angle_min + LASER.angle_step * (LASER.beams - 1)
    turned = [replace(one, scan=replace(one.scan, ranges=one.scan.ranges[::-1], angle_min=-last)) for one in drive]
    return laser, turned


def ranged(scale: float) -> Making:
    """Ranges and their limits in another unit."""

    def changed(scan: Scan) -> Scan:
        return replace(scan, ranges=scale * scan.ranges, range_max=scale * scan.range_max)

    return lambda laser, drive: (laser, [replace(one, scan=changed(one.scan)) for one in drive])


def at_random(laser: Laser, drive: list[Member]) -> tuple[Laser, list[Member]]:
    """Wheels that lead as far as they should, in any direction."""
    rng = np.random.default_rng(6)

    def turned(_: float, move: Pose) -> Pose:
        x, y = math.hypot(move.x, move.y) * np.array([np.cos(a := rng.uniform(0, math.tau)), np.sin(a)])
        return Pose(float(x), float(y), float(rng.choice([-1.0, 1.0])) * move.heading)

    return by_moves(turned)(laser, drive)


def late(seconds: float) -> Making:
    steps = round(seconds / PERIOD_S)
    return lambda laser, drive: (
        laser,
        [replace(one, wheels=drive[min(max(k + steps, 0), len(drive) - 1)].wheels) for k, one in enumerate(drive)],
    )


def spinning(start: float, lasts: float) -> Making:
    """A robot that is held for so long while its wheels go on."""

    def make(laser: Laser, drive: list[Member]) -> tuple[Laser, list[Member]]:
        at, rng = round(start / PERIOD_S), np.random.default_rng(4)
        ahead, held = arc(0.25 * PERIOD_S, 0.1), list[Member]()
        for number in range(round(lasts / PERIOD_S)):
            wheels = (held[-1].wheels if held else drive[at].wheels) @ ahead
            ranges = drive[at].scan.ranges + rng.normal(0.0, 0.01, LASER.beams)
            scan = replace(drive[at].scan, ranges=ranges, stamp=drive[at].scan.stamp + number * PERIOD_S)
            held.append(Member(scan, wheels, drive[at].truth))
        back, later = held[-1].wheels @ drive[at].wheels.inverse(), len(held) * PERIOD_S
        rest = [
            replace(one, wheels=back @ one.wheels, scan=replace(one.scan, stamp=one.scan.stamp + later))
            for one in drive[at:]
        ]
        return laser, drive[:at] + held + rest

    return make


def listened(making: Making, drive: list[Member]) -> tuple[Odometry, list[Pose], list[Member]]:
    """The odometry, the moves that it made of the drive added up, and the drive."""
    laser, made = making(LASER, drive)
    odometry, pose, path = Odometry(laser, MotionSettings(), ScanOdometrySettings()), Pose(), list[Pose]()
    for one in made:
        wheels = Wheels(odometry=one.wheels, speed=0.0, turn_rate=0.0)
        motion = odometry.update(SensorFrame(stamp=one.scan.stamp, wheels=wheels, scan=one.scan))
        pose = pose @ motion.increment.pose
        path.append(pose)
    odometry.agreement.finish()
    return odometry, path, made


@pytest.fixture(scope="module")
def drives() -> dict[str, list[Member]]:
    return {world: sound_drive(world) for world in ("lab", "floor")}


@pytest.mark.parametrize("world", ["lab", "floor"])
@pytest.mark.parametrize("making", [scaled(0.97, 1.05), scaled(1.02, 0.95)])
def test_sound_wheels_and_scans_agree(drives: dict[str, list[Member]], world: str, making: Making) -> None:
    odometry, _, made = listened(making, drives[world])
    assert len(made) > 200
    assert odometry.faults == ()
    assert odometry.agreement.lateness == 0.0


@pytest.mark.parametrize("world", ["lab", "floor"])
@pytest.mark.parametrize("sweep_s", [0.05, 0.1, 0.15])
def test_a_scan_that_takes_a_while_agrees_with_the_wheels(world: str, sweep_s: float) -> None:
    odometry, _, _ = listened(lambda laser, drive: (laser, drive), sound_drive(world, sweep_s))
    assert odometry.faults == ()
    assert odometry.agreement.compared.way_scale == pytest.approx(1.02, abs=0.05)
    assert odometry.agreement.compared.turn_scale == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize(
    ("making", "code"),
    [
        (scaled(1.2, 1.0), "agreement.way_scale"),
        (scaled(0.8, 1.0), "agreement.way_scale"),
        (scaled(100.0, 1.0), "agreement.way_scale"),
        (scaled(0.01, 1.0), "agreement.way_scale"),
        (ranged(1.1), "agreement.way_scale"),
        (ranged(0.9), "agreement.way_scale"),
        (ranged(10.0), "agreement.way_scale"),
        (scaled(1.0, 1.5), "agreement.turn_scale"),
        (by_moves(lambda _, move: Pose(move.x, move.y, max(move.heading, 0.0))), "agreement.turn_scale"),
        (at_random, "agreement.differ"),
        (scaled(1.0, -1.0), "agreement.mirrored"),
        (mirrored, "agreement.mirrored"),
        (scaled(-1.0, 1.0), "agreement.mount"),
        (mounted(12.0), "agreement.mount"),
        (mounted(90.0), "agreement.mount"),
        (mounted(180.0), "agreement.mount"),
        (late(0.6), "agreement.late"),
        (late(2.0), "agreement.late"),
        (late(-0.6), "agreement.early"),
        (stuck(15.0, 5.0), "agreement.wheels_stand"),
        (spinning(15.0, 5.0), "agreement.wheels_spin"),
    ],
)
def test_each_contradiction_is_named(drives: dict[str, list[Member]], making: Making, code: str) -> None:
    odometry, _, _ = listened(making, drives["lab"])
    assert [fault.code for fault in odometry.faults] == [code]


def test_wheels_that_tremble_while_the_robot_stands_do_not_spin(drives: dict[str, list[Member]]) -> None:
    rng, (first, *_) = np.random.default_rng(8), drives["lab"]
    stands = [
        Member(
            replace(first.scan, ranges=first.scan.ranges + rng.normal(0.0, 0.01, LASER.beams), stamp=PERIOD_S * k),
            Pose(float(rng.normal(0.0, 0.05)), float(rng.normal(0.0, 0.05)), 0.0),
            first.truth,
        )
        for k in range(100)
    ]
    odometry, _, _ = listened(lambda laser, drive: (laser, drive), stands)
    assert "agreement.wheels_spin" not in {fault.code for fault in odometry.faults}


def says_a_sweep(seconds: float) -> Making:
    """Scans of one moment that claim to begin then, and to take so long."""

    def changed(scan: Scan) -> Scan:
        return replace(scan, time_step=seconds / LASER.beams)

    return lambda laser, drive: (laser, [replace(one, scan=changed(one.scan)) for one in drive])


@pytest.mark.parametrize("world", ["lab", "floor"])
def test_half_a_sweep_of_lateness_is_named(drives: dict[str, list[Member]], world: str) -> None:
    odometry, _, _ = listened(says_a_sweep(0.15), drives[world])
    assert [fault.code for fault in odometry.faults] == ["agreement.late"]
    assert odometry.agreement.lateness == pytest.approx(-0.075, abs=0.03)


@pytest.mark.parametrize("making", [stuck(21.0, 8.0), stuck(14.0, 5.0), spinning(8.0, 5.0)])
def test_wheels_that_stand_or_spin_alone_are_not_followed(drives: dict[str, list[Member]], making: Making) -> None:
    _, path, made = listened(making, drives["floor"])
    off = (made[0].truth.inverse() @ made[-1].truth).inverse() @ path[-1]
    claimed = (made[0].truth.inverse() @ made[-1].truth).inverse() @ made[-1].wheels
    assert math.hypot(off.x, off.y) < 0.5 * math.hypot(claimed.x, claimed.y)


@pytest.mark.parametrize("turned", [0.004, 0.2])
def test_wheels_that_err_are_not_late_where_they_did_not_turn(turned: float) -> None:
    """At some other moment they stood: then there is less to differ in, and a scale of -1 takes all turns away."""
    rng = np.random.default_rng(0)
    seen = turned * rng.choice([-1.0, 1.0], 20)
    rolled = seen[:, None] + rng.normal(0.0, 0.02, (20, len(LATES_S)))
    rolled[:, 5] = rng.normal(0.0, 0.002, 20)
    found, _ = find_lateness(deque((0.5, *one) for one in zip(seen.tolist(), rolled, strict=True)))
    assert found == 0.0
