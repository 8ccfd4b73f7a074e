"""The runtime behind the page: robot process, pilot thread, scene, and twenty times a second the state.

The pilot's thread is one sentence: for each frame of the robot, step, send the setpoint, publish. All else lives on
the event loop. The gate hears the console's heartbeat only from the loop, and only while the pilot steps.
"""

import asyncio
import contextlib
import logging
import secrets
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from console.access.guard import Access
from console.access.login_keeper import LoginKeeper
from console.access.logins import Person
from console.access.open_sockets import OpenSockets
from console.broadcast import Broadcaster
from console.camera_stream import CameraStream, Picture
from console.capabilities import ConsoleBase, make_parts
from console.control.command_freshness import StateTimes
from console.control.dispatcher import CommandDispatcher
from console.control.history import History
from console.control.lease import Lease
from console.control.link_monitor import LinkMonitor
from console.control.notices import Notifications
from console.control.own_navigation import OwnNavigationService
from console.control.pending_commands import PendingCommands
from console.control.pilot_supervisor import PilotSupervisor
from console.data_folder import DataFolder
from console.maps.places import PlaceService
from console.maps.zones import ZoneService
from console.messages import state as messages
from console.rest import StatePace
from console.robot.pilot_thread import PilotPace, PilotThread
from console.robot.supervisor import RobotSupervisor
from console.scene import Scene
from console.speech.robot_voice import RobotVoice
from console.state_view import StateContext, state_message
from console.workers.tasks import HeldTasks
from core.errors import BeckonError
from core.gate.suspend import SleepWatch
from core.pilot.pilot import Pilot
from core.robots.requests import AnswerT, RobotRequest
from core.sensors import SensorFrame
from core.settings import ChapterMode, Settings
from core.snapshot import Snapshot
from core.speech.understanding.own_phrases import own_phrases

log = logging.getLogger(__name__)

BEAT_S = 0.05


class Runtime:
    """Starts and supervises everything. One per console; its methods run on the event loop."""

    def __init__(
        self,
        robot: RobotSupervisor,
        make_pilot: Callable[[], Pilot],
        *,
        home: Path,
        access: Access | None = None,
        settings: Settings | None = None,
        settings_file: Path | None = None,
    ) -> None:
        """`settings_file`: where changed settings are saved; None: in the data folder."""
        settings = settings or Settings()
        self.name = secrets.token_hex(4)  # of this run of the console
        self.robot = robot
        self.chapter: ChapterMode = settings.chapter.mode  # "printed": the chapter's own equations run
        self.access = access or Access()
        self.broadcaster = Broadcaster()
        self.camera_stream = CameraStream(self.broadcaster)
        self.sockets = OpenSockets()
        self.lease = Lease()
        self.notifications = Notifications()
        self.folder = DataFolder(home, self.notifications)
        self.history = History(home, partial(self._call, self.folder.history))
        own = own_phrases(settings.speech.phrases)
        self.dispatcher = CommandDispatcher(robot, self.lease, self.history, self.notifications, own)
        self.state_times = StateTimes()
        self.snapshot: Snapshot | None = None
        self.over = False  # the console is ending
        self.trouble = ""  # why the robot did not come
        self.failure = ""  # of a part that ended, a sentence
        self._make_pilot = make_pilot
        self.pilots = PilotSupervisor(self._start_pilot, self._pilot_failed, self._leave_out, self.notifications)
        self._seq = 0
        self._state_pace = StatePace()
        self._link_monitor = LinkMonitor(robot, self.dispatcher, self.notifications)
        self._sleep, self._opening = SleepWatch(), False
        self.login_keeper = LoginKeeper(self.access.logins, self.sign_out, self._logins_unsaved)
        self._tasks = HeldTasks(self._part_failed)
        self.keep = self._tasks.start  # work that nobody waits for
        self._loop: asyncio.AbstractEventLoop | None = None
        self.parts = make_parts(
            ConsoleBase(
                home=home,
                settings=settings,
                settings_file=settings_file,
                robot=robot,
                lease=self.lease,
                history=self.history,
                dispatcher=self.dispatcher,
                notifications=self.notifications,
                broadcaster=self.broadcaster,
                recalibrated=self._recalibrated,
                adopted=self._adopted,
            )
        )
        self.parts.add(self.folder)
        self.parts.add(self.login_keeper)
        self._context = StateContext(
            robot, self.lease, self.history, self.notifications, self.sockets, self.pilots, self.parts, self.chapter
        )
        self.scene = Scene(
            robot,
            partial(self._call, self.notifications.tell, "warning"),
            lambda: self.parts[PendingCommands].command,
            lambda: self.parts[OwnNavigationService].map_view,
            lambda: (self.parts[PlaceService].places, self.parts[ZoneService].zones),
        )

    # life

    async def open(self) -> None:
        """Bring everything up. Raises Unavailable or BadInput when the robot does not come."""
        self._loop = asyncio.get_running_loop()
        self.robot.alarm = partial(self._call, self.notifications.tell, "error")
        self._opening = True
        try:
            await asyncio.to_thread(self.robot.start)
        except BeckonError as trouble:
            self.trouble = str(trouble)
            raise
        finally:
            self._opening = False
        await asyncio.to_thread(self.history.open)
        await self.scene.open(self.dispatcher, self.sockets)
        await self.parts.open()
        self.dispatcher.freshness.time.simulated = self.robot.profile.simulated
        self.pilots.start()
        for work in (self._beat, *(part.run for part in self.parts)):
            self.keep(work())

    def shut_down_soon(self) -> None:
        """From a signal handler or any thread: the console is about to end."""
        self.robot.leave_soon()
        self._call(self.shut_down)

    def shut_down(self) -> None:
        """End the console: the robot stands, every socket is closed with a reason, nothing more is opened."""
        if self.over:
            return
        self.over = True
        self.dispatcher.close()
        self.sockets.close_all("The console is ending.")
        if self._opening:
            self.keep(asyncio.to_thread(self.robot.close))

    async def close(self) -> None:
        self.shut_down()
        await self._tasks.end()
        with contextlib.suppress(BeckonError):
            await self.login_keeper.settle()
        await self.pilots.close()
        await self.parts.close()
        await asyncio.to_thread(self.robot.close)
        await self.scene.close()
        await asyncio.to_thread(self.history.close)

    # state

    def state(self) -> messages.State | None:
        """The newest state, or None before the first frame."""
        if self.snapshot is None:
            return None
        now = time.monotonic()
        self._seq += 1
        self.state_times.note(self._seq, now)
        return state_message(self.snapshot, self._context, self._seq, now)

    @property
    def pace(self) -> PilotPace:
        return self.pilots.pace

    async def ask(self, request: RobotRequest[AnswerT]) -> AnswerT:
        """A request to the driver, waited for outside the event loop."""
        return await asyncio.to_thread(self.robot.ask, request)

    def _part_failed(self, fault: BaseException) -> None:
        self.failure = f"A part of the console failed ({type(fault).__name__}). Restart the console."
        self.notifications.tell("error", self.failure)

    # the pilot

    def _start_pilot(self) -> PilotThread:
        self.dispatcher.pilot = None
        pilot = self._make_pilot()
        pilot.look_through(self.parts.calibrated(self.robot.profile))
        self.equip(pilot)
        thread = PilotThread(
            self.robot,
            pilot,
            self.dispatcher.setpoint_sender,
            publish=self._published,
            failed=partial(self._call, self.pilots.bury),
            deaf=self.parts[RobotVoice].deaf,
        )
        thread.start()
        self.dispatcher.pilot = pilot
        return thread

    def equip(self, pilot: Pilot | None = None) -> None:
        """Give a pilot, or the one that steers now, what it needs of every part."""
        if pilot is None and self.pilots.thread is not None:
            pilot = self.pilots.thread.pilot
        if pilot is not None:
            for part in self.parts:
                part.equip(pilot)

    def _adopted(self, settings: Settings) -> None:
        for part in self.parts:
            part.adopt(settings)
        self.equip()

    def _pilot_failed(self) -> None:
        self.dispatcher.pilot = None
        self.dispatcher.ended_without_pilot("The pilot failed; the robot was stopped.")
        self._nothing_under_way()

    def _leave_out(self, fault: str) -> list[str]:
        """Use no calibration any more → the files that were in use until now."""
        why = f"The pilot failed ({fault}) within seconds of using it."
        return [file for part in self.parts for file in part.leave_out(why)]

    def _published(self, snapshot: Snapshot, frame: SensorFrame) -> None:
        picture = self.camera_stream.encoded(frame.image, self._state_pace.saw(snapshot))
        self.scene.show(snapshot)
        self._call(self._on_snapshot, snapshot, picture, frame)

    def _recalibrated(self) -> None:
        """A calibration was accepted or taken back: used from the next frame on."""
        if (thread := self.pilots.thread) is not None:
            self.pilots.recalibrated()
            thread.pilot.look_through(self.parts.calibrated(self.robot.profile))

    def _call(self, act: Callable[..., None], *given: Any) -> None:
        if self._loop is not None and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(act, *given)

    def _on_snapshot(self, snapshot: Snapshot, picture: Picture | None, frame: SensorFrame) -> None:
        self._look_for_sleep()
        if not (self.over or self._state_pace.at_rest):  # at rest those of the tick are enough
            self.robot.beat()  # the loop runs and the pilot steps: that is what the gate wants to know
        self.robot.rest(self._state_pace.at_rest and not self.broadcaster.viewers)
        self.snapshot = snapshot
        for part in self.parts:
            part.on_snapshot(snapshot, frame)
        self.notifications.adopt(snapshot.notices, snapshot.stamp)
        self.dispatcher.ended(snapshot.endings)
        if picture is not None:
            self.camera_stream.show(picture)
        self._tell_state(time.monotonic())

    def _tell_state(self, now: float, later: float = 0.0) -> None:
        """Send the state if it is due, as `StatePace.due`, and a viewer wants it."""
        if not self.broadcaster.watched("state") or not self._state_pace.due(now, self._context.situation, later):
            return
        self._state_pace.sent(now, self._context.situation)
        if (state := self.state()) is not None:
            self.broadcaster.publish("state", messages.encode(state).decode())

    # twenty times a second

    async def _beat(self) -> None:
        due = time.monotonic()
        while True:
            try:
                self._tick(time.monotonic())
            except Exception:
                log.exception("A tick failed")
            due = max(due + BEAT_S, time.monotonic() - BEAT_S)
            await asyncio.sleep(max(0.0, due - time.monotonic()))

    def _tick(self, now: float) -> None:
        self._look_for_sleep()
        if self.pilots.is_stepping and not self.over:
            self.robot.beat()
        self.dispatcher.tick(now)
        if self._link_monitor.look(hangs=self.pilots.hangs):
            self._nothing_under_way()
        for part in self.parts:
            part.tick(now)
        self._tell_state(now, BEAT_S)

    def sign_out(self, person: Person, why: str) -> None:
        """This person's login or key is over: they drive no more, and their sockets end."""
        self.dispatcher.forget(person)
        self.sockets.close_of(person, 1008, why)

    def _logins_unsaved(self, trouble: str) -> None:
        if trouble:
            self.notifications.tell("warning", trouble, "logins")
        else:
            self.notifications.tell("info", "Keys and logins can be saved again.", "logins")

    def _look_for_sleep(self) -> None:
        if self._sleep.woke():
            self.dispatcher.setpoint_sender.stop()
            self.dispatcher.cancel("failed", "The machine slept; the robot was stopped.")

    def _nothing_under_way(self) -> None:
        """The newest snapshot may stay the newest for long: commands that it shows as active have failed."""
        if self.snapshot is not None and self.snapshot.active_command is not None:
            self.snapshot = replace(self.snapshot, active_command=None, goal=None)
