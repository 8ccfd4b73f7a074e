"""A campaign: the runs of an experiment on any number of workers, kept as they end, resumed after a kill.

The answers depend on the numbers of the runs alone, and are put together in that order: one process, several and a
cluster give the same result to the last digit.
"""

from __future__ import annotations

import contextlib
import dataclasses
import fcntl
import hashlib
import json
import os
import time
from collections.abc import Callable, Mapping
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import IO, Any, cast, get_origin

import msgspec
import numpy as np

from core.errors import BadInput, Unavailable
from core.experiments.plan import ExperimentPlan
from core.experiments.result import ExperimentResult, SpeedUp
from core.experiments.workers import Workers, killed, timed, versions
from core.files import saving
from core.message import listed

BOOKKEEPING_KEYS = ("number", "done", "of", "seconds")  # of every line, before the answer's own keys
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
            kept = msgspec.to_builtins(answer, enc_hook=listed)
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
        rest = {key: value for key, value in row.items() if key not in BOOKKEEPING_KEYS}
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


def _array(kind: type, value: Any) -> Any:
    if get_origin(kind) is np.ndarray:
        return np.array(value)
    raise NotImplementedError(kind)


MAX_BREAKS = 3  # of the workers in succession without a run between them
PROGRESS_LINES = 10  # of the progress at least
REPORT_EVERY_S = 10.0
IN_HAND = 2  # runs that every worker is given at a time


@dataclass(frozen=True)
class Campaign:
    """How runs are carried out. `progress` is given a line now and then, `tell` what remains to be read."""

    experiment: str
    seed: int = 0
    out: Path | None = None
    tell: Callable[[str], None] | None = None
    workers: int | None = None  # None: as many as this computer has, where the runs are worth it
    cluster: str = ""  # address of a scheduler of dask; "": this computer
    resume: bool = False  # the runs in `out` are not carried out again
    progress: Callable[[str], None] | None = None  # None: `tell`
    report_every_s: float = REPORT_EVERY_S

    def carry_out(self, plan: ExperimentPlan) -> ExperimentResult:
        """Carry out every run that lacks → the result. Raises BeckonError."""
        answers, figures = self.answers(plan)
        result: ExperimentResult = plan.finish(answers, self.out)
        result["files"] |= {} if self.runs_file is None else {"runs": str(self.runs_file)}
        return cast(ExperimentResult, {**result, **figures})

    @property
    def runs_file(self) -> Path | None:
        """The file of the runs that are done."""
        return None if self.out is None else self.out / f"{self.experiment.replace('-', '_')}_runs.jsonl"

    def answers(self, plan: ExperimentPlan) -> tuple[list[Any], SpeedUp]:
        """Carry out every run that lacks → all answers by number, and how it went. Raises BeckonError."""
        path, count = self.runs_file, plan.count
        found = versions()
        heading = {"experiment": self.experiment, "seed": self.seed} | found
        began = time.monotonic()
        with Workers(self.workers, self.cluster, count) as workers, RunLog(path, plan, heading, self.resume) as log:
            done = _Progress(self, count, log.resumed)
            try:
                _Rounds(plan, log, workers, done, found["Beckon"]).run()
            except BaseException:
                if path is not None and self.tell is not None:
                    self.tell(f"Ended after {len(log.answers)} of {count} runs; their figures are in {path}.")
                raise
        seconds = time.monotonic() - began
        figures: SpeedUp = {
            "workers": workers.count,
            "seconds": seconds,
            "resumed_runs": log.resumed,
            "serial_seconds": done.serial,
            "speed_up": done.serial / seconds if done.serial and seconds else None,
        }
        return [log.answers[number] for number in range(count)], figures


class _Rounds:
    """The runs that lack, handed out until all are done."""

    def __init__(self, plan: ExperimentPlan, log: RunLog, workers: Workers, progress: _Progress, source: str) -> None:
        self._plan, self._log, self._workers, self._progress = plan, log, workers, progress
        self._source = source
        self._missing = [number for number in reversed(range(plan.count)) if number not in log.answers]
        self._under_way: dict[Future[tuple[Any, float]], int] = {}
        self._breaks = 0

    def run(self) -> None:
        """Hand out, wait, keep; where a process was killed, what it had is handed out again."""
        while self._missing or self._under_way:
            try:
                self._hand_out()
                self._keep()
            except Exception as error:
                if not killed(error):
                    raise
                self._begin_again()

    def _hand_out(self) -> None:
        most = 1 if self._workers.count == 1 else IN_HAND * self._workers.count
        while self._missing and len(self._under_way) < most:
            batch, number = self._plan.batch_of(self._missing[-1])
            future = self._workers.executor.submit(timed, batch.work, number, self._source)
            self._under_way[future] = self._missing.pop()

    def _keep(self) -> None:
        finished, _ = wait(self._under_way, return_when=FIRST_COMPLETED)
        for future in finished:
            try:
                answer, seconds = future.result()
            except CancelledError:
                raise Unavailable("The scheduler of the cluster is gone; the runs that were done are kept.") from None
            self._log.add(self._under_way.pop(future), answer, seconds)
            self._progress.add(seconds)
            self._breaks = 0

    def _begin_again(self) -> None:
        self._missing += sorted(self._under_way.values(), reverse=True)
        self._under_way.clear()
        self._workers.discard()
        self._breaks += 1
        if self._breaks > MAX_BREAKS:
            raise Unavailable(
                "The system kills the workers again and again before a run is done; use fewer --workers, each needs "
                "its memory."
            )


class _Progress:
    """Lines such as "12 of 40 runs, 1.3 a second, 22 s to go"."""

    def __init__(self, campaign: Campaign, count: int, resumed: int) -> None:
        self._say = campaign.progress or campaign.tell
        self._every_s = campaign.report_every_s
        self._count, self._done, self._resumed = count, resumed, resumed
        self._began = self._said = time.monotonic()
        self.serial = 0.0  # [s] of processor time
        if resumed and campaign.tell is not None:
            campaign.tell(f"Resumed: {resumed} of {count} runs were done.")

    def add(self, seconds: float) -> None:
        self._done += 1
        self.serial += seconds
        now = time.monotonic()
        tenth = self._done * PROGRESS_LINES // self._count > (self._done - 1) * PROGRESS_LINES // self._count
        if self._say is not None and (tenth or now - self._said >= self._every_s):
            self._said = now
            rate = (self._done - self._resumed) / max(now - self._began, 1e-3)
            left = _in_words((self._count - self._done) / rate)
            pace = f"{rate:.2g} a second" if rate >= 1 else f"{1 / rate:.2g} s each"
            self._say(f"{self._done} of {self._count} runs, {pace}, {left} to go")


def _in_words(seconds: float) -> str:
    if seconds < 100:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 100 else f"{minutes // 60} h {minutes % 60} min"
