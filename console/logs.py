"""Where the console writes what happened: everything to a file, only what matters to the terminal, in one line."""

from __future__ import annotations

import logging
import sys
from logging.handlers import RotatingFileHandler
from pathlib import Path

LARGEST = 1_000_000  # [bytes] of a file before the next one begins
OLDER = 3  # files kept


class OneLine(logging.Formatter):
    """A sentence; the traceback stays in the file."""

    def format(self, record: logging.LogRecord) -> str:
        """The message alone, its first line."""
        return f"beckon: {record.getMessage().partition(chr(10))[0]}"


def start_logging(path: Path) -> None:
    """Log to `path` from now on; a folder that cannot be written to is told and does not stop the console."""
    root = logging.getLogger()
    root.setLevel(logging.INFO)
    terminal = logging.StreamHandler(sys.stderr)
    terminal.setLevel(logging.ERROR)
    terminal.setFormatter(OneLine())
    terminal.addFilter(lambda record: not record.name.startswith("uvicorn"))
    root.addHandler(terminal)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        kept = RotatingFileHandler(path, maxBytes=LARGEST, backupCount=OLDER, encoding="utf-8")
    except OSError as trouble:
        root.error("The log %s cannot be written: %s.", path.name, trouble.strerror)
        return
    kept.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(name)s: %(message)s"))
    root.addHandler(kept)
