"""What another program writes into speech.txt is ordered like what is typed (paper 4.2)."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable

from console.door import Door
from console.fresh_words import Said
from console.history import History
from console.lease import Lease
from console.logins import Person
from console.notice_board import NoticeBoard
from console.problems import Problem
from console.text_files import TextFiles
from core.errors import BadInput
from core.perception.people.call import Call
from core.snapshot import Snapshot
from core.speech.grammar import Refusal, understand

SOURCE = "file"
WRITER = Person("text files", "who writes the text files", "operator")
PERIOD = 0.1  # [s] between two looks
TO_A_PERSON = ("come_here", "follow_me")  # the paper reads where the voice was for these alone


class TextOrders:
    """Lives on the event loop; the files are read outside."""

    def __init__(
        self,
        files: TextFiles,
        door: Door,
        lease: Lease,
        history: History,
        board: NoticeBoard,
        snapshot: Callable[[], Snapshot | None],
    ) -> None:
        self._files, self._door, self._lease = files, door, lease
        self._history, self._board, self._snapshot = history, board, snapshot

    async def run(self) -> None:
        """Look again and again."""
        while True:
            now = time.monotonic()
            told = await asyncio.to_thread(self._files.look, time.time())
            if self._files.writer_lives:
                self._lease.active(WRITER, now)
            if told is not None and told.trouble:
                self._tell(told.trouble)
            elif told is not None:
                await self.order(told.words, Said(now - told.age, now - told.age))
            await asyncio.sleep(PERIOD)

    async def order(self, words: str, said: Said) -> None:
        """One sentence, and when it was written: under way, or why not in the history and on the notice board."""
        command = understand(words, spoken=True)
        if isinstance(command, Refusal):
            self._refuse(words, command.reason)
            return
        try:
            call = await self._call() if command.name in TO_A_PERSON else None
            self._door.submit(command.heard_as, SOURCE, WRITER, call, said)
        except Problem as problem:
            self._tell(problem.detail)
        except BadInput as misfit:
            self._refuse(words, str(misfit))

    def _refuse(self, words: str, why: str) -> None:
        self._history.add("command", WRITER, state="refused", source=SOURCE, words=words, remark=why)
        self._tell(why)

    def _tell(self, why: str) -> None:
        self._board.tell("warning", f"From the text file: {why}")

    async def _call(self) -> Call | None:
        """From where the words came, by source.txt. Raises BadInput."""
        source = await asyncio.to_thread(self._files.source, time.time())
        now = self._snapshot()
        if now is None:
            return None
        here = now.estimate.pose
        return Call(
            stamp=now.stamp - source.age, azimuth=here.heading + source.azimuth, sd=source.sd, x=here.x, y=here.y
        )
