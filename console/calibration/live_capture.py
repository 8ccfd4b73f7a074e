"""The robot's pictures and scans on their way to a session: the newest of each, nothing queues."""

import asyncio
import logging

import cv2
import numpy as np

from console.calibration.laser_worker import LaserWorker
from console.calibration.session import PICTURE_BUDGET_S, CalibrationSession
from console.calibration.session_worker import SessionWorker
from console.http.problems import Problem
from core.errors import BeckonError
from core.geometry import Pose
from core.message import Array
from core.sensors import Image, Scan, SensorFrame

log = logging.getLogger(__name__)

BROKE_OFF = "Looking at the robot broke off; nothing was lost. Switch it on again; the log says more."
RETRY_PAUSE_S = 0.5  # after something went wrong
MAX_CARRIED_M, MAX_TURNED_RAD = 0.02, np.deg2rad(1.5)  # the robot may move after it has looked at the empty room


class LiveCapture:
    """Looks at what the robot sees until it is over. Lives on the event loop."""

    def __init__(self, session: CalibrationSession, laser: str) -> None:
        """`laser`: name of the one that is calibrated; scans of others are left out."""
        self._session, self._laser = session, laser
        self._image: Image | None = None
        self._scan: Scan | None = None
        self._odometry: Pose | None = None
        self._news = asyncio.Event()
        self._over = False
        self.task = asyncio.get_running_loop().create_task(self._run())

    def saw(self, frame: SensorFrame) -> None:
        """A frame of the robot; the newest replaces what nobody has looked at yet."""
        self._image = frame.image or self._image
        if frame.scan is not None and frame.scan.laser in ("", self._laser):
            self._scan = frame.scan
        if frame.wheels is not None:
            self._odometry = frame.wheels.odometry
        self._news.set()

    def end(self) -> None:
        """End as soon as the running step is done."""
        self._over = True
        self._news.set()

    async def _run(self) -> None:
        while not self._over:
            await self._news.wait()
            self._news.clear()
            (scan, self._scan), (image, self._image) = (self._scan, None), (self._image, None)
            try:
                if scan is not None and self._session.card.kind == "laser":
                    await self._sweep(scan)
                if image is not None:
                    await self._look(image)
            except (BeckonError, Problem) as wrong:
                if self._over:
                    return
                self._session.trouble(str(wrong))
                await asyncio.sleep(RETRY_PAUSE_S)
            except Exception:
                log.exception("Looking at the robot broke off.")
                self._session.trouble(BROKE_OFF)
                return

    async def _look(self, image: Image) -> None:
        job = SessionWorker.look(grey_picture(image), image.stamp)
        await self._session.act(job, budget=PICTURE_BUDGET_S, stamp=image.stamp, patient=True)

    async def _sweep(self, scan: Scan) -> None:
        here = self._odometry
        if moved(self._session.stood, here):
            await self._forget_room(here)
        known = await self._session.act(LaserWorker.sweep(scan), stamp=scan.stamp, patient=True)
        if self._session.stood is None and here is not None:
            if known.room_known:  # from before a restart: nobody knows where the robot stood then
                await self._forget_room(here)
            self._session.stood = here

    async def _forget_room(self, here: Pose | None) -> None:
        await self._session.act(LaserWorker.forget_room(), patient=True)
        self._session.stood = here


def moved(stood: Pose | None, here: Pose | None) -> bool:
    """Return whether the robot is known to stand elsewhere than when it began to look at the empty room."""
    if stood is None or here is None:
        return False
    away = stood.inverse() @ here
    return float(np.hypot(away.x, away.y)) > MAX_CARRIED_M or abs(away.heading) > MAX_TURNED_RAD


def grey_picture(image: Image) -> Array:
    """A picture as a worker takes it (H, W) uint8."""
    pixels: Array = image.pixels
    return cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY) if pixels.ndim == 3 else pixels
