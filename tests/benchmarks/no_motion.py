"""What moves after an event although nobody asked for it: `python -m tests.benchmarks.no_motion [NAME …]`.

Per driver, the robot turns by a command over its wire until the event strikes: the link is cut and restored, a
process (console, gate, driver, the robot's own side) is frozen and thaws, the console is killed and another one
comes, or a second console comes while the first one stands. Told: how far the robot moved after the event, in metres,
a radian counts as one; it has to be 0. The client of the first console goes on with its signs of life all the time.
"""

import contextlib
import os
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path

import psutil

from tests.benchmarks.command import print_row, run_command
from tests.benchmarks.real_sessions import SUBJECTS
from tests.benchmarks.running_console import Console
from tests.emulators.robot_process import RobotProcess, robot_process

FROZEN, AFTER = 3.0, 3.0  # [s] of a loss or freeze, which is longer than any failsafe; and of watching after it
GRACE = 0.4  # [s] after a thaw of the robot's side, whose wheels turned when it froze, in which it may come to rest
STANDS = 0.002  # [m] or [rad] that are no motion
PATIENCE_S = 300.0  # beside whatever else the machine does


class Trial:
    """One driver: an emulated robot and its console."""

    def __init__(self, name: str, robot: RobotProcess, stack: ExitStack) -> None:
        self.name, self.robot, self._stack = name, robot, stack
        self.running = self.console()

    def console(self, folder: Path | None = None) -> Console:
        """Another console on the robot, in a new data folder, or in one that has been used."""
        if folder is None:
            folder = Path(self._stack.enter_context(tempfile.TemporaryDirectory(ignore_cleanup_errors=True)))
        running = Console(folder, auth=True, robot=self.robot.url, environment=self.robot.environment)
        self._stack.callback(running.close)
        return running

    def look(self, seconds: float) -> None:
        """Signs of life for a while."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            with contextlib.suppress(OSError):
                self.running.get("/api/state")
            time.sleep(0.1)

    def until_live(self) -> None:
        until(lambda: self.running.get("/api/state").get("robot", {}).get("link") == "live")
        self.look(1.0)

    def turn(self) -> None:
        """Set it in motion. Raises TimeoutError."""
        self.until_live()
        self.running.answer("/api/commands", {"text": "stop moving"})
        self.look(0.5)
        self.running.answer("/api/commands", {"text": "turn left"})
        began = time.monotonic()
        until(lambda: self.running.get("/api/state") and self.robot.ask("moved", since=began) > 0.1)

    def child(self, module: str) -> int:
        children = psutil.Process(self.running.process.pid).children(recursive=True)
        return next(child.pid for child in children if module in child.cmdline())

    def moved_from(self, instant: float) -> float:
        """[m] moved from that time.monotonic() on, until `AFTER` after now."""
        self.look(AFTER)
        return float(self.robot.ask("moved", since=instant))


def until(true: Callable[[], object]) -> None:
    end = time.monotonic() + PATIENCE_S
    while not true():
        if time.monotonic() > end:
            raise TimeoutError
        time.sleep(0.05)


def link_cut(trial: Trial) -> float:
    trial.turn()
    trial.robot.ask("cut")
    trial.look(FROZEN)
    restored = time.monotonic()
    trial.robot.ask("restore")
    trial.until_live()
    return trial.moved_from(restored)


def frozen(trial: Trial, pid: int) -> float:
    """Freeze that process in the middle of a turn."""
    trial.turn()
    os.kill(pid, signal.SIGSTOP)
    time.sleep(FROZEN) if pid == trial.running.process.pid else trial.look(FROZEN)
    thawed = time.monotonic()
    with contextlib.suppress(ProcessLookupError):  # it was replaced meanwhile
        os.kill(pid, signal.SIGCONT)
    return trial.moved_from(thawed)


def robot_frozen(trial: Trial) -> float:
    trial.turn()
    trial.robot.freeze(FROZEN)
    return trial.moved_from(time.monotonic() + GRACE)


def second_console(trial: Trial) -> float:
    trial.turn()
    trial.running.answer("/api/commands", {"text": "stop moving"})
    trial.look(1.0)
    came = time.monotonic()
    with contextlib.suppress(IndexError):  # the wire is taken: it ends with a sentence
        trial.console()
    return trial.moved_from(came)


def console_killed(trial: Trial) -> float:
    trial.turn()
    trial.running.process.kill()
    time.sleep(FROZEN)
    came = time.monotonic()
    trial.running = trial.console()
    trial.until_live()
    return trial.moved_from(came)


EVENTS: dict[str, Callable[[Trial], float]] = {
    "link cut": link_cut,
    "console frozen": lambda trial: frozen(trial, trial.running.process.pid),
    "gate frozen": lambda trial: frozen(trial, trial.child("core.gate.process")),
    "driver frozen": lambda trial: frozen(trial, trial.child("core.robots.process")),
    "robot frozen": robot_frozen,
    "console killed": console_killed,
    "second console": second_console,
}


def run(name: str) -> dict[str, float]:
    """All events on one driver → [m] moved after each."""
    with robot_process(*SUBJECTS[name]) as robot, ExitStack() as stack:
        trial = Trial(name, robot, stack)
        return {event: happen(trial) for event, happen in EVENTS.items()}


def main(names: Sequence[str] = (name for name, kinds in SUBJECTS.items() if kinds)) -> None:
    for name in names:
        for event, moved in run(name).items():
            verdict = "ok" if moved < STANDS else "MOVED"
            print_row(f"{name:22} {event:15} {moved:7.4f}  {verdict}  load {os.getloadavg()[0]:.1f}")
        sys.stdout.flush()


if __name__ == "__main__":
    run_command(main)
