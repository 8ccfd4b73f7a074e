"""A console in a process of its own, and its HTTP side for looking behind the page."""

from __future__ import annotations

import contextlib
import json
import math
import re
import subprocess
import sys
import time
import urllib.error
import urllib.request
from pathlib import Path
from typing import Any

REPOSITORY = Path(__file__).resolve().parent.parent.parent
START_TIME = 120.0  # [s] on a busy machine
ANSWER_S = 60.0  # that an answer may take there


class Running:
    """`beckon run` until the end of the `with`."""

    def __init__(self, folder: Path, *options: str, people: bool = False, precedence: bool = True) -> None:
        """`people`: those of a console that is started without options; else the simulated room is empty.
        `precedence`: run before other programs, as the tests of a busy machine need it.
        """
        self.trace = folder / "gate.csv"
        self._said = folder / "said.txt"
        told = ["--no-browser", "--port", "0", "--data", str(folder / "home"), "--gate-trace", str(self.trace)]
        told += [] if people else ["--nobody"]
        told += ["--precedence"] if precedence else []
        self._command = [sys.executable, "-m", "console", "run", *told, *options]

    def __enter__(self) -> Running:
        with self._said.open("w") as said:
            self._process = subprocess.Popen(self._command, cwd=REPOSITORY, stdout=said, stderr=subprocess.STDOUT)
        self.driving, self.watching = self._links()
        self.linked_at = time.monotonic()
        self.url = self.driving.partition("#")[0]
        self._until_live()
        return self

    def __exit__(self, *_: object) -> None:
        self._process.terminate()
        try:
            self._process.wait(10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    @property
    def pid(self) -> int:
        return self._process.pid

    def ask(self, path: str, body: dict[str, Any] | None = None, *, method: str | None = None) -> Any:
        """GET, or POST when there is a body, or another method; as the operator whose token was printed."""
        token = self.driving.partition("#t=")[2]
        headers = {"authorization": f"Bearer {token}", "content-type": "application/json"}
        told = None if body is None else json.dumps(body).encode()
        with urllib.request.urlopen(
            urllib.request.Request(self.url + path, told, headers, method=method), timeout=ANSWER_S
        ) as answer:
            return json.loads(answer.read() or "null")

    def truth(self) -> tuple[float, float, float]:
        """Where the simulated robot really is: x, y [m], heading [rad]."""
        told = self.ask("api/sim/truth")
        return told["x_m"], told["y_m"], told["heading_rad"]

    def speed(self) -> float:
        """How fast the wheels turn [m/s]."""
        return self.ask("api/state")["velocity"]["v_m_s"]

    def turning(self) -> float:
        """How fast it turns [rad/s], left positive."""
        return self.ask("api/state")["velocity"]["w_rad_s"]

    def stamp(self) -> float:
        """The robot's clock [s]."""
        return self.ask("api/state")["stamp_s"]

    def newest(self) -> dict[str, Any]:
        """The newest command of the history."""
        return next(iter(self.ask("api/commands/history")["commands"]), {"id": 0, "state": "done", "remark": ""})

    def until_nobody_drives(self) -> None:
        """Free control from a page that has closed: it would keep it for five seconds, in case it comes back."""
        until = time.monotonic() + START_TIME
        while (holder := self.ask("api/state")["lease"]["holder"]) is not None:
            assert time.monotonic() < until, f"{holder} still drives"
            for do in ("take", "release"):
                self.ask("api/lease", {"do": do})

    def _links(self) -> tuple[str, str]:
        until = time.monotonic() + START_TIME
        while time.monotonic() < until and self._process.poll() is None:
            links = re.findall(r"http://\S+#t=\S+", self._said.read_text())
            if len(links) >= 2:
                return links[0], links[1]
            time.sleep(0.1)
        raise AssertionError(f"The console did not start:\n{self._said.read_text()}")

    def _until_live(self) -> None:
        until = time.monotonic() + START_TIME
        while time.monotonic() < until:
            with contextlib.suppress(urllib.error.HTTPError):
                state = self.ask("api/state")
                if not state["slam"]["looking_around"] or state["robot"]["kind"] == "LOG":  # a recording waits
                    return
            time.sleep(0.2)
        raise AssertionError(f"The robot did not wake up:\n{self._said.read_text()}")


def write_log(path: Path) -> Path:
    """Thirty seconds through a room of 6 by 4 m, in the CARMEN form."""
    lines: list[str] = []
    for step in range(300):
        t, x = 0.1 * step, 0.1 * 0.1 * step
        ranges: list[float] = []
        for beam in range(181):
            angle = math.radians(beam - 90)
            reach = [(3 - x) / math.cos(angle)] if math.cos(angle) > 1e-6 else []
            reach += [2 / abs(math.sin(angle))] if abs(math.sin(angle)) > 1e-6 else []
            ranges.append(min(reach))
        told = " ".join(f"{value:.3f}" for value in ranges)
        lines.append(f"FLASER 181 {told} {x:.4f} 0 0 {x:.4f} 0 0 {t:.3f} robot {t:.3f}")
    path.write_text("\n".join(lines) + "\n")
    return path
