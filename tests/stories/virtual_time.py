"""An event loop whose time is only counted: nothing waits, and `time` says what the loop says."""

import asyncio
import random
import selectors
import time
from collections.abc import Callable, Coroutine, Iterator
from contextlib import contextmanager
from typing import Any
from unittest.mock import patch

WALL = 1.7e9  # [s] of the wall clock where the other begins


class Clock:
    """What all clocks of the process say [s]."""

    def __init__(self) -> None:
        self.now = 100.0


class JumpingSelector(selectors.DefaultSelector):
    """Waits by moving the clock on."""

    def __init__(self, clock: Clock) -> None:
        super().__init__()
        self._clock = clock

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        assert timeout is not None, "everything waits for something that nobody does"
        if timeout > 0:
            self._clock.now += timeout
        return []


@contextmanager
def virtual_time(chance: random.Random) -> Iterator[tuple[asyncio.AbstractEventLoop, Clock]]:
    """A loop, and the clock; what is done in threads is done in the loop up to 3 s later."""
    clock = Clock()
    loop = asyncio.SelectorEventLoop(JumpingSelector(clock))

    async def to_thread(act: Callable[..., Any], *given: Any) -> Any:
        await asyncio.sleep(chance.choice((0.0, 0.01, 3.0)) * chance.random())
        return act(*given)

    try:
        with (
            patch.object(loop, "time", lambda: clock.now),
            patch.object(time, "monotonic", lambda: clock.now),
            patch.object(time, "time", lambda: WALL + clock.now),
            patch.object(asyncio, "to_thread", to_thread),
        ):
            yield loop, clock
            for task in asyncio.all_tasks(loop):
                task.cancel()
            loop.run_until_complete(asyncio.sleep(0))
    finally:
        loop.close()


def run(loop: asyncio.AbstractEventLoop, act: Coroutine[Any, Any, None]) -> None:
    """Until it is over."""
    loop.run_until_complete(act)
