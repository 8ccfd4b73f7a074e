"""An emulated robot in a process of its own, so that it can be frozen, and the console's process measured by itself.

`python -m tests.emulators.robot_process serial scip` serves `sim:lab` on these wires and answers lines of JSON.
"""

import contextlib
import itertools
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import msgspec

from core.geometry import Pose
from core.robots.requests import FloorPlan, PlaceThing, ReadPlan, Speak
from core.sensors.wheels import MOVING_SPEED
from core.speech.recognition.recognizer import for_words, pcm
from core.speech.settings import RATE_HZ
from core.speech.synthesis import PERSONS_VOICE, VoiceSettings, speak
from tests.emulators.camera import CameraEmulator
from tests.emulators.foxglove import FoxgloveEmulator
from tests.emulators.lds import LidarEmulator
from tests.emulators.microphones import MicrophonesEmulator
from tests.emulators.ros_messages import PROFILE
from tests.emulators.rosbridge import RosbridgeEmulator
from tests.emulators.scip import ScipEmulator
from tests.emulators.serial_base import SerialRobot
from tests.emulators.srv1 import Srv1Emulator
from tests.emulators.world import World
from tests.emulators.zenoh_robot import ZenohEmulator

SPEAKER = "Ann"
PERIOD_S = 1 / PROFILE.rate  # between frames of the world
SHIFT = "shift="  # begins a kind that is none: what is added to the stamps of scans [s]


def scip(world: World) -> ScipEmulator:
    """A Hokuyo that sees the world."""
    sensor = ScipEmulator()
    world.on_scan.append(lambda scan: sensor.show_scan(scan, world.instant(scan.stamp)))
    return sensor


KINDS: dict[str, Callable[[World], Any]] = {
    "foxglove": FoxgloveEmulator,
    "zenoh": ZenohEmulator,
    "rosbridge": RosbridgeEmulator,
    "serial": SerialRobot,
    "srv1": Srv1Emulator,
    "scip": scip,
    "lds": lambda world: LidarEmulator(world, "ld19"),
    "camera": CameraEmulator,
    "audio": MicrophonesEmulator,
}


def _moves(before: Pose, after: Pose) -> bool:
    """Whether the wheels turn noticeably between two frames; how fast they come to these says nothing."""
    step = before.inverse() @ after
    return max(step.distance_to(0.0, 0.0), abs(step.heading)) > MOVING_SPEED * PERIOD_S


class Served:
    """The world, its emulators, and what may be asked of them."""

    def __init__(self, kinds: list[str]) -> None:
        shifts = [float(kind.removeprefix(SHIFT)) for kind in kinds if kind.startswith(SHIFT)]
        kinds = [kind for kind in kinds if not kind.startswith(SHIFT)]
        self.world = World(
            failsafe=None if "srv1" in kinds else 0.5, listening="audio" in kinds, scan_shift=sum(shifts)
        )
        self.parts = [KINDS[kind](self.world) for kind in kinds]
        self.track: list[tuple[float, Pose]] = []  # time.monotonic() and the true pose
        self.world.on_wheels.append(lambda _: self.track.append((time.monotonic(), self.world.truth)))

    def start(self) -> dict[str, Any]:
        for part in (*self.parts, self.world):
            part.start()
        cards = [part.environment() for part in self.parts if isinstance(part, MicrophonesEmulator)]
        return {"url": "+".join(part.url for part in self.parts), "environment": cards[0] if cards else {}}

    def stop(self) -> None:
        for part in (self.world, *self.parts):
            part.stop()

    def answer(self, asked: dict[str, Any]) -> Any:
        match asked["do"]:
            case "truth":
                pose = self.world.truth
                return [pose.x, pose.y, pose.heading]
            case "moved":
                return self.moved(asked["since"])
            case "rest":
                return self.rest(asked["since"])
            case "applied":
                return self.applied()[-3:]
            case "plan":
                return msgspec.to_builtins(self.world.ask(ReadPlan()))
            case "place":
                self.world.ask(PlaceThing(what="person", id=SPEAKER, x_m=asked["x"], y_m=asked["y"]))
            case "say":
                samples = pcm(for_words(speak(asked["text"], VoiceSettings(voice=PERSONS_VOICE))).samples[:, 0])
                self.world.ask(Speak(id=SPEAKER, pcm=samples, rate_hz=RATE_HZ))
            case "cut" | "restore":
                for part in self.parts:
                    part.stop() if asked["do"] == "cut" else part.start()
        return None

    def applied(self) -> list[tuple[float, float, float]]:
        """time.monotonic(), v, w of what came through the wire of the part that drives."""
        base = self.parts[0]
        return getattr(base, "received", None) or getattr(base, "heard", [])

    def moved(self, since: float) -> float:
        """[m], a radian counted as one: what it moved since that time.monotonic()."""
        poses = [pose for stamp, pose in self.track if stamp >= since]
        return sum(
            (step := before.inverse() @ after).distance_to(0.0, 0.0) + abs(step.heading)
            for before, after in itertools.pairwise(poses)
        )

    def rest(self, since: float) -> float:
        """time.monotonic() after which it did not move noticeably; `since` where it never did."""
        poses = [(stamp, pose) for stamp, pose in self.track if stamp >= since]
        return max((now for (_, one), (now, other) in itertools.pairwise(poses) if _moves(one, other)), default=since)


class RobotProcess:
    """The other end: a running emulated robot."""

    def __init__(self, *kinds: str) -> None:
        command = [sys.executable, "-m", "tests.emulators.robot_process", *kinds]
        self._process = subprocess.Popen(
            command, cwd=Path(__file__).parents[2], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self._asking = threading.Lock()
        described = self._next()
        self.url: str = described["url"]
        self.environment: dict[str, str] = described["environment"]

    def _next(self) -> Any:
        assert self._process.stdout is not None
        return json.loads(self._process.stdout.readline())

    def ask(self, do: str, **more: object) -> Any:
        assert self._process.stdin is not None
        with self._asking:
            self._process.stdin.write(json.dumps({"do": do, **more}) + "\n")
            self._process.stdin.flush()
            return self._next()

    def truth(self) -> Pose:
        return Pose(*self.ask("truth"))

    def plan(self) -> FloorPlan:
        return msgspec.convert(self.ask("plan"), FloorPlan)

    def freeze(self, seconds: float) -> None:
        os.kill(self._process.pid, signal.SIGSTOP)
        time.sleep(seconds)
        os.kill(self._process.pid, signal.SIGCONT)

    def close(self) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()
        try:
            self._process.wait(10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


@contextlib.contextmanager
def robot_process(*kinds: str) -> Iterator[RobotProcess]:
    """A robot on these wires."""
    robot = RobotProcess(*kinds)
    try:
        yield robot
    finally:
        robot.close()


def main() -> None:
    """Serve until the other end of the pipe is closed."""
    served = Served(sys.argv[1:])
    answer: Any = served.start()
    while True:
        sys.stdout.write(json.dumps(answer) + "\n")
        sys.stdout.flush()
        line = sys.stdin.readline()
        if not line:
            break
        answer = served.answer(json.loads(line))
    served.stop()


if __name__ == "__main__":
    main()
