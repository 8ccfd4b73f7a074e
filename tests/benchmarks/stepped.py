"""A console in lock step with a simulated robot: benchmarks of long drives, faster than real time.

The parts are those of a console that runs; only time is another one: `time.monotonic` passes with the robot's frames.
Nobody looks at the 3-D scene; the robot has a small laser (341 beams, 5 Hz) and 20 frames a second.
"""

import asyncio
import contextlib
import functools
import math
import time
from pathlib import Path
from typing import Any

from core.gate.suspend import SleepWatch
from core.robots import Profile
from core.sensors import Laser
from core.simulation import robot as simulated
from tests.console import live as live_console
from tests.console.in_process import SteppedClock, SteppedRobot
from tests.console.live import Live

SCANS_HZ, FRAMES_HZ = 5.0, 20.0
BEAMS, BEAM_STEP_RAD = 341, 2 * math.pi / 512
LOOP_WAIT_S = 5.0  # real seconds, for a loop that is ending


def step_time() -> SteppedClock:
    """From now on time passes in this process only as robots are stepped."""
    clock = SteppedClock()
    time.monotonic = clock  # type: ignore[assignment]
    simulated.Laser = functools.partial(
        Laser, beams=BEAMS, angle_step=BEAM_STEP_RAD, time_step=1 / (512 * 10), rate=SCANS_HZ
    )  # type: ignore[misc,assignment]
    simulated.Profile = functools.partial(Profile, rate=FRAMES_HZ)  # type: ignore[misc,assignment]
    return clock


def stepped_console(folder: Path, url: str, clock: SteppedClock, **options: Any) -> Live:
    """A console that really listens, with a robot that is stepped by it; `options`: of `SteppedRobot`."""
    live_console.InProcessRobot = functools.partial(SteppedRobot, clock=clock, **options)  # type: ignore[misc]
    live = Live(folder, url=url)
    live.runtime._sleep = SleepWatch(lambda: 0.0)
    live.runtime.scene.show = lambda _: None  # type: ignore[method-assign]  # nobody looks

    async def nothing() -> None:
        await asyncio.sleep(0)
        await asyncio.sleep(0)

    def loop_done() -> None:
        with contextlib.suppress(TimeoutError, RuntimeError):
            asyncio.run_coroutine_threadsafe(nothing(), live.loop).result(LOOP_WAIT_S)

    live.robot.loop_done = loop_done  # type: ignore[attr-defined]
    return live
