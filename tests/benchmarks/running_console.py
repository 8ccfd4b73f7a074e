"""The console in a process of its own, for measurements from outside."""

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import urllib.error
import urllib.parse
import urllib.request
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import psutil


class Console:
    """`beckon run` in a process of its own, on the simulator, with the gate's diary."""

    def __init__(
        self,
        folder: Path,
        *,
        auth: bool = False,
        robot: str = "sim:lab",
        environment: Mapping[str, str] | None = None,
    ) -> None:
        """`auth`: who comes has to show one of the `keys`, the operator's or the viewer's. `environment`: further."""
        self.trace = folder / "gate.csv"
        self._log = folder / "console.log"
        command = [
            sys.executable,
            "-m",
            "console",
            "run",
            "--no-browser",
            "--port",
            "0",
            "--nobody",
            "--precedence",
            "--robot",
            robot,
        ]
        self.process = subprocess.Popen(
            [*command, *(() if auth else ("--no-auth",)), "--gate-trace", str(self.trace), "--data", str(folder)],
            stdout=subprocess.PIPE,
            text=True,
            env={**os.environ, **(environment or {})},
        )
        assert self.process.stdout is not None
        lines = [self.process.stdout.readline() for _ in range(2 if auth else 1)]
        self.port = int(lines[0].split("127.0.0.1:")[1].split("/")[0].split()[0])
        self.keys = tuple(line.strip().partition("#t=")[2] for line in lines)
        self.signed = {"Authorization": f"Bearer {self.keys[0]}"} if auth else {}  # as the operator
        self.children = psutil.Process(self.process.pid).children(recursive=True)

    def get(self, path: str, patience: float = 5.0) -> Any:
        """GET → what the JSON says, also where it is a problem; TimeoutError after so many seconds."""
        asked = urllib.request.Request(f"http://127.0.0.1:{self.port}{path}", headers=self.signed)
        try:
            with urllib.request.urlopen(asked, timeout=patience) as answer:
                return json.load(answer)
        except urllib.error.HTTPError as refused:
            return json.load(refused)

    def download(self, path: str) -> bytes:
        """GET → the file. Raises OSError where it is refused."""
        asked = urllib.request.Request(f"http://127.0.0.1:{self.port}{path}", headers=self.signed)
        with urllib.request.urlopen(asked, timeout=60) as answer:
            return answer.read()

    def post(self, path: str, body: dict[str, object] | None = None) -> int:
        """POST and answer with the status."""
        with urllib.request.urlopen(self._request(path, body), timeout=60) as answer:
            return answer.status

    def delete(self, path: str) -> None:
        """DELETE; a refusal is passed over."""
        asked = self._request(urllib.parse.quote(path), None)
        asked.method = "DELETE"
        with contextlib.suppress(urllib.error.HTTPError):
            urllib.request.urlopen(asked, timeout=20).close()

    def answer(self, path: str, body: dict[str, object] | None = None) -> Any:
        """POST → what the JSON says. Raises OSError where it is refused."""
        with urllib.request.urlopen(self._request(path, body), timeout=60) as answer:
            return json.load(answer)

    def _request(self, path: str, body: dict[str, object] | None) -> urllib.request.Request:
        return urllib.request.Request(
            f"http://127.0.0.1:{self.port}{path}",
            data=json.dumps(body or {}).encode(),
            headers={"Content-Type": "application/json", "Origin": f"http://127.0.0.1:{self.port}", **self.signed},
        )

    def faults(self) -> list[str]:
        """The tracebacks in its log."""
        text = self._log.read_text() if self._log.exists() else ""
        return [part for part in re.split(r"(?m)^(?=\d{4}-)", text) if "Traceback" in part]

    def close(self) -> None:
        """End it, and everything that it started."""
        for process in [self.process, *self.children]:
            with contextlib.suppress(ProcessLookupError, psutil.NoSuchProcess):
                process.send_signal(signal.SIGCONT)
        self.process.terminate()
        try:
            self.process.wait(5)
        except subprocess.TimeoutExpired:
            self.process.kill()
        psutil.wait_procs(self.children, 3)
        for child in self.children:
            with contextlib.suppress(psutil.NoSuchProcess):
                child.kill()


@contextlib.contextmanager
def console(
    *, auth: bool = False, robot: str = "sim:lab", environment: Mapping[str, str] | None = None
) -> Iterator[Console]:
    """A console for a few trials."""
    with tempfile.TemporaryDirectory() as folder:
        running = Console(Path(folder), auth=auth, robot=robot, environment=environment)
        try:
            yield running
        finally:
            running.close()


def watch(running: Console, viewers: int, stack: contextlib.ExitStack) -> None:
    """`viewers` sockets that read everything and one that reads nothing, in a process of their own."""
    key = running.keys[:1] if running.signed else ()
    command = [sys.executable, "-m", "tests.benchmarks.onlookers", str(running.port), str(viewers), *key]
    watching = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    stack.callback(watching.wait)
    stack.callback(watching.kill)
    assert watching.stdout is not None
    assert watching.stdout.readline() == "watching\n"
