"""Who the robot knows, to whom alone it comes, and the one who is being learnt."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import secrets
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from console.calibration.live import moved
from console.calibration.turns import Turns
from console.door import Door
from console.logins import Person
from console.people.album import MOST_PEOPLE, VERSION, Album, Card, name_of
from console.people.desk import told_picture
from console.people.lesson import MOST_PICTURES, Lesson
from console.people.showing import Showing
from console.problems import Problem
from console.robot_link import RobotLink
from console.workers import Lost, Worker
from core.errors import Refused, Unavailable
from core.files import saving
from core.geometry import Pose
from core.perception.people.colours import Enrolled
from core.perception.people.enrolment import FEWEST
from core.sensors import Image
from core.snapshot import Level, Snapshot

log = logging.getLogger(__name__)

BUDGET = 4.0  # [s] of processor time for one picture
MOST_WAITING = 3  # pictures that are looked at or wait for it
LOOKS, GETS_READY = "I look at the picture.", "I get ready to look at pictures; the first takes longest."
OVER = "That lesson is over; begin anew."
ONLY = "When called I come only to {}; that is chosen under People."
ANYBODY = "When called I come to anybody."

Told = dict[str, Any]


class School:
    """Lives on the event loop. One per console, and in it one lesson at a time."""

    def __init__(
        self,
        home: Path,
        robot: RobotLink,
        door: Door,
        tell: Callable[[Level, str], None],
        newest: Callable[[], Image | None],
    ) -> None:
        """The pilot behind the `door` hears who is chosen; `tell` hangs a notice; `newest` picture of the robot."""
        self.people: dict[str, Card] = {}
        self.lesson: Lesson | None = None
        self._chosen: str | None = None
        self.album = Album(home)
        self._robot, self._door, self._tell, self._newest = robot, door, tell, newest
        self._pose: Pose | None = None  # of the robot by its wheels
        self._worker = Worker("people")
        self._turn = asyncio.Lock()  # of whoever writes on the disk
        self._looks = Turns(MOST_WAITING)  # what comes of one picture depends on those before it
        self._showing = Showing(robot, newest, self._judge)

    # life

    async def open(self) -> None:
        """Find who was known before."""
        complaints: list[str] = []
        self.people, self._chosen = await asyncio.to_thread(self.album.read, complaints.append)
        for words in dict.fromkeys(complaints):
            self._tell("warning", words)
        if self.chosen is not None:
            self._tell("info", ONLY.format(self.chosen.name))

    async def close(self) -> None:
        """End what is under way; the pictures are gone."""
        await self._showing.stop()
        self._worker.kill()
        await self._worker.gone()

    def took(self, snapshot: Snapshot) -> None:
        """The newest of what the robot does."""
        self._pose = snapshot.dead_reckoning.pose
        if self.lesson is not None and self.lesson.stale:
            self._over()

    @property
    def chosen(self) -> Enrolled | None:
        """To whom alone the robot comes; None: to anybody."""
        card = self.people.get(self._chosen or "")
        return None if card is None else card.who

    def told(self) -> Told:
        """Everything that the page shows."""
        rows = [
            {"id": one.id, "name": one.name, "learnt_s": one.learnt_s, "by": one.by, "pictures": one.pictures}
            for one in sorted(self.people.values(), key=lambda card: card.name.casefold())
        ]
        profile = self._robot.profile
        return {
            "people": rows,
            "chosen": self._chosen,
            "enrolment": None if self.lesson is None else self.lesson.told(),
            "camera": profile.camera is not None,
            "stands": self._showing.stands,
            "simulated": profile.kind == "SIM" and profile.drives,
        }

    # learning

    def begin(self, who: Person) -> Lesson:
        """A new lesson; one's own former one is over. Raises Problem 409 while somebody else teaches."""
        if len(self.people) >= MOST_PEOPLE:
            raise Problem(409, f"I know {MOST_PEOPLE} people already; let me forget somebody first.")
        if self.lesson is not None and self.lesson.owner != who.id and not self.lesson.stale:
            raise Problem(409, f"{self.lesson.who} is teaching me somebody now; wait, or ask them to cancel it.")
        self._over()
        self.lesson = Lesson(secrets.token_hex(6), who.name, who.id)
        return self.lesson

    def find(self, lesson_id: str) -> Lesson:
        """Raises Problem 404."""
        if self.lesson is None or self.lesson.id != lesson_id:
            raise Problem(404, OVER)
        return self.lesson

    async def background(self, lesson: Lesson, picture: Told, stood: Pose | None = None) -> None:
        """The empty picture. Raises BadInput, Problem."""
        async with self._looks.taken():
            answer = await self._asked(lesson, "background", {"picture": picture})
            lesson.begin_anew(answer, stood)

    async def take(self, lesson: Lesson, picture: Told) -> None:
        """A picture of somebody; what comes of it stands in the lesson. Raises BadInput, Problem."""
        async with self._looks.taken():
            if lesson.background is None:
                raise Problem(409, "First the background: a picture without anybody.")
            if len(lesson.taken) >= MOST_PICTURES:
                raise Problem(409, f"{MOST_PICTURES} pictures are enough; say who you are.")
            taken = [one.portrait for one in lesson.taken]
            given = {"picture": picture, "background": lesson.background, "taken": taken}
            lesson.take(await self._asked(lesson, "judge", given))

    async def capture(self, lesson: Lesson, what: str) -> None:
        """The same with the newest picture of the robot's own camera. Raises BadInput, Problem 409, 503."""
        if self._robot.profile.camera is None:
            raise Problem(409, "This robot has no camera; use a webcam or picture files.")
        image = self._newest()
        if image is None or self._robot.link()[0] != "live":
            raise Problem(503, "No picture comes from the robot now.")
        await self._judge(lesson, what, image)

    async def finish(self, lesson: Lesson, given: str) -> Card:
        """Learn and keep who it was; the pictures are gone. Raises Problem 409, 422, 503."""
        name = self._free(given)
        if lesson.showing:
            raise Problem(409, "The simulated person still shows gestures; wait, or stop it.")
        if len(lesson.taken) < FEWEST:
            raise Refused(f"I need at least {FEWEST} good pictures with different gestures; take more.")
        async with self._looks.taken():
            taken = [one.portrait for one in lesson.taken]
            learnt = await self._asked(lesson, "learn", {"name": name, "taken": taken})
        async with self._turn:
            self.find(lesson.id)
            self._free(name)
            card = Card(VERSION, lesson.id, name, round(time.time(), 1), lesson.who, **learnt)
            await self._written(lambda: self.album.keep(card))
            self.people[card.id] = card
            if self.lesson is lesson:  # nobody began another while it was written
                self._over()
        return card

    async def cancel(self, lesson: Lesson) -> None:
        """Nothing of it is kept, and nobody of it stays in the simulated room. Raises Problem 404."""
        self.find(lesson.id)
        self._over()
        if self._robot.profile.kind == "SIM":
            with contextlib.suppress(Unavailable):
                await self.send_away()

    async def show_me(self, lesson: Lesson, *, on: bool) -> None:
        """In the simulated room somebody steps before the camera and takes the gestures, or stops. Problem 409."""
        self._simulated()
        if on:
            await self._showing.begin(lesson, look=len(self.people))
        else:
            await self._showing.stop()

    async def send_away(self) -> None:
        """Who showed the gestures leaves the simulated room. Raises Problem 409, Unavailable."""
        self._simulated()
        await self._showing.send_away()

    # who is known

    async def choose(self, card_id: str | None) -> None:
        """Come only to this person, or to anybody. Raises Problem 404, 503."""
        async with self._turn:
            if card_id is not None and card_id not in self.people:
                raise Problem(404, "I know nobody of that id.")
            await self._written(lambda: self.album.choose(card_id))
            self._use(card_id)
            self._tell("info", ANYBODY if self.chosen is None else ONLY.format(self.chosen.name))

    async def rename(self, card_id: str, given: str) -> Card:
        """Raises Problem 404, 409, 422, 503."""
        async with self._turn:
            card = self._known(card_id)
            fresh = Card(**{field: getattr(card, field) for field in Card.__struct_fields__})
            fresh.name = self._free(given, besides=card_id)
            await self._written(lambda: self.album.keep(fresh))
            self.people[card_id] = fresh
            if self._chosen == card_id:
                self._use(card_id)
        return fresh

    async def forget(self, card_id: str) -> None:
        """For good; who was chosen is chosen no more. Raises Problem 404, 503."""
        async with self._turn:
            card = self._known(card_id)
            if self._chosen == card_id:
                await self._written(lambda: self.album.choose(None))
                self._use(None)
                self._tell("warning", f"I forgot {card.name}, to whom alone I came; now I come to anybody.")
            await self._written(lambda: self.album.forget(card_id))
            del self.people[card_id]

    # steps of the above

    def _use(self, card_id: str | None) -> None:
        """Come only to this person from the next frame on."""
        self._chosen = card_id
        if self._door.pilot is not None:
            self._door.pilot.obey_only(self.chosen)

    def _known(self, card_id: str) -> Card:
        if card_id not in self.people:
            raise Problem(404, "I know nobody of that id.")
        return self.people[card_id]

    def _free(self, given: str, besides: str = "") -> str:
        """A name that nobody else has. Raises Problem 409, 422."""
        name = name_of(given)
        taken = {one.name.casefold() for one in self.people.values() if one.id != besides}
        if name.casefold() in taken:
            raise Problem(409, "I know somebody of that name already; give another, or let me forget them first.")
        return name

    def _over(self) -> None:
        """No lesson any more; its pictures and its worker go."""
        self.lesson = None
        self._showing.drop()
        self._rest()

    def _rest(self) -> None:
        """No lesson, no worker; one that looks at a picture still is ended after it."""
        if self.lesson is None and not self._worker.busy:
            self._worker.kill()

    def _simulated(self) -> None:
        if self._robot.profile.kind != "SIM":
            raise Problem(409, "Only in the simulated room somebody is there to help; show yourself.")

    async def _judge(self, lesson: Lesson, what: str, image: Image) -> None:
        """A picture of the robot's own camera. Raises BadInput, Problem."""
        if what == "background":
            await self.background(lesson, told_picture(image), self._pose)
            return
        if moved(lesson.stood, self._pose):
            raise Problem(409, "The robot has moved since the background was taken; take the background anew.")
        await self.take(lesson, told_picture(image))

    async def _asked(self, lesson: Lesson, do: str, given: Told) -> Any:
        """Raises what the desk raises, Problem when it breaks, Problem 404 when the lesson is over."""
        self.find(lesson.id)
        lesson.waits = LOOKS if self._worker.alive else GETS_READY
        try:
            answer = await self._worker.ask(do, given, budget=BUDGET)
        except Lost as lost:
            log.warning("The worker that looks at people was lost: %s", lost)
            if lost.killed:
                raise Problem(503, "What looks at the pictures was ended; try once more.") from None
            raise Problem(422, "That picture broke what looked at it; nothing else was lost. Take another.") from None
        finally:
            lesson.waits = ""
            self._rest()
        self.find(lesson.id)
        return answer

    async def _written(self, work: Callable[[], None]) -> None:
        with saving("What I learnt could not be saved"):
            await asyncio.to_thread(work)
