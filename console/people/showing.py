"""Show me: the lesson is gone through in the simulated room, by somebody who then stays to be come to."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import time
from collections.abc import Awaitable, Callable
from typing import Any

from console.people.lesson import Lesson
from console.people.sitter import ID, Sitter
from console.problems import Problem
from console.robot_link import RobotLink
from console.tasks import end
from core.errors import BadInput, BeckonError
from core.sensors import Image

log = logging.getLogger(__name__)

PATIENCE = 20.0  # [s] for a picture: the machine may be busy
ANSWERING = 10.0  # [s] that the driver may take to answer
GAP = 0.03  # [s] between two looks whether the picture is there
WAITS = "I wait for a picture from the robot's camera."
SILENT = "No picture comes from the robot's camera; press Show me again when one does."
BROKE_OFF = "Showing it broke off; nothing was lost. Press Show me again; the log says more."

Take = Callable[[Lesson, str, Image], Awaitable[None]]


class Showing:
    """One at a time. Lives on the event loop."""

    def __init__(self, robot: RobotLink, newest: Callable[[], Image | None], take: Take) -> None:
        """`newest` picture of the robot; `take(lesson, what, picture)` has it judged."""
        self.stands = False  # who showed everything is in the simulated room still
        self._robot, self._newest, self._take = robot, newest, take
        self._task: asyncio.Task[None] | None = None
        self._turn = asyncio.Lock()

    async def begin(self, lesson: Lesson, look: int) -> None:
        """Somebody steps before the camera, in the clothes of that number; whoever did so before leaves."""
        async with self._turn:
            await end(self._task)
            self.stands = False
            lesson.showing, lesson.trouble = True, ""
            self._task = asyncio.get_running_loop().create_task(self._shown(lesson, look))
            self._task.add_done_callback(lambda _: lesson.rest())  # also where it was cancelled before it began

    async def stop(self) -> None:
        """Enough is shown: whoever does so leaves."""
        async with self._turn:
            await end(self._task)

    def drop(self) -> None:
        """The same without waiting for it."""
        if self._task is not None:
            self._task.cancel()

    async def send_away(self) -> None:
        """Nobody who showed something is in the room any more. Raises Unavailable."""
        await self.stop()
        with contextlib.suppress(BadInput):  # nobody is there
            await self._ask({"do": "remove", "id": ID})
        self.stands = False

    async def _shown(self, lesson: Lesson, look: int) -> None:
        sitter = Sitter(self._ask, self._robot.profile.camera, look=look)
        try:
            await sitter.sit(lesson, self._capture)
            self.stands = True
        except (BeckonError, Problem) as wrong:
            lesson.trouble = str(wrong)
        except Exception:
            log.exception("Showing broke off")
            lesson.trouble = BROKE_OFF
        finally:
            await asyncio.shield(sitter.leave())

    async def _capture(self, lesson: Lesson, what: str) -> None:
        """Take a picture of how the room is now: none that was on its way already. Raises Problem, BeckonError."""
        lesson.waits = WAITS
        now = (await self._ask({"do": "truth"}))["stamp_s"]
        until = time.monotonic() + PATIENCE
        while (image := self._newest()) is None or image.stamp <= now:
            if time.monotonic() > until:
                raise Problem(503, SILENT)
            await asyncio.sleep(GAP)
        await self._take(lesson, what, image)

    async def _ask(self, request: dict[str, Any]) -> dict[str, Any]:
        return await asyncio.to_thread(self._robot.ask, request, ANSWERING)
