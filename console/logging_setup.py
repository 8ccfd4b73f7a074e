"""Logging of the console: everything to a file, only what matters to the terminal, in one line."""

import json
import logging
import sys
import time
from collections.abc import Callable
from logging.handlers import RotatingFileHandler
from pathlib import Path

MAX_LOG_BYTES = 1_000_000  # of a file before the next one begins
MAX_OLDER_FILES = 3  # files kept
MOST_ALIKE = 20  # lines within a minute: what strangers provoke must not push the rest out of the files
MINUTE_S = 60.0
MOST_KINDS = 1000  # of lines that are distinguished
# how uvicorn begins lines about what a sentence will say
STARTUP_FAILED = ("Traceback", "Application startup failed")


class OneLineFormatter(logging.Formatter):
    """A sentence; the traceback stays in the file."""

    def format(self, record: logging.LogRecord) -> str:
        """The message alone, its first line."""
        return f"beckon: {record.getMessage().partition(chr(10))[0]}"


class JsonFormatter(logging.Formatter):
    """One JSON object a line, for programs that collect logs."""

    def format(self, record: logging.LogRecord) -> str:
        """Time (UTC), level, logger, message, and the traceback where there is one."""
        line = {
            "time": time.strftime("%Y-%m-%dT%H:%M:%S", time.gmtime(record.created)) + f".{int(record.msecs):03}Z",
            "level": record.levelname,
            "logger": record.name,
            "message": record.getMessage(),
        }
        if record.exc_info:
            line["traceback"] = self.formatException(record.exc_info)
        return json.dumps(line, ensure_ascii=False)


def json_line(sentence: str) -> str:
    """An error that ends the program, as a line of its log."""
    return JsonFormatter().format(logging.makeLogRecord({"name": "beckon", "levelname": "ERROR", "msg": sentence}))


class RepeatFilter(logging.Filter):
    """Lets through so many lines of one kind within a minute; in the next one it says how many were left out."""

    def __init__(self, say: Callable[[str], None]) -> None:
        super().__init__()
        self._say = say
        self._counted: dict[tuple[str, str], tuple[float, int]] = {}  # minute's begin [s], lines in it

    def filter(self, record: logging.LogRecord) -> bool:
        """True to write this line. Its kind is its logger and its text before numbers and names are put in."""
        kind, now = (record.name, str(record.msg).partition("\n")[0]), time.monotonic()
        begun, count = self._counted.pop(kind, (now, 0))
        if now - begun > MINUTE_S:
            if count > MOST_ALIKE:
                self._say(f"{count - MOST_ALIKE} lines like “{kind[1]}” were left out.")
            begun, count = now, 0
        if len(self._counted) >= MOST_KINDS:
            del self._counted[next(iter(self._counted))]
        self._counted[kind] = begun, count + 1
        return count < MOST_ALIKE


def start_logging(path: Path, *, as_json: bool = False) -> None:
    """Log to `path` from now on; a folder that cannot be written to is reported and does not stop the console.

    `as_json`: an object a line, and the terminal gets all of them.
    """
    root = logging.getLogger()
    root.setLevel(logging.INFO)
    logging.getLogger("uvicorn.error").setLevel(logging.WARNING)  # else every stranger's socket writes lines
    terminal = logging.StreamHandler(sys.stderr)
    terminal.setLevel(logging.INFO if as_json else logging.ERROR)
    terminal.setFormatter(JsonFormatter() if as_json else OneLineFormatter())
    terminal.addFilter(
        lambda record: (
            not record.name.startswith("uvicorn") or (as_json and not record.getMessage().startswith(STARTUP_FAILED))
        )
    )
    terminal.addFilter(RepeatFilter(lambda _: None))
    root.addHandler(terminal)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        kept = RotatingFileHandler(path, maxBytes=MAX_LOG_BYTES, backupCount=MAX_OLDER_FILES, encoding="utf-8")
    except OSError as trouble:
        root.error("The log %s cannot be written: %s.", path.name, trouble.strerror)
        return
    plain = logging.Formatter("%(asctime)s %(levelname)s %(name)s: %(message)s")
    kept.setFormatter(JsonFormatter() if as_json else plain)
    kept.addFilter(RepeatFilter(logging.getLogger(__name__).warning))
    root.addHandler(kept)
