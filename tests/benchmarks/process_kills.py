"""Each process of a console is killed in turn while the robot drives: `python -m tests.benchmarks.process_kills`.

[--kills 200] [--wires foxglove] [--seed 0]. An emulated robot, in a process of its own, turns by a command; then one
process gets SIGKILL: recorder, gate, driver, console, and from the beginning. Told of each: until the wheels rest,
by the robot's own record [ms] (a recorder's death stops nothing); until there is another such process and everything
is up again [s], the next console's start included; and commands that were answered and are not in the history.
A console at rest has no recorder for its first 20 s, or until 5 s after the first motion: none is waited for there.
"""

import contextlib
import json
import math
import os
import random
import signal
import sqlite3
import sys
import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

import psutil

from core.gate import Limits
from core.robots.process import TWIST_TIMEOUT_S
from core.sensors.wheels import MOVING_SPEED
from core.simulation.settings import SimulationSettings
from tests.benchmarks.command import run_command
from tests.benchmarks.late_scans import FAILSAFE_S
from tests.benchmarks.no_motion import Trial, until
from tests.benchmarks.real_sessions import SUBJECTS
from tests.emulators.robot_process import robot_process

RECORDER, GATE, DRIVER, CONSOLE = "--worker=recorder", "core.gate.process", "core.robots.process", "console"
NEEDED_PROCESSES = (GATE, DRIVER)
KILLED_PROCESSES = (RECORDER, *NEEDED_PROCESSES, CONSOLE)
SILENCES_S = {GATE: TWIST_TIMEOUT_S, DRIVER: FAILSAFE_S, CONSOLE: Limits().heartbeat}  # after which zero is asked for
FRAMES_S = 0.05  # two frames of a robot: of the driver, and of the base
COASTING_S = SimulationSettings().response * math.log(Limits().max_turn_rate / MOVING_SPEED)
WATCHED_S = 1.5  # after a kill, longer than any silence and the coasting
NOW_S, TURNING_RAD = 0.2, 0.03  # who turned so far in the last moment turns


@dataclass(frozen=True)
class ProcessKill:
    """One kill and its consequences; `answered` and `lost` are commands of the console's life that it ended."""

    process: str
    rest_ms: float | None
    up_s: float
    answered: int = 0
    lost: int = 0


def rest_bound_ms(process: str) -> int:
    """The silence after which the next one acts, and the time in which the wheels come to rest then."""
    return round(1000 * (SILENCES_S[process] + FRAMES_S + COASTING_S))


class KilledTrial(Trial):
    """A console whose successors have its data folder."""

    answered: list[int]

    def healthy(self) -> bool:
        """The console says so, the robot is live, and there is what drives it."""
        with contextlib.suppress(OSError):
            live = self.running.get("/api/state").get("robot", {}).get("link") == "live"
            return live and not self.running.get("/api/health")["reasons"] and all(map(self.pids, NEEDED_PROCESSES))
        return False

    def pids(self, word: str) -> list[int]:
        """The console's processes that have this word in their command line."""
        found: list[int] = []
        for child in psutil.Process(self.running.process.pid).children(recursive=True):
            with contextlib.suppress(psutil.NoSuchProcess):
                if word in child.cmdline():
                    found.append(child.pid)
        return found

    def drive(self, chance: random.Random) -> None:
        """Turn by commands that are answered, and be at it now."""
        self.command("stop moving")
        self.look(chance.uniform(0.0, 0.5))
        until(self.turns)

    def command(self, words: str) -> None:
        self.answered.append(self.running.answer("/api/commands", {"text": words})["id"])

    def turns(self) -> bool:
        """Whether it turned in the last moment; a turn that is over is followed by another."""
        if self.running.get("/api/state")["command"] is None:
            self.command("turn left")
        return self.robot.ask("moved", since=time.monotonic() - NOW_S) > TURNING_RAD

    def kill(self, process: str) -> ProcessKill:
        """Kill it, and wait until all is up."""
        folder = self.running.trace.parent
        if process == RECORDER:
            until(lambda: self.running.get("/api/state") and self.pids(RECORDER))
        pid = self.running.process.pid if process == CONSOLE else self.pids(process)[0]
        instant = time.monotonic()
        os.kill(pid, signal.SIGKILL)
        answered, lost = 0, 0
        if process == CONSOLE:
            self.running.close()
            answered, lost = len(self.answered), len(set(self.answered) - stored(folder))
            self.answered = []
            self.running = self.console(folder)
        else:
            until(lambda: set(self.pids(process)) - {pid})
        until(self.healthy)
        up = time.monotonic() - instant
        self.look(max(0.0, WATCHED_S - up))
        rest = round(1000 * (self.robot.ask("rest", since=instant) - instant), 1)
        drove = process != RECORDER and rest > 0.0  # one that had come to its end shows nothing
        return ProcessKill(process, rest if drove else None, round(up, 2), answered, lost)


def stored(folder: Path) -> set[int]:
    """The numbers of the last console's commands in the history."""
    with contextlib.closing(sqlite3.connect(folder / "history.sqlite")) as store:
        newest_run = store.execute("SELECT max(run) FROM deeds").fetchone()[0]
        return {row[0] for row in store.execute("SELECT id FROM deeds WHERE run = ?", (newest_run,))}


def campaign(
    wires: str, kills: int, seed: int, processes: tuple[str, ...] = KILLED_PROCESSES
) -> Iterator[ProcessKill]:
    """So many kills of each process in turn. A console's own is among them, so that no crash is its third."""
    chance = random.Random(seed)
    with robot_process(*SUBJECTS[wires]) as robot, ExitStack() as stack:
        trial = KilledTrial(wires, robot, stack)
        trial.answered = []
        until(trial.healthy)
        for _ in range(kills):
            for process in processes:
                trial.until_live()
                trial.drive(chance)
                yield trial.kill(process)


def main(
    *,
    kills: int = 200,
    wires: Annotated[str, [name for name, kinds in SUBJECTS.items() if kinds]] = "foxglove",
    seed: int = 0,
) -> object:
    found = defaultdict[str, list[ProcessKill]](list)
    for one in campaign(wires, kills, seed):
        found[one.process].append(one)
        sys.stderr.write(json.dumps(asdict(one)) + "\n")
    return {
        process: {
            "kills": len(these),
            "rest_ms": max((one.rest_ms for one in these if one.rest_ms is not None), default=None),
            "up_s": max(one.up_s for one in these),
            "answered": sum(one.answered for one in these),
            "lost": sum(one.lost for one in these),
        }
        for process, these in found.items()
    }


if __name__ == "__main__":
    run_command(main)
