"""A whole session per driver: the console in processes of its own drives an emulated robot over a real wire.

`python -m tests.benchmarks.real_sessions [NAME …]`: the motion commands and FOLLOW WALL by REST, scored against the
emulator's truth; the simulator itself beside them under the same bounds.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

from core.geometry import Pose, wrap
from tests.benchmarks.running_console import Console, console
from tests.emulators.foxglove import FoxgloveEmulator
from tests.emulators.rosbridge import RosbridgeEmulator
from tests.emulators.scip import ScipEmulator
from tests.emulators.serial_base import SerialRobot
from tests.emulators.world import World

TURN, WAY, PLACE = math.radians(5), 0.06, 0.12  # [rad], [m], [m] that a command may be off


@dataclass(frozen=True)
class Row:
    """How one command ended."""

    words: str
    state: str
    error: float  # [m] or [rad]
    bound: float
    seconds: float

    @property
    def good(self) -> bool:
        """True when it was done within its bound."""
        return self.state == "done" and self.error <= self.bound


@contextmanager
def simulator() -> Iterator[tuple[str, Callable[[], Pose] | None]]:
    """The simulated robot itself."""
    yield "sim:lab", None


@contextmanager
def emulated(*kinds: str) -> Iterator[tuple[str, Callable[[], Pose]]]:
    """Emulators in one world, joined in one URL."""
    world = World()
    with ExitStack() as stack:
        parts = [_emulator(kind, world) for kind in kinds]
        for part in (*parts, world):
            part.start()
            stack.callback(part.stop)
        yield "+".join(part.url for part in parts), lambda: world.truth


def _emulator(kind: str, world: World) -> FoxgloveEmulator | RosbridgeEmulator | SerialRobot | ScipEmulator:
    if kind == "foxglove":
        return FoxgloveEmulator(world)
    if kind == "rosbridge":
        return RosbridgeEmulator(world)
    if kind == "serial":
        return SerialRobot(world)
    laser = ScipEmulator()
    world.on_scan.append(laser.show_scan)
    return laser


SUBJECTS: dict[str, Callable[[], object]] = {
    "sim": simulator,
    "serial+scip": lambda: emulated("serial", "scip"),
    "foxglove": lambda: emulated("foxglove"),
    "rosbridge": lambda: emulated("rosbridge"),
}


def session(running: Console, where: Callable[[], Pose], follow: float = 20.0) -> list[Row]:
    """TURN LEFT and RIGHT, CONTINUE, STOP AT, FOLLOW WALL and STOP MOVING by REST."""
    rows = [
        _turned(running, where, "turn left", math.pi / 2),
        _turned(running, where, "turn right", -math.pi / 2),
        _went(running, where, "continue 0.5 meters", 0.5),
        _reached(running, where, 1.0, 0.4),
    ]
    return [*rows, _followed(running, where, follow)]


def _turned(running: Console, where: Callable[[], Pose], words: str, angle: float) -> Row:
    before = where()
    state, seconds = obey(running, words)
    return Row(words, state, abs(wrap(where().heading - before.heading - angle)), TURN, seconds)


def _went(running: Console, where: Callable[[], Pose], words: str, way: float) -> Row:
    before = where()
    state, seconds = obey(running, words)
    here = before.inverse() @ where()
    return Row(words, state, math.hypot(here.x - way, here.y), WAY, seconds)


def _reached(running: Console, where: Callable[[], Pose], x: float, y: float) -> Row:
    words = f"stop at {x} and {y}"
    state, seconds = obey(running, words)
    return Row(words, state, where().distance_to(x, y), PLACE, seconds)


def _followed(running: Console, where: Callable[[], Pose], seconds: float) -> Row:
    """Follow the wall for a while, then STOP → the way that is missing of 4 cm/s over that time."""
    running.answer("/api/commands", {"text": "follow wall"})
    way, last, end = 0.0, where(), time.monotonic() + seconds
    while time.monotonic() < end:
        running.get("/api/state")  # a sign of life
        time.sleep(0.25)
        here = where()
        way, last = way + here.distance_to(last.x, last.y), here
    running.answer("/api/commands", {"text": "stop moving"})
    time.sleep(0.5)
    stands = where()
    time.sleep(0.5)
    rolled = where().distance_to(stands.x, stands.y)
    state = "done" if rolled < 0.005 else f"rolled {rolled:.3f} m after STOP"
    return Row("follow wall, stop moving", state, max(0.0, 0.04 * seconds - way), 0.0, seconds)


def obey(running: Console, words: str, patience: float = 60.0) -> tuple[str, float]:
    """A command by REST → how it ended, and after how many seconds."""
    began = time.monotonic()
    entry = running.answer("/api/commands", {"text": words})
    while time.monotonic() - began < patience:
        newest = running.get("/api/commands/history?limit=5")["commands"]
        state = next((one["state"] for one in newest if one["id"] == entry["id"]), "gone")
        if state not in ("running", "accepted"):
            time.sleep(0.3)
            return state, time.monotonic() - began
        time.sleep(0.1)
    return "no end", patience


def truth_of(running: Console) -> Callable[[], Pose]:
    """The simulator's own truth, asked of the console."""

    def where() -> Pose:
        told = running.get("/api/sim/truth")
        return Pose(told["x_m"], told["y_m"], told["heading_rad"])

    return where


def run(name: str, follow: float = 20.0) -> list[Row]:
    """One subject's session."""
    with SUBJECTS[name]() as (url, where), console(auth=not url.startswith("sim:"), robot=url) as running:  # type: ignore[attr-defined]
        time.sleep(3.0)  # the robot looks around
        return session(running, where or truth_of(running), follow)


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", default=list(SUBJECTS))
    for name in parser.parse_args().names:
        for row in run(name):
            unit = "°" if row.bound == TURN else "m"
            error = math.degrees(row.error) if unit == "°" else row.error
            verdict = "ok" if row.good else "MISSED"
            sys.stdout.write(
                f"{name:14} {row.words:26} {row.state:8} {error:7.3f} {unit}  {row.seconds:5.1f} s  {verdict}\n"
            )


if __name__ == "__main__":
    main()
