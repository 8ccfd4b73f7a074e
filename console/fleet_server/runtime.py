"""All behind the fleet's page: the router, who is signed in, and who may do what at which robot."""

import asyncio
import contextlib
import logging
import time
from pathlib import Path
from typing import Any

import msgspec

from console.access.guard import Access
from console.access.login_keeper import LoginKeeper
from console.access.logins import RANK, Person
from console.access.open_sockets import OpenSockets
from console.control.history import History
from console.control.lease import Lease
from console.fleet.authority import Authority
from console.fleet.bus import FleetAddress, FleetKeyAnswer, FleetRole
from console.fleet.router import FleetRouter
from console.workers.tasks import HeldTasks
from core.errors import BadInput, BeckonError
from core.files import locked, write_atomic
from core.sentences import Statement

log = logging.getLogger(__name__)

ROLES_FILE = "roles.json"
TICK_PERIOD_S = 0.5
MAX_HOLD_UP_S = 3.0  # of this process; what arrives after a longer one may have been said before it
BACKLOG_S = 1.0  # after a hold-up, within which what waited has come in

RobotRole = FleetRole | None  # None: not let in


class FleetRoles:
    """The role of a person at a robot, where it is another than the person's own. By the name of their key."""

    def __init__(self, folder: Path) -> None:
        self._path = folder / ROLES_FILE
        self._seen = 0.0
        self._table: dict[str, dict[str, RobotRole]] = {}

    def at(self, key: str, robot: str, own: FleetRole) -> RobotRole:
        """The role of who signed in by the key of this name, at this robot; the least of all where that is not known.

        Raises BadInput for a damaged file.
        """
        changed = self._path.stat().st_mtime if self._path.is_file() else 0.0
        if changed != self._seen:
            self._table, self._seen = self.read(), changed
        if key:
            return self._table.get(key, {}).get(robot, own)
        roles: list[RobotRole] = [own, *(row[robot] for row in self._table.values() if robot in row)]
        return min(roles, key=lambda role: RANK[role or "public"])

    def read(self) -> dict[str, dict[str, RobotRole]]:
        """All that is set. Raises BadInput for a damaged file."""
        try:
            return msgspec.json.decode(self._path.read_bytes(), type=dict[str, dict[str, RobotRole]])
        except FileNotFoundError:
            return {}
        except (OSError, msgspec.MsgspecError):
            raise BadInput(Statement("fleet.list_damaged", path=self._path)) from None

    def set(self, person: str, robot: str, role: RobotRole) -> None:
        """Let this person be so at this robot from now on. Raises BadInput, OSError."""
        with locked(self._path.with_suffix(".lock")):
            table = self.read()
            table.setdefault(person, {})[robot] = role
            write_atomic(self._path, msgspec.json.format(msgspec.json.encode(table)) + b"\n")


class FleetRuntime:
    """One per fleet; its methods run on the event loop. Login and links work on it as on a console's runtime."""

    def __init__(self, home: Path, access: Access, authority: Authority, listen: FleetAddress) -> None:
        self.access, self.sockets, self.lease = access, OpenSockets(), Lease()
        self.history = History(home, self._say)
        self.login_keeper = LoginKeeper(access.logins, self.sign_out, self._say)
        self.roles = FleetRoles(home)
        self.dispatcher = self  # who signs out has nothing under way here but keys
        self.over = False
        self.trouble = ""  # why it could not start
        self._authority, self._listen = authority, listen
        self._router: FleetRouter | None = None
        self._keys: dict[tuple[str, str], FleetKeyAnswer] = {}  # person, robot → key of its console
        self._tasks = HeldTasks(self._part_failed)
        self.failure = ""  # a sentence: a part of it has failed
        self._loop: asyncio.AbstractEventLoop | None = None
        self._ticked_at = time.monotonic()  # [s] when the loop ran last
        self._hold_up, self._back_at = 0.0, 0.0  # [s] that the newest hold-up took, and when it was over

    @property
    def router(self) -> FleetRouter:
        """The router; known after `open`."""
        assert self._router is not None
        return self._router

    async def open(self) -> None:
        """Bring up the router. Raises Unavailable, BadInput."""
        self._loop = asyncio.get_running_loop()
        self._router = FleetRouter(self._authority, self._listen)
        try:
            await self._router.open()
        except BeckonError as why:
            self.trouble = str(why)
            raise
        await asyncio.to_thread(self.history.open)
        for work in (self._router.run(), self.login_keeper.run(), self._tick()):
            self._tasks.start(work)

    async def close(self) -> None:
        """Let go of all: the robots go on."""
        self.shut_down()
        await self._tasks.end()
        with contextlib.suppress(BeckonError):
            await self.login_keeper.settle()
        if self._router is not None:
            await self._router.close()
        await asyncio.to_thread(self.history.close)

    def shut_down(self) -> None:
        if not self.over:
            self.over = True
            self.sockets.close_all("The fleet is ending.")

    def shut_down_soon(self) -> None:
        """From a signal handler or any thread."""
        if self._loop is not None and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self.shut_down)

    def forget(self, who: Person) -> None:
        self._keys = {at: key for at, key in self._keys.items() if at[0] != who.id}

    def sign_out(self, who: Person, why: str) -> None:
        """This person's login or key is over: so are the sockets to robots."""
        self.forget(who)
        self.sockets.close_of(who, 1008, why)

    @property
    def hold_up_s(self) -> float:
        """The seconds for which this process, stopped or starved, heard nothing until a moment ago; 0.0: it did."""
        now = time.monotonic()
        if now - self._ticked_at > MAX_HOLD_UP_S:
            return now - self._ticked_at
        return self._hold_up if now - self._back_at < BACKLOG_S else 0.0

    # people at robots

    def role_at(self, who: Person, robot: str) -> RobotRole:
        logins, key = self.access.logins, who.name  # a program is called as its key
        for login in logins.all_logins():
            if login.id == who.id:
                opener = (one.name for one in logins.all_keys() if one.digest == login.key)
                key = login.key_name or next(opener, "")
        return self.roles.at(key, robot, _role(who.role))

    async def key_of(self, who: Person, robot: str, *, renew: bool = False) -> FleetKeyAnswer | None:
        """A key of the robot's console for this person; None where the robot does not answer."""
        role = self.role_at(who, robot)
        at = (f"{who.id}", f"{robot}:{role}")
        if role is None:
            return None
        if renew or at not in self._keys:
            key = await self.router.console_key(robot, who.name, role)
            if key is None:
                return None
            self._keys[at] = key
        return self._keys[at]

    # steps of the above

    async def _tick(self) -> None:
        self._ticked_at = time.monotonic()
        while True:
            now = time.monotonic()
            if now - self._ticked_at > MAX_HOLD_UP_S:
                self._hold_up, self._back_at = now - self._ticked_at, now
                self.router.renew()
            self._ticked_at = now
            self.login_keeper.tick(now)
            await asyncio.sleep(TICK_PERIOD_S)

    def _part_failed(self, fault: BaseException) -> None:
        self.failure = f"A part of the fleet failed ({type(fault).__name__}). Restart the fleet."

    def _say(self, words: Any) -> None:
        if words:
            log.warning("%s", words)


def _role(role: str) -> FleetRole:
    return "admin" if role == "admin" else "operator" if role == "operator" else "viewer"
