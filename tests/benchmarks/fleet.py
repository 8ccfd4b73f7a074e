"""A whole fleet: `python -m tests.benchmarks.fleet [--robots 20] [--consoles 3] [--presses 40] [--lost 30]`.

`beckon fleet` is a process of its own, and all is read as its page reads it. Light robots (one recorded frame, the
real gate) share a process, but for three that have one of their own: one is killed, one frozen, one cut off behind a
wire. Whole consoles on the simulated robot join, too; they drive to places while the fleet stands still. Figures:
processor, memory and bytes; seconds until the page is right; STOP ALL from the press to each gate's zero.
"""

import asyncio
import contextlib
import json
import math
import os
import re
import signal
import statistics
import subprocess
import sys
import tempfile
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import psutil

from console.fleet.authority import Authority
from console.fleet.bus import FleetAddress
from tests.benchmarks.command import run_command
from tests.emulators.light_console import LightConsole
from tests.emulators.zenoh_robot import free_port

SETTLE_TIMEOUT_S = 180.0
LOOK_S = 0.02
ANSWER_TIMEOUT_S = 60.0
PLACES_M = ((1.0, 0.5), (0.8, -0.5), (1.2, 0.2))  # to which the whole robots drive
ARRIVED_M = 0.25
CALM_S = 5.0  # after the fleet is back, in which nothing late may happen


def until(true: Callable[[], bool], seconds: float = SETTLE_TIMEOUT_S) -> float:
    begun = time.monotonic()
    while not true():
        if time.monotonic() - begun > seconds:
            raise TimeoutError(f"not within {seconds} s")
        time.sleep(LOOK_S)
    return round(time.monotonic() - begun, 3)


class Relay:
    """A way to the router that can be cut: what is sent while it is silent arrives nowhere, and nobody is told."""

    def __init__(self, port: int) -> None:
        self.silent, self.bytes, self._target = False, 0, port
        self._tasks: set[asyncio.Task[None]] = set()
        self._loop = asyncio.new_event_loop()
        opened = threading.Event()
        threading.Thread(target=self._run, args=(opened,), daemon=True).start()
        opened.wait()

    def _run(self, opened: threading.Event) -> None:
        self._loop.run_until_complete(self._open())
        opened.set()
        self._loop.run_forever()

    async def _open(self) -> None:
        self._server = await asyncio.start_server(self._join, "127.0.0.1", 0)
        self.port = int(self._server.sockets[0].getsockname()[1])

    async def _join(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            there = await asyncio.open_connection("127.0.0.1", self._target)
        except OSError:  # the router restarts
            writer.close()
            return
        for source, target in ((reader, there[1]), (there[0], writer)):
            self._tasks.add(asyncio.create_task(self._carry(source, target)))

    async def _carry(self, source: asyncio.StreamReader, target: asyncio.StreamWriter) -> None:
        with contextlib.suppress(OSError):
            while data := await source.read(65536):
                if not self.silent:
                    self.bytes += len(data)
                    target.write(data)
                    await target.drain()
        if not self.silent:
            target.close()


def light(arguments: list[str]) -> None:
    """The light robots of one process, which drive whenever they stand: PORT FOLDER NAME…"""
    port, folder, *names = arguments

    async def work() -> None:
        consoles = [
            LightConsole(
                name, FleetAddress("127.0.0.1", int(port)), Path(folder) / name, Path(folder) / f"{name}-home"
            )
            for name in names
        ]
        for console in consoles:
            console.open()
        while True:
            for console in consoles:
                if console.robot.status().v == 0:
                    console.robot.drive()
            await asyncio.sleep(0.4)

    asyncio.run(work())


class Fleet:
    """A fleet, and the processes of its robots."""

    def __init__(self, folder: Path, robots: int, consoles: int) -> None:
        self.folder = folder
        self.names = [f"light{number:02}" for number in range(robots)]
        self.whole = {f"whole{number}": free_port() for number in range(consoles)}
        authority = Authority(folder / "fleet-data" / "fleet")
        for name in (*self.names, *self.whole):
            authority.issue(name, folder / name, kind="robot")
        self.port, self.page = free_port(), free_port()
        self.processes: dict[str, subprocess.Popen[bytes]] = {}
        self._token = ""

    def start(self, what: str, *arguments: str) -> None:
        log = (self.folder / f"{what}.log").open("wb")
        self.processes[what] = subprocess.Popen([sys.executable, *arguments], stdout=log, stderr=log)

    def start_fleet(self) -> None:
        data = ["--data", str(self.folder / "fleet-data"), "--port", str(self.page), "--no-browser"]
        self.start("fleet", "-m", "console", "fleet", "--listen", f"tls/127.0.0.1:{self.port}", *data)
        log = self.folder / "fleet.log"
        until(lambda: "#t=" in log.read_text())
        self._token = re.findall(r"#t=(\S+)", log.read_text())[0]

    def start_light(self, what: str, port: int, *names: str) -> None:
        self.start(what, "-m", "tests.benchmarks.fleet", "--light", str(port), str(self.folder), *names)

    def start_whole(self, name: str) -> None:
        """A whole console on the simulated robot."""
        joins = ["--fleet", f"tls/127.0.0.1:{self.port}", "--name", name, "--fleet-cert", str(self.folder / name)]
        data = ["--data", str(self.folder / f"{name}-data"), "--port", str(self.whole[name]), "--nobody"]
        self.start(name, "-m", "console", "run", "--no-browser", "--no-auth", *data, *joins)

    def ask(self, path: str, body: object = None, *, method: str = "GET") -> Any:
        """The fleet's answer, under the key that it printed."""
        return asked(f"http://127.0.0.1:{self.page}/{path}", body, method, self._token)

    def console(self, name: str, path: str) -> Any:
        """The answer of a whole console itself, whatever the fleet does."""
        return asked(f"http://127.0.0.1:{self.whole[name]}/{path}", None, "GET", "")

    def links(self, names: Iterable[str]) -> set[str]:
        """How these are there, as the page shows it; "none" while there is no answer."""
        with contextlib.suppress(OSError):
            wanted = set(names)
            return {one["link"] for one in self.ask("api/fleet")["robots"] if one["name"] in wanted}
        return {"none"}

    def end(self) -> None:
        for process in self.processes.values():
            with contextlib.suppress(ProcessLookupError):
                process.send_signal(signal.SIGCONT)
                process.terminate()
        for process in self.processes.values():
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(10)
            process.kill()


def asked(url: str, body: object, method: str, token: str) -> Any:
    headers = {"Authorization": f"Bearer {token}"} if token else {}
    content = None if body is None else json.dumps(body).encode()
    if method != "GET":
        headers |= {"Content-Type": "application/json"}
    request = urllib.request.Request(url, content, headers, method=method)
    with urllib.request.urlopen(request, timeout=ANSWER_TIMEOUT_S) as answer:
        raw = answer.read()
    return json.loads(raw) if raw[:1] in (b"{", b"[") else raw


def presses(fleet: Fleet, number: int, names: list[str]) -> dict[str, Any]:
    """STOP ALL again and again, while all drive: milliseconds to each answer and to each gate's zero."""
    answers: list[float] = []
    gates: list[float] = []
    missed: list[str] = []
    for _ in range(number):
        for name in fleet.whole:
            fleet.ask(f"robots/{name}/api/commands", {"text": "turn left"}, method="POST")
        time.sleep(0.5)
        rows = {one["name"]: one for one in fleet.ask("api/fleet/stop", method="POST")["robots"]}
        missed += [name for name in names if not rows[name]["acknowledged"]]
        answers += [rows[name]["ms"] for name in names if rows[name]["ms"] is not None]
        gates += [rows[name]["gate_ms"] for name in names if rows[name]["gate_ms"] is not None]
    counted = {"presses": number, "answers": len(answers), "missed": missed}
    return {**counted, **spread("answer", answers), **spread("gate", gates)}


def spread(name: str, values: list[float]) -> dict[str, float]:
    ordered = sorted(values)
    return {
        f"{name}_p50_ms": round(statistics.median(ordered), 1),
        f"{name}_p99_ms": round(ordered[min(len(ordered) - 1, int(0.99 * len(ordered)))], 1),
        f"{name}_worst_ms": round(ordered[-1], 1),
    }


def load(fleet: Fleet, wire: Relay, seconds: float) -> dict[str, Any]:
    """Processor, memory and bytes, while a page shows all robots; of the one behind the wire, bytes with TLS."""
    everyone = {name: [psutil.Process(process.pid)] for name, process in fleet.processes.items()}
    for own in everyone.values():
        own += own[0].children(recursive=True)
    spent = {name: sum(map(seconds_of, own)) for name, own in everyone.items()}
    begun, before, pictures = time.monotonic(), wire.bytes, 0
    while time.monotonic() - begun < seconds:
        for robot in fleet.ask("api/fleet")["robots"]:
            with contextlib.suppress(OSError):
                pictures += len(fleet.ask(f"api/fleet/robots/{robot['name']}/picture"))
        time.sleep(0.5)
    took = time.monotonic() - begun
    percent = {name: round(100 * (sum(map(seconds_of, own)) - spent[name]) / took) for name, own in everyone.items()}
    memory = {name: round(sum(one.memory_info().rss for one in own) / 1e6) for name, own in everyone.items()}
    return {
        "cpu_percent": percent,
        "rss_mb": memory,
        "bytes_per_s_of_one_robot": round((wire.bytes - before) / took),
        "picture_bytes_per_s_of_all": round(pictures / took),
        "load_average": os.getloadavg()[0],
    }


def seconds_of(process: psutil.Process) -> float:
    return sum(process.cpu_times()[:2])


def faults(fleet: Fleet, wire: Relay, killed: str, frozen: str, cut: str) -> dict[str, Any]:
    """One robot killed, one frozen, one cut off, STOP ALL without them; then the fleet killed and started again."""
    found: dict[str, Any] = {}
    fleet.processes[killed].kill()
    found["killed_gone_s"] = until(lambda: fleet.links([killed]) == {"gone"})
    fleet.processes[frozen].send_signal(signal.SIGSTOP)
    found["frozen_stale_s"] = until(lambda: fleet.links([frozen]) != {"live"})
    found["frozen_gone_s"] = round(found["frozen_stale_s"] + until(lambda: fleet.links([frozen]) == {"gone"}), 3)
    wire.silent = True
    found["cut_gone_s"] = until(lambda: fleet.links([cut]) == {"gone"})
    rows = fleet.ask("api/fleet/stop", method="POST")["robots"]
    found["named_missing"] = sorted(one["name"] for one in rows if not one["acknowledged"])
    wire.silent = False
    found["cut_back_s"] = until(lambda: fleet.links([cut]) == {"live"})
    fleet.processes[frozen].send_signal(signal.SIGCONT)
    found["frozen_back_s"] = until(lambda: fleet.links([frozen]) == {"live"})
    rest = [name for name in (*fleet.names, *fleet.whole) if name != killed]
    fleet.processes["fleet"].kill()
    fleet.processes["fleet"].wait()
    begun = time.monotonic()
    fleet.start_fleet()
    found["restart_page_s"] = round(time.monotonic() - begun, 3)
    found["restart_live_s"] = round(found["restart_page_s"] + until(lambda: fleet.links(rest) == {"live"}), 3)
    found["rows_after_restart"] = len(fleet.ask("api/fleet")["robots"])
    return found


def lost(fleet: Fleet, seconds: float) -> dict[str, Any]:
    """The fleet stands still while whole robots drive to places; a command waits in it all the time."""
    goals = dict(zip(fleet.whole, PLACES_M, strict=False))
    begun = {
        name: fleet.ask(f"robots/{name}/api/commands", {"text": f"stop at {x} and {y}"}, method="POST")["id"]
        for name, (x, y) in goals.items()
    }
    fleet.processes["fleet"].send_signal(signal.SIGSTOP)
    refused: list[str] = []
    waiting = [threading.Thread(target=say_late, args=(fleet, name, refused)) for name in goals]
    for one in waiting:
        one.start()
    time.sleep(seconds)
    ended = {name: newest(fleet, name) for name in goals}
    found: dict[str, Any] = {"lost_s": seconds}
    found["arrived"] = sum(ended[name]["id"] == begun[name] and ended[name]["state"] == "done" for name in goals)
    found["from_the_goal_m"] = {name: round(off(fleet, name, goal), 3) for name, goal in goals.items()}
    before = {name: fleet.console(name, "api/sim/truth") for name in goals}
    fleet.processes["fleet"].send_signal(signal.SIGCONT)
    found["back_live_s"] = until(lambda: fleet.links(goals) == {"live"})
    for one in waiting:
        one.join()
    time.sleep(CALM_S)
    found["late_commands"] = sum(newest(fleet, name)["id"] != ended[name]["id"] for name in goals)
    found["late_motion_m"] = max(off(fleet, name, (at["x_m"], at["y_m"])) for name, at in before.items())
    found["refused_with"] = sorted(set(refused))
    return found


def say_late(fleet: Fleet, name: str, refused: list[str]) -> None:
    """A program that says something to a robot while the fleet stands still, and waits."""
    try:
        fleet.ask(f"robots/{name}/api/commands", {"text": "turn left"}, method="POST")
    except urllib.error.HTTPError as refusal:
        refused.append(json.loads(refusal.read())["detail"])


def newest(fleet: Fleet, name: str) -> dict[str, Any]:
    return fleet.console(name, "api/commands/history")["commands"][0]


def off(fleet: Fleet, name: str, goal: tuple[float, float]) -> float:
    true = fleet.console(name, "api/sim/truth")
    return math.hypot(true["x_m"] - goal[0], true["y_m"] - goal[1])


def awake(fleet: Fleet, name: str) -> bool:
    with contextlib.suppress(OSError):
        return not fleet.console(name, "api/state")["slam"]["looking_around"]
    return False


def measure(robots: int, consoles: int, number: int, seconds: float, lost_s: float) -> dict[str, Any]:
    """The whole campaign."""
    with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as stack:
        fleet = Fleet(Path(folder), robots, consoles)
        stack.callback(fleet.end)
        killed, frozen, cut, *rest = fleet.names
        everyone = [*fleet.names, *fleet.whole]
        wire = Relay(fleet.port)
        fleet.start_fleet()
        for name in (killed, frozen):
            fleet.start_light(name, fleet.port, name)
        fleet.start_light(cut, wire.port, cut)
        fleet.start_light("rest", fleet.port, *rest)
        for name in fleet.whole:
            fleet.start_whole(name)
        found: dict[str, Any] = {"robots": robots, "consoles": consoles}
        found["all_live_s"] = until(lambda: fleet.links(everyone) == {"live"})
        until(lambda: all(awake(fleet, name) for name in fleet.whole))
        found["load"] = load(fleet, wire, seconds)
        found["stop_all"] = presses(fleet, number, everyone)
        found["faults"] = faults(fleet, wire, killed, frozen, cut)
        found["lost"] = lost(fleet, lost_s)
        return found


def main(
    *, robots: int = 20, consoles: int = 3, presses: int = 40, seconds: float = 20.0, lost: float = 30.0
) -> object:
    return measure(robots, consoles, presses, seconds, lost)


if __name__ == "__main__":
    light(sys.argv[2:]) if sys.argv[1:2] == ["--light"] else run_command(main)
