"""The wheels' encoders: how far the robot believes it has rolled."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from core.geometry import Pose, arc, wrap
from core.message import Array, message

MOVING_SPEED = 0.02  # [m/s], [rad/s] from which a robot moves noticeably


MAX_SPEED_M_S, MAX_TURN_RATE_RAD_S = 5.0, 7.0  # of a base, with a margin
MAX_STEP_M, MAX_STEP_RAD = 0.5, 0.6  # by which a reading may jump beyond that
ORIGIN_M, ORIGIN_RAD = 0.02, 0.035  # within which a base is that has just started
AWAY_M, AWAY_RAD = 0.1, 0.17  # beyond which a base was before it started again
BOOT_S = 0.4  # without a reading, in which any base can start again
SWIFT_M_S, SWIFT_RAD_S = 1.5, 3.0  # of a base that was on its way to its origin, in less time


def is_restart(before: Pose, after: Pose, elapsed: float) -> bool:
    """Return whether a base was restarted between two readings of its odometry, `elapsed` seconds apart.

    No base comes so far or turns so much in that time, or it counts from its origin again after a silence, or sooner
    than a robot that maps rooms comes there. Seen from the base itself, so places as they were read.
    """
    turned = abs(wrap(after.heading - before.heading))
    way, elapsed = before.distance_to(after.x, after.y), max(elapsed, 0.0)
    if way > MAX_STEP_M + MAX_SPEED_M_S * elapsed or turned > MAX_STEP_RAD + MAX_TURN_RATE_RAD_S * elapsed:
        return True
    was_away = before.distance_to(0.0, 0.0) > AWAY_M or abs(wrap(before.heading)) > AWAY_RAD
    is_at_origin = after.distance_to(0.0, 0.0) < ORIGIN_M and abs(wrap(after.heading)) < ORIGIN_RAD
    is_too_soon = way > AWAY_M + SWIFT_M_S * elapsed or turned > AWAY_RAD + SWIFT_RAD_S * elapsed
    return was_away and is_at_origin and (elapsed > BOOT_S or is_too_soon)


@message
class Wheels:
    """Odometry since the robot woke, so that a lost reading loses nothing."""

    odometry: Pose  # cumulative, in a frame of its own that drifts
    speed: float  # [m/s]
    turn_rate: float  # [rad/s]
    age: float = 0.0  # [s] over which the reading was carried on to its frame
    rate: float | None = None  # [Hz] at which readings come; None: with every frame

    @property
    def moves(self) -> bool:
        """True while the robot moves noticeably."""
        return max(abs(self.speed), abs(self.turn_rate)) > MOVING_SPEED

    def carried(self, seconds: float) -> Wheels:
        """The same `seconds` [s] later, if they went on as they were."""
        place = self.odometry @ arc(self.speed * seconds, self.turn_rate * seconds)
        return replace(self, odometry=place, age=self.age + seconds)

    @property
    def as_read(self) -> Pose:
        """The odometry as it was read, `age` before its frame."""
        return self.odometry @ arc(self.speed * self.age, self.turn_rate * self.age).inverse()


FIT_WINDOW_S = 0.5  # over which speeds and places are compared: what encoders count may be coarse
MIN_WINDOW_M, MIN_WINDOW_RAD = 0.02, 0.02  # in one window: less may be noise
MIN_FIT_WAY_M, MIN_FIT_TURN_RAD = 0.5, 0.5  # in all, from which the ratio is known
MAX_SPEED_RATIO = 3.0  # of the speeds over the changes of the places


class SpeedFit:
    """Compares the speeds that a base reports with how its own places change."""

    def __init__(self) -> None:
        self._moved, self._claimed = np.zeros(2), np.zeros(2)

    def add(self, moves: Array, claimed: Array) -> None:
        """Take ways [m] and turns [rad] by the places (N, 2), and by the speeds (N, 2), each over FIT_WINDOW_S."""
        moves = np.where(np.abs(moves) > (MIN_WINDOW_M, MIN_WINDOW_RAD), moves, 0.0)
        self._moved += np.abs(moves).sum(axis=0)
        self._claimed += (np.sign(moves) * np.clip(claimed, -1e6, 1e6)).sum(axis=0)

    @property
    def ratios(self) -> tuple[float, float]:
        """Speed and turn rate over those by the places; 1 where too little has moved."""
        known = self._moved >= (MIN_FIT_WAY_M, MIN_FIT_TURN_RAD)
        way, turn = np.where(known, self._claimed / np.maximum(self._moved, 1e-12), 1.0).tolist()
        return way, turn

    @property
    def is_used(self) -> bool:
        """Return whether the speeds can be those of the places."""
        return all(1 / MAX_SPEED_RATIO < ratio < MAX_SPEED_RATIO for ratio in self.ratios)

    @property
    def is_wrong(self) -> bool:
        """Return whether the speeds are in another unit or of the other sign; those that are always 0 are none."""
        return any(ratio != 0 and not 1 / MAX_SPEED_RATIO < ratio < MAX_SPEED_RATIO for ratio in self.ratios)


class BaseSpeeds:
    """The speeds of a base, reading by reading: as it reports them, or by its places where those cannot be true."""

    def __init__(self) -> None:
        self.fit = SpeedFit()
        self._start: tuple[float, Pose] | None = None  # of the present window: its stamp [s] and place
        self._last: tuple[float, Pose, float, float] | None = None
        self._claimed = np.zeros(2)  # [m], [rad] since the start of the window
        self._measured = 0.0, 0.0  # [m/s], [rad/s] by the places of the last window

    def take(self, stamp: float, place: Pose, speed: float, turn_rate: float) -> tuple[float, float, bool]:
        """The next reading at `stamp` [s] → speed [m/s], turn rate [rad/s], and whether it reports false ones."""
        if self._start is None or self._last is None or not 0 < stamp - self._last[0] < FIT_WINDOW_S:
            self._start, self._claimed = (stamp, place), np.zeros(2)
        else:
            elapsed = stamp - self._last[0]
            self._claimed += (elapsed * self._last[2], elapsed * self._last[3])
        self._last = stamp, place, speed, turn_rate
        lasted = stamp - self._start[0]
        if lasted >= FIT_WINDOW_S:
            self._compare(self._start[1].inverse() @ place, lasted)
            self._start, self._claimed = (stamp, place), np.zeros(2)
        possible = abs(speed) <= MAX_SPEED_M_S and abs(turn_rate) <= MAX_TURN_RATE_RAD_S
        if possible and self.fit.is_used:
            return speed, turn_rate, False
        return *self._measured, not possible or self.fit.is_wrong

    def _compare(self, move: Pose, lasted: float) -> None:
        if not is_restart(Pose(), move, lasted):
            self.fit.add(np.array([[move.x, move.heading]]), self._claimed[None])
            self._measured = move.x / lasted, move.heading / lasted
