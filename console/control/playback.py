"""Steering a recording that plays."""

import asyncio
from pathlib import Path

from console.access.logins import Person
from console.control.history import History
from console.control.notices import Notifications
from console.http.problems import Problem
from console.messages.inbound import PlaybackMessage
from console.part import Part
from console.robot.supervisor import RobotSupervisor
from core.pilot.recorded_drive import ReplayFrame
from core.recording.drive import NO_OWN_RECORDING
from core.robots import requests
from core.sensors import SensorFrame
from core.snapshot import Snapshot

REACHED_SHARE = 0.95  # of the speed that was asked for, from which on it counts as reached


class PlaybackController(Part):
    """Asks the recording's driver, outside the event loop."""

    def __init__(self, robot: RobotSupervisor, history: History, notifications: Notifications) -> None:
        self.speed = 1.0  # of the playback, times real time
        self.state: requests.PlaybackState | None = (
            None  # newest of a recording that can be shown in more than one way
        )
        self._robot = robot
        self._history = history
        self._notifications = notifications
        self._marks: tuple[requests.PlaybackMark, ...] | None = None

    def on_snapshot(self, snapshot: Snapshot, frame: SensorFrame) -> None:
        """Take how it plays, and what is said of that; no pilot hands it on."""
        if isinstance(frame, ReplayFrame):
            self.state = frame.playback if "results" in self._robot.profile.capabilities else None
            for note in frame.notes:
                self._notifications.tell("info", note)

    async def steer(self, order: PlaybackMessage, who: Person) -> None:
        """Play, pause, change the speed, seek, show another way. Raises Problem 403, 409, 422."""
        if not who.may("operator"):
            raise Problem(403, "Only an operator can steer the playback.")
        self._check(409)
        answer = await asyncio.to_thread(self._robot.ask, self._request(order))
        self.speed = answer.speed
        if order.action == "speed" and order.speed is not None and self.speed < REACHED_SHARE * order.speed:
            self._notifications.tell(
                "info", f"It plays {self.speed:.2g} times as fast: beyond, scans would be left out."
            )
        self._history.add("playback", who, words=order.action)

    async def read(self) -> tuple[requests.PlaybackState, tuple[requests.PlaybackMark, ...]]:
        """How it plays, and what happened in it. Raises Problem 404 where none plays."""
        self._check(404)
        if self._marks is None:
            self._marks = (await asyncio.to_thread(self._robot.ask, requests.ReadMarks())).marks
        return await asyncio.to_thread(self._robot.ask, requests.ReadPlayback()), self._marks

    def file(self, status: int) -> Path:
        """The recording that plays. Raises Problem where none of Beckon's own does."""
        profile = self._robot.profile
        if "results" not in profile.capabilities:
            raise Problem(status, NO_OWN_RECORDING)
        return Path(profile.url.removeprefix("log:"))

    def _check(self, status: int) -> None:
        if "replay" not in self._robot.profile.capabilities:
            raise Problem(status, "Only a recording can be played, paused and sought.")

    def _request(self, order: PlaybackMessage) -> requests.RobotRequest[requests.PlaybackState]:
        """Request to the recording's driver. Raises Problem 422 where a value is missing."""
        match order.action:
            case "play":
                return requests.Play()
            case "pause":
                return requests.Pause()
            case "speed":
                if order.speed is None:
                    raise Problem(422, "A speed needs a value: speed.")
                return requests.SetSpeed(value=order.speed)
            case "seek":
                if order.t_s is None:
                    raise Problem(422, "To seek needs a time: t_s.")
                return requests.Seek(value=order.t_s / (self._robot.profile.duration or 1.0))
            case "way":
                if order.way is None:
                    raise Problem(422, "To show another way needs its name: way.")
                return requests.ShowWay(way=order.way, compare=order.compare)
