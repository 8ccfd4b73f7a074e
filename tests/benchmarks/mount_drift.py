"""How soon a turned camera is noticed: `python -m tests.benchmarks.mount_drift [--tours 20] [--minutes 3]`.

A robot wanders through both simulated worlds: in place towards a free way, along it, and so on. Laser and camera are
simulated on the way and seen with the pilot's own eyes, whose profile has the camera turned or shifted against where
it really sits. False alarms are counted over all tours without any fault; then the time until the alarm for several
turns and shifts, and by how much the estimate errs at the end.
"""

import itertools
import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from core.calibration.laser.drift import Drift, MountWatch
from core.geometry import Pose, Transform, arc, wrap
from core.perception.landmarks.edge_pairs import EdgePair
from core.pilot.landmark_perception import LandmarkPerception
from core.robots import Profile
from core.sensors import Camera, Laser, SensorFrame, Wheels
from core.settings import Settings
from core.simulation.camera import SimulatedCamera
from core.simulation.laser import SimulatedLaser
from core.simulation.world import World, world_named
from core.slam.motion import Motion, WheelTrack
from tests.benchmarks.command import print_row, run_command

STEP = 0.025  # [s]
EVERY = 12  # steps between two looks: what lies between moves too little to be counted
SPEED, TURN_RATE = 0.12, 0.5  # [m/s], [rad/s]
CLEAR = 0.3  # [m] from the way to everything
DELAY = 2  # steps from the picture to the scan


def wander(world: World, rng: np.random.Generator, seconds: float) -> Iterator[tuple[Pose, float, float]]:
    """(pose, speed, turn rate) every STEP: to one free place after the other on straight ways."""
    bounds, pose, steps = world.bounds, Pose(), itertools.count()
    while True:
        x, y = rng.uniform((bounds.x0, bounds.y0), (bounds.x1, bounds.y1)).tolist()
        far = pose.distance_to(x, y)
        way = [(pose.x + s * (x - pose.x), pose.y + s * (y - pose.y)) for s in np.arange(0, 1, 0.1 / max(far, 0.1))]
        if not 0.5 < far < 4.0 or not world.free(x, y, CLEAR):
            continue
        if any(world.distance(*spot) < CLEAR for spot in way[3:]):
            continue
        turn = wrap(math.atan2(y - pose.y, x - pose.x) - pose.heading)
        legs = [(0.0, math.copysign(TURN_RATE, turn), abs(turn) / TURN_RATE), (SPEED, 0.0, far / SPEED)]
        for speed, turn_rate, lasting in legs:
            for _ in range(round(lasting / STEP)):
                pose = pose @ arc(speed * STEP, turn_rate * STEP)
                yield pose, speed, turn_rate
                if next(steps) * STEP > seconds:
                    return


Look = tuple[float, Pose, tuple[EdgePair, ...]]


def looks(world: World, seed: int, seconds: float, turn: float = 0.0, shift: float = 0.0) -> Iterator[Look]:
    """Stamp [s], pose and pairs all along a tour; the camera sits turned [rad] and shifted [m] to the left."""
    rng = np.random.default_rng(seed)
    laser, believed = Laser(), Camera()
    mounting = Transform(
        rotation=Transform.of_pose(Pose(0, 0, turn)).rotation @ believed.mounting.rotation,
        translation=believed.mounting.translation + np.array([0.0, shift, 0.0]),
    )
    camera = SimulatedCamera(Camera(mounting=mounting), world, rng)
    sweep = SimulatedLaser(laser, rng, floor_sd=0.01, share_sd=0.01, dropout=0.004)
    eyes = LandmarkPerception(Profile(name="", url="", lasers=(laser,), cameras=(believed,)), Settings())
    past: list[tuple[float, float, float, float]] = []
    heading, track = 0.0, WheelTrack()
    for number, (pose, speed, turn_rate) in enumerate(wander(world, rng, seconds)):
        stamp = number * STEP
        heading += wrap(pose.heading - heading)
        past.append((stamp, pose.x, pose.y, heading))
        wheels = Wheels(odometry=Pose(), speed=speed, turn_rate=turn_rate)
        phase = number % EVERY
        motion = Motion(track.step(stamp, wheels), wheels)
        if phase == 0 and number:
            image = camera.take(world, stamp, pose, turn_rate)
            eyes.look(SensorFrame(stamp=stamp, wheels=wheels, image=image), motion)
        elif phase == DELAY + 4 and number > EVERY:
            poses = np.array(past[-20:])
            scan = sweep.scan(world, stamp - 4 * STEP, poses[:, 0], poses[:, 1:])
            yield stamp, pose, eyes.look(SensorFrame(stamp=stamp, wheels=wheels, scan=scan), motion).pairs


def watched(told: Iterator[Look]) -> tuple[float | None, Drift | None, int]:
    """A tour → when the alarm came [s], the estimate at the end, and how often an alarm began."""
    watch, camera = MountWatch(), Camera()
    first: float | None = None
    begun, before = 0, False
    for stamp, pose, pairs in told:
        watch.watch(stamp, pose, pairs, camera)
        alarm = bool(watch.alarm)
        begun += alarm and not before
        before = alarm
        if alarm and first is None:
            first = stamp
    return first, watch.drift, begun


def row(world: str, seed: int, seconds: float, turn: float, shift: float) -> dict[str, Any]:
    """One tour's figures."""
    first, drift, begun = watched(looks(world_named(world), seed, seconds, turn, shift))
    told: dict[str, Any] | None = None
    if drift is not None:
        told = {name: getattr(drift, name) for name in ("shift", "shift_sd", "pairs", "corners")}
        angles = ("apparent", "apparent_sd", "turn", "turn_sd")
        told |= {f"{name}_deg": math.degrees(getattr(drift, name)) for name in angles}
    return {"world": world, "seed": seed, "alarm_s": first, "alarms": begun, "estimate": told}


def main(
    *,
    tours: int = 20,
    minutes: float = 3.0,
    first: int = 0,  # seed of the first tour
    out: Path | None = None,
) -> None:
    faults = [(0.0, 0.0, tours, 60 * minutes)]
    faults += [(math.radians(turn), 0.0, max(tours // 5, 2), 60.0) for turn in (0.5, -0.5, 0.8, 3.0)]
    faults += [(0.0, 0.03, max(tours // 5, 2), 90.0)]
    told: list[dict[str, Any]] = []
    for turn, shift, count, seconds in faults:
        rows = [row(("lab", "floor")[seed % 2], seed, seconds, turn, shift) for seed in range(first, first + count)]
        told.append({"turn_deg": math.degrees(turn), "shift_m": shift, "seconds": seconds, "tours": rows})
        print_row(f"turned {math.degrees(turn):+.1f} deg, shifted {shift:+.3f} m, {count} tours of {seconds:g} s")
        for one in rows:
            print_row(f"  {one['world']:5} {one['seed']:3} {_when(one['alarm_s'])}, {_shown(one)}")
    if out is not None:
        out.write_text(json.dumps(told, indent=1))


def _when(alarm: float | None) -> str:
    return "no alarm" if alarm is None else f"alarm at {alarm:.1f} s"


def _shown(one: dict[str, Any]) -> str:
    told = one["estimate"]
    if told is None:
        return "no estimate"
    turn = f"apparent turn {told['apparent_deg']:+.2f} ± {told['apparent_sd_deg']:.2f} deg"
    shift = f"shift {told['shift']:+.4f} ± {told['shift_sd']:.4f} m"
    return f"{turn}, {shift}, {told['pairs']} pairs of {told['corners']} corners"


if __name__ == "__main__":
    run_command(main)
