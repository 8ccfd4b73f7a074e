"""Demonstrations in the simulated room: one at a time is begun, stopped, and always leaves the room again."""

import asyncio
import logging
from collections.abc import Awaitable, Callable
from dataclasses import dataclass

from console.http.problems import Problem
from console.workers.tasks import end
from core.errors import BeckonError

log = logging.getLogger(__name__)

BROKE_OFF = "The demonstration broke off; nothing was lost. Press Show me again; the log says more."


@dataclass(frozen=True)
class Demo:
    """A demonstration. `began` and `ended` are called in pairs, also when it is stopped before its first step."""

    session: str  # id of the session for which it is shown
    run: Callable[[], Awaitable[None]]  # until all is shown; may raise BeckonError, Problem
    leave: Callable[[], Awaitable[None]]  # clear the room; called after `run`, however that ended
    began: Callable[[], None]
    ended: Callable[[], None]
    trouble: Callable[[str], None]  # takes the sentence why it ended early


class DemoRunner:
    """Runs one demonstration at a time. Lives on the event loop."""

    def __init__(self) -> None:
        self._demo: Demo | None = None
        self._task: asyncio.Task[None] | None = None
        self._turn = asyncio.Lock()

    def shows(self, session: str) -> bool:
        return self._demo is not None and self._demo.session == session

    async def start(self, demo: Demo) -> None:
        """Start it in a task of its own, after the one before has left the room."""
        async with self._turn:
            await end(self._task)
            self._demo = demo
            demo.began()
            self._task = asyncio.get_running_loop().create_task(_run(demo))
            self._task.add_done_callback(lambda _: self._ended(demo))

    async def stop(self) -> None:
        """Stop the one that runs, and wait until it has left the room."""
        async with self._turn:
            await end(self._task)

    def cancel(self) -> None:
        """Stop it without waiting."""
        if self._task is not None:
            self._task.cancel()

    def _ended(self, demo: Demo) -> None:
        self._demo = None
        demo.ended()


async def _run(demo: Demo) -> None:
    try:
        await demo.run()
    except (BeckonError, Problem) as wrong:
        demo.trouble(str(wrong))
    except Exception:
        log.exception("A demonstration broke off")
        demo.trouble(BROKE_OFF)
    finally:
        await asyncio.shield(demo.leave())
