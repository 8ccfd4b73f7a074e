"""Asyncio tasks: work that is seen to its end, and ends that are waited for."""

import asyncio
from collections.abc import Callable
from typing import Any, TypeVar

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
