"""A console without page and pilot: one recorded frame, the real gate, and the part that joins a fleet."""

import asyncio
import itertools
import threading
import time
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

from console.access.logins import Logins
from console.control.dispatcher import CommandDispatcher
from console.control.history import History
from console.control.lease import Lease
from console.control.notices import Notifications
from console.fleet.authority import CertificateFiles
from console.fleet.bus import FleetAddress, MemberOptions
from console.fleet.member import FleetMember
from console.maps.service import MapService
from core.gate.gate import TICK_S, Gate
from core.gate.limits import Limits
from core.gate.setpoint import Setpoint
from core.gate.status import GateStatus
from core.geometry import Pose
from core.pilot import Pilot
from core.robots import Profile
from core.robots.connect import connect
from core.sensors import SensorFrame
from core.settings import Settings
from core.snapshot import Snapshot

BEAT_S = 0.05
SPEED_M_S = 0.2


@cache
def recorded() -> tuple[Profile, Snapshot, SensorFrame]:
    """A robot in the lab, what its pilot made of its first frames, and the last of these."""
    robot = connect("sim:lab", seed=1, settings=Settings())
    pilot = Pilot(robot.profile)
    frame = robot.read()  # with a picture
    snapshot = pilot.step(frame)
    robot.close()
    return robot.profile, snapshot, frame


class GateAlone:
    """The console's RobotSupervisor with a real gate, and a robot that stands still in its one frame.

    The gate has a clock of its own, which a tick advances: it trips when a tick is late, as it has to, but in its own
    process, which no loop of a console and no busy machine delays.
    """

    def __init__(self, profile: Profile) -> None:
        self.profile, self.trouble = profile, ""
        self.gate = Gate(Limits(heartbeat=1.0, deadman=1.0, guard=False))
        self.driven = False  # a hand drives, until the gate takes it no more
        self.frozen: GateStatus | None = None  # as it answers while nothing reaches its gate
        self._now, self._press = 0.0, 0  # [s]; of the hand
        self._numbers = itertools.count(1)
        self._lock = threading.RLock()

    def tick(self) -> None:
        with self._lock:
            self._now = now = self._now + TICK_S
            self.gate.heartbeat(now)
            self.gate.touch(False, now)
            self.gate.tick(now)
            if self.driven:
                nonce = self.gate.status().nonce
                self.gate.accept(Setpoint(1, next(self._numbers), "jog", self._press, SPEED_M_S, 0.0, nonce), now)

    def stop(self) -> None:
        if self.frozen is not None:
            return
        with self._lock:
            self.gate.stop(self._now)

    def halt(self) -> None:
        with self._lock:
            self.gate.halt(self._now)

    def disarm(self) -> None:
        with self._lock:
            self.gate.disarm(self._now)

    def arm(self, epoch: int, owner: str) -> None:
        with self._lock:
            self.gate.arm(epoch, owner, self._now)

    def send(self, setpoint: Setpoint) -> None:
        with self._lock:
            self.gate.accept(setpoint, self._now)

    def reset(self) -> bool:
        with self._lock:
            self.gate.reset(self._now)
        return True

    def status(self) -> GateStatus:
        with self._lock:
            return self.frozen or self.gate.status()

    def link(self) -> tuple[Any, float]:
        return "live", 0.05

    def drive(self) -> None:
        """Move as under a hand that presses anew and holds on, whatever the gate says."""
        self.disarm()
        self.arm(1, "test")
        with self._lock:
            self._press += 1
            nonce = self.gate.status().nonce
            self.gate.accept(Setpoint(1, next(self._numbers), "jog", self._press, 0.0, 0.0, nonce), self._now)
            self.gate.tick(self._now)
            self.driven = True


class LightConsole:
    """Lives on the event loop between `open` and `close`."""

    def __init__(
        self,
        name: str,
        address: FleetAddress,
        folder: Path,
        home: Path,
        number: int = 0,
        page: str = "http://127.0.0.1:1/",
        certificate: str = "",
    ) -> None:
        profile, self._snapshot, self._frame = recorded()
        self.name, self.robot, self.logins = name, GateAlone(profile), Logins()
        self.lease, self.notifications = Lease(), Notifications()
        link = cast(Any, self.robot)
        history = History(home, print)
        self.dispatcher = CommandDispatcher(link, self.lease, history, self.notifications)
        self.maps: Any = SimpleNamespace(shown=SimpleNamespace(name=None), frame="")
        self.member = FleetMember(
            MemberOptions(address, name, CertificateFiles(folder)),
            page,
            certificate,
            robot=link,
            dispatcher=self.dispatcher,
            lease=self.lease,
            notifications=self.notifications,
            logins=self.logins,
            maps=cast(MapService, self.maps),
        )
        pose = Pose(0.3 * number, 0.1 * number, 0.0)
        self._snapshot = replace(
            self._snapshot, estimate=replace(self._snapshot.estimate, pose=pose), battery=0.5, notices=()
        )
        self._tasks: list[asyncio.Task[None]] = []

    def open(self) -> None:
        self._tasks = [asyncio.create_task(work) for work in (self.member.run(), self._live())]

    async def close(self) -> None:
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        await self.member.close()

    async def _live(self) -> None:
        beat = 0.0
        while True:
            now = time.monotonic()
            self.robot.tick()
            if now - beat >= BEAT_S:
                beat = now
                self.member.on_snapshot(self._snapshot, self._frame)
                self.member.tick(now)
            await asyncio.sleep(TICK_S)
