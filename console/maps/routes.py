"""Routes: places in an order, with waits and actions, driven one after the other in an operator's name.

A route owns no motion of its own: each stop is a command like any other, through the one dispatcher, under the lease.
Whatever ends or pre-empts that command pauses or ends the route, and only a person lets it go on. What it does is
written down with every step: after a restart it stands as interrupted, and never moves by itself.
"""

import asyncio
import json
import logging
import re
import time
from collections.abc import Callable
from pathlib import Path
from typing import Literal

import cv2
import msgspec

from console.access.logins import Person
from console.control.dispatcher import VIEWERS_WATCH, CommandDispatcher
from console.control.history import History
from console.control.lease import Lease
from console.control.notices import Notifications
from console.http.problems import Problem
from console.maps.marks import MapMarks, RouteMark, RouteStop, renamed
from console.maps.places import PlaceService
from console.maps.service import MapService
from console.maps.store import checked_name, key_of, slug
from console.part import Part
from console.recording.recorder import RecorderService
from console.speech.robot_voice import RobotVoice
from console.workers.tasks import HeldTasks
from core.commands.come_here import COME_HERE
from core.commands.command import Command
from core.commands.routes import PAUSE_ROUTE, RESUME_ROUTE, START_ROUTE
from core.commands.stop_at import command_to
from core.errors import BadInput, BeckonError
from core.files import write_atomic
from core.geometry import Pose
from core.message import Array
from core.sensors import Image, SensorFrame
from core.sentences import Statement, code_of, plain
from core.snapshot import Ending, Snapshot

log = logging.getLogger(__name__)

RouteState = Literal["idle", "driving", "waiting", "paused", "ended"]

SOURCE = "route"
MAX_ROUTES, MAX_STOPS = 100, 100
MAX_WAIT_S = 3600.0
MAX_PICTURE_AGE_S = 1.0  # of one that is kept, by the robot's clock, either way: it may have begun again
BLOCKED_WAIT_S = 10.0  # until a way that was blocked is tried again
MAX_TRIES = 3  # to reach one stop
LOW_BATTERY = 0.2  # share of its charge
FILE = "route.json"  # in the data folder: what the running route does
MAX_NOTES = 200  # that are kept of what happened at stops
PICTURE_FOLDER = "pictures"  # in the data folder: those that were taken at stops
MIN_RECORD_S, MAX_SAID_LETTERS = 1.0, 280
SAID = "say"  # cause of a notice that a browser with spoken answers says aloud
SPEECH_START_S = 2.0  # until such a browser has begun
DAY_S = 86_400
HOUR_FORM = re.compile(r"(?:[01]\d|2[0-3]):[0-5]\d")
NONE_RUNS = Statement("routes.none_runs")
BUSY = Statement("routes.busy")
LOST = Statement("routes.lost")
LOW = Statement("routes.low")
EXPECTED_ENDS = ("routes.done", "routes.paused", "routes.stopped")  # what a person asked for is no warning
NEVER_AGAIN = "pilot."
"""Begin of the codes of ends after which the way is not tried again: a touch, or the robot is lost or blind."""


class RouteNote(msgspec.Struct, frozen=True):
    """An event at a stop."""

    at_s: float  # Unix time
    stop: int  # from 1
    place: str
    state: str  # done, skipped or failed
    remark: str  # a sentence; "": it was reached
    picture: str = ""  # name of the one that was taken


class RouteRun(msgspec.Struct):
    """A route under way, with its own copy of the stops."""

    route: RouteMark
    owner: Person
    unattended: bool  # it goes on without a sign of life of its owner
    stop: int = 0  # index of the stop that is driven to, or stood at
    rounds: int = 0
    state: RouteState = "driving"
    reason: str = ""  # a sentence: why it stands, or ended
    tries: int = 0  # to reach this stop
    acts: bool = False  # the command under way is the stop's action
    command: int | None = None  # id of the command under way
    until: float = 0.0  # [s] monotonic: end of a wait
    rests: bool = False  # it waits for the time of its next round
    round_at: float = 0.0  # [s] Unix time: when this round began
    skipped: int = 0
    notes: list[RouteNote] = []  # the newest MAX_NOTES of all rounds

    @property
    def here(self) -> RouteStop:
        """The stop that is driven to, or stood at."""
        return self.route.stops[self.stop]


class RouteService(Part):
    """Lives on the event loop."""

    def __init__(
        self,
        home: Path,
        maps: MapService,
        places: PlaceService,
        dispatcher: CommandDispatcher,
        lease: Lease,
        history: History,
        notifications: Notifications,
        voice: RobotVoice,
    ) -> None:
        self.run_now: RouteRun | None = None
        self._file = home / FILE
        self._maps, self._places, self._dispatcher, self._lease = maps, places, dispatcher, lease
        self._history, self._notifications, self._voice = history, notifications, voice
        # called with what happened at a stop, and how it ended
        self.when_noted: list[Callable[[str, str], None]] = []
        self.pictures = home / PICTURE_FOLDER
        self.recorder: RecorderService | None = None
        self.clock = time.time  # [s] Unix time
        self._picture: tuple[Image, Pose] | None = None  # the newest, and where the robot was
        self._stamp = 0.0  # [s] robot clock of the newest snapshot
        self._unwritten = ""  # what the route does, for its file
        self._writing: asyncio.Task[None] | None = None
        self._tasks = HeldTasks()
        self._own = False  # this service itself gives a command now
        self._battery: float | None = None
        self._trouble: str | None = None  # why the base could not be driven, at the last time that it could not
        dispatcher.when_cancelled.append(self._cancelled)
        places.when_renamed.append(self._renamed)
        dispatcher.handlers |= {
            START_ROUTE.name: lambda command, who: self.start(command.place, who, unattended=False),
            PAUSE_ROUTE.name: lambda _, who: self._pause_or_stop(who),
            RESUME_ROUTE.name: lambda _, who: self.resume(who),
        }

    async def open(self) -> None:
        """Read what a console before this one was doing: it stands as interrupted."""
        try:
            found = msgspec.convert(json.loads(self._file.read_bytes()), RouteRun)
        except (OSError, ValueError, RecursionError, msgspec.ValidationError):
            return
        if not 0 <= found.stop < len(found.route.stops):  # by another's hand: there is no such stop to show
            return
        if found.state not in ("idle", "ended"):
            found.state, found.command = "ended", None
            found.reason = Statement("routes.restarted")
        self.run_now = found

    async def close(self) -> None:
        """Wait until it is written down what became of the route."""
        if self._writing is not None:
            await self._writing

    # routes of the map

    @property
    def routes(self) -> tuple[RouteMark, ...]:
        return self._maps.marks.routes

    def find(self, name: str) -> RouteMark:
        """The route of this name. Raises Problem 404."""
        found = next((one for one in self.routes if key_of(one.name) == key_of(name)), None)
        if found is None:
            raise Problem(404, Statement("routes.gone"))
        return found

    async def add(self, route: RouteMark, who: Person, *, replace: bool) -> RouteMark:
        """Keep a route. Raises BadInput, Problem 404, 409, 503, Unwritable."""
        checked = self._checked(route)

        def change(marks: MapMarks) -> MapMarks:
            others = tuple(one for one in marks.routes if key_of(one.name) != key_of(checked.name))
            if len(others) < len(marks.routes) and not replace:
                raise Problem(409, Statement("routes.taken"))
            if len(others) >= MAX_ROUTES:
                raise Problem(409, Statement("routes.full", most=MAX_ROUTES))
            return msgspec.structs.replace(marks, routes=(*others, checked))

        await self._maps.mark(change, f"route {checked.name}", who)
        return checked

    async def remove(self, name: str, who: Person) -> None:
        """Remove a route; one that runs goes on with its own copy. Raises Problem 404, 503, Unwritable."""
        gone = self.find(name)
        await self._maps.mark(lambda marks: marks.without("routes", gone.name), f"route {gone.name} removed", who)

    # the route under way

    def start(self, name: str, who: Person, *, unattended: bool) -> RouteRun:
        """Start a route from its first stop. Raises Problem 403 to 503."""
        if self.run_now is not None and self.run_now.state not in ("idle", "ended"):
            raise Problem(409, BUSY)
        route = self.find(name)
        for stop in route.stops:
            try:
                self._places.find(stop.place)
            except Problem:
                raise Problem(404, Statement("routes.no_place", name=stop.place)) from None
        if self._is_low:
            raise Problem(409, LOW)
        run = RouteRun(route, who, unattended)
        if (rest := self._rest(run)) > 0.0:
            self._dispatcher.admit_waiting(who)
            self.run_now = run
            self._wait_for_round(run, rest)
        else:
            run.round_at = self.clock()
            self._drive(run)
            self.run_now = run
        self._keep()
        self._history.add("route", who, words=f"start {route.name}")
        return run

    def pause(self, who: Person) -> RouteRun:
        """Stand, and wait for `resume`. Raises Problem 403, 409."""
        run = self._running(who)
        if run.state != "paused":
            self._stand(run, "paused", Statement("routes.paused", who=who.name))
        return run

    def resume(self, who: Person) -> RouteRun:
        """Go on at the stop where it stands, in this person's name. Raises Problem 403, 409, 503."""
        run = self._running(who)
        if run.state == "waiting" and run.rests:
            self._lease.check_not_anothers(who)
            self._try_again(run)
        elif run.state == "waiting" and run.here.action == "wait_for_continue":
            self._lease.check_not_anothers(who)
            self._next(run)
        elif run.state == "paused":
            if self._is_low:
                raise Problem(409, LOW)
            before, run.owner, run.tries, run.acts = run.owner, who, 0, False
            try:
                self._drive(run)
            except Problem:
                run.owner = before
                raise
        else:
            raise Problem(409, Statement("routes.not_paused"))
        self._history.add("route", who, words=f"resume {run.route.name}")
        self._keep()
        return run

    def skip(self, who: Person) -> RouteRun:
        """Leave out the stop that is driven to or stood at. Raises Problem 403, 409, 503; 409 between two rounds."""
        run = self._running(who)
        self._lease.check_not_anothers(who)
        if run.rests:
            raise Problem(409, Statement("routes.rests"))
        paused = run.state == "paused"
        self._end_command(Statement("routes.skipped", who=who.name))
        self._note(run, "skipped", Statement("routes.skipped", who=who.name))
        run.skipped += 1
        self._next(run, stand=paused)
        return run

    def stop(self, who: Person) -> RouteRun:
        """End the route; anybody signed in may. Raises Problem 409."""
        run = self.run_now
        if run is None or run.state in ("idle", "ended"):
            raise Problem(409, NONE_RUNS)
        self._stand(run, "ended", Statement("routes.stopped", who=who.name))
        return run

    # what happens by itself

    def on_snapshot(self, snapshot: Snapshot, frame: SensorFrame) -> None:
        """A robot that lost its place drives no route."""
        self._battery, self._trouble = snapshot.battery, frame.trouble or self._trouble
        self._stamp = snapshot.stamp
        if frame.image is not None:
            self._picture = frame.image, snapshot.estimate.pose
        run = self.run_now
        if run is not None and run.state in ("driving", "waiting") and snapshot.floor.lost is not None:
            self._stand(run, "paused", LOST)

    def tick(self, now: float) -> None:
        run = self.run_now
        if run is None or run.state not in ("driving", "waiting"):
            return
        if run.unattended and self._lease.held_by(run.owner):
            self._lease.active(run.owner, now)
        if run.state == "driving" and run.command is not None:
            self._look_at_command(run, now)
        elif run.state == "driving" and now >= run.until:
            self._try_again(run)
        elif run.state == "waiting" and run.rests:
            if self._rest(run) == 0.0:  # by the clock, which goes on while the computer sleeps, and may be set
                self._try_again(run)
        elif run.state == "waiting" and now >= run.until and not self._is_held(run):
            self._next(run)

    def _is_held(self, run: RouteRun) -> bool:
        """Return whether it waits for a person, or for its own words: it hears no STOP while it speaks."""
        action = run.here.action
        return action == "wait_for_continue" or (action == "say" and self._voice.muted)

    def _look_at_command(self, run: RouteRun, now: float) -> None:
        if self._dispatcher.obeys(run.command or 0):
            run.reason = ""  # what was to pre-empt it was refused
        entry = self._history.find(run.command or 0)
        if entry is None or entry.state == "running":
            return
        run.command = None
        if run.reason:
            self._stand(run, "paused", run.reason)
        elif entry.state == "done":
            self._arrived(run)
        elif entry.remark == self._trouble or (code_of(entry.remark).code or "").startswith(NEVER_AGAIN):
            self._stand(run, "paused", entry.remark)
        else:
            self._blocked(run, entry.remark, now)

    def _arrived(self, run: RouteRun) -> None:
        self._note(run, "done", "")
        if self._is_low:
            self._stand(run, "paused", LOW)
        elif run.here.action == "come_here" and not run.acts:
            self._come_here(run)
        else:
            self._act(run)
            self._wait(run)

    def _act(self, run: RouteRun) -> None:
        """Say, take a picture, record: what needs no motion and is not waited for."""
        stop = run.here
        if stop.action == "say":
            self._notifications.tell("info", stop.text, f"{SAID} {self.clock()}")
            self._note(run, "done", Statement("routes.said", text=stop.text))
        elif stop.action == "take_a_picture":
            self._tasks.start(self._take_picture(run, stop))
        elif stop.action == "record":
            self._tasks.start(self._record(run, max(MIN_RECORD_S, stop.wait_s)))

    async def _take_picture(self, run: RouteRun, stop: RouteStop) -> None:
        """The newest picture as a JPEG, with where and when it was taken in its comment."""
        if self._picture is None or abs(self._stamp - self._picture[0].stamp) > MAX_PICTURE_AGE_S:
            self._note(run, "failed", Statement("routes.no_camera"))
            return
        (image, pose), at, now = self._picture, run.stop, self.clock()
        when = time.strftime("%Y%m%d-%H%M%S", time.localtime(now))
        name = f"{slug(run.route.name, 'route')}-{when}-{at + 1}.jpg"
        facts = {
            "route": run.route.name,
            "round": run.rounds + 1,
            "stop": at + 1,
            "place": stop.place,
            "unix_s": round(now, 3),
            "robot_s": round(image.stamp, 3),
            "pose": [round(pose.x, 3), round(pose.y, 3), round(pose.heading, 4)],
            "map": self._maps.shown.name,
        }
        try:
            content = await asyncio.to_thread(commented_jpeg, image.pixels, json.dumps(facts))
            await asyncio.to_thread(write_atomic, self.pictures / name, content)
        except OSError as trouble:
            self._note(run, "failed", Statement("routes.no_picture", why=trouble.strerror or str(trouble)), at)
            return
        self._note(run, "done", Statement("routes.picture", name=name), at, name)

    async def _record(self, run: RouteRun, seconds: float) -> None:
        if self.recorder is None:
            return
        at = run.stop
        try:
            state = await self.recorder.start(None, f"{run.route.name}: {run.here.place}", run.owner)
            self._note(run, "done", Statement("routes.records", name=state.name), at)
            await asyncio.sleep(seconds)
            await self.recorder.stop_own(state.name or "", run.owner)
        except (Problem, BeckonError) as trouble:
            words = trouble.detail if isinstance(trouble, Problem) else str(trouble)
            self._note(run, "failed", words, at)

    # rounds by the clock

    def _rest(self, run: RouteRun) -> float:
        """How long [s] until its next round may begin."""
        route, now = run.route, self.clock()
        run.round_at = min(run.round_at, now)  # the clock was set back
        soonest = run.round_at + 60.0 * route.every_min if run.round_at else now
        return max(0.0, seconds_until_open(route.begins, route.ends, max(now, soonest)) + max(0.0, soonest - now))

    def _wait_for_round(self, run: RouteRun, seconds: float) -> None:
        when = time.strftime("%H:%M", time.localtime(self.clock() + seconds))
        run.state, run.rests = "waiting", True
        run.reason = Statement("routes.next_round", when=when)
        self._keep()

    def _come_here(self, run: RouteRun) -> None:
        """Go from the stop to who called last; who cannot be found is left alone."""
        run.acts = True
        try:
            self._give(run, Command(name=COME_HERE.name, numbers={}, heard_as=COME_HERE.words[0]))
        except Problem as problem:
            self._note(run, "failed", problem.detail)
            self._wait(run)

    def _wait(self, run: RouteRun) -> None:
        least = SPEECH_START_S if run.here.action == "say" else 0.0
        run.state, run.until = "waiting", time.monotonic() + max(least, run.here.wait_s)
        run.reason = Statement("routes.waits") if run.here.action == "wait_for_continue" else ""
        self._keep()

    def _next(self, run: RouteRun, *, stand: bool = False) -> None:
        run.stop, run.tries, run.acts = run.stop + 1, 0, False
        if run.stop == len(run.route.stops):
            run.rounds += 1
            if not run.route.loop:
                run.stop -= 1
                self._stand(run, "ended", Statement("routes.done") if not run.skipped else Statement("routes.over"))
                return
            run.stop = 0
            if not stand and (rest := self._rest(run)) > 0.0:
                self._wait_for_round(run, rest)
                return
            run.round_at = self.clock()
        if stand:
            run.reason = Statement("routes.before_next")
            self._keep()
            return
        self._try_again(run)

    def _try_again(self, run: RouteRun) -> None:
        try:
            self._drive(run)
        except Problem as problem:
            self._stand(run, "paused", problem.detail)
        self._keep()

    def _drive(self, run: RouteRun) -> None:
        """Give the command to the present stop. Raises Problem."""
        self._give(run, command_to(self._places.find(run.here.place)))

    def _give(self, run: RouteRun, command: Command) -> None:
        self._own = True
        try:
            entry = self._dispatcher.dispatch(command, SOURCE, run.owner)
        finally:
            self._own = False
        if run.rests:
            run.rests, run.round_at = False, self.clock()
        run.command, run.state, run.reason = entry.id, "driving", ""

    def _blocked(self, run: RouteRun, why: str, now: float) -> None:
        """The stop was not reached: try again after a while, then leave it out on a round, else end."""
        if run.acts:
            self._note(run, "failed", why)
            self._wait(run)
            return
        run.tries += 1
        if run.tries < MAX_TRIES:
            run.until, run.reason = now + BLOCKED_WAIT_S, Statement("routes.again", why=why)
            self._keep()
            return
        self._note(run, "failed", why)
        if run.route.loop:
            run.skipped += 1
            self._next(run)
        else:
            self._stand(run, "ended", why)

    def _renamed(self, names: dict[str, str]) -> None:
        """The copy of the route that runs follows new names of places."""
        if (run := self.run_now) is not None:
            run.route = renamed(run.route, run.route.name, names)

    def _cancelled(self, state: Ending, why: str, _: bool) -> None:
        """A command, or whatever was under way, was ended by a person, the gate, or the lease."""
        run = self.run_now
        if self._own or run is None or run.state not in ("driving", "waiting"):
            return
        run.reason = why
        if state == "pre-empted" and run.command is not None:
            return  # it goes on where the pilot refuses the newer one: see `_look_at_command`
        run.command = None
        run.state = "ended" if state == "failed" else "paused"
        self._report(run)

    # steps of the above

    @property
    def _is_low(self) -> bool:
        return self._battery is not None and self._battery < LOW_BATTERY

    def _running(self, who: Person) -> RouteRun:
        run = self.run_now
        if run is None or run.state in ("idle", "ended"):
            raise Problem(409, NONE_RUNS)
        if not who.may("operator"):
            raise Problem(403, VIEWERS_WATCH)
        return run

    def _pause_or_stop(self, who: Person) -> None:
        """Pause by words; what else moves the robot, or is about to, stops, as it does without routes."""
        if who.may("operator") and self.run_now is not None and self.run_now.state in ("driving", "waiting"):
            self.pause(who)
        self._dispatcher.stop(who, "words")

    def _stand(self, run: RouteRun, state: RouteState, why: str) -> None:
        """The robot stands; the route waits for a person, or is over."""
        run.state, run.reason = state, why
        self._end_command(why)
        run.command = None
        self._report(run)

    def _end_command(self, why: str) -> None:
        if self.run_now is not None and self.run_now.command is not None:
            self._own = True
            try:
                self._dispatcher.cancel("cancelled", why)
            finally:
                self._own = False
            self.run_now.command = None

    def _report(self, run: RouteRun) -> None:
        words = f"{run.state} {run.route.name} at stop {run.stop + 1} of {len(run.route.stops)}"
        self._history.add("route", run.owner, words=words, remark=run.reason)
        level = "info" if code_of(run.reason).code in EXPECTED_ENDS else "warning"
        self._notifications.tell(level, Statement("routes.tells", name=run.route.name, why=run.reason), "route")
        self._keep()

    def _note(self, run: RouteRun, state: str, remark: str, at: int | None = None, picture: str = "") -> None:
        """Write down what happened at a stop; `at`: its index, where the route may have gone on."""
        at = run.stop if at is None else at
        note = RouteNote(round(self.clock(), 3), at + 1, run.route.stops[at].place, state, remark, picture)
        run.notes = [*run.notes, note][-MAX_NOTES:]
        self._keep()
        words = f"{run.route.name}: stop {at + 1} of {len(run.route.stops)}, {run.route.stops[at].place}"
        for tell in self.when_noted:
            tell(words, remark or state)
        self._history.add(
            "route", run.owner, state=state if state != "skipped" else "done", words=words, remark=remark
        )

    def _keep(self) -> None:
        """Write down what it does, in a thread and the newest only; a disk that refuses ends no route."""
        if self.run_now is None:
            return
        self._unwritten = json.dumps(msgspec.to_builtins(self.run_now, enc_hook=plain))
        if self._writing is None:
            self._writing = asyncio.get_running_loop().create_task(self._write())

    async def _write(self) -> None:
        while self._unwritten:
            content, self._unwritten = self._unwritten, ""
            try:
                await asyncio.to_thread(write_atomic, self._file, content)
            except OSError as trouble:
                log.warning("What the route does cannot be written down: %s", trouble)
        self._writing = None

    def _checked(self, route: RouteMark) -> RouteMark:
        """A route as it is kept. Raises BadInput, Problem 404."""
        if not 1 <= len(route.stops) <= MAX_STOPS:
            raise BadInput(Statement("routes.stops", most=MAX_STOPS))
        stops: list[RouteStop] = []
        for stop in route.stops:
            if not 0.0 <= stop.wait_s <= MAX_WAIT_S:
                raise BadInput(Statement("routes.wait", most=f"{MAX_WAIT_S:g}"))
            if stop.action == "say" and not 0 < len(stop.text) <= MAX_SAID_LETTERS:
                raise BadInput(Statement("routes.text", most=MAX_SAID_LETTERS))
            stops.append(msgspec.structs.replace(stop, place=self._places.find(stop.place).name))
        if (route.begins or route.ends or route.every_min) and not route.loop:
            raise BadInput(Statement("routes.hours_of_rounds"))
        hours = (route.begins, route.ends)
        if bool(route.begins) != bool(route.ends) or not all(HOUR_FORM.fullmatch(one or "00:00") for one in hours):
            raise BadInput(Statement("routes.hours"))
        if route.begins and route.begins == route.ends:
            raise BadInput(Statement("routes.no_hours", hour=route.begins))
        if (
            route.loop
            and not route.every_min
            and {(one.place, one.wait_s, one.action) for one in stops} == {(stops[0].place, 0.0, None)}
        ):
            raise BadInput(Statement("routes.turns_on_the_spot", name=stops[0].place))
        return msgspec.structs.replace(route, name=checked_name(route.name), stops=tuple(stops))


def seconds_until_open(begins: str, ends: str, now: float) -> float:
    """How long [s] from `now` [s] Unix time until the clock is between two hours, "HH:MM", over midnight too."""
    if not begins:
        return 0.0
    local = time.localtime(now)
    seconds = 3600 * local.tm_hour + 60 * local.tm_min + local.tm_sec
    first, last = (60 * (60 * int(one[:2]) + int(one[3:])) for one in (begins, ends))
    is_open = first <= seconds < last if first < last else seconds >= first or seconds < last
    return 0.0 if is_open else float((first - seconds) % DAY_S)


def commented_jpeg(pixels: Array, comment: str) -> bytes:
    """Pixels (H, W, 3), blue first → JPEG with a comment."""
    packed = cv2.imencode(".jpg", pixels)[1].tobytes()
    text = comment.encode()
    return packed[:2] + b"\xff\xfe" + (len(text) + 2).to_bytes(2, "big") + text + packed[2:]
