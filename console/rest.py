"""A robot that stands and has nothing to do: what the pages show of it hardly changes, and is sent less often."""

from __future__ import annotations

import math

from core.snapshot import Snapshot

AFTER = 2.0  # [s] of standing
STILL = 0.005  # [m/s], [rad/s]


class RestDetector:
    """Takes every snapshot."""

    def __init__(self) -> None:
        self.at_rest = False
        self._since = math.inf  # [s] by the robot's clock

    def saw(self, snapshot: Snapshot) -> bool:
        """The newest snapshot → whether the robot rests."""
        velocity = snapshot.velocity
        moves = max(abs(velocity.v), abs(velocity.w)) > STILL or not snapshot.running
        busy = snapshot.active_command is not None or (snapshot.hearing is not None and snapshot.hearing.speaking)
        if moves or busy or snapshot.stamp < self._since:
            self._since = snapshot.stamp
        self.at_rest = snapshot.stamp - self._since > AFTER
        return self.at_rest
