"""Writes lines to a file from a thread of its own: a disk that is busy or full must not make the gate late."""

from __future__ import annotations

import contextlib
import queue
import threading
from pathlib import Path


class Scribe:
    """Appends what `write` is given, in order; beginning with `heading` when the file is new."""

    def __init__(self, path: Path, heading: str = "") -> None:
        """Raises OSError when the file cannot be opened."""
        self._file = path.open("a", newline="", encoding="utf-8")
        self._lines: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="scribe", daemon=True)
        if self._file.tell() == 0:
            self.write(heading)
        self._thread.start()

    def write(self, lines: str) -> None:
        """Write this as soon as the disk takes it; never waits."""
        self._lines.put(lines)

    def close(self, patience: float = 1.0) -> None:
        """Write what is left, for `patience` [s] at most."""
        self._lines.put(None)
        self._thread.join(patience)

    def _run(self) -> None:
        while (lines := self._lines.get()) is not None:
            with contextlib.suppress(OSError):
                self._file.write(lines)
                if self._lines.empty():
                    self._file.flush()
        with contextlib.suppress(OSError):
            self._file.close()
