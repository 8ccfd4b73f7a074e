"""A simulated robot with faults, as `core.robots.injected_faults` lists them: they fall on what it senses alone."""

import math
from dataclasses import replace

import numpy as np

from core.geometry import Pose
from core.robots.injected_faults import Delay, faults_of
from core.sensors import Image, Scan, SensorFrame, Wheels
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import SimulationSettings

JUMP_PERIOD_S = 5.0  # between two jumps of the odometry


class FaultyRobot(SimulatedRobot):
    """Drives and answers as the simulated robot does; its frames are spoilt."""

    def __init__(self, place: str, faults: dict[str, float], seed: int, settings: SimulationSettings | None) -> None:
        super().__init__(place, seed=seed, settings=settings)
        self._faults, self._chance = faults, np.random.default_rng(seed)
        self._late_scans, self._late_images = Delay[Scan](), Delay[Image]()
        self._frozen_scan: Scan | None = None  # the first one of a laser that hangs
        self._frozen_image: Image | None = None
        self._rolled, self._odometry = Pose(), Pose()  # as the wheels have it, and as it is said
        self._jumps = 0

    def read(self) -> SensorFrame:
        """Sense, and spoil it once the faults have begun."""
        frame = super().read()
        if frame.stamp < self._faults.get("after", 0.0):
            if frame.wheels is not None:
                self._rolled = self._odometry = frame.wheels.odometry
            return frame
        return replace(
            frame,
            wheels=self._rolling(frame.wheels, frame.stamp),
            scan=self._seen(frame.scan, frame.stamp),
            image=self._taken(frame.image, frame.stamp),
            sound=None if self._faults.get("no_sound") else frame.sound,
            contact=frame.contact or bool(self._faults.get("bumper")),
            battery=self._faults.get("battery", frame.battery),
        )

    def _rolling(self, wheels: Wheels | None, stamp: float) -> Wheels | None:
        """Turn in vain, and jump."""
        if wheels is None:
            return None
        moved = self._rolled.inverse() @ wheels.odometry
        self._rolled = wheels.odometry
        spun = 1.0 / (1.0 - self._faults.get("slip", 0.0))
        self._odometry = self._odometry @ Pose(moved.x * spun, moved.y * spun, moved.heading)
        jumps = math.floor((stamp - self._faults.get("after", 0.0)) / JUMP_PERIOD_S)
        if jumps > self._jumps:
            self._jumps = jumps
            self._odometry = self._odometry @ Pose(0.0, self._faults.get("odometry_jump", 0.0), 0.0)
        return replace(wheels, odometry=self._odometry, speed=wheels.speed * spun)

    def _seen(self, scan: Scan | None, stamp: float) -> Scan | None:
        """Spoil a scan; the eldest that has arrived comes, for a frame has room for one."""
        if scan is not None and self._chance.random() >= self._faults.get("lost_scan", 0.0):
            if self._faults.get("frozen_scan"):
                self._frozen_scan = self._frozen_scan or scan
                scan = replace(scan, ranges=self._frozen_scan.ranges)
            blind = self._chance.random(len(scan.ranges)) < self._faults.get("blind_scan", 0.0)
            spoilt = np.where(blind, np.nan, scan.ranges)
            scan = replace(scan, ranges=spoilt, stamp=scan.stamp + self._faults.get("early_scan", 0.0))
            self._late_scans.put(scan, stamp + self._faults.get("late_scan", 0.0))
        return next(self._late_scans.arrived(stamp), None)

    def _taken(self, image: Image | None, stamp: float) -> Image | None:
        if image is not None:
            if self._faults.get("frozen_picture"):
                self._frozen_image = self._frozen_image or image
                image = replace(image, pixels=self._frozen_image.pixels, packed=self._frozen_image.packed)
            if self._faults.get("black_picture"):
                image = replace(image, pixels=np.zeros_like(image.pixels), packed=b"")
            self._late_images.put(image, stamp + self._faults.get("late_picture", 0.0))
        return next(self._late_images.arrived(stamp), None)


def open_robot(rest: str, *, seed: int = 0, settings: SimulationSettings | None = None) -> SimulatedRobot:
    """`sim:<rest>` → the robot in that world, with the faults behind a question mark. Raises BadInput."""
    place, faults = faults_of(rest)
    if faults:
        return FaultyRobot(place or "lab", faults, seed, settings)
    return SimulatedRobot(place or "lab", seed=seed, settings=settings)
