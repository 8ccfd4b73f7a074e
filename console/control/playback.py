"""Steering a recording that plays."""

from __future__ import annotations

import asyncio
from typing import Literal

from console.access.logins import Person
from console.control.history import History
from console.control.notices import Notifications
from console.http.problems import Problem
from console.part import Part
from console.robot.link import RobotLink
from core.robots.requests import Pause, Play, PlaybackState, RobotRequest, Seek, SetSpeed

PlaybackAction = Literal["play", "pause", "speed", "seek"]

REACHED_SHARE = 0.95  # of the speed that was asked for, from which on it counts as reached


class PlaybackController(Part):
    """Asks the recording's driver, outside the event loop."""

    def __init__(self, robot: RobotLink, history: History, notifications: Notifications) -> None:
        self.speed = 1.0  # of the playback, times real time
        self._robot = robot
        self._history = history
        self._notifications = notifications

    async def steer(self, do: PlaybackAction, value: float | None, who: Person) -> None:
        """Play, pause, speed (times real time), seek (0..1). Raises Problem 403, 409, 422."""
        if not who.may("operator"):
            raise Problem(403, "Only an operator can steer the playback.")
        if "replay" not in self._robot.profile.capabilities:
            raise Problem(409, "Only a recording can be played, paused and sought.")
        answer = await asyncio.to_thread(self._robot.ask, request_of(do, value))
        self.speed = answer.speed
        if do == "speed" and value is not None and self.speed < REACHED_SHARE * value:
            self._notifications.tell(
                "info", f"It plays {self.speed:.2g} times as fast: beyond, scans would be left out."
            )
        self._history.add("playback", who, words=do)


def request_of(do: PlaybackAction, value: float | None) -> RobotRequest[PlaybackState]:
    """Request to the recording's driver. Raises Problem 422 where a value is missing."""
    match do:
        case "play":
            return Play()
        case "pause":
            return Pause()
        case "speed":
            if value is None:
                raise Problem(422, "A speed needs a value.")
            return SetSpeed(value=value)
        case "seek":
            if value is None:
                raise Problem(422, "To seek needs a value.")
            return Seek(value=value)
