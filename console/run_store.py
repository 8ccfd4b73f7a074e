"""Runs of long work: one at a time, watched, cancelled, and kept in a folder each."""

import asyncio
import logging
import re
import secrets
import shutil
import time
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Generic, Literal, TypeVar

import msgspec

from console.http.problems import Problem
from console.part import Part
from console.workers.tasks import end, to_the_end
from core.errors import BeckonError, Unwritable
from core.files import saving, write_atomic
from core.sentences import plain

log = logging.getLogger(__name__)

RUN_ID = re.compile(r"[0-9a-f]{12}")
CANCELLED = "Cancelled before it was done."

RunState = Literal["running", "done", "cancelled", "failed"]


class StoredRun(msgspec.Struct, kw_only=True):
    """One run, as it is kept; a kind of run adds what it measures."""

    id: str = msgspec.field(default_factory=lambda: secrets.token_hex(6))
    who: str
    at_s: float = msgspec.field(default_factory=time.time)  # Unix time of its start
    state: RunState = "running"
    doing: str = "Starting…"
    reason: str = ""  # why it failed
    progress: float | None = None  # 0..1; None: it does not count
    took_s: float = 0.0  # once it is over

    @property
    def elapsed_s(self) -> float:
        """Time [s] since its start, or that it took."""
        return time.time() - self.at_s if self.state == "running" else self.took_s


RunT = TypeVar("RunT", bound=StoredRun)


class RunStore(Part, Generic[RunT]):
    """Lives on the event loop. `folder/ID/run.json` holds a run, `folder/ID/files` what it wrote."""

    def __init__(self, folder: Path, kind: type[RunT], max_kept: int, busy: str) -> None:
        """`busy`: the sentence that refuses a second run while one is under way."""
        self.runs: dict[str, RunT] = {}  # oldest first
        self._folder, self._kind, self._max_kept, self._busy = folder, kind, max_kept, busy
        self._task: asyncio.Task[None] | None = None
        self._turn = asyncio.Lock()  # one write after the other

    async def open(self) -> None:
        for run in await asyncio.to_thread(lambda: sorted(self._kept(), key=lambda one: one.at_s)):
            self.runs[run.id] = run

    async def close(self) -> None:
        await end(self._task)

    @property
    def running(self) -> bool:
        return self._task is not None and not self._task.done()

    def find(self, run_id: str) -> RunT:
        """Raises Problem 404."""
        if run_id not in self.runs:
            raise Problem(404, "There is no such run; it may have been deleted.")
        return self.runs[run_id]

    def start(self, run: RunT, work: Callable[[RunT], Awaitable[None]]) -> RunT:
        """Start a run; `work` raises BeckonError where it fails. Raises Problem 409 while another one runs."""
        if self.running:
            raise Problem(409, self._busy)
        self.runs[run.id] = run
        self._task = asyncio.get_running_loop().create_task(self._carry_out(run, work))
        return run

    async def cancel(self, run: RunT) -> None:
        """End a run, and wait until it has ended; its files and figures so far stay."""
        if run.state == "running":
            await end(self._task)

    async def delete(self, run: RunT) -> None:
        """Delete a run for good, with its files. Raises Unwritable."""
        await self.cancel(run)
        self.runs.pop(run.id, None)
        async with self._turn:
            with saving("The run could not be deleted"):
                await to_the_end(lambda: self._remove(run.id))

    def files_folder(self, run: RunT) -> Path:
        """Return the folder of the files that a run writes; its first writer makes it."""
        return self._folder / run.id / "files"

    async def keep(self, run: RunT) -> None:
        """Write a run to disk, and forget the oldest ones; where the disk refuses, the run says so."""
        async with self._turn:
            if run.id not in self.runs:
                return
            raw = msgspec.json.encode(run, enc_hook=plain)
            older = list(self.runs)[: max(0, len(self.runs) - self._max_kept)]
            for oldest in older:
                del self.runs[oldest]

            def write() -> None:
                for oldest in older:
                    self._remove(oldest)
                write_atomic(self._folder / run.id / "run.json", raw)

            try:
                with saving("This run could not be saved, and is gone when the console ends"):
                    await to_the_end(write)
            except Unwritable as trouble:
                log.warning(str(trouble))
                run.reason = run.reason or str(trouble)

    async def _carry_out(self, run: RunT, work: Callable[[RunT], Awaitable[None]]) -> None:
        state: RunState = "cancelled"
        try:
            await work(run)
            state = "done"
        except BeckonError as refusal:
            state, run.reason = "failed", str(refusal)
        except Exception:
            log.exception("A run of %s failed", self._folder.name)
            state, run.reason = "failed", "The run failed on this computer; the log says more."
        finally:
            run.took_s, run.state = run.elapsed_s, state
            run.doing = CANCELLED if state == "cancelled" else ""
            await self.keep(run)

    def _remove(self, run_id: str) -> None:
        if (self._folder / run_id).is_dir():
            shutil.rmtree(self._folder / run_id)

    def _kept(self) -> list[RunT]:
        found: list[RunT] = []
        for file in self._folder.glob("*/run.json"):
            try:
                run = msgspec.json.decode(file.read_bytes(), type=self._kind)
            except (OSError, msgspec.MsgspecError):
                log.warning("The run %s cannot be read.", file.parent.name)
                continue
            if RUN_ID.fullmatch(run.id) and file.parent.name == run.id:
                if run.state == "running":
                    run.state, run.doing = "cancelled", CANCELLED
                found.append(run)
        return found
