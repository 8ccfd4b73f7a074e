"""The figures of every run as soon as there are any: an interrupted experiment keeps what it has."""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from types import TracebackType
from typing import IO, Any

from core.files import saving


class RunLog:
    """Lines of JSON, one for each run and each with how many of how many are done; without a folder none are kept.

    The first line says of what they are. A context manager; entering it raises Unwritable, before there is any work.
    """

    def __init__(
        self, out: Path | None, experiment: str, runs: int, seed: int, tell: Callable[[str], None] | None
    ) -> None:
        self._path = None if out is None else out / f"{experiment.replace('-', '_')}_runs.jsonl"
        self._head = {"experiment": experiment, "runs": runs, "seed": seed}
        self._runs, self._done = runs, 0
        self._tell = tell
        self._file: IO[str] | None = None

    @property
    def files(self) -> dict[str, str]:
        """Paths of the files."""
        return {} if self._path is None else {"runs": str(self._path)}

    def add(self, figures: Mapping[str, object]) -> None:
        """A run is done. Raises Unwritable."""
        self._done += 1
        self._write({"done": self._done, "of": self._runs, **figures})

    def __enter__(self) -> RunLog:
        """Begin the file."""
        if self._path is not None:
            with saving(f"{self._path} cannot be written"):
                self._path.parent.mkdir(parents=True, exist_ok=True)
                self._file = self._path.open("w", encoding="utf-8")
            self._write(self._head)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, fault: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Say what an interrupted experiment leaves."""
        if self._file is None:
            return
        with contextlib.suppress(OSError):  # a line that could not be written was reported already
            self._file.close()
        if kind is not None and self._tell is not None:
            self._tell(f"Ended after {self._done} of {self._runs} runs; their figures are in {self._path}.")

    def _write(self, line: Mapping[str, object]) -> None:
        if self._file is not None:
            with saving(f"{self._path} cannot be written"):
                self._file.write(json.dumps(line, default=_plain) + "\n")
                self._file.flush()
                os.fsync(self._file.fileno())


def _plain(value: Any) -> Any:
    """A number or an array of numpy as JSON takes it."""
    return value.tolist()
