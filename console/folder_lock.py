"""One console per data folder: the halt, the maps and the calibrations in it belong to one robot."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import json
import logging
import os
from collections.abc import Generator
from pathlib import Path
from typing import IO

from console.data_folder import prepare
from core.errors import Unavailable, Unwritable
from core.files import remove_unfinished

log = logging.getLogger(__name__)

NAME = "lock"
NO_LOCKS = frozenset({errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP})  # of file systems that know none


class FolderLock:
    """Held as long as this process lives, however it ends: a file that is left behind locks nothing."""

    def __init__(self, file: IO[str]) -> None:
        self._file = file

    def announce(self, port: int) -> None:
        """Write down for others who holds the lock and where it listens."""
        with contextlib.suppress(OSError):
            self._file.seek(0)
            self._file.truncate()
            self._file.write(json.dumps({"pid": os.getpid(), "port": port}) + "\n")
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
    """Who holds the lock, as far as it is written there."""
    try:
        file.seek(0)
        told = json.loads(file.read(200))
        port = f", port {told['port']:d}" if told["port"] else ""
        return f" (process {told['pid']:d}{port})"
    except (OSError, ValueError, KeyError, TypeError):
        return ""
