"""Findings on the robot, or on another one that is looked at; robot files in the data folder."""

import asyncio
import re
import shlex
from collections.abc import Awaitable, Callable, Iterable, Sequence
from pathlib import Path
from typing import TypeVar
from urllib.parse import urlsplit

import msgspec
from msgspec import structs

from console.access.logins import Person
from console.connection.probe_worker import ProbeWorker
from console.connection.reach import Reach, inside
from console.http.problems import Problem
from console.maps.service import MapService
from console.maps.store import slug
from console.part import Part
from console.robot.supervisor import RobotSupervisor
from console.workers.worker import Worker, WorkerLost
from core.errors import BadInput, BeckonError, Refused, Unavailable
from core.files import saving, write_atomic
from core.recording import LogSettings
from core.robots.connect import OWN, SCHEMES, parts_of, split
from core.robots.connection import FoundRobot, ReadConnection, ReadRobotFile, describe
from core.robots.requests import SentSpeeds, SpeedsType, SwitchSpeeds
from core.robots.robot_file import RobotFile, TopicChoice, with_topics, without_lock
from core.sentences import Statement

ANSWER_S = 1.0  # [s]
PORT_SCHEMES = ("foxglove", "rosbridge", "zenoh", "srv1")  # those that have a port of their own
SERIAL_PATTERNS = (("serial", "ttyUSB*"), ("scip", "ttyACM*"))  # kind of device, and how its ports are called


def host_of(url: str) -> str:
    """The host that a URL names; "" where it names none."""
    try:
        return urlsplit(url).hostname or ""
    except ValueError:
        return ""


def serial_ports() -> list[str]:
    """The URLs of devices at this computer's serial ports, as far as their names say what they are."""
    return [f"{kind}://{path}" for kind, name in SERIAL_PATTERNS for path in sorted(Path("/dev").glob(name))]


async def answers(host: str, port: int) -> bool:
    """Return whether a connection opens within `ANSWER_S`."""
    try:
        async with asyncio.timeout(ANSWER_S):
            _, writer = await asyncio.open_connection(host, port)
    except (OSError, TimeoutError, UnicodeError):  # the last: no name service takes this name
        return False
    writer.close()
    return True


T = TypeVar("T")

LEAVING_DELAY_S = 0.2  # [s] in which the page gets its answer before the console starts again
PROBE_BUDGET_S = 10.0  # [s] of processor time of a probe
RECORDING_READ_S = 60.0  # [s] of processor time in which a recording is read
TOPICS = ("foxglove", "zenoh", "rosbridge")  # links to which a second client may connect
LONGEST_URL = 2000
FOLDER, RECORDINGS = "robots", "recordings"  # in the data folder
MAX_KNOCKS = 60  # addresses of one search
WORLDS = ("sim:lab", "sim:floor")
ROBOT_LOST = Statement("connect.not_looked_at")
RECORDING_LOST = Statement("connect.recording_lost")
REAL_ONLY = Statement("connect.no_file")


class WrittenFile(msgspec.Struct, frozen=True):
    """A robot file on the disk."""

    name: str  # "marvin.toml"
    path: str
    command: str  # that starts a console with it
    text: str


class FoundAddresses(msgspec.Struct, frozen=True):
    """Addresses of possible robots."""

    urls: list[str]  # that answer, to be looked at
    looked_at: list[str]  # host:port, all of them


class ConnectionService(Part):
    """Lives on the event loop; one robot is looked at, or one recording read, at a time."""

    def __init__(
        self, home: Path, robot: RobotSupervisor, maps: MapService, settings: LogSettings | None = None
    ) -> None:
        self._folder, self._recordings = home / FOLDER, home / RECORDINGS
        self._robot, self._maps = robot, maps
        self._settings = settings or LogSettings()
        self.reach = Reach()  # of operators
        self.other = ""  # URL of the robot that is opened instead of this one
        self.leave: Callable[[], None] = lambda: None  # ends the console, so that the other robot is opened
        self._turn = asyncio.Lock()

    @property
    def real(self) -> bool:
        return self._robot.profile.kind == "LIVE"

    async def found(self) -> FoundRobot:
        """Return the findings on the console's robot. Raises Unavailable while its driver is gone."""
        if not self.real:
            return describe(self._robot.profile)
        return await asyncio.to_thread(self._robot.ask, ReadConnection())

    async def switch_speeds(self, name: SpeedsType) -> SentSpeeds:
        """Send speeds as another type from now on. Raises BadInput where it was not guessed, Unavailable."""
        return await asyncio.to_thread(self._robot.ask, SwitchSpeeds(type=name))

    async def files(self) -> list[str]:
        return await asyncio.to_thread(lambda: sorted(path.name for path in self._folder.glob("*.toml")))

    async def opened_here(self) -> list[str]:
        """The URLs that can be opened instead: simulated robots, and the recordings in the data folder; none on a
        real robot.
        """
        if self.real:
            return []
        names = await asyncio.to_thread(lambda: sorted(path.name for path in self._recordings.glob("[!.]*")))
        return [*WORLDS, *(f"log:{name}" for name in names)]

    async def readable(self, url: str, who: Person) -> str:
        """Read a recording in a worker before anything is let go → its whole URL; a simulated robot as it is.

        Raises BadInput with the reader's sentence, Problem 403, Refused on a real robot, Unavailable.
        """
        if self.real:
            raise Refused(Statement("connect.keeps_real", url=shlex.quote(url)))
        if url in WORLDS:
            return url
        url = await asyncio.to_thread(self._recording, url, who)
        job = ProbeWorker.read(url.removeprefix("log:"), self._settings)
        await self._at_work(lambda worker: worker.ask(job, budget=RECORDING_READ_S), RECORDING_LOST)
        return url

    def open_instead(self, url: str) -> None:
        """Let go of this robot, and open another one at the same address as soon as the answer is out."""
        self.other, self._maps.kept_as = url, f"before opening {url.rpartition('/')[2]}"
        asyncio.get_running_loop().call_later(LEAVING_DELAY_S, self.leave)

    def _recording(self, url: str, who: Person) -> str:
        """The whole URL of a recording. Raises BadInput, Problem 403."""
        scheme, _, rest = url.partition(":")
        if scheme != "log" or not rest or not url.isprintable():
            raise BadInput(Statement("connect.opened_here"))
        name, mark, run = rest.partition("#")  # FILE#N picks a run
        try:
            file = self._recordings / Path(name).expanduser()
        except RuntimeError:  # ~ of nobody
            raise BadInput(
                Statement("connect.no_recording", name=Path(name).name[:80], folder=self._recordings)
            ) from None
        if not self._is_free_for(who, url) and not inside(file, [self._recordings, *self.reach.folders]):
            raise Problem(403, Statement("connect.only_recordings", folder=self._recordings))
        if not (file.is_file() or file.is_dir()):
            raise BadInput(Statement("connect.no_recording", name=Path(name).name[:80], folder=self._recordings))
        return f"log:{file}{mark}{run}"

    async def look(self, url: str, choices: Sequence[TopicChoice], who: Person) -> FoundRobot:
        """Connect once more, or to another robot, and see what is there.

        Raises BadInput, Problem 403 for an address out of an operator's reach, Refused, Unavailable.
        """
        chosen = await self.chosen(url, choices)
        self._check_free(chosen.url)
        restrained = not self._is_free_for(who, url)
        if restrained:
            chosen = structs.replace(chosen, url=await asyncio.to_thread(self.reach.pinned, chosen.url))
        job = ProbeWorker.probe(without_lock(chosen, parts_of(chosen.url)), restrained=restrained)
        found = await self._at_work(lambda worker: worker.ask(job, budget=PROBE_BUDGET_S))
        return structs.replace(found, url=url)  # as it was asked for: a file is made of that robot's own one

    async def find(self, known: Iterable[str], who: Person) -> FoundAddresses:
        """Return who answers, on this computer and at the hosts of URLs that were used before; nothing is said there.

        Addresses that this person may not name are left out. Takes up to `ANSWER_S`.
        """
        files = await asyncio.to_thread(
            lambda: [path.read_text(errors="replace") for path in self._folder.glob("*.toml")]
        )
        used = [*known, *(url for text in files for url in re.findall(r'^url = "(.*)"', text, re.MULTILINE))]
        hosts = ["127.0.0.1", *(host_of(part) for url in used for part in parts_of(url))]
        ports = {name: urlsplit(SCHEMES[name].example).port or 0 for name in PORT_SCHEMES}
        wanted = [
            (f"{kind}://{f'[{host}]' if ':' in host else host}:{port}", host, port)
            for host in dict.fromkeys(filter(None, hosts))
            for kind, port in ports.items()
        ][:MAX_KNOCKS]
        allowed = [one for one in wanted if await asyncio.to_thread(self._allows, one[0], who)]
        answering = await asyncio.gather(*(answers(host, port) for _, host, port in allowed))
        devices = await asyncio.to_thread(serial_ports) if who.may("admin") else []
        return FoundAddresses(
            urls=[url for (url, _, _), answered in zip(allowed, answering, strict=True) if answered] + devices,
            looked_at=list(dict.fromkeys(f"{host}:{port}" for _, host, port in allowed)),
        )

    def _allows(self, url: str, who: Person) -> bool:
        try:
            return self._is_free_for(who, url) or bool(self.reach.pinned(url))
        except (Problem, BeckonError):
            return False

    async def chosen(self, url: str, choices: Sequence[TopicChoice]) -> RobotFile:
        """The robot file of a URL with the operator's choice of topics. Raises BadInput."""
        base = await self._base(url)
        return with_topics(base, choices, parts_of(base.url))

    def _is_free_for(self, who: Person, url: str) -> bool:
        return who.may("admin") or url == self._robot.profile.url

    async def write(self, file: RobotFile, comment: str, who: Person, *, replace: bool) -> WrittenFile:
        """Write a robot file that its drivers accept.

        Raises BadInput, Problem 403 for an address out of an operator's reach, Refused where it exists, Unwritable.
        """
        if not self._is_free_for(who, file.url):
            await asyncio.to_thread(self.reach.pinned, file.url)
        path = self._folder / f"{slug(file.name, 'robot')}.toml"
        command = f"beckon run --robot {shlex.quote(str(path))}"
        text = await self._at_work(
            lambda worker: worker.ask(ProbeWorker.check(file, f"{comment}\n{command}"), budget=PROBE_BUDGET_S)
        )
        async with self._turn:
            if path.exists() and not replace:
                raise Refused(Statement("connect.file_exists", name=path.name))
            with saving("The robot file could not be written"):
                await asyncio.to_thread(write_atomic, path, text)
        return WrittenFile(path.name, str(path), command, text)

    async def _base(self, url: str) -> RobotFile:
        """The file that a URL's robot has now, or an empty one. Raises BadInput for a URL that is none."""
        if self.real and url == self._robot.profile.url:
            return await asyncio.to_thread(self._robot.ask, ReadRobotFile())
        if len(url) > LONGEST_URL or not url.isprintable() or url.endswith(".toml"):
            raise BadInput(Statement("connect.type_url"))
        for part in parts_of(url):
            name, _ = split(part)
            if name == OWN:
                raise BadInput(Statement("connect.own_driver"))
            if name in SCHEMES and SCHEMES[name].section:
                raise BadInput(Statement("connect.no_file_start", kind=SCHEMES[name].what, url=shlex.quote(url)))
        return RobotFile(url=url)

    def _check_free(self, url: str) -> None:
        """Raises Refused for a device that this console uses and that bears no second client."""
        if not self.real:
            return
        used = {part.partition("?")[0] for part in parts_of(self._robot.profile.url)}
        for part in parts_of(url):
            name, _ = split(part)
            address = part.partition("?")[0]
            if name not in TOPICS and (address in used or name == OWN):
                raise Refused(Statement("connect.in_use", address=address))

    async def _at_work(self, work: Callable[[Worker], Awaitable[T]], sentence: Statement = ROBOT_LOST) -> T:
        """Do one thing in a worker of its own, which is gone afterwards. Raises Refused while another is done."""
        if self._turn.locked():
            raise Refused(Statement("connect.looked_at"))
        async with self._turn:
            worker = Worker("probe")
            try:
                return await work(worker)
            except WorkerLost as lost:
                raise Unavailable(sentence(why=lost)) from None
            finally:
                worker.kill()
                await worker.gone()
