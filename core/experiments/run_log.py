"""File of a campaign's runs: each as soon as it is done, so that a killed campaign goes on with those that lack."""

from __future__ import annotations

import contextlib
import dataclasses
import fcntl
import hashlib
import json
import os
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import IO, Any, get_origin

import msgspec
import numpy as np

from core.errors import BadInput, Unavailable
from core.experiments.plan import ExperimentPlan
from core.files import saving

BOOKKEEPING = ("number", "done", "of", "seconds")  # of every line, before the answer's own keys
ANSWER = "answer"  # the key of an answer without keys


class RunLog:
    """Lines of JSON: what the runs are, then one for each run; without a folder none are kept.

    A context manager; entering it raises, before there is any work, Unwritable, Unavailable where another campaign
    writes the file, and with `resume` BadInput where the file is of other runs.
    """

    def __init__(self, path: Path | None, plan: ExperimentPlan, heading: Mapping[str, object], resume: bool) -> None:
        self._path, self._plan, self._resume = path, plan, resume
        self._heading = {**heading, "runs": plan.count, "options": checksum(plan.batches)}
        self._file: IO[str] | None = None
        self.answers: dict[int, Any] = {}  # by the number of the run
        self.resumed = 0  # of them, that were in the file

    def add(self, number: int, answer: Any, seconds: float) -> None:
        """A run is done, and took that much processor time. Raises Unwritable."""
        self.answers[number] = answer
        if self._file is not None:
            kept = _plain(answer)
            line = {"number": number, "done": len(self.answers), "of": self._plan.count, "seconds": seconds}
            self._write(line | (kept if isinstance(kept, dict) else {ANSWER: kept}))

    def __enter__(self) -> RunLog:
        if self._path is not None:
            with saving(f"{self._path} cannot be written"):
                self._path.parent.mkdir(parents=True, exist_ok=True)
                self._file = self._path.open("a+", encoding="utf-8")
            try:
                self._begin(self._file, self._path)
            except BaseException:
                self._file.close()
                raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, fault: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._file is not None:
            with contextlib.suppress(OSError):  # a line that could not be written was reported already
                self._file.close()

    def _begin(self, file: IO[str], path: Path) -> None:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise Unavailable(
                f"Another campaign writes {path}; wait for its end, or choose another folder."
            ) from None
        except OSError:
            pass  # a disk without locks
        whole = self._read(file, path) if self._resume else 0
        self.resumed = len(self.answers)
        with saving(f"{path} cannot be written"):
            file.truncate(whole)
        if not whole:
            self._write(self._heading)

    def _read(self, file: IO[str], path: Path) -> int:
        """Take the answers of a former campaign → bytes of the file that are whole."""
        file.seek(0)
        whole = 0
        for line in file:
            try:
                row = json.loads(line) if line.endswith("\n") else None
                if row is None:
                    break
                if whole:
                    self._take(row)
                else:
                    self._compare(row, path)
            except (ValueError, LookupError, TypeError, AttributeError, msgspec.ValidationError):
                break
            whole += len(line.encode())
        return whole

    def _compare(self, heading: dict[str, object], path: Path) -> None:
        for name, value in self._heading.items():
            if heading[name] != value:
                shown = "" if name == "options" else f" ({name}: {heading[name]}, now {value})"
                other = "options or settings" if name == "options" else "runs"
                raise BadInput(
                    f"{path} holds other {other}{shown}; resume it with what it was begun with, or choose another "
                    "folder."
                )

    def _take(self, row: dict[str, Any]) -> None:
        number = row["number"]
        batch, _ = self._plan.batch_of(number)
        rest = {key: value for key, value in row.items() if key not in BOOKKEEPING}
        answer = rest[ANSWER] if rest.keys() == {ANSWER} else rest
        self.answers[number] = msgspec.convert(answer, batch.kind, dec_hook=_array)

    def _write(self, line: Mapping[str, object]) -> None:
        assert self._file is not None
        with saving(f"{self._path} cannot be written"):
            self._file.write(json.dumps(line) + "\n")
            self._file.flush()
            os.fsync(self._file.fileno())


def checksum(value: object) -> str:
    """Checksum of a work with all its options: equal in every process, and changed by each of them."""
    return hashlib.sha256(json.dumps(_described(value), sort_keys=True).encode()).hexdigest()[:16]


def _described(value: Any) -> object:
    """A work and its options as JSON; a file by its content."""
    if isinstance(value, partial):
        return [_described(value.func), _described(value.args), _described(value.keywords)]
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = {field.name: _described(getattr(value, field.name)) for field in dataclasses.fields(value)}
        return {"": type(value).__qualname__, **fields}
    if isinstance(value, Path):
        return hashlib.sha256(value.read_bytes()).hexdigest() if value.is_file() else str(value)
    if isinstance(value, Mapping):
        return {str(key): _described(one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [_described(one) for one in value]
    if isinstance(value, np.ndarray):
        return hashlib.sha256(value.tobytes()).hexdigest()
    return getattr(value, "__qualname__", None) or repr(value)


def _plain(value: Any) -> Any:
    """An answer as JSON, from which it can be made again to the last digit."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: _plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {key: _plain(one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(one) for one in value]
    return value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value


def _array(kind: type, value: Any) -> Any:
    """An array of a message out of JSON."""
    if get_origin(kind) is np.ndarray:
        return np.array(value)
    raise NotImplementedError(kind)
