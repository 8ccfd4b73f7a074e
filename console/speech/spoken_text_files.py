"""Commands that the robot's ears understood, written into text files for another program (paper 4.2)."""

import asyncio
import time

from console.control.notices import Notifications
from console.control.text_files import RENEWAL_S, TextFileCommand, TextFileSource, TextFileWriter
from console.part import Part
from console.speech.listener import SpokenOutcome
from core.errors import Unwritable
from core.snapshot import VoiceDirection

MOST_WAITING = 20  # commands; a folder that takes none for longer has no use of older ones


class SpokenTextFiles(Part):
    """Lives on the event loop; the files are written outside."""

    def __init__(self, files: TextFileWriter, notifications: Notifications) -> None:
        self._files, self._notifications = files, notifications
        self._waiting: asyncio.Queue[tuple[str, VoiceDirection | None, float]] = asyncio.Queue(MOST_WAITING)

    def heard(self, outcome: SpokenOutcome, voice: VoiceDirection | None) -> None:
        """Take words, whether they are obeyed here or not; only commands that were heard for sure count."""
        decision, stops = outcome.utterance.decision, outcome.heard == "stop"
        if outcome.heard == "stopped" or decision.verdict != "accept" or decision.command is None:
            return
        if not self._waiting.full():
            ended = time.monotonic() if stops else outcome.said.ended
            self._waiting.put_nowait((decision.command.heard_as, None if stops else voice, ended))

    async def run(self) -> None:
        """Write, one after the other, and give signs of life."""
        while True:
            try:
                async with asyncio.timeout(RENEWAL_S):
                    words, voice, ended = await self._waiting.get()
            except TimeoutError:
                await asyncio.to_thread(self._files.renew)
                continue
            age = max(time.monotonic() - ended, 0.0)
            source = None if voice is None else TextFileSource(voice.azimuth, voice.sd_heard, age)
            try:
                await asyncio.to_thread(self._files.write, TextFileCommand(words, age=age), source)
            except Unwritable as trouble:
                self._notifications.tell("warning", str(trouble))
