"""The data folder: its owner's alone, and whether what must last can be written into it."""

from __future__ import annotations

import asyncio
import errno
import os
import re
import stat
from pathlib import Path

from console.notice_board import NoticeBoard
from core.errors import Unwritable
from core.files import reason, try_writing

OURS = re.compile(r"history\.sqlite.*|console\.log.*|halt\..*|lock|maps|calibration|people|speech_quality|\..*\.new")
LOOK, LOOK_AGAIN = 10.0, 2.0  # [s] between looks while all is well, and while it is not
PATIENCE = 5.0  # [s] after which a disk that does not answer is told
CAUSE = "data folder"  # of the notice


def prepare(folder: Path) -> None:
    """Make the folder where it is missing, and close it and what is ours in it to other users of this machine.

    Raises Unwritable when nothing can be kept there.
    """
    try:
        if folder.exists() and not folder.is_dir():
            raise NotADirectoryError(errno.ENOTDIR, "It is not a folder", str(folder))
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        try_writing(folder)
    except OSError as trouble:
        raise Unwritable(
            f"Nothing can be kept in the data folder {folder}: {reason(trouble)} Or choose another with --data DIR."
        ) from None
    close_to_others(folder)


def close_to_others(folder: Path) -> None:
    """Take the rights of group and others from what is ours; from the folder itself where all in it is ours."""
    found = list(folder.iterdir())
    ours = [path for path in found if OURS.fullmatch(path.name)]
    for path in [*ours, *([folder] if len(ours) == len(found) else [])]:
        mode = path.lstat().st_mode
        if not stat.S_ISLNK(mode) and path.lstat().st_uid == os.geteuid() and mode & 0o077:
            path.chmod(stat.S_IMODE(mode) & ~0o077)


class DataFolder:
    """Looks now and then, from a thread, whether it can be written. Lives on the event loop."""

    def __init__(self, folder: Path, board: NoticeBoard) -> None:
        self._folder, self._board = folder, board
        self._disk = self._history = ""
        self._told = ""
        self._looking: asyncio.Task[str] | None = None

    @property
    def trouble(self) -> str:
        """Why what must last cannot be kept now, in a sentence; "" when it can."""
        return self._disk or self._history

    async def watch(self) -> None:
        """For as long as the console runs."""
        while True:
            await self.look()
            await asyncio.sleep(LOOK_AGAIN if self.trouble else LOOK)

    async def look(self) -> None:
        """Try it once, and tell when something has changed."""
        self._looking = self._looking or asyncio.create_task(asyncio.to_thread(self._tried))
        done, _ = await asyncio.wait({self._looking}, timeout=PATIENCE)
        if done:
            self._disk, self._looking = self._looking.result(), None
        else:
            self._disk = f"The disk of the data folder {self._folder} does not answer. Check it."
        self._tell()

    def history(self, trouble: str) -> None:
        """The history cannot be written, and why; "": it can again."""
        self._history = trouble
        self._tell()

    def _tell(self) -> None:
        if self.trouble == self._told:
            return
        self._told = self.trouble
        if self.trouble:
            self._board.tell("error", self.trouble, CAUSE)
        else:
            self._board.tell("info", "The data folder can be written again.", CAUSE)

    def _tried(self) -> str:
        try:
            if not self._folder.exists():
                self._folder.mkdir(mode=0o700, parents=True)
            try_writing(self._folder)
        except OSError as trouble:
            return f"Nothing can be saved in the data folder {self._folder}: {reason(trouble)}"
        return ""
