"""A whole fleet: `python -m tests.benchmarks.fleet [--robots 20] [--consoles 3] [--presses 40] [--json]`.

Light robots (one recorded frame, the real gate) share a process, but for three that have one of their own: one is
killed, one frozen, one cut off behind a wire. With `--consoles`, whole simulated consoles join, too. Figures:
processor, memory and bytes; seconds until the table is right; STOP ALL from the press to each gate's zero.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import json
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import psutil

from console.fleet.authority import Authority
from console.fleet.bus import FleetAddress
from console.fleet.router import FleetRouter
from tests.emulators.light_console import LightConsole
from tests.emulators.zenoh_robot import free_port

SETTLE_TIMEOUT_S = 120.0
LOST_S = 30.0
LOOK_S = 0.005


async def until(true: Callable[[], bool], seconds: float = SETTLE_TIMEOUT_S) -> float:
    """Seconds until it is so."""
    begun = time.monotonic()
    async with asyncio.timeout(seconds):
        while not true():
            await asyncio.sleep(LOOK_S)
    return time.monotonic() - begun


class Relay:
    """A way to the router that can be cut: what is sent while it is silent arrives nowhere, and nobody is told."""

    def __init__(self, port: int) -> None:
        self.silent, self._target = False, port
        self._tasks: set[asyncio.Task[None]] = set()

    async def open(self) -> None:
        self._server = await asyncio.start_server(self._join, "127.0.0.1", 0)
        self.port = int(self._server.sockets[0].getsockname()[1])

    def close(self) -> None:
        self._server.close()
        for task in self._tasks:
            task.cancel()

    async def _join(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            there = await asyncio.open_connection("127.0.0.1", self._target)
        except OSError:  # the router restarts
            writer.close()
            return
        for source, target in ((reader, there[1]), (there[0], writer)):
            task = asyncio.create_task(self._carry(source, target))
            self._tasks.add(task)

    async def _carry(self, source: asyncio.StreamReader, target: asyncio.StreamWriter) -> None:
        with contextlib.suppress(OSError):
            while data := await source.read(65536):
                if not self.silent:
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
    """A router, and the processes of its robots."""

    def __init__(self, folder: Path, robots: int) -> None:
        self.folder = folder
        self.names = [f"light{number:02}" for number in range(robots)]
        self.authority = Authority(folder / "fleet")
        self.authority.prepare(("127.0.0.1",))
        self.address = FleetAddress("127.0.0.1", free_port())
        self.processes: dict[str, subprocess.Popen[bytes]] = {}
        self.router: FleetRouter | None = None

    def certify(self, *names: str) -> None:
        for name in names:
            self.authority.issue(name, self.folder / name, kind="robot")

    def start(self, what: str, *arguments: str) -> None:
        log = (self.folder / f"{what}.log").open("wb")
        self.processes[what] = subprocess.Popen([sys.executable, *arguments], stdout=log, stderr=log)

    def start_light(self, what: str, port: int, *names: str) -> None:
        self.start(what, "-m", "tests.benchmarks.fleet", "--light", str(port), str(self.folder), *names)

    def links(self, *names: str) -> set[str]:
        assert self.router is not None
        return {self.router.table.robots[name].link for name in names}

    def end(self) -> None:
        for process in self.processes.values():
            with contextlib.suppress(ProcessLookupError):
                process.send_signal(signal.SIGCONT)
                process.terminate()
        for process in self.processes.values():
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(10)
            process.kill()


async def presses(fleet: Fleet, number: int, names: list[str]) -> dict[str, Any]:
    """STOP ALL again and again, while they drive: milliseconds to each answer and to each gate's zero."""
    answers: list[float] = []
    gates: list[float] = []
    missed: list[str] = []
    assert fleet.router is not None
    for _ in range(number):
        await asyncio.sleep(0.5)
        stop = await fleet.router.stop_all("stop", "benchmark")
        missed += [name for name in names if not stop.robots[name].acknowledged]
        answers += [one.ms for name in names if (one := stop.robots[name]).ms is not None]
        gates += [one.answer.ms for name in names if (one := stop.robots[name]).answer is not None]
    return {
        "presses": number,
        "answers": len(answers),
        "missed": missed,
        **spread("answer", answers),
        **spread("gate", gates),
    }


def spread(name: str, values: list[float]) -> dict[str, float]:
    ordered = sorted(values)
    return {
        f"{name}_p50_ms": round(statistics.median(ordered), 1),
        f"{name}_p99_ms": round(ordered[min(len(ordered) - 1, int(0.99 * len(ordered)))], 1),
        f"{name}_worst_ms": round(ordered[-1], 1),
    }


async def load(fleet: Fleet, seconds: float) -> dict[str, Any]:
    """Processor, memory and bytes of the router's process and of the robots."""
    assert fleet.router is not None
    own, robots = psutil.Process(), fleet.router.table.robots
    cpu, before, begun = own.cpu_times(), sum(one.bytes for one in robots.values()), time.monotonic()
    others = {
        name: psutil.Process(process.pid) for name, process in fleet.processes.items() if process.poll() is None
    }
    spent = {name: sum(one.cpu_times()[:2]) for name, one in others.items()}
    pictures = 0
    while time.monotonic() - begun < seconds:  # as a page that shows all of them
        for name in list(robots):
            pictures += len(await fleet.router.picture(name) or b"")
        await asyncio.sleep(0.5)
    took = time.monotonic() - begun
    now = own.cpu_times()
    return {
        "router_cpu_percent": round(100 * (now.user + now.system - cpu.user - cpu.system) / took, 1),
        "router_rss_mb": round(own.memory_info().rss / 1e6),
        "report_bytes_per_s": round((sum(one.bytes for one in robots.values()) - before) / took),
        "picture_bytes_per_s": round(pictures / took),
        "robots_cpu_percent": {
            name: round(100 * (sum(one.cpu_times()[:2]) - spent[name]) / took, 1) for name, one in others.items()
        },
        "load_average": os.getloadavg()[0],
    }


async def measure(robots: int, consoles: int, number: int, seconds: float) -> dict[str, Any]:
    """The whole campaign."""
    with tempfile.TemporaryDirectory() as folder:
        fleet = Fleet(Path(folder), robots)
        whole = [f"whole{number}" for number in range(consoles)]
        fleet.certify(*fleet.names, *whole)
        killed, frozen, cut, *rest = fleet.names
        fleet.router = router = FleetRouter(fleet.authority, fleet.address)
        await router.open()
        work = asyncio.create_task(router.run())
        try:
            wire = Relay(fleet.address.port)
            await wire.open()
            try:
                for name in (killed, frozen):
                    fleet.start_light(name, fleet.address.port, name)
                fleet.start_light(cut, wire.port, cut)
                fleet.start_light("rest", fleet.address.port, *rest)
                for name in whole:
                    fleet.start(name, *console_arguments(fleet, name))
                everyone = [*fleet.names, *whole]
                found: dict[str, Any] = {"robots": robots, "consoles": consoles}
                found["all_live_s"] = round(await until(lambda: fleet.links(*everyone) == {"live"}), 2)
                found["load"] = await load(fleet, seconds)
                found["stop_all"] = await presses(fleet, number, everyone)
                await faults(fleet, found, wire, killed, frozen, cut)
            finally:
                wire.close()
        finally:
            fleet.end()
            work.cancel()
            await router.close()
        return found


async def faults(fleet: Fleet, found: dict[str, Any], wire: Relay, killed: str, frozen: str, cut: str) -> None:
    """One robot killed, one frozen, one cut off, then the router restarted."""
    router = fleet.router
    assert router is not None
    fleet.processes[killed].kill()
    found["killed_gone_s"] = round(await until(lambda: fleet.links(killed) == {"gone"}), 3)
    fleet.processes[frozen].send_signal(signal.SIGSTOP)
    found["frozen_stale_s"] = round(await until(lambda: fleet.links(frozen) != {"live"}), 3)
    found["frozen_gone_s"] = round(found["frozen_stale_s"] + await until(lambda: fleet.links(frozen) == {"gone"}), 3)
    wire.silent = True
    found["cut_gone_s"] = round(await until(lambda: fleet.links(cut) == {"gone"}), 3)
    stop = await router.stop_all("stop", "benchmark")
    found["named_missing"] = sorted(name for name, one in stop.robots.items() if not one.acknowledged)
    wire.silent = False
    found["cut_back_s"] = round(await until(lambda: fleet.links(cut) == {"live"}), 3)
    fleet.processes[frozen].send_signal(signal.SIGCONT)
    found["frozen_back_s"] = round(await until(lambda: fleet.links(frozen) == {"live"}), 3)
    rest = [name for name in router.table.robots if name != killed]
    await router._restart()
    found["restart_stale"] = sorted(fleet.links(*rest))
    found["restart_live_s"] = round(await until(lambda: fleet.links(*rest) == {"live"}), 3)
    found["kept_rows"] = len(router.table.robots)


def console_arguments(fleet: Fleet, name: str) -> list[str]:
    """A whole console on the simulated robot."""
    joins = ["--fleet", f"tls/{fleet.address.name}", "--name", name, "--fleet-cert", str(fleet.folder / name)]
    data = ["--data", str(fleet.folder / f"{name}-data"), "--port", "0", "--no-browser", "--no-auth"]
    return ["-m", "console", "run", *data, *joins]


def main() -> None:
    """Print the figures."""
    if sys.argv[1:2] == ["--light"]:
        light(sys.argv[2:])
        return
    parser = argparse.ArgumentParser()
    parser.add_argument("--robots", type=int, default=20)
    parser.add_argument("--consoles", type=int, default=3)
    parser.add_argument("--presses", type=int, default=40)
    parser.add_argument("--seconds", type=float, default=20.0)
    chosen = parser.parse_args()
    found = asyncio.run(measure(chosen.robots, chosen.consoles, chosen.presses, chosen.seconds))
    sys.stdout.write(json.dumps(found, indent=2) + "\n")


if __name__ == "__main__":
    main()
