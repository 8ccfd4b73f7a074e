"""Routes: places in an order, with waits and actions, driven one after the other in an operator's name.

A route owns no motion of its own: each stop is a command like any other, through the one dispatcher, under the lease.
Whatever ends or pre-empts that command pauses or ends the route, and only a person lets it go on. What it does is
written down with every step: after a restart it stands as interrupted, and never moves by itself.
"""

from __future__ import annotations

import json
import logging
import time
from pathlib import Path
from typing import Literal

import msgspec

from console.access.logins import Person
from console.control.dispatcher import VIEWERS_WATCH, CommandDispatcher
from console.control.history import History
from console.control.lease import Lease
from console.control.notices import Notifications
from console.http.problems import Problem
from console.maps.marks import MapMarks, RouteMark, RouteStop
from console.maps.places import PlaceService
from console.maps.service import MapService
from console.maps.store import checked_name, key_of
from console.part import Part
from core.commands.come_here import COME_HERE
from core.commands.command import Command
from core.commands.stop_at import command_to
from core.errors import BadInput
from core.files import write_atomic
from core.pilot.pilot import AGAIN, BLIND, NO_ODOMETRY
from core.sensors import SensorFrame
from core.sentences import Statement, plain
from core.snapshot import Ending, Snapshot

log = logging.getLogger(__name__)

RouteState = Literal["idle", "driving", "waiting", "paused", "ended"]

SOURCE = "route"
MAX_ROUTES, MAX_STOPS = 100, 100
MAX_WAIT_S = 3600.0
BLOCKED_WAIT_S = 10.0  # until a way that was blocked is tried again
MAX_TRIES = 3  # to reach one stop
LOW_BATTERY = 0.2  # share of its charge
FILE = "route.json"  # in the data folder: what the running route does
NO_SUCH_ROUTE = Statement("routes.gone")
NONE_RUNS = Statement("routes.none_runs")
BUSY = Statement("routes.busy")
LOST = Statement("routes.lost")
LOW = Statement("routes.low")
DONE = Statement("routes.done")
NEVER_AGAIN = frozenset((AGAIN, NO_ODOMETRY, BLIND))
"""Ends of a command after which the way is not tried again: the robot does not know where it is."""


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
    skipped: int = 0

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
    ) -> None:
        self.run_now: RouteRun | None = None
        self._file = home / FILE
        self._maps, self._places, self._dispatcher, self._lease = maps, places, dispatcher, lease
        self._history, self._notifications = history, notifications
        self._own = False  # this service itself gives a command now
        self._battery: float | None = None
        dispatcher.when_cancelled.append(self._cancelled)

    async def open(self) -> None:
        """Read what a console before this one was doing: it stands as interrupted."""
        try:
            found = msgspec.convert(json.loads(self._file.read_bytes()), RouteRun)
        except (OSError, ValueError, msgspec.ValidationError):
            return
        if found.state not in ("idle", "ended"):
            found.state, found.command = "ended", None
            found.reason = Statement("routes.restarted")
        self.run_now = found

    # routes of the map

    @property
    def routes(self) -> tuple[RouteMark, ...]:
        """Those of the map in use."""
        return self._maps.marks.routes

    def find(self, name: str) -> RouteMark:
        """The route of this name. Raises Problem 404."""
        found = next((one for one in self.routes if key_of(one.name) == key_of(name)), None)
        if found is None:
            raise Problem(404, NO_SUCH_ROUTE)
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

        def change(marks: MapMarks) -> MapMarks:
            return msgspec.structs.replace(marks, routes=tuple(one for one in marks.routes if one.name != gone.name))

        await self._maps.mark(change, f"route {gone.name} removed", who)

    # the route under way

    def start(self, name: str, who: Person, *, unattended: bool) -> RouteRun:
        """Start a route from its first stop. Raises Problem 403 to 503."""
        if self.run_now is not None and self.run_now.state not in ("idle", "ended"):
            raise Problem(409, BUSY)
        route = self.find(name)
        for stop in route.stops:
            self._places.find(stop.place)
        if self._is_low:
            raise Problem(409, LOW)
        run = RouteRun(route, who, unattended)
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
        if run.state == "waiting" and run.here.action == "wait_for_continue":
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
        """Leave out the stop that is driven to or stood at. Raises Problem 403, 409, 503."""
        run = self._running(who)
        self._lease.check_not_anothers(who)
        paused = run.state == "paused"
        self._end_command("cancelled", Statement("routes.skipped", who=who.name))
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
        self._battery = snapshot.battery
        run = self.run_now
        if run is not None and run.state in ("driving", "waiting") and snapshot.floor.lost is not None:
            self._stand(run, "paused", LOST)

    def tick(self, now: float) -> None:
        """Look how the present stop goes."""
        run = self.run_now
        if run is None or run.state not in ("driving", "waiting"):
            return
        if run.unattended and self._lease.held_by(run.owner):
            self._lease.active(run.owner, now)
        if run.state == "driving" and run.command is not None:
            self._look_at_command(run, now)
        elif run.state == "driving" and now >= run.until:
            self._try_again(run)
        elif run.state == "waiting" and run.here.action != "wait_for_continue" and now >= run.until:
            self._next(run)

    def _look_at_command(self, run: RouteRun, now: float) -> None:
        entry = self._history.find(run.command or 0)
        if entry is None or entry.state == "running":
            return
        run.command = None
        if entry.state == "done":
            self._arrived(run)
        elif entry.remark in NEVER_AGAIN:
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
            self._wait(run)

    def _come_here(self, run: RouteRun) -> None:
        """Go from the stop to who called last; who cannot be found is left alone."""
        run.acts = True
        try:
            self._give(run, Command(name=COME_HERE.name, numbers={}, heard_as=COME_HERE.words[0]))
        except Problem as problem:
            self._note(run, "failed", problem.detail)
            self._wait(run)

    def _wait(self, run: RouteRun) -> None:
        run.state, run.until = "waiting", time.monotonic() + run.here.wait_s
        run.reason = Statement("routes.waits") if run.here.action == "wait_for_continue" else ""
        self._keep()

    def _next(self, run: RouteRun, *, stand: bool = False) -> None:
        """Go to the next stop, or round again, or end."""
        run.stop, run.tries, run.acts = run.stop + 1, 0, False
        if run.stop == len(run.route.stops):
            run.rounds += 1
            if not run.route.loop:
                run.stop -= 1
                self._stand(run, "ended", DONE if not run.skipped else Statement("routes.over"))
                return
            run.stop = 0
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

    def _cancelled(self, state: Ending, why: str, _: bool) -> None:
        """A command, or whatever was under way, was ended by a person, the gate, or the lease."""
        run = self.run_now
        if self._own or run is None or run.state not in ("driving", "waiting"):
            return
        run.command = None
        run.state, run.reason = ("ended" if state == "failed" else "paused"), why
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

    def _stand(self, run: RouteRun, state: RouteState, why: str) -> None:
        """The robot stands; the route waits for a person, or is over."""
        run.state, run.reason = state, why
        self._end_command("cancelled", why)
        run.command = None
        self._report(run)

    def _end_command(self, state: Ending, why: str) -> None:
        if self.run_now is not None and self.run_now.command is not None:
            self._own = True
            try:
                self._dispatcher.cancel(state, why)
            finally:
                self._own = False
            self.run_now.command = None

    def _report(self, run: RouteRun) -> None:
        words = f"{run.state} {run.route.name} at stop {run.stop + 1} of {len(run.route.stops)}"
        self._history.add("route", run.owner, words=words, remark=run.reason)
        level = "info" if run.reason == DONE else "warning"
        self._notifications.tell(level, f"Route “{run.route.name}”: {run.reason}", "route")
        self._keep()

    def _note(self, run: RouteRun, state: str, remark: str) -> None:
        """Write into the history how a stop ended."""
        words = f"{run.route.name}: stop {run.stop + 1} of {len(run.route.stops)}, {run.here.place}"
        self._history.add(
            "route", run.owner, state=state if state != "skipped" else "done", words=words, remark=remark
        )

    def _keep(self) -> None:
        """Write down what it does; a disk that refuses ends no route."""
        if self.run_now is None:
            return
        try:
            write_atomic(self._file, json.dumps(msgspec.to_builtins(self.run_now, enc_hook=plain)))
        except OSError as trouble:
            log.warning("What the route does cannot be written down: %s", trouble)

    def _checked(self, route: RouteMark) -> RouteMark:
        """A route as it is kept. Raises BadInput, Problem 404."""
        if not 1 <= len(route.stops) <= MAX_STOPS:
            raise BadInput(Statement("routes.stops", most=MAX_STOPS))
        stops: list[RouteStop] = []
        for stop in route.stops:
            if not 0.0 <= stop.wait_s <= MAX_WAIT_S:
                raise BadInput(Statement("routes.wait", most=f"{MAX_WAIT_S:g}"))
            stops.append(msgspec.structs.replace(stop, place=self._places.find(stop.place).name))
        return RouteMark(checked_name(route.name), tuple(stops), route.loop)
