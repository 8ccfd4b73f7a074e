"""How subcommands answer: one JSON object with `--json`, sentences without."""

import argparse
import json
import math
import shutil
import signal
import sys
import time
from collections.abc import Callable, Generator, Iterable, Mapping
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path
from types import TracebackType
from typing import Any, Self, TextIO

import numpy as np

from core.errors import BadInput, BadSettings, BeckonError, Refused, Unavailable, Unwritable
from core.files import check_file, check_folder
from core.progress import WorkProgress
from core.sensors.checks import UnusableReading, found_faults
from core.sentences import code_of

JSON_BEGUN = ContextVar("json_begun", default=False)
"""An object was begun on standard output: a refusal that comes later is no second one."""

KINDS = (
    (BadSettings, "usage"),
    (BadInput, "input"),
    (Unwritable, "unwritable"),
    (Unavailable, "unavailable"),
    (Refused, "refused"),
    (OSError, "system"),
)
"""Codes of errors whose sentences have none of their own."""

FIRST_SHOWN_S = 2.0  # of work, before which no progress is shown
BAR_PERIOD_S = 0.1  # between two states of a bar
TENTH_PERIOD_S, LINE_PERIOD_S = 2.0, 10.0  # between two lines without a terminal, with another tenth done or not
BAR_LETTERS = 20


def add_command(
    subcommands: Any, name: str, run: Callable[[argparse.Namespace], int], purpose: str, *, json: bool = True
) -> argparse.ArgumentParser:
    """Add a subcommand, with `--json` where it has such an answer, to what `add_subparsers` returned."""
    parser: argparse.ArgumentParser = subcommands.add_parser(name, help=purpose)
    parser.set_defaults(run=run)
    if json:
        parser.add_argument("--json", action="store_true", help="print one JSON object and nothing else")
    return parser


def add_out(parser: argparse.ArgumentParser, purpose: str, *, required: bool = False) -> None:
    """Give a subcommand `--out DIR`, which is checked before anything is computed."""
    parser.add_argument("--out", type=Path, required=required, metavar="DIR", help=purpose)
    parser.set_defaults(check_out=check_folder)


def add_out_file(parser: argparse.ArgumentParser, name: str, purpose: str, *, required: bool = False) -> None:
    """The same for a single file."""
    parser.add_argument("--out", type=Path, required=required, metavar=name, help=purpose)
    parser.set_defaults(check_out=check_file)


def number(low: float, high: float, otherwise: str) -> Callable[[str], float]:
    """A reader of an argument that is a number within bounds; `otherwise`: the sentence that refuses it."""

    def read(text: str) -> float:
        with suppress(ValueError):
            if low <= (value := float(text)) <= high:
                return value
        raise argparse.ArgumentTypeError(otherwise)

    return read


def whole_number(low: int, high: int, otherwise: str) -> Callable[[str], int]:
    """The same for a whole number, in digits alone."""

    def read(text: str) -> int:
        if not (text.isascii() and text.isdigit() and len(text) <= len(str(high)) and low <= int(text) <= high):
            raise argparse.ArgumentTypeError(otherwise)
        return int(text)

    return read


def plain(value: Any) -> Any:
    """Numbers and arrays → values that JSON can hold; a number that is not finite becomes null."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value


def write_json(value: Mapping[str, object]) -> None:
    JSON_BEGUN.set(True)
    sys.stdout.write(_json(value) + "\n")


def answer(
    chosen: argparse.Namespace, report: Mapping[str, object], *lines: str, warnings: Iterable[str] = ()
) -> int:
    """Print a report as JSON, its warnings on standard error, or in lines for people; return exit code 0."""
    if chosen.json:
        for warning in warnings:
            tell(warning)
        write_json(report)
    else:
        for line in lines:
            write(line)
    return 0


def refusal_of(error: Exception) -> dict[str, object]:
    """Return what forbids an answer as it stands in JSON: sentence, code, and faults of readings with theirs."""
    faults = error.faults if isinstance(error, UnusableReading) else ()
    known = faults[0].code if faults else code_of(sentence_of(error)).code
    kind = next((code for kind, code in KINDS if isinstance(error, kind)), "internal")
    refusal: dict[str, object] = {"error": sentence_of(error), "code": known or kind}
    if faults:
        refusal["faults"] = found_faults(faults)
    return refusal


def sentence_of(error: Exception) -> str:
    """Return an error in a sentence for people."""
    if isinstance(error, BeckonError):
        return str(error)
    if isinstance(error, OSError):
        return f"The system refuses {error.filename or 'this'}: {error.strerror or error}."
    return (
        f"Something went wrong inside Beckon ({type(error).__name__}). "
        "Run the same command with BECKON_DEBUG=1 and report what it prints."
    )


class GrowingJson:
    """One JSON object on standard output, of which one member grows: each entry is printed as soon as it is known.

    A command that is ended before its last entry (Ctrl+C, SIGTERM) leaves a whole object with those that were ready.
    """

    def __init__(self, member: str, *, named: bool = True) -> None:
        """`member` is an object whose entries have names, or else a list."""
        self._member, self._ends = member, "{}" if named else "[]"
        self._named, self._count = named, 0
        self.tail: dict[str, object] = {}  # what stands after the member

    def __enter__(self) -> Self:
        JSON_BEGUN.set(True)
        self._print(_json({self._member: None}).removesuffix("null}") + self._ends[0])
        self._before = signal.signal(signal.SIGTERM, signal.default_int_handler)
        return self

    def add(self, entry: Mapping[str, object], name: str = "") -> None:
        """Print an entry of the member; a second one of the same name would be lost on who reads it."""
        begin = f"{_json(name)}: " if self._named else ""
        self._print((", " if self._count else "") + begin + _json(entry))
        self._count += 1

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None
    ) -> None:
        signal.signal(signal.SIGTERM, self._before)
        if isinstance(error, Exception):
            self.tail |= refusal_of(error)
        if kind is None or not issubclass(kind, BrokenPipeError):
            self._print(self._ends[1] + "".join(f", {_json(key)}: {_json(one)}" for key, one in self.tail.items()))
            self._print("}\n")

    def _print(self, text: str) -> None:
        _clear_line()
        sys.stdout.write(text)
        sys.stdout.flush()


def _json(value: object) -> str:
    return json.dumps(plain(value), ensure_ascii=False, allow_nan=False)


def write(text: str) -> None:
    """Print a line for people, at once: what was said stays said when the rest is interrupted."""
    _clear_line()
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


def tell(text: str) -> None:
    """Print a line that stays where it does not disturb an answer."""
    _clear_line()
    sys.stderr.write(text + "\n")


def _clear_line() -> None:
    """Take a progress that is shown on a terminal away, until it is shown again."""
    if sys.stderr.isatty():
        sys.stderr.write("\r\x1b[K")
        sys.stderr.flush()


class ShownProgress(WorkProgress):
    """Progress on standard error: on a terminal a bar with the time to go, elsewhere a line now and then.

    Work that takes less than FIRST_SHOWN_S shows neither.
    """

    def __init__(self, stream: TextIO, clock: Callable[[], float] = time.monotonic) -> None:
        self._stream, self._clock, self._terminal = stream, clock, stream.isatty()
        self._began, self._shown, self._tenth = clock(), -math.inf, 0

    def at(self, share: float, doing: str = "") -> None:
        """Show the share, as often as people can read it."""
        now = self._clock()
        if share <= 0.0:
            self._began, self._tenth = now, 0
        passed, tenth = now - self._began, int(10 * share)
        slowly = not self._terminal and tenth == self._tenth
        period_s = LINE_PERIOD_S if slowly else TENTH_PERIOD_S if not self._terminal else BAR_PERIOD_S
        if passed < FIRST_SHOWN_S or now - self._shown < period_s:
            return
        self._shown, self._tenth = now, tenth
        left = f"{_clock_words(passed * (1 - share) / share)} to go" if share > 0.0 else ""
        if self._terminal:
            filled = round(BAR_LETTERS * share)
            bar = f"[{'#' * filled}{'.' * (BAR_LETTERS - filled)}] {share:4.0%}"
            self(" ".join(filter(None, (bar, left, doing))))
        else:
            self(", ".join(filter(None, (f"{share:.0%}", left, doing))))

    def tell(self, line: str) -> None:
        self._stream.write(f"\r\x1b[K{line}\n" if self._terminal else f"{line}\n")

    def __call__(self, line: str) -> None:
        """On a terminal one line that changes, elsewhere a line each."""
        if not self._terminal:
            self._stream.write(f"{line}\n")
            return
        width = shutil.get_terminal_size().columns - 1
        self._stream.write(f"\r\x1b[K{line[:width]}")
        self._stream.flush()


def _clock_words(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes}:{rest:02}" if minutes < 60 else f"{minutes // 60}:{minutes % 60:02}:{rest:02}"


@contextmanager
def progress() -> Generator[ShownProgress]:
    """Progress of a command while it works; on a terminal its line is gone afterwards."""
    shown = ShownProgress(sys.stderr)
    try:
        yield shown
    finally:
        _clear_line()
