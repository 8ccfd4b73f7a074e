"""How subcommands answer: one JSON object with `--json`, sentences without."""

from __future__ import annotations

import argparse
import json
import signal
import sys
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from core.errors import BadInput, BadSettings, BeckonError, Refused, Unavailable, Unwritable
from core.files import check_file, check_folder
from core.sensors.checks import UnusableReading
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


def add_json(parser: argparse.ArgumentParser) -> None:
    """Give a subcommand `--json`."""
    parser.add_argument("--json", action="store_true", help="print one JSON object and nothing else")


def add_out(parser: argparse.ArgumentParser, purpose: str, *, required: bool = False) -> None:
    """Give a subcommand `--out DIR`, which is checked before anything is computed."""
    parser.add_argument("--out", type=Path, default=None, required=required, metavar="DIR", help=purpose)
    parser.set_defaults(check_out=check_folder)


def add_out_file(parser: argparse.ArgumentParser, name: str, purpose: str, *, required: bool = False) -> None:
    """The same for a single file."""
    parser.add_argument("--out", type=Path, default=None, required=required, metavar=name, help=purpose)
    parser.set_defaults(check_out=check_file)


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
    """Print one JSON object."""
    JSON_BEGUN.set(True)
    sys.stdout.write(_json(value) + "\n")


def refusal_of(error: Exception) -> dict[str, object]:
    """Return what forbids an answer as it stands in JSON: sentence, code, and faults of readings with theirs."""
    faults = error.faults if isinstance(error, UnusableReading) else ()
    known = faults[0].code if faults else code_of(sentence_of(error)).code
    kind = next((code for kind, code in KINDS if isinstance(error, kind)), "internal")
    refusal: dict[str, object] = {"error": sentence_of(error), "code": known or kind}
    if faults:
        refusal["faults"] = [{"code": one.code, "sensor": one.sensor, "sentence": one.sentence} for one in faults]
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

    def __init__(self, member: str, head: Mapping[str, object] | None = None, *, named: bool = True) -> None:
        """`member` is an object whose entries have names, or else a list; `head` has what stands before it."""
        self._member, self._head, self._ends = member, head or {}, "{}" if named else "[]"
        self._named, self._count = named, 0
        self.tail: dict[str, object] = {}  # what stands after the member

    def __enter__(self) -> GrowingJson:
        JSON_BEGUN.set(True)
        begin = {**self._head, self._member: None}
        self._print(_json(begin).removesuffix("null}") + self._ends[0])
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
        sys.stdout.write(text)
        sys.stdout.flush()


def _json(value: object) -> str:
    return json.dumps(plain(value), ensure_ascii=False, allow_nan=False)


def write(text: str) -> None:
    """Print a line for people, at once: what was said stays said when the rest is interrupted."""
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


def tell(text: str) -> None:
    """Print progress where it does not disturb an answer."""
    sys.stderr.write(text + "\n")


@contextmanager
def progress() -> Generator[Callable[[str], None]]:
    """Progress in words: on a terminal one line that changes and goes, elsewhere a line each."""
    if not sys.stderr.isatty():
        yield tell
        return

    def say(text: str) -> None:
        sys.stderr.write(f"\r\x1b[K{text}")
        sys.stderr.flush()

    try:
        yield say
    finally:
        say("")
