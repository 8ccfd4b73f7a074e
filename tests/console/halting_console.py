"""A console without its web part that halts when told, to be killed: `python -m tests.console.halting_console HOME`.

It says its processes' numbers as JSON, waits for a line, halts, waits as POST /api/halt does, and says the answer.
"""

import asyncio
import json
import sys
import time
from pathlib import Path

from console.control.notices import Notifications
from console.control.stop import latched
from core.robots.connect import SCHEMES
from tests.console.tiny_process import TinyProcess
from tests.console.tiny_robot import TINY


def say(told: object) -> None:
    sys.stdout.write(json.dumps(told) + "\n")
    sys.stdout.flush()


def main() -> None:
    SCHEMES["tiny"] = TINY
    robot = TinyProcess("tiny:", home=Path(sys.argv[1]))
    robot.start()
    while not robot.status().nonce:
        time.sleep(0.005)
    say(robot.pids)
    sys.stdin.readline()
    robot.halt()
    say({"latched": asyncio.run(latched(robot, Notifications())) == ""})
    time.sleep(60.0)


if __name__ == "__main__":
    main()
