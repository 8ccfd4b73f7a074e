"""Commands that another program writes into speech.txt are treated like typed ones (paper 4.2)."""

import asyncio
import time
from collections.abc import Callable
from dataclasses import replace

from console.access.logins import Person
from console.control.command_freshness import Spoken
from console.control.dispatcher import CommandDispatcher
from console.control.history import History
from console.control.lease import Lease
from console.control.notices import Notifications
from console.control.text_files import TextFileReader
from console.http.problems import Problem
from console.part import Part
from core.commands import spec_of
from core.errors import BadInput
from core.perception.people.voice_bearing import VoiceBearing
from core.snapshot import Snapshot
from core.speech.understanding.grammar import Refusal, understand

SOURCE = "file"
WRITER = Person("text files", "who writes the text files", "operator")
LOOK_PERIOD_S = 0.1  # between two looks


class TextFileCommands(Part):
    """Lives on the event loop; the files are read outside."""

    def __init__(
        self,
        files: TextFileReader,
        dispatcher: CommandDispatcher,
        lease: Lease,
        history: History,
        notifications: Notifications,
        snapshot: Callable[[], Snapshot | None],
    ) -> None:
        self._files, self._dispatcher, self._lease = files, dispatcher, lease
        self._history, self._notifications, self._snapshot = history, notifications, snapshot

    async def run(self) -> None:
        while True:
            now = time.monotonic()
            found = await asyncio.to_thread(self._files.look, time.time())
            if self._files.writer_lives:
                self._lease.active(WRITER, now)
            if found is not None and found.trouble:
                self._tell(found.trouble)
            elif found is not None:
                await self.order(found.words, Spoken(now - found.age, now - found.age))
            await asyncio.sleep(LOOK_PERIOD_S)

    async def order(self, words: str, said: Spoken) -> None:
        """One sentence, and when it was written: under way, or why not in the history and on the notice board."""
        command = understand(words, spoken=True, own=self._dispatcher.phrases)
        if isinstance(command, Refusal):
            self._refuse(words, command.reason)
            return
        try:
            call = await self._call() if spec_of(command.name).target == "person" else None
            self._dispatcher.dispatch(replace(command, call=call), SOURCE, WRITER, said)
        except Problem as problem:
            self._tell(problem.detail)
        except BadInput as misfit:
            self._refuse(words, str(misfit))

    def _refuse(self, words: str, why: str) -> None:
        self._history.add("command", WRITER, state="refused", source=SOURCE, words=words, remark=why)
        self._tell(why)

    def _tell(self, why: str) -> None:
        self._notifications.tell("warning", f"From the text file: {why}")

    async def _call(self) -> VoiceBearing | None:
        """From where the words came, by source.txt. Raises BadInput."""
        source = await asyncio.to_thread(self._files.source, time.time())
        now = self._snapshot()
        if now is None:
            return None
        here = now.estimate.pose
        return VoiceBearing(
            stamp=now.stamp - source.age, azimuth=here.heading + source.azimuth, sd=source.sd, x=here.x, y=here.y
        )
