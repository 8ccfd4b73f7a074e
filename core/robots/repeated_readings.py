"""Lasers and cameras that hang: they repeat one reading although the robot moves."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from core.message import Array
from core.robots import Profile
from core.sensors import Fault, SensorFrame, Wheels
from core.sensors.checks import fault
from core.sentences import Statement

MIN_REPEATS = 2  # equal readings in a row, on the move, that mean the sensor hangs
MIN_FROZEN, FROZEN_SHARE = 5, 0.05  # of the scans on the move that repeat: said
USELESS_SHARE = 0.75  # of them: nothing of the laser can be used

Sensor = tuple[str, str]  # "laser" or "camera", and its name


class RepeatedReadings:
    """Filter that takes out a hanging sensor's readings, which are as good as nothing, until another one comes.

    Only a robot that moves can tell: one that stands sees the same again and again, in a simulator without noise to
    the last bit. A scan without any echo says nothing either way.
    """

    def __init__(self, profile: Profile) -> None:
        self._lasers = [laser.name for laser in profile.lasers]
        self._cameras = [camera.name for camera in profile.cameras]
        self._last: dict[Sensor, Array] = {}
        self._repeats: dict[Sensor, int] = {}  # of the newest reading, on the move
        self._frozen: dict[str, tuple[int, int]] = {}  # by laser: scans that repeated, and all of them, on the move

    def taken_out(self, frame: SensorFrame, wheels: Wheels | None) -> SensorFrame:
        """The frame without what a hanging sensor repeats; `wheels`: the newest motion, None: not known."""
        moving = wheels is not None and wheels.moves
        scan, image = frame.scan, frame.image
        if scan is not None and scan.valid.any():
            name = scan.laser or next(iter(self._lasers), "")
            if self._hangs(("laser", name), scan.ranges, moving):
                scan = None
        if image is not None:
            name = image.camera or next(iter(self._cameras), "")
            if self._hangs(("camera", name), image.pixels, moving):
                image = None
        if scan is frame.scan and image is frame.image:
            return frame
        return replace(frame, scan=scan, image=image)

    def troubles(self) -> Iterator[tuple[Sensor, str]]:
        """Every sensor, with a sentence while it hangs, else ""."""
        for sensor, repeats in self._repeats.items():
            kind, name = sensor
            alone = len(self._lasers if kind == "laser" else self._cameras) <= 1
            which, what = f"{kind}{'' if alone else f' {name}'}", "scan" if kind == "laser" else "picture"
            sentence = Statement("sensor.repeats", which=which, what=what)
            yield sensor, sentence if repeats >= MIN_REPEATS else ""

    @property
    def faults(self) -> tuple[Fault, ...]:
        """The lasers that repeated their scans."""
        return tuple(
            fault("scan.frozen", name or "the laser", used=count < USELESS_SHARE * every, count=count, all=every)
            for name, (count, every) in self._frozen.items()
            if count >= max(MIN_FROZEN, FROZEN_SHARE * every)
        )

    def hangs(self, kind: str, name: str) -> bool:
        """Return whether this sensor repeats itself."""
        return self._repeats.get((kind, name), 0) >= MIN_REPEATS

    def _hangs(self, sensor: Sensor, data: Array, moving: bool) -> bool:
        last, self._last[sensor] = self._last.get(sensor), data
        before = self._repeats.get(sensor, 0)
        hangs = self._counts(sensor, last, data, moving)
        if sensor[0] == "laser" and moving:
            count, every = self._frozen.get(sensor[1], (0, 0))
            self._frozen[sensor[1]] = count + (self._repeats.get(sensor, 0) > before), every + 1
        return hangs

    def _counts(self, sensor: Sensor, last: Array | None, data: Array, moving: bool) -> bool:
        if last is None or not np.array_equal(last, data, equal_nan=data.dtype.kind == "f"):
            self._repeats[sensor] = 0
        elif moving:
            self._repeats[sensor] = self._repeats.get(sensor, 0) + 1
        return self._repeats.get(sensor, 0) >= MIN_REPEATS
