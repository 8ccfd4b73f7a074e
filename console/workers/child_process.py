"""A process of our own: started with its pipes, ended without leaving anything behind."""

import contextlib
import os
import socket
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import core
from core.library_threads import ONE_THREAD

ROOT = Path(core.__file__).resolve().parents[1]


class ChildProcess:
    """One running module. It leads a session of its own, so that Ctrl-C reaches the console alone, which decides."""

    def __init__(
        self, module: str, arguments: Sequence[str], pipes: Sequence[socket.socket], *, bare: bool = False
    ) -> None:
        """Start; `pipes` are handed over under their own numbers. `bare`: the standard library only."""
        path = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
        self._process = subprocess.Popen(
            [sys.executable, "-P", *(["-S"] if bare else []), "-m", module, *arguments],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            env={**os.environ, **ONE_THREAD, "PYTHONPATH": path},
            pass_fds=[pipe.fileno() for pipe in pipes],
            start_new_session=True,
        )

    @property
    def pid(self) -> int:
        return self._process.pid

    @property
    def alive(self) -> bool:
        """True while it still runs; a dead one is buried at once."""
        return self._process.poll() is None

    @property
    def code(self) -> int | None:
        """How it ended, negative by a signal; None while it runs."""
        return self._process.poll()

    def kill(self) -> None:
        """End it now, even when it is stopped."""
        with contextlib.suppress(ProcessLookupError):
            self._process.kill()

    def end(self, patience: float) -> None:
        """It was asked to end: wait `patience` [s], then kill; no zombie remains."""
        try:
            self._process.wait(patience)
        except subprocess.TimeoutExpired:
            self.kill()
            self._process.wait()
