"""Starts the pilot again when it fails: without its calibrations where these may be the reason, and not for ever."""

import asyncio
import logging
import time
from collections import deque
from collections.abc import Callable

from console.control.notices import Notifications
from console.robot.pilot_thread import PilotPace, PilotThread
from core.sentences import Statement

log = logging.getLogger(__name__)

MAX_RESTARTS = 3  # of the pilot
RESTART_WINDOW_S = 60.0  # within which that many are the most
RESTART_PAUSE_S = 1.0
EARLY_FAILURE_S = 5.0  # of work with a calibration within which a failure is blamed on it


class PilotSupervisor:
    """Owns the pilot's thread. Lives on the event loop."""

    def __init__(
        self,
        make: Callable[[], PilotThread],
        failed: Callable[[], None],
        leave_out_calibrations: Callable[[str], list[str]],
        notifications: Notifications,
    ) -> None:
        """`make` starts a pilot; `failed` ends the active command; the third returns the files no longer used."""
        self.failure = ""  # why there is no pilot
        self.thread: PilotThread | None = None
        self._make, self._failed, self._leave_out = make, failed, leave_out_calibrations
        self._notifications = notifications
        self._failures: deque[float] = deque(maxlen=MAX_RESTARTS + 1)
        self._calibrated_at = 0.0  # [s] since when it has worked with its present calibration
        self._restart: asyncio.Task[None] | None = None
        self._over = False

    @property
    def pace(self) -> PilotPace:
        return self.thread.pace if self.thread is not None else PilotPace()

    @property
    def is_stepping(self) -> bool:
        """True while the pilot runs and is not caught in a step."""
        return self.thread is not None and self.thread.is_stepping

    @property
    def hangs(self) -> bool:
        """True while the pilot is caught in a step."""
        return self.thread is not None and self.thread.alive and not self.thread.is_stepping

    @property
    def trouble(self) -> str:
        """Why no pilot works, a sentence; "" while one does."""
        if self.failure or self.thread is None or self.thread.alive or self._over:
            return self.failure
        return Statement("pilot.ended")

    def start(self) -> None:
        """Start a pilot; one that cannot be started has failed."""
        self.failure, self._calibrated_at = "", time.monotonic()
        try:
            self.thread = self._make()
        except Exception as fault:
            log.exception("The pilot could not be started")
            self.bury(type(fault).__name__)
        else:
            self._notifications.reset_pilot()

    def recalibrated(self) -> None:
        self._calibrated_at = time.monotonic()

    def bury(self, fault: str) -> None:
        """The pilot has failed: start another one soon, unless that happens too often."""
        now = time.monotonic()
        self._failed()
        if now - self._calibrated_at < EARLY_FAILURE_S and (files := self._leave_out(fault)):
            names = " and ".join(files)
            self.failure = (
                f"The pilot failed ({fault}) within seconds of using {names}; the robot was stopped and the pilot "
                "starts again without. Calibrate again, or take the calibration back."
            )
        else:
            self._failures.append(now)
            if len(self._failures) > MAX_RESTARTS and now - self._failures[0] < RESTART_WINDOW_S:
                self.failure = (
                    f"The pilot failed {MAX_RESTARTS + 1} times in a minute and stays off. Restart the console."
                )
                self._notifications.tell("error", self.failure, "pilot")
                return
            self.failure = f"The pilot failed ({fault}); the robot was stopped and the pilot starts again."
        self._notifications.tell("error", f"{self.failure} The map begins again.", "pilot")
        self._restart = asyncio.get_running_loop().create_task(self._start_again())

    async def close(self) -> None:
        self._over = True
        if self._restart is not None:
            self._restart.cancel()
        if self.thread is not None:
            await asyncio.to_thread(self.thread.close)

    async def _start_again(self) -> None:
        await asyncio.sleep(RESTART_PAUSE_S)
        if not self._over:
            self.start()
