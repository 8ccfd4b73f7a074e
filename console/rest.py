"""A robot that stands and has nothing to do: what the pages show of it hardly changes, and is sent less often."""

import math

from core.snapshot import Snapshot

STATE_GAP_S = 0.045  # at least between two states: 20 Hz
REST_GAP_S = 0.2  # the same while the robot rests and nothing happens at the console
STANDING_S = 2.0  # of standing
STILL_SPEED = 0.005  # [m/s], [rad/s]


class StatePace:
    """When the next state is due: nobody waits for what has happened at the console. It takes every snapshot."""

    def __init__(self) -> None:
        self.at_rest = False  # the robot stands and has nothing to do
        self._since = math.inf  # [s] by the robot's clock
        self._sent = 0.0  # [s]
        self._pace = 1.0  # share of real time at which the robot's clock runs
        self._situation: tuple[object, ...] = ()  # of the console, when the newest state was sent

    def saw(self, snapshot: Snapshot) -> bool:
        """The newest snapshot → whether the robot rests."""
        velocity, self._pace = snapshot.velocity, snapshot.pace
        moves = max(abs(velocity.v), abs(velocity.w)) > STILL_SPEED or not snapshot.running
        busy = snapshot.active_command is not None or (snapshot.hearing is not None and snapshot.hearing.speaking)
        if moves or busy or snapshot.stamp < self._since:
            self._since = snapshot.stamp
        self.at_rest = snapshot.stamp - self._since > STANDING_S
        return self.at_rest

    def due(self, now: float, situation: tuple[object, ...], later: float = 0.0) -> bool:
        """Return whether a state is due, `later` [s] than with every snapshot.

        Where the robot's clock runs slowly the states are as many a second by it, so that it runs less slowly.
        """
        gap = STATE_GAP_S
        if situation == self._situation:
            gap = REST_GAP_S if self.at_rest else min(STATE_GAP_S / max(self._pace, STATE_GAP_S), REST_GAP_S)
        return now - self._sent >= gap + later

    def sent(self, now: float, situation: tuple[object, ...]) -> None:
        self._sent, self._situation = now, situation
