"""Keeps the logins in memory and those on disk alike, from a thread; tells who was signed out by another process."""

import asyncio
from collections.abc import Callable

from console.access.logins import Logins, Person
from console.part import Part
from core.errors import BeckonError

ENDED = "Your login was ended; sign in again."
LOOK_PERIOD_S = 0.5  # between looks at the file: what the command line revokes ends within a second


class LoginKeeper(Part):
    """Lives on the event loop."""

    def __init__(self, logins: Logins, sign_out: Callable[[Person, str], None], tell: Callable[[str], None]) -> None:
        """`sign_out`: called with who is no longer signed in, and why; `tell`: with a sentence when the file cannot
        be had, and with "" when it can again.
        """
        self._logins, self._sign_out, self._tell = logins, sign_out, tell
        self._one = asyncio.Lock()
        self._trouble = ""

    async def run(self) -> None:
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
                    self._sign_out(person, ENDED)

    def tick(self, now: float) -> None:
        for person in self._logins.expire(now):
            self._sign_out(person, "Your login has expired; sign in again.")

    def _report(self, trouble: str) -> None:
        if trouble != self._trouble:
            self._trouble = trouble
            self._tell(trouble)
