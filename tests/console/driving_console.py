"""A console that only drives, to be killed or frozen: `python -m tests.console.driving_console URL HOME [goal|jog]`.

It says its processes' numbers as JSON, then "driving" as soon as the robot moves, and goes on for ever.
"""

import json
import sys
import time
from pathlib import Path

from console.robot.supervisor import RobotSupervisor
from core.gate import Setpoint
from core.robots.connect import SCHEMES
from tests.console.tiny_process import TinyProcess
from tests.console.tiny_robot import TINY


def say(words: str) -> None:
    sys.stdout.write(words + "\n")
    sys.stdout.flush()


def main() -> None:
    url, home, source = sys.argv[1], Path(sys.argv[2]), sys.argv[3]
    SCHEMES["tiny"] = TINY
    kind = TinyProcess if url.startswith("tiny:") else RobotSupervisor
    robot = kind(url, home=home, gate_trace=home / "gate.csv")
    robot.start()
    say(json.dumps(robot.pids))
    robot.arm(1, "ann")
    seq, press, beaten, driving = 0, 1, 0.0, False
    while True:
        now = time.monotonic()
        if now - beaten >= 0.05:
            robot.beat()
            beaten = now
        frame = robot.next_frame(0.05)
        status = robot.status()
        if frame is None or status.state != "armed":
            continue
        seq += 1
        press = status.trips + 1 if not driving else press
        speeds = (0.0, 0.0) if source == "jog" and status.need_neutral and not driving else (0.1, 0.5)
        nonce = status.nonce if source == "jog" else frame.nonce
        robot.send(Setpoint(1, seq, source, press, *speeds, nonce))  # type: ignore[arg-type]
        if status.v >= 0.1 and not driving:
            driving = True
            say("driving")


if __name__ == "__main__":
    main()
