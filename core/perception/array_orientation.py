"""How the array is turned on the robot: a wizard without a screen that listens to claps from known directions."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from core.geometry import wrap, wrap_all
from core.message import message
from core.perception.sound.direction import Direction

FEWEST = 3  # claps
SPREAD = math.radians(60)  # between the two most distant claps
AGREES = 3.0  # standard deviations of a clap that fits
PLACING = math.radians(3)  # [rad] how exactly a person stands where they are asked to


@message
class Orientation:
    """The result."""

    yaw: float  # [rad] robot_from_microphones
    yaw_sd: float  # [rad]
    mirrored: bool  # the array is mounted upside down
    residual: float  # [rad] rms


@dataclass
class OrientationWizard:
    """Asks for claps and gathers them."""

    asked: tuple[float, ...] = (0.0, math.pi / 2, math.pi, -math.pi / 2)  # [rad] in the robot frame
    claps: list[tuple[float, Direction]] = field(default_factory=list[tuple[float, Direction]])

    @property
    def advice(self) -> str:
        """What to do next, in a sentence."""
        if len(self.claps) < len(self.asked):
            where = math.degrees(self.asked[len(self.claps)])
            return f"Stand about 2 m away at {where:.0f}° (0° is ahead, 90° left) and clap twice."
        return "That is enough; accept the result or clap from one more place."

    def add(self, asked: float, direction: Direction) -> str:
        """A clap at azimuth `asked` [rad] in the robot frame → '' when it is taken, or why it is not."""
        if direction.azimuth_sd > math.radians(15):
            return "That clap came from no clear direction; clap again, nearer."
        self.claps.append((asked, direction))
        return ""

    def drop(self, number: int) -> None:
        """Forget a clap."""
        del self.claps[number]

    def solve(self) -> Orientation | str:
        """The orientation, or what is still missing."""
        if len(self.claps) < FEWEST:
            return f"{FEWEST} claps are needed; {len(self.claps)} were heard."
        asked = np.array([where for where, _ in self.claps])
        if np.max(np.abs(wrap_all(asked[:, None] - asked))) < SPREAD:
            return "The claps came all from one side; clap from another one."
        heard = np.array([one.azimuth for _, one in self.claps])
        variance = np.array([one.azimuth_sd**2 + PLACING**2 for _, one in self.claps])
        best: Orientation | None = None
        for side in (1.0, -1.0):
            turns = asked - side * heard
            yaw = math.atan2(float(np.sum(np.sin(turns) / variance)), float(np.sum(np.cos(turns) / variance)))
            gaps = wrap_all(turns - yaw)
            residual = float(np.sqrt(np.mean(gaps**2)))
            if best is None or residual < best.residual:
                chi = float(np.sum(gaps**2 / variance)) / (len(gaps) - 1)
                spread = math.sqrt(max(1.0, chi) / float(np.sum(1 / variance)))
                best = Orientation(yaw=wrap(yaw), yaw_sd=spread, mirrored=side < 0, residual=residual)
        assert best is not None
        if best.residual > AGREES * float(np.sqrt(variance.mean())):
            return (
                f"The claps do not agree on one orientation ({math.degrees(best.residual):.0f}° apart); "
                "check the order of the channels first."
            )
        return best
