"""How subcommands answer: one JSON object with `--json`, sentences without."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from core.files import check_file, check_folder


def add_json(parser: argparse.ArgumentParser) -> None:
    """Give a subcommand `--json`."""
    parser.add_argument("--json", action="store_true", help="print one JSON object and nothing else")


def add_out(parser: argparse.ArgumentParser, purpose: str, *, required: bool = False) -> None:
    """Give a subcommand `--out DIR`, which is checked before anything is computed."""
    parser.add_argument("--out", type=Path, default=None, required=required, metavar="DIR", help=purpose)
    parser.set_defaults(check_out=check_folder)


def add_out_file(parser: argparse.ArgumentParser, name: str, purpose: str) -> None:
    """The same for a single file."""
    parser.add_argument("--out", type=Path, default=None, metavar=name, help=purpose)
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
    sys.stdout.write(json.dumps(plain(value), ensure_ascii=False, allow_nan=False) + "\n")


def write(text: str) -> None:
    """Print a line for people."""
    sys.stdout.write(text + "\n")


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
