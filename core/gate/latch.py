"""The latch of a halt, which survives everything: a file that is there while the robot is halted."""

import contextlib
import os
from pathlib import Path

NAME = "halt.json"


class Latch:
    """Set means that the file exists; what it says is for people. What `set` and `clear` returned from is on disk."""

    def __init__(self, home: Path) -> None:
        self._path = home / NAME

    @property
    def is_set(self) -> bool:
        """True while the robot is halted, and also when that cannot be read."""
        try:
            self._path.lstat()
        except FileNotFoundError:
            return False
        except OSError:
            return True
        return True

    def set(self) -> None:
        """Latch. Raises OSError when that cannot be kept."""
        self._path.parent.mkdir(parents=True, exist_ok=True)
        draft = self._path.with_suffix(".new")
        with draft.open("w") as file:
            file.write('{"halted": true}\n')
            file.flush()
            os.fsync(file.fileno())
        try:
            draft.replace(self._path)
        except FileNotFoundError:  # another process sets it too, and moved the draft of both
            if not self.is_set:
                raise
        self._keep_folder()

    def clear(self) -> None:
        """Unlatch. Raises OSError when that cannot be kept."""
        self._path.unlink(missing_ok=True)
        with contextlib.suppress(FileNotFoundError):
            self._keep_folder()

    def _keep_folder(self) -> None:
        folder = os.open(self._path.parent, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)
