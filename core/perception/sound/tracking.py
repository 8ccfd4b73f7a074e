"""Voices followed on the sphere of the world: a talker who walks, falls silent, and is joined by another.

Bearings are kept in a frame that does not turn with the robot, so a robot that turns keeps them.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy

from core.message import Array, message
from core.perception.sound.direction import Direction, tangents

# Birth, gate and death.
BEARING_WALK_RAD = 0.35  # [rad/√s] by which a talker's direction wanders: 1 m/s at 2 m
GATE_CHI2 = 11.8  # chi-square, 2 degrees of freedom, 99.7 %
CONFIRMING_HITS = 2  # hits until a voice is confirmed
SURE_SD_RAD = 0.10  # [rad] a first hit this sure confirms a voice at once
MAX_SILENCE_S = 3.0  # [s] without a hit until a voice is dropped
MIN_APART_RAD = 0.25  # [rad] nearer tracks are one
MAX_DIRECTION_SD_RAD = 1.0  # [rad] directions less sure are not used


@message
class Voice:
    """One talker in the world's directions."""

    id: int
    towards: Array  # (3,) in the frame that does not turn
    covariance: Array  # (2, 2) [rad²] along (counter-clockwise, up)
    heard: float  # [s] of the last hit
    hits: int
    confirmed: bool  # heard often enough, or surely enough, to be shown

    @property
    def bearing(self) -> float:
        """Azimuth [rad] in the frame that does not turn."""
        return math.atan2(self.towards[1], self.towards[0])

    @property
    def bearing_sd(self) -> float:
        """[rad]."""
        level = max(math.hypot(self.towards[0], self.towards[1]), 1e-6)
        return min(math.pi / math.sqrt(3), math.sqrt(self.covariance[0, 0]) / level)


class VoiceTracker:
    """Tracks the voices."""

    def __init__(self) -> None:
        self._voices: list[Voice] = []
        self._now = -math.inf
        self._next = 1

    @property
    def voices(self) -> tuple[Voice, ...]:
        """The confirmed voices, most recently heard first."""
        confirmed = [one for one in self._voices if one.confirmed]
        return tuple(sorted(confirmed, key=lambda one: (-one.heard, -one.hits)))

    def update(self, directions: Sequence[Direction], now: float, heading: float = 0.0) -> tuple[Voice, ...]:
        """Directions heard at one time [s] by a robot with this heading [rad] → the voices.

        Call it without directions to let time pass. Time that runs backwards resets the tracker.
        """
        if now < self._now:
            self._voices = []
        passed = now - self._now if math.isfinite(self._now) and now >= self._now else 0.0
        self._now = now
        spread = BEARING_WALK_RAD**2 * passed * np.eye(2)
        kept = [one for one in self._voices if now - one.heard <= MAX_SILENCE_S]
        self._voices = [replace(one, covariance=one.covariance + spread) for one in kept]
        heard = [one.turned(heading) for one in directions if one.azimuth_sd <= MAX_DIRECTION_SD_RAD]
        self._meet(heard, now)
        self._join()
        return self.voices

    def _meet(self, heard: list[Direction], now: float) -> None:
        """Give every direction to at most one voice within the gate; what is left is born."""
        costs = np.array([[_distance(voice, one) for one in heard] for voice in self._voices])
        taken: set[int] = set()
        if costs.size:
            for row, column in zip(*scipy.optimize.linear_sum_assignment(np.minimum(costs, 1e3)), strict=True):
                if costs[row, column] <= GATE_CHI2:
                    hit = _corrected(self._voices[row], heard[column], now)
                    self._voices[row] = replace(hit, confirmed=hit.confirmed or hit.hits >= CONFIRMING_HITS)
                    taken.add(int(column))
        for number, one in enumerate(heard):
            if number not in taken:
                self._voices.append(self._born(one, now))
                self._next += 1

    def _born(self, direction: Direction, now: float) -> Voice:
        return Voice(
            id=self._next,
            towards=direction.towards,
            covariance=direction.covariance,
            heard=now,
            hits=1,
            confirmed=CONFIRMING_HITS <= 1 or math.sqrt(direction.covariance[0, 0]) <= SURE_SD_RAD,
        )

    def _join(self) -> None:
        """Two voices that came together are one: the older."""
        kept: list[Voice] = []
        for voice in sorted(self._voices, key=lambda one: (-one.hits, one.id)):
            if all(voice.towards @ other.towards < math.cos(MIN_APART_RAD) for other in kept):
                kept.append(voice)
        self._voices = kept


def _offset(voice: Voice, towards: Array) -> Array:
    """Offset of a direction from the voice's, (2,) [rad] along (counter-clockwise, up)."""
    sides = tangents(voice.towards) @ towards
    along = float(voice.towards @ towards)
    length = float(np.linalg.norm(sides))
    return sides * (math.atan2(length, along) / length if length > 1e-12 else 1.0)


def _distance(voice: Voice, direction: Direction) -> float:
    offset = _offset(voice, direction.towards)
    return float(offset @ np.linalg.solve(voice.covariance + direction.covariance, offset))


def _corrected(voice: Voice, direction: Direction, now: float) -> Voice:
    """Kalman's correction in the tangent plane."""
    gain = voice.covariance @ np.linalg.inv(voice.covariance + direction.covariance)
    step = gain @ _offset(voice, direction.towards)
    length = float(np.linalg.norm(step))
    towards = voice.towards
    if length > 1e-12:
        towards = math.cos(length) * towards + math.sin(length) / length * step @ tangents(towards)
    rest = np.eye(2) - gain
    covariance = rest @ voice.covariance @ rest.T + gain @ direction.covariance @ gain.T
    return replace(
        voice, towards=towards / np.linalg.norm(towards), covariance=covariance, heard=now, hits=voice.hits + 1
    )
