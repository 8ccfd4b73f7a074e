"""Asyncio tasks: work that is seen to its end, ends that are waited for, and turns at what takes memory."""

import asyncio
import logging
from collections.abc import AsyncGenerator, Callable, Coroutine
from contextlib import asynccontextmanager
from typing import Any, TypeVar

from console.http.problems import Problem

log = logging.getLogger(__name__)

T = TypeVar("T")


async def to_the_end(work: Callable[[], T]) -> T:
    """Work in a thread, which is waited for even when who waits is cancelled meanwhile."""
    working = asyncio.ensure_future(asyncio.to_thread(work))
    try:
        return await asyncio.shield(working)
    except asyncio.CancelledError:
        await asyncio.wait({working})
        raise


async def end(*tasks: asyncio.Task[Any] | None) -> None:
    """Cancel those that run, and wait until all have ended; how each ended is not asked."""
    begun = [task for task in tasks if task is not None]
    for task in begun:
        task.cancel()
    await asyncio.gather(*begun, return_exceptions=True)


class HeldTasks:
    """Tasks that nobody waits for: held until they end; one that fails is reported. Lives on the event loop."""

    def __init__(self, failed: Callable[[BaseException], object] | None = None) -> None:
        """`failed` is called with what ended a task; it is logged, too."""
        self._failed, self._running = failed, set[asyncio.Task[Any]]()

    def start(self, work: Coroutine[Any, Any, T]) -> asyncio.Task[T]:
        task = asyncio.get_running_loop().create_task(work)
        self._running.add(task)
        task.add_done_callback(self._ended)
        return task

    async def end(self) -> None:
        """Cancel those that run, and wait until all have ended."""
        await end(*self._running)

    def _ended(self, task: asyncio.Task[Any]) -> None:
        self._running.discard(task)
        if not task.cancelled() and (fault := task.exception()) is not None:
            log.error("A task failed", exc_info=fault)
            if self._failed is not None:
                self._failed(fault)


class QueueLimit:
    """Lives on the event loop. Nothing should be held in memory before the turn has come."""

    def __init__(self, most: int) -> None:
        """`most`: who has the turn and those who wait for it."""
        self._most, self._here = most, 0
        self._turn = asyncio.Lock()

    @asynccontextmanager
    async def taken(self) -> AsyncGenerator[None, None]:
        """While one has the turn. Raises Problem 429 when too many wait already."""
        if self._here >= self._most:
            raise Problem(429, "Too many ask for this at once; try again in a moment.")
        self._here += 1
        try:
            async with self._turn:
                yield
        finally:
            self._here -= 1
