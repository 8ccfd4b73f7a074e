"""Keeps the logins in memory and those on disk alike, from a thread; tells who was signed out by another process."""

import asyncio
from collections.abc import Callable

from console.access.logins import Logins, Person
from console.part import Part
from core.errors import BeckonError

LOOK_PERIOD_S = 0.5  # between looks at the file: what the command line revokes ends within a second


class LoginKeeper(Part):
    """Lives on the event loop."""

    def __init__(self, logins: Logins, signed_out: Callable[[Person], None], tell: Callable[[str], None]) -> None:
        """`tell`: called with a sentence when the file cannot be had, and with "" when it can again."""
        self._logins, self._signed_out, self._tell = logins, signed_out, tell
        self._one = asyncio.Lock()
        self._trouble = ""

    async def run(self) -> None:
        """For as long as the console runs."""
        while True:
            try:
                await self.settle()
                self._report("")
            except BeckonError as trouble:
                self._report(str(trouble))
            await asyncio.sleep(LOOK_PERIOD_S)

    async def settle(self) -> None:
        """Wait until all that was changed by now is on disk. Raises Unavailable, Unwritable."""
        async with self._one:
            changes = self._logins.take_unsaved()
            on_disk = await asyncio.to_thread(self._logins.write_out, changes)
            if on_disk is not None:
                for person in self._logins.synced(on_disk, len(changes)):
                    self._signed_out(person)

    def _report(self, trouble: str) -> None:
        if trouble != self._trouble:
            self._trouble = trouble
            self._tell(trouble)
