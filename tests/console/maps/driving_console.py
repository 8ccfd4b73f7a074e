"""A console's maps without its page, on a robot that drives, to be killed.

`python -m tests.console.maps.driving_console HOME`
"""

import asyncio
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from console.control.history import History
from console.control.lease import Lease
from console.maps import service
from core.gate import Twist
from core.pilot import Pilot
from core.robots.connect import connect
from core.settings import Settings


async def keep_maps(home: Path) -> None:
    robot = connect("sim:lab")
    pilot = Pilot(robot.profile)
    link: Any = SimpleNamespace(profile=robot.profile)
    dispatcher: Any = SimpleNamespace(pilot=pilot)
    maps = service.MapService(home, Settings(), link, dispatcher, Lease(), History(home, print))
    saving = asyncio.create_task(maps.run())
    while not saving.done():
        frame = robot.read()
        maps.on_snapshot(pilot.step(frame), frame)
        robot.drive(Twist(0.3, 0.1))
        await asyncio.sleep(0.0)


if __name__ == "__main__":
    service.AUTOSAVE_PERIOD_S = 0.1
    asyncio.run(keep_maps(Path(sys.argv[1])))
