"""One experiment in processes of its own: the command line itself, so that the files are the same."""

from __future__ import annotations

import asyncio
import contextlib
import os
import re
import signal
import sys
from asyncio.subprocess import PIPE
from collections.abc import Callable
from pathlib import Path

from console.workers.child_process import ROOT
from core.errors import Unavailable
from core.library_threads import ONE_THREAD

MOST_RESULT = 2**24  # [bytes] of JSON
LONGEST = 2**16  # [bytes] of a line that it says
COUNTED = re.compile(r"(\d+) of (\d+)")
BROKE = "The experiment broke off; the log says more."


class ExperimentProcess:
    """`beckon experiment` with its progress, from its start until it has ended or was killed."""

    def __init__(self, name: str, runs: int, seed: int, out: Path) -> None:
        self._arguments = ["experiment", name, "--runs", str(runs), "--seed", str(seed), "--out", str(out), "--json"]
        self._child: asyncio.subprocess.Process | None = None
        self.said: list[str] = []  # the newest lines

    async def run(self, tell: Callable[[str, float | None], None]) -> bytes:
        """Run it → its result as JSON; `tell` gets what it says, and 0..1 when that counts something.

        Killed when cancelled. Raises Unavailable with its sentence when it fails.
        """
        path = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
        self._child = await asyncio.create_subprocess_exec(
            *(sys.executable, "-P", "-m", "console.workers.leashed", "console", *self._arguments),
            stdin=PIPE,
            stdout=PIPE,
            stderr=PIPE,
            env={**os.environ, **ONE_THREAD, "PYTHONPATH": path},
            start_new_session=True,
            limit=LONGEST,
        )
        try:
            result, _ = await asyncio.gather(self._result(), self._listen(tell))
            code = await self._child.wait()
        finally:
            await self._kill()
        if code != 0:
            raise Unavailable(self.said[-1] if code == 1 and self.said else BROKE)
        return result

    async def _result(self) -> bytes:
        assert self._child is not None and self._child.stdout is not None
        parts = bytearray()
        while part := await self._child.stdout.read(2**18):
            parts += part
            if len(parts) > MOST_RESULT:
                raise Unavailable("The experiment's result is too large to be kept.")
        return bytes(parts)

    async def _listen(self, tell: Callable[[str, float | None], None]) -> None:
        assert self._child is not None and self._child.stderr is not None
        while True:
            try:
                raw = await self._child.stderr.readline()
            except ValueError:
                continue  # a line without an end
            if not raw:
                return
            line = raw.decode(errors="replace").strip()[:300]
            if line:
                self.said = [*self.said[-20:], line]
                tell(line, counted(line))

    async def _kill(self) -> None:
        """Nothing of it stays."""
        child = self._child
        if child is None:
            return
        with contextlib.suppress(ProcessLookupError):
            os.killpg(child.pid, signal.SIGKILL)
        if child.stdin is not None:
            child.stdin.close()
        await asyncio.shield(child.wait())


def counted(line: str) -> float | None:
    """'12 of 40 runs…' → 0.3; None where nothing is counted."""
    found = COUNTED.search(line)
    if found is None or int(found[2]) == 0:
        return None
    return min(1.0, int(found[1]) / int(found[2]))
