"""Turns at what takes memory: one at a time, a few may wait, the others are sent away."""

import asyncio
from collections.abc import AsyncGenerator
from contextlib import asynccontextmanager

from console.http.problems import Problem


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
