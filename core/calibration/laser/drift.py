"""Check that the camera still sits on the laser as it was calibrated, from corners and edges met on the way."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from core.calibration.laser.mixture import Gathered, TransformFit, fit
from core.geometry import Pose
from core.message import Array, message
from core.perception.landmarks.edge_pairs import EdgePair
from core.sensors import Camera
from core.setting import Meta, Section, ThresholdSet


@dataclass(frozen=True)
class DriftThresholds(ThresholdSet):
    """Looks that are kept, and how sure a change must be."""

    step: float = 0.04  # [m] way between two looks: at rest they are all the same
    turn: float = math.radians(3)  # [rad] turn between two looks, where the way is shorter
    looks: int = 200  # looks that are kept
    half_life: float = 60.0  # [looks] age at which a look counts half
    every: float = 1.0  # [s] time between two estimates
    apart: float = 0.4  # [m] corners closer together than this are one corner
    corners: int = 4  # different corners, at least, before anything is reported
    sure: float = 3.0  # [sd] significance of a reported change
    calm: float = 0.5  # share of the thresholds below which an alarm is over


@dataclass(frozen=True)
class DriftSettings(DriftThresholds, Section):
    """Criteria of a moved mount.

    Watch:
        turned: warnings of a turned mount; raise it for false ones
        shifted: warnings of a shifted mount; raise it for false ones
        lasting: time until such a warning
    """

    turned: Annotated[float, Meta("rad", 1e-4, 0.5, "a smaller turn of the mount does not matter")] = math.radians(
        0.3
    )
    shifted: Annotated[float, Meta("m", 0.001, 0.5, "a smaller shift of the mount does not matter")] = 0.015
    lasting: Annotated[float, Meta("s", 0, 60, "time that a change must be seen before it is reported")] = 3.0


@message
class Drift:
    """Estimated difference of the camera's mount from the calibration in use."""

    turn: float  # [rad] counter-clockwise
    turn_sd: float
    shift: float  # [m] to the left of where it looks
    shift_sd: float
    apparent: float  # [rad] the turn that looks like both together at the usual distance: known best
    apparent_sd: float
    pairs: int  # of a corner and its edge that say so
    corners: int  # different ones
    alarm: bool = False
    words: str = ""


class MountWatch:
    """Gathers pairs of corner and edge while the robot drives. Owned by the pilot."""

    def __init__(self, settings: DriftSettings | None = None) -> None:
        self._settings = settings or DriftSettings()
        self.drift: Drift | None = None  # None: not enough was seen
        self._forget(None)

    def _forget(self, camera: Camera | None) -> None:
        """Start again, for this camera as it is calibrated."""
        self._camera = camera
        self._looks: deque[list[tuple[EdgePair, int]]] = deque(maxlen=self._settings.looks)
        self._places: list[Array] = []  # (2,) [m] of corners that were met, world
        self._last: Pose | None = None
        self._estimated = -math.inf
        self._suspected: float | None = None  # [s] since when
        self._alarm = ""
        self.drift = None

    @property
    def alarm(self) -> str:
        """The warning for the operator; empty while all is well. The first figures stay: it is reported once."""
        return self._alarm

    def watch(self, stamp: float, pose: Pose, pairs: tuple[EdgePair, ...], camera: Camera | None) -> None:
        """The pairs of one scan, seen from `pose` in the world. A new calibration of the camera starts again."""
        if camera is not self._camera:
            self._forget(camera)
        if not pairs or not self._moved(pose):
            return
        self._last = pose
        places = pose.apply(np.array([pair.position for pair in pairs]))
        self._looks.append([(pair, self._place(place)) for pair, place in zip(pairs, places, strict=True)])
        if stamp - self._estimated >= self._settings.every:
            self._estimated = stamp
            self._estimate(stamp)

    def _moved(self, pose: Pose) -> bool:
        last, settings = self._last, self._settings
        if last is None:
            return True
        turned = abs(math.remainder(pose.heading - last.heading, math.tau))
        return pose.distance_to(last.x, last.y) >= settings.step or turned >= settings.turn

    def _place(self, place: Array) -> int:
        """The number of the corner that stands there."""
        if self._places:
            away = np.hypot(*(np.array(self._places) - place).T)
            if away.min() < self._settings.apart:
                return int(away.argmin())
        self._places.append(place)
        return len(self._places) - 1

    def _estimate(self, stamp: float) -> None:
        settings = self._settings
        rows = [
            (pair.off, pair.sd, pair.lever, 0.5 ** (age / settings.half_life), place)
            for age, look in enumerate(reversed(self._looks))
            for pair, place in look
        ]
        off, sd, lever, weight, place = np.array(rows).T
        found = fit(Gathered(off=off, sd=sd, lever=lever, weight=weight, corner=place.astype(int)))
        if found is None or found.corners < settings.corners:
            self.drift = None
            return
        self.drift = self._judged(stamp, found)

    def _judged(self, stamp: float, found: TransformFit) -> Drift:
        """The estimate, and whether it is an alarm: only after it lasted, and then until it is clearly over."""
        settings, before = self._settings, self.drift is not None and self.drift.alarm
        ease = settings.calm if before else 1.0
        moved = _beyond(found.apparent, found.apparent_sd, settings.turned * ease, settings.sure * ease)
        shifted = _beyond(found.shift, found.shift_sd, settings.shifted, settings.sure)
        self._suspected = (stamp if self._suspected is None else self._suspected) if moved else None
        alarm = self._suspected is not None and (before or stamp - self._suspected >= settings.lasting)
        words = _words(found, shifted) if alarm else ""
        self._alarm = (self._alarm or words) if alarm else ""
        return Drift(
            turn=found.turn,
            turn_sd=found.turn_sd,
            shift=found.shift,
            shift_sd=found.shift_sd,
            apparent=found.apparent,
            apparent_sd=found.apparent_sd,
            pairs=found.pairs,
            corners=found.corners,
            alarm=alarm,
            words=words,
        )


def _beyond(value: float, sd: float, matters: float, sure: float) -> bool:
    return abs(value) > matters and abs(value) > sure * sd


def _words(found: TransformFit, shifted: bool) -> str:
    """The alarm in words: a turn, as long as nothing separates it from a shift that looks alike."""
    if shifted:
        side = "left" if found.shift > 0 else "right"
        said = f"moved by {100 * abs(found.shift):.1f} ± {100 * found.shift_sd:.1f} cm to the {side}"
        if abs(found.turn) > 3 * found.turn_sd:
            said += f" and turned by {math.degrees(found.turn):+.1f}° ± {math.degrees(found.turn_sd):.1f}°"
    else:
        side = "left" if found.apparent > 0 else "right"
        turn, sd = math.degrees(abs(found.apparent)), math.degrees(found.apparent_sd)
        said = f"turned by {turn:.1f}° ± {sd:.1f}° to the {side}"
    return f"The camera seems to have {said} on its mount; calibrate the laser again."
