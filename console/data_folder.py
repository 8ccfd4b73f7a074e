"""The data folder: its owner's alone, and whether what must last can be written into it."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import fcntl
import json
import logging
import os
import re
import shutil
import stat
from collections.abc import Generator
from pathlib import Path
from typing import IO, TYPE_CHECKING

from console.part import Part
from core.errors import Unavailable, Unwritable
from core.files import reason, remove_unfinished, try_writing
from core.models import user_folder

if TYPE_CHECKING:
    from console.control.notices import Notifications

OURS = re.compile(
    r"history\.sqlite.*|console\.log.*|halt\..*|lock|access\..*|maps|calibration|people|robots|speech_quality|experiments|recordings|fleet|settings\.toml|route\.json|pictures|models|"
    r"recordings\.json|before-restore|open\.html|"
    r"\..*\.new"
)
LOOK_PERIOD_S, TROUBLED_LOOK_PERIOD_S = 10.0, 2.0  # between looks while all is well, and while it is not
DISK_TIMEOUT_S = 5.0  # after which a disk that does not answer is reported
CAUSE = "data folder"  # of the notice


def prepare(folder: Path) -> None:
    """Make the folder where it is missing, and close it and our files in it to other users of this machine.

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
    """Take the rights of group and others from our files; from the folder itself where all in it is ours."""
    found = list(folder.iterdir())
    ours = [path for path in found if OURS.fullmatch(path.name)]
    for path in [*ours, *([folder] if len(ours) == len(found) else [])]:
        mode = path.lstat().st_mode
        if not stat.S_ISLNK(mode) and path.lstat().st_uid == os.geteuid() and mode & 0o077:
            path.chmod(stat.S_IMODE(mode) & ~0o077)


class DataFolder(Part):
    """Looks now and then, from a thread, whether it can be written. Lives on the event loop."""

    def __init__(self, folder: Path, notifications: Notifications) -> None:
        self._folder, self._notifications = folder, notifications
        self._disk = self._history = ""
        self._reported = ""
        self._looking: asyncio.Task[str] | None = None

    @property
    def trouble(self) -> str:
        """Why what must last cannot be kept now, in a sentence; "" when it can."""
        return self._disk or self._history

    @property
    def free_bytes(self) -> int | None:
        """Free space where the folder lies; None where nothing is known of it."""
        try:
            return shutil.disk_usage(self._folder).free
        except OSError:
            return None

    async def run(self) -> None:
        while True:
            await self.look()
            await asyncio.sleep(TROUBLED_LOOK_PERIOD_S if self.trouble else LOOK_PERIOD_S)

    async def look(self) -> None:
        """Try it once, and tell when something has changed."""
        self._looking = self._looking or asyncio.create_task(asyncio.to_thread(self._tried))
        done, _ = await asyncio.wait({self._looking}, timeout=DISK_TIMEOUT_S)
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
        if self.trouble == self._reported:
            return
        self._reported = self.trouble
        if self.trouble:
            self._notifications.tell("error", self.trouble, CAUSE)
        else:
            self._notifications.tell("info", "The data folder can be written again.", CAUSE)

    def _tried(self) -> str:
        try:
            if not self._folder.exists():
                self._folder.mkdir(mode=0o700, parents=True)
            try_writing(self._folder)
        except OSError as trouble:
            return f"Nothing can be saved in the data folder {self._folder}: {reason(trouble)}"
        return ""


def home_folder(chosen: str | Path | None = None) -> Path:
    """`--data DIR`, else $BECKON_HOME, else the user's data folder."""
    return Path(chosen).expanduser() if chosen else user_folder()


log = logging.getLogger(__name__)

SETTINGS_FILE = "settings.toml"
NAME = "lock"
MAX_OWNER_CHARACTERS = 1000  # characters of what stands in it
NO_LOCKS = frozenset({errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP})  # of file systems that know none


class FolderLock:
    """Held as long as this process lives, however it ends: a file that is left behind locks nothing."""

    def __init__(self, file: IO[str]) -> None:
        self._file = file

    def announce(self, port: int, address: str = "") -> None:
        """Write down for others who holds the lock, where it listens, and under which address it is opened."""
        with contextlib.suppress(OSError):
            self._file.seek(0)
            self._file.truncate()
            self._file.write(json.dumps({"pid": os.getpid(), "port": port, "address": address}) + "\n")
            self._file.flush()


@contextlib.contextmanager
def locked(home: Path) -> Generator[FolderLock]:
    """Take the data folder, and remove what a crash left half-written in it.

    Raises Unavailable when another console has it, Unwritable when nothing can be kept in it.
    """
    prepare(home)
    try:
        file = (home / NAME).open("a+", encoding="utf-8")
    except OSError as trouble:
        raise Unwritable(
            f"The file {home / NAME} cannot be written ({trouble.strerror}); choose another folder with --data."
        ) from None
    with file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise Unavailable(
                f"Another console{_holder(file)} uses the data folder {home}: work with that one, or start this one "
                "with --data and a folder of its own."
            ) from None
        except OSError as trouble:
            if trouble.errno not in NO_LOCKS:
                raise Unavailable(f"The data folder {home} cannot be locked ({trouble.strerror}).") from None
            log.warning("The data folder %s cannot be locked; start no second console on it.", home)
        lock = FolderLock(file)
        lock.announce(0)
        remove_unfinished(home)
        yield lock


def _holder(file: IO[str]) -> str:
    try:
        file.seek(0)
        owner = json.loads(file.read(MAX_OWNER_CHARACTERS))
        port = f", port {owner['port']:d}" if owner["port"] else ""
        return f" (process {owner['pid']:d}{port})"
    except (OSError, ValueError, KeyError, TypeError):
        return ""


def running_at(home: Path) -> str | None:
    """The address of the console that has this data folder; None when none runs."""
    try:
        with (home / NAME).open(encoding="utf-8") as file:
            with contextlib.suppress(BlockingIOError):
                fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
                return None
            return json.loads(file.read(MAX_OWNER_CHARACTERS))["address"] or None
    except (OSError, ValueError, KeyError, TypeError):
        return None
