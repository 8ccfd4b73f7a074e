"""Scans on their way to a laser session: a robot that has moved since it looked at the empty room is noticed."""

import asyncio
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from console.calibration.answers import SessionAnswer
from console.calibration.laser_worker import LaserWorker
from console.calibration.live_capture import LiveCapture, moved
from console.calibration.session import CalibrationSession
from console.workers.job import Job
from core.geometry import Pose
from core.sensors import SensorFrame
from core.sensors.laser import Scan

SCAN = Scan(stamp=0.0, laser="front", ranges=np.ones(4), angle_min=0.0, angle_step=0.1)


class Desk:
    """Notes what a session is asked for."""

    def __init__(self, stood: Pose | None, room_known: bool) -> None:
        self.card, self.stood, self.room_known = SimpleNamespace(kind="laser"), stood, room_known
        self.asked: list[type[Job[SessionAnswer]]] = []
        self.swept = asyncio.Event()

    async def act(self, job: Job[SessionAnswer], **_: Any) -> SessionAnswer:
        self.asked.append(type(job))
        assert not isinstance(job, LaserWorker.sweep) or job.scan is SCAN
        if isinstance(job, LaserWorker.forget_room):
            self.room_known = False
        else:
            self.swept.set()
        return SessionAnswer(size=None, room_known=self.room_known)


async def asked(
    stood: Pose | None, here: Pose | None, room_known: bool
) -> tuple[list[type[Job[SessionAnswer]]], Pose | None]:
    """What one scan leads to, taken where the wheels say `here`."""
    worker = Desk(stood, room_known)
    live = LiveCapture(cast(CalibrationSession, worker), "front")
    wheels = None if here is None else SimpleNamespace(odometry=here)
    for scan in (SCAN, replace(SCAN, laser="rear")):
        live.saw(cast(SensorFrame, SimpleNamespace(image=None, scan=scan, wheels=wheels)))
    await worker.swept.wait()
    live.end()
    await live.task
    return worker.asked, worker.stood


HOME, AWAY = Pose(0.0, 0.0, 0.0), Pose(0.1, 0.0, 0.0)


@pytest.mark.parametrize(
    ("stood", "here", "room_known", "expected", "then"),
    [
        (None, HOME, False, [LaserWorker.sweep], HOME),
        (HOME, HOME, True, [LaserWorker.sweep], HOME),
        (HOME, AWAY, True, [LaserWorker.forget_room, LaserWorker.sweep], AWAY),  # moved between pause and going on
        (None, HOME, True, [LaserWorker.sweep, LaserWorker.forget_room], HOME),  # after a restart of the console
        (None, None, True, [LaserWorker.sweep], None),  # a robot without wheels tells nothing
        (HOME, None, True, [LaserWorker.sweep], HOME),
    ],
)
def test_the_room_is_looked_at_anew_when_the_robot_moved_or_nobody_knows(
    stood: Pose | None,
    here: Pose | None,
    room_known: bool,
    expected: list[type[Job[SessionAnswer]]],
    then: Pose | None,
) -> None:
    assert asyncio.run(asked(stood, here, room_known)) == (expected, then)


def test_a_turn_on_the_spot_is_a_move() -> None:
    assert moved(HOME, Pose(0.0, 0.0, 0.1)) and not moved(HOME, Pose(0.01, 0.0, 0.01))
