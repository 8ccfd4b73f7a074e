"""What runs behind the page: the robot's process, the pilot's thread, the scene, and twenty times a second the state.

The pilot's thread is one sentence: for each frame of the robot, obey, step, drive, publish. All else lives on the
event loop. The gate hears the console's heartbeat only from the loop, and only while the pilot steps.
"""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Callable, Coroutine
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from console import wire
from console.array_bench import ArrayBench
from console.calibration.workbench import Workbench
from console.camera_feed import CameraFeed, Picture
from console.data_folder import DataFolder
from console.door import Door
from console.hearing import Ears
from console.history import History
from console.intents import Intents
from console.latest import Hub
from console.lease import Lease
from console.map_desk import MapDesk
from console.microphone import Microphone
from console.notice_board import NoticeBoard
from console.people.school import School
from console.pilot_supervisor import PilotSupervisor
from console.pilot_thread import Pace, PilotLike, PilotThread
from console.player import Player
from console.portrait import Circumstances, draw
from console.quality_runs import QualityRuns
from console.robot_link import RobotLink
from console.robot_voice import RobotVoice
from console.scene import Scene
from console.security import Access
from console.sockets import Sockets
from console.spoken_orders import SpokenOrders
from console.state_times import StateTimes
from console.tasks import end
from console.watch import Watch
from core.errors import BeckonError
from core.gate.sleep import SleepWatch
from core.robots import Profile
from core.sensors import SensorFrame
from core.snapshot import Snapshot

log = logging.getLogger(__name__)

BEAT = 0.05  # [s]
STATE_GAP = 0.045  # [s] at least between two states: 20 Hz


class Runtime:
    """Starts and supervises everything. One per console; its methods run on the event loop."""

    def __init__(
        self, robot: RobotLink, make_pilot: Callable[[], PilotLike], *, home: Path, access: Access | None = None
    ) -> None:
        self.robot = robot
        self.access = access or Access()
        self.hub = Hub()
        self.feed = CameraFeed(self.hub)
        self.sockets = Sockets()
        self.lease = Lease()
        self.board = NoticeBoard()
        self.folder = DataFolder(home, self.board)
        self.history = History(home, partial(self._call, self.folder.history))
        self.door = Door(robot, self.lease, self.history, self.board)
        self.maps = MapDesk(home, robot, self.door, self.lease, self.history)
        self.ears = Ears(self.door, self.history, self.board)
        self.intents = Intents(self.door, self.lease, self.history, self.board)
        self.spoken = SpokenOrders(self.ears, self.door, self.lease, self.intents, self.board)
        self.microphone = Microphone()
        self.voice = RobotVoice()
        self.quality = QualityRuns(home)
        self.player = Player(robot, self.history, self.board)
        self.scene = Scene(robot, partial(self._call, self.board.tell, "warning"), lambda: self.intents.command)
        self.workbench = Workbench(home, robot, self.hub, self.board.tell, self._look_through)
        self.array = ArrayBench(home, robot, lambda: self._look_through(self.workbench.profile()))
        self.people = School(home, robot, self.door, self.board.tell, lambda: self.workbench.newest)
        self.states = StateTimes()
        self.snapshot: Snapshot | None = None
        self.over = False  # the console is ending
        self.trouble = ""  # why the robot did not come
        self.beside: list[Callable[[], Coroutine[Any, Any, None]]] = []  # what runs beside it while it is open
        self._make_pilot = make_pilot
        self.pilots = PilotSupervisor(self._start_pilot, self._pilot_failed, self._leave_out, self.board)
        self._seq = 0
        self._state_at = 0.0
        self._watch = Watch(robot, self.door, self.board)
        self._sleep = SleepWatch()
        self._opening = False
        self._tasks: set[asyncio.Task[None]] = set()
        self._loop: asyncio.AbstractEventLoop | None = None

    # life

    async def open(self) -> None:
        """Bring everything up. Raises Unavailable or BadInput when the robot does not come."""
        self._loop = asyncio.get_running_loop()
        self.robot.alarm = partial(self._call, self.board.tell, "error")
        self._opening = True
        try:
            await asyncio.to_thread(self.robot.start)
        except BeckonError as trouble:
            self.trouble = str(trouble)
            raise
        finally:
            self._opening = False
        await asyncio.to_thread(self.history.open)
        await self.scene.open(self.door, self.sockets)
        await asyncio.gather(self.workbench.open(), self.quality.open(), self.array.open(), self.people.open())
        self.pilots.start()
        for task in (self._beat, self.folder.watch, *self.beside):
            self.keep(asyncio.create_task(task()))

    def farewell_soon(self) -> None:
        """From a signal handler or any thread: the console is about to end."""
        self._call(self.farewell)

    def farewell(self) -> None:
        """The console is about to end: the robot stands, every socket is told, nothing more is opened."""
        if self.over:
            return
        self.over = True
        self.door.close()
        self.sockets.close_all(1012, "The console is ending.")
        if self._opening:
            self.keep(asyncio.create_task(asyncio.to_thread(self.robot.close)))

    async def close(self) -> None:
        """Stop the robot and let go of everything."""
        self.farewell()
        await end(*self._tasks)
        await self.pilots.close()
        parts = (self.workbench, self.ears, self.microphone, self.quality, self.array, self.people)
        await asyncio.gather(*(part.close() for part in parts))
        await asyncio.to_thread(self.robot.close)
        await self.scene.close()
        await asyncio.to_thread(self.history.close)

    # what is shown

    def state(self) -> wire.State | None:
        """The newest state, or None before the first frame."""
        if self.snapshot is None:
            return None
        (link, age), now = self.robot.link(), time.monotonic()
        around = Circumstances(
            profile=self.robot.profile,
            link=link,
            age=round(age, 3),
            pace=self.pace.told(now),
            speed=self.player.speed,
            gate=self.robot.status(),
            lease=self.lease,
            viewers=len(self.hub.viewers),
            notices=tuple(self.board.shown),
            history_revision=self.history.revision,
            map=self.maps.shown,
            muted=self.voice.muted,
            obeyed=self.spoken.driver is not None,
            words=self.ears.words,
            intent=self.intents.waiting,
            now=now,
        )
        self._seq += 1
        self.states.note(self._seq, now)
        return draw(self.snapshot, around, self._seq)

    @property
    def pace(self) -> Pace:
        """How the pilot keeps up."""
        return self.pilots.pace

    async def ask(self, request: dict[str, Any]) -> dict[str, Any]:
        """A request to the driver, waited for outside the event loop."""
        return await asyncio.to_thread(self.robot.ask, request)

    def keep(self, task: asyncio.Task[None]) -> None:
        """Hold on to a task until it is done; one that fails is told."""
        self._tasks.add(task)
        task.add_done_callback(self._done)

    def _done(self, task: asyncio.Task[None]) -> None:
        self._tasks.discard(task)
        if not task.cancelled() and (fault := task.exception()) is not None:
            log.error("A part of the console failed", exc_info=fault)
            self.board.tell("error", f"A part of the console failed ({type(fault).__name__}). Restart the console.")

    # the pilot

    def _start_pilot(self) -> PilotThread:
        self.door.pilot = None
        pilot = self._make_pilot()
        pilot.look_through(self.array.profile(self.workbench.profile()))
        pilot.obey_only(self.people.chosen)
        told = (self._published, partial(self._call, self.pilots.bury), self.voice.deaf)
        thread = PilotThread(self.robot, pilot, self.door.helm, *told)
        thread.start()
        self.door.pilot = pilot
        return thread

    def _pilot_failed(self) -> None:
        self.door.pilot = None
        self.door.ended_without_pilot("The pilot failed; the robot was stopped.")
        self._nothing_under_way()

    def _leave_out(self, fault: str) -> list[str]:
        """Use no calibration any more → the files that were in use until now."""
        why = f"The pilot failed ({fault}) within seconds of using it."
        return [*self.workbench.leave_out(why), *self.array.leave_out(why)]

    def _published(self, snapshot: Snapshot, frame: SensorFrame) -> None:
        """From the pilot's thread."""
        picture = self.feed.encoded(frame.image)
        self.scene.show(snapshot)
        self.workbench.newest = frame.image or self.workbench.newest
        if self.workbench.watching:
            self._call(self.workbench.saw, frame)
        self._call(self._took, snapshot, picture, frame)

    def _look_through(self, profile: Profile) -> None:
        """A calibration was accepted or taken back: used from the next frame on."""
        if (thread := self.pilots.thread) is not None:
            self.pilots.recalibrated()
            thread.pilot.look_through(self.array.profile(profile))

    def _call(self, act: Callable[..., None], *given: Any) -> None:
        """On the event loop, if there still is one."""
        if self._loop is not None and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(act, *given)

    def _took(self, snapshot: Snapshot, picture: Picture | None, frame: SensorFrame) -> None:
        self._look_for_sleep()
        if not self.over:
            self.robot.beat()  # the loop runs and the pilot steps: that is what the gate wants to know
        self.snapshot = snapshot
        self.maps.took(snapshot)
        self.people.took(snapshot)
        sound = None if self.array.helped else frame.sound
        self.ears.took(snapshot, sound, self.robot.profile.microphones, frame.sensed)
        self.intents.took(snapshot)
        self.array.took(snapshot, frame.sound)
        self.board.adopt(snapshot.notices, snapshot.stamp)
        for told in snapshot.endings:
            self.door.ended(told)
        if picture is not None:
            self.feed.show(picture)
        if time.monotonic() - self._state_at >= STATE_GAP:
            self._tell_state()

    def _tell_state(self) -> None:
        self._state_at = time.monotonic()
        if self.hub.watched("state") and (state := self.state()) is not None:
            self.hub.publish("state", wire.encode(state).decode())

    # twenty times a second

    async def _beat(self) -> None:
        due = time.monotonic()
        while True:
            try:
                self._tick(time.monotonic())
            except Exception:
                log.exception("A tick failed")
            due = max(due + BEAT, time.monotonic() - BEAT)
            await asyncio.sleep(max(0.0, due - time.monotonic()))

    def _tick(self, now: float) -> None:
        self._look_for_sleep()
        if self.pilots.steps and not self.over:
            self.robot.beat()
        self.door.tick(now)
        for person in self.access.logins.expire(now):
            self.door.forget(person)
            self.sockets.close_of(person, 1008, "Your login has expired; sign in again.")
        if self._watch.look(hangs=self.pilots.hangs):
            self._nothing_under_way()
        self.workbench.tick(now)
        self.microphone.tick(now)
        if now - self._state_at > BEAT + STATE_GAP:
            self._tell_state()

    def _look_for_sleep(self) -> None:
        """What was ordered, or waited to begin, before the machine slept does not go on."""
        if self._sleep.woke():
            self.door.helm.stop()
            self.door.cancel("failed", "The machine slept; the robot was stopped.")

    def _nothing_under_way(self) -> None:
        """The newest snapshot may stay the newest for long: what it says is under way has failed."""
        if self.snapshot is not None and self.snapshot.undertaking is not None:
            self.snapshot = replace(self.snapshot, undertaking=None, goal=None)
