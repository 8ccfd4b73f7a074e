"""The people whom the robot knows, the only one to whom it comes, and the enrollment under way."""

import asyncio
import contextlib
import logging
import secrets
import time
from collections.abc import Callable
from pathlib import Path

import msgspec
import numpy as np

from console.access.logins import Person
from console.calibration.live_capture import moved
from console.control.dispatcher import CommandDispatcher
from console.http.problems import Problem
from console.part import Part
from console.people.demo import EnrollmentDemo
from console.people.enrollment import MOST_PICTURES, EnrollmentSession, EnrollmentState
from console.people.store import CARD_VERSION, MOST_PEOPLE, PersonFile, PersonStore, StoredLooks, name_of
from console.people.worker import PeopleWorker, PersonPicture, PixelPicture
from console.robot.supervisor import RobotSupervisor
from console.workers.job import Answer, Job
from console.workers.tasks import QueueLimit
from console.workers.worker import Worker, WorkerLost
from core.errors import Refused, Unavailable
from core.files import saving
from core.geometry import Pose
from core.perception.people.appearance import DARK_NOISE_GREY, Appearance, PersonProfile
from core.perception.people.enrollment import MIN_PICTURES
from core.perception.people.legs import find_standers
from core.pilot.pilot import Pilot
from core.sensors import Image, SensorFrame
from core.snapshot import Level, Snapshot

log = logging.getLogger(__name__)

BUDGET_S = 4.0  # of processor time for one picture
MOST_WAITING = 3  # pictures that are looked at or wait for it
LOOKS, GETS_READY = "I look at the picture.", "I get ready to look at pictures; the first takes longest."
ONLY = "When called I come only to {}; that is chosen under People."
ANYBODY = "When called I come to anybody."


class KnownPerson(msgspec.Struct, frozen=True, kw_only=True):
    """A person whom the robot knows, and the middle colour of each part of their clothes."""

    id: str
    name: str
    learnt_s: float  # Unix time
    by: str  # who was at the console
    pictures: int
    colours: list[str | None]  # "#rrggbb" of head, torso, legs; None: not known


def middle_colours(looks: Appearance) -> list[str | None]:
    """Medians of the parts' logarithms (3, TONE_COUNT), blue first → "#rrggbb", None for what is unknown."""
    colours: list[str | None] = []
    for part in looks.colours[:, 2::-1]:
        grey = np.exp(part) - DARK_NOISE_GREY
        known = bool(np.isfinite(grey).all())
        colours.append("#" + bytes(grey.round().clip(0, 255).astype(np.uint8)).hex() if known else None)
    return colours


class PeopleState(msgspec.Struct, frozen=True, kw_only=True):
    """The people and the enrollment under way, as the page gets them."""

    people: list[KnownPerson]
    chosen: str | None  # id
    enrollment: EnrollmentState | None
    camera: bool  # the robot has one
    stands: bool  # the person who showed the gestures is still in the simulated room
    simulated: bool


class EnrollmentService(Part):
    """The people and the enrollment. Lives on the event loop. One per console, and in it one enrollment at a time."""

    def __init__(
        self,
        home: Path,
        robot: RobotSupervisor,
        dispatcher: CommandDispatcher,
        tell: Callable[[Level, str], None],
        newest: Callable[[], Image | None],
    ) -> None:
        """The dispatcher's pilot hears who is chosen; `tell` hangs a notice; `newest` picture of the robot."""
        self.people: dict[str, PersonFile] = {}
        self.enrollment: EnrollmentSession | None = None
        self._chosen: str | None = None
        self.person_store = PersonStore(home)
        self._robot, self._dispatcher, self._tell, self._newest = robot, dispatcher, tell, newest
        self._pose: Pose | None = None  # of the robot by its wheels
        self._newest_snapshot: Snapshot | None = None
        self._worker = Worker("people")
        self._turn = asyncio.Lock()  # of the one who writes on the disk
        self._looks = QueueLimit(MOST_WAITING)  # what comes of one picture depends on those before it
        self._demo = EnrollmentDemo(robot, newest, self._judge)

    # life

    async def open(self) -> None:
        complaints: list[str] = []
        self.people, self._chosen = await asyncio.to_thread(self.person_store.read, complaints.append)
        for words in dict.fromkeys(complaints):
            self._tell("warning", words)
        if self.chosen is not None:
            self._tell("info", ONLY.format(self.chosen.name))

    async def close(self) -> None:
        """End the enrollment under way; the pictures are gone."""
        await self._demo.stop()
        self._worker.kill()
        await self._worker.gone()

    def on_snapshot(self, snapshot: Snapshot, frame: SensorFrame) -> None:
        self._pose, self._newest_snapshot = snapshot.dead_reckoning.pose, snapshot
        if self.enrollment is not None and self.enrollment.stale:
            self._over()

    def equip(self, pilot: Pilot) -> None:
        pilot.obey_only(self.chosen)

    @property
    def chosen(self) -> PersonProfile | None:
        """To whom alone the robot comes; None: to anybody."""
        card = self.people.get(self._chosen or "")
        return None if card is None else card.who

    @property
    def shown(self) -> PeopleState:
        rows = [
            msgspec.convert({**msgspec.structs.asdict(one), "colours": middle_colours(one.who.looks)}, KnownPerson)
            for one in sorted(self.people.values(), key=lambda card: card.name.casefold())
        ]
        profile = self._robot.profile
        return PeopleState(
            people=rows,
            chosen=self._chosen,
            enrollment=None if self.enrollment is None else self.enrollment.shown,
            camera=profile.camera is not None,
            stands=self._demo.stands,
            simulated=profile.simulated,
        )

    # learning

    def begin(self, who: Person) -> EnrollmentSession:
        """Begin a new enrollment; one's own former one is over. Raises Problem 409 while another person teaches."""
        if len(self.people) >= MOST_PEOPLE:
            raise Problem(409, f"I know {MOST_PEOPLE} people already; let me forget someone first.")
        if self.enrollment is not None and self.enrollment.owner != who.id and not self.enrollment.stale:
            raise Problem(409, f"{self.enrollment.who} is teaching me someone now; wait, or ask them to cancel it.")
        self._over()
        self.enrollment = EnrollmentSession(secrets.token_hex(6), who.name, who.id)
        return self.enrollment

    def find(self, enrollment_id: str) -> EnrollmentSession:
        """Raises Problem 404."""
        if self.enrollment is None or self.enrollment.id != enrollment_id:
            raise Problem(404, "That enrollment is over; begin again.")
        return self.enrollment

    async def background(
        self, enrollment: EnrollmentSession, picture: PersonPicture, stood: Pose | None = None
    ) -> None:
        """The empty picture. Raises BadInput, Problem."""
        async with self._looks.taken():
            enrollment.restart(await self._asked(enrollment, PeopleWorker.background(picture)), stood)

    async def take(self, enrollment: EnrollmentSession, picture: PersonPicture, *, own: bool = False) -> None:
        """A picture of a person; its verdict stands in the enrollment. Raises BadInput, Problem.

        `own`: the robot's camera took it, so the laser helps to measure how tall the person is.
        """
        async with self._looks.taken():
            if enrollment.background is None:
                raise Problem(409, "First the background: a picture without anybody.")
            if len(enrollment.taken) >= MOST_PICTURES:
                raise Problem(409, f"{MOST_PICTURES} pictures are enough; say who you are.")
            snapshot, known = self._newest_snapshot, (enrollment.background, enrollment.person_images)
            gauge = (self._robot.profile.camera, legs_seen(snapshot)) if own and snapshot is not None else (None, [])
            enrollment.take(await self._asked(enrollment, PeopleWorker.judge(picture, *known, *gauge)))

    async def capture(self, enrollment: EnrollmentSession, what: str) -> None:
        """The same with the newest picture of the robot's own camera. Raises BadInput, Problem 409, 503."""
        if self._robot.profile.camera is None:
            raise Problem(409, "This robot has no camera; use a webcam or picture files.")
        image = self._newest()
        if image is None or self._robot.link()[0] != "live":
            raise Problem(503, "No picture comes from the robot now.")
        await self._judge(enrollment, what, image)

    async def finish(self, enrollment: EnrollmentSession, given: str) -> PersonFile:
        """Learn and keep who it was; the pictures are gone. Raises Problem 409, 422, 503."""
        name = self._free(given)
        if enrollment.demo:
            raise Problem(409, "The simulated person still shows gestures; wait, or stop it.")
        if len(enrollment.taken) < MIN_PICTURES:
            raise Refused(f"I need at least {MIN_PICTURES} good pictures with different gestures; take more.")
        async with self._looks.taken():
            learnt = await self._asked(enrollment, PeopleWorker.learn(name, enrollment.person_images))
        async with self._turn:
            self.find(enrollment.id)
            self._free(name)
            card = PersonFile(
                CARD_VERSION,
                enrollment.id,
                name,
                round(time.time(), 1),
                enrollment.who,
                pictures=learnt.pictures,
                looks=StoredLooks.of(learnt.looks),
            )
            await self._written(lambda: self.person_store.keep(card))
            self.people[card.id] = card
            if self.enrollment is enrollment:  # nobody began another while it was written
                self._over()
        return card

    async def cancel(self, enrollment: EnrollmentSession) -> None:
        """Nothing of it is kept, and nobody of it stays in the simulated room. Raises Problem 404."""
        self.find(enrollment.id)
        self._over()
        if self._robot.profile.simulated:
            with contextlib.suppress(Unavailable):
                await self.send_away()

    async def show_demo(self, enrollment: EnrollmentSession, *, on: bool, inhabitant: str = "") -> None:
        """Let a person in the simulated room step before the camera and take the gestures, or stop; `inhabitant`: one
        who stands there already. Raises Problem 409.
        """
        self._simulated()
        if on:
            await self._demo.begin(enrollment, len(self.people), inhabitant)
        else:
            await self._demo.stop()

    async def send_away(self) -> None:
        """Send the person who showed the gestures out of the simulated room. Raises Problem 409, Unavailable."""
        self._simulated()
        await self._demo.send_away()

    # who is known

    async def choose(self, card_id: str | None) -> None:
        """Come only to this person, or to anybody. Raises Problem 404, 503."""
        async with self._turn:
            if card_id is not None:
                self._known(card_id)
            await self._written(lambda: self.person_store.choose(card_id))
            self._use(card_id)
            self._tell("info", ANYBODY if self.chosen is None else ONLY.format(self.chosen.name))

    async def rename(self, card_id: str, given: str) -> PersonFile:
        """Raises Problem 404, 409, 422, 503."""
        async with self._turn:
            fresh = msgspec.structs.replace(self._known(card_id), name=self._free(given, besides=card_id))
            await self._written(lambda: self.person_store.keep(fresh))
            self.people[card_id] = fresh
            if self._chosen == card_id:
                self._use(card_id)
        return fresh

    async def forget(self, card_id: str) -> None:
        """For good; who was chosen is chosen no more. Raises Problem 404, 503."""
        async with self._turn:
            card = self._known(card_id)
            if self._chosen == card_id:
                await self._written(lambda: self.person_store.choose(None))
                self._use(None)
                self._tell("warning", f"I forgot {card.name}, to whom alone I came; now I come to anybody.")
            await self._written(lambda: self.person_store.forget(card_id))
            del self.people[card_id]

    # steps of the above

    def _use(self, card_id: str | None) -> None:
        self._chosen = card_id
        if self._dispatcher.pilot is not None:
            self._dispatcher.pilot.obey_only(self.chosen)

    def _known(self, card_id: str) -> PersonFile:
        if card_id not in self.people:
            raise Problem(404, "I know nobody of that id.")
        return self.people[card_id]

    def _free(self, given: str, besides: str = "") -> str:
        """A name that nobody else has. Raises Problem 409, 422."""
        name = name_of(given)
        taken = {one.name.casefold() for one in self.people.values() if one.id != besides}
        if name.casefold() in taken:
            raise Problem(409, "I know someone of that name already; give another, or let me forget them first.")
        return name

    def _over(self) -> None:
        """End the enrollment; its pictures and its worker go."""
        self.enrollment = None
        self._demo.drop()
        self._rest()

    def _rest(self) -> None:
        """End the worker without an enrollment; one that looks at a picture still is ended after it."""
        if self.enrollment is None and not self._worker.busy:
            self._worker.kill()

    def _simulated(self) -> None:
        if not self._robot.profile.simulated:
            raise Problem(409, "Only in the simulated room someone is there to help; show yourself.")

    async def _judge(self, enrollment: EnrollmentSession, what: str, image: Image) -> None:
        """A picture of the robot's own camera. Raises BadInput, Problem."""
        if what == "background":
            await self.background(enrollment, PixelPicture(image.pixels), self._pose)
            return
        if moved(enrollment.stood, self._pose):
            raise Problem(409, "The robot has moved since the background was taken; take the background again.")
        await self.take(enrollment, PixelPicture(image.pixels), own=True)

    async def _asked(self, enrollment: EnrollmentSession, job: Job[Answer]) -> Answer:
        """Raises what the worker raises, Problem when it breaks, Problem 404 when the enrollment is over."""
        self.find(enrollment.id)
        enrollment.waits = LOOKS if self._worker.alive else GETS_READY
        try:
            answer = await self._worker.ask(job, budget=BUDGET_S)
        except WorkerLost as lost:
            log.warning("The worker that looks at people was lost: %s", lost)
            if lost.killed:
                raise Problem(503, "What looks at the pictures was ended; try once more.") from None
            raise Problem(422, "That picture broke what looked at it; nothing else was lost. Take another.") from None
        finally:
            enrollment.waits = ""
            self._rest()
        self.find(enrollment.id)
        return answer

    async def _written(self, work: Callable[[], None]) -> None:
        with saving("What I learnt could not be saved"):
            await asyncio.to_thread(work)


def legs_seen(snapshot: Snapshot) -> list[tuple[float, float]]:
    """Return the places at which the laser sees possible legs: x, y [m] in the robot's frame."""
    points = snapshot.estimate.pose.inverse().apply(snapshot.scan_points)
    return [(float(one.place[0]), float(one.place[1])) for one in find_standers(points)]
