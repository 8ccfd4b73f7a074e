"""How one session is written: one write after the other, each to its end, and none after the session is gone."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from console.calibration.folder import Folder
from console.tasks import to_the_end


class Writing:
    """Lives on the event loop; the disk is waited for in threads."""

    def __init__(self, folder: Folder) -> None:
        self._folder = folder
        self._turn = asyncio.Lock()
        self._gone = False

    async def save(self, encoded: Callable[[], bytes]) -> None:
        """Replace the session's file by what is `encoded` when its turn comes. Raises OSError."""
        async with self._turn:
            if not self._gone:
                raw = encoded()
                await to_the_end(lambda: self._folder.save(raw))

    async def picture(self, number: int, picture: bytes, small: bytes) -> str | None:
        """A view's picture and its thumbnail → the file's name; None: the session is gone. Raises OSError."""
        async with self._turn:
            if self._gone:
                return None
            return await to_the_end(lambda: self._folder.save_picture(number, picture, small))

    async def remove(self) -> None:
        """Everything, for good; what comes later is not written any more."""
        self._gone = True
        async with self._turn:
            await to_the_end(self._folder.remove)
