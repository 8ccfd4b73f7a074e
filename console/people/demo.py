"""Show me: a simulated person steps before the robot's camera and takes the gestures that are asked for.

It is someone who comes in for that, or someone who stands in the room already and goes back afterwards.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import time
from collections.abc import Awaitable, Callable
from itertools import product

from console.http.problems import Problem
from console.people.enrollment import EnrollmentSession, Gesture
from console.robot.link import RobotLink
from console.workers.demo_runner import Demo, DemoRunner
from core.errors import BadInput, BeckonError, Refused
from core.geometry import Pose
from core.robots.requests import (
    AnswerT,
    Ask,
    PlacedThing,
    PlaceThing,
    ReadPlan,
    ReadTruth,
    RemoveThing,
    RobotRequest,
)
from core.sensors import Camera, Image

Capture = Callable[[EnrollmentSession, str], Awaitable[None]]

ID = "show me"
AWAY = (3.7, 4.1, 3.5, 4.5)  # [m] from the camera, the best first
BESIDE = 0.15  # [rad] beside the picture, where a part of someone would be in it
ASIDE = (0.0, 0.1, -0.1, 0.2, -0.2)  # [rad]
LOOKS = ("green/black", "red/blue", "white/brown", "yellow/grey", "blue/white", "black/green")
ARMS = {"down": "", "out": "wide", "wave": "wave", "side": ""}
NO_ROOM = "There is no room to stand whole before the camera. Turn the robot so that some four metres are free."
NOT_EMPTY = (
    "{who} stands before the camera, and the first picture is of the empty room. Turn the robot away from there."
)


class DemoPerson:
    """Owned by one task. `ask(request)` awaits the driver's answer and raises BadInput where one cannot stand."""

    def __init__(self, ask: Ask, camera: Camera | None, look: int, person: str = "") -> None:
        """`person`: the one in the room who shows themselves; "": one comes in, in the clothes of that number."""
        self._ask, self._camera = ask, camera
        self._look = LOOKS[look % len(LOOKS)]
        self._id, self._inhabitant = person or ID, bool(person)
        self._stood: PlacedThing | None = None  # the inhabitant, before
        self._shown = False  # someone stands before the camera
        self._stays = False

    async def sit(self, enrollment: EnrollmentSession, capture: Capture) -> None:
        """Show every gesture of the enrollment; then the person stays, to be come to. Raises Refused, BadInput."""
        if self._inhabitant:
            self._stood = await self._in_room()
        await self.leave()
        robot = await self._ask(ReadTruth())
        here = Pose(robot.x_m, robot.y_m, robot.heading_rad)
        await self._check_empty(here)
        places = [here @ Pose(far * math.cos(angle), far * math.sin(angle), 0.0) for far, angle in self._towards()]
        await self._check_room(places)
        await capture(enrollment, "background")
        standing: Pose | None = None
        for place in places:
            if await self._try(enrollment, capture, place):
                standing = place
                break
        if standing is None:
            raise Refused(NO_ROOM)
        while enrollment.next is not None:
            if not await self._try(enrollment, capture, standing):
                raise Refused(enrollment.newest.wrong if enrollment.newest else NO_ROOM)
        if self._stood is not None:
            await self._return(self._stood)
        else:
            await self._stand(standing, None)
        self._stays = True

    async def leave(self) -> None:
        """Out of the room, unless everything was shown."""
        if self._stays:
            return
        with contextlib.suppress(BeckonError):  # was not there
            await self._ask(RemoveThing(id=self._id))
        if self._stood is not None and self._shown:
            with contextlib.suppress(BeckonError):
                await self._return(self._stood)

    async def _in_room(self) -> PlacedThing:
        """The inhabitant who shows themselves. Raises Refused."""
        things = (await self._ask(ReadPlan())).things
        found = next((one for one in things if isinstance(one, PlacedThing) and one.id == self._id), None)
        if found is None or found.what != "person":
            raise Refused(f"There is no {self._id} in the simulated room.")
        self._look = found.clothes or self._look
        return found

    async def _check_empty(self, here: Pose) -> None:
        """Raises Refused when someone else stands where the camera looks."""
        if self._camera is None:
            return
        half = math.atan(self._camera.model.width / 2 / self._camera.model.fx) + BESIDE
        for thing in (await self._ask(ReadPlan())).things:
            if isinstance(thing, PlacedThing) and thing.what == "person" and thing.id != self._id:
                bearing = math.remainder(here.bearing_to(thing.x_m, thing.y_m) - self._axis, math.tau)
                if abs(bearing) < half and here.distance_to(thing.x_m, thing.y_m) < max(AWAY):
                    raise Refused(NOT_EMPTY.format(who=thing.id))

    async def _check_room(self, places: list[Pose]) -> None:
        """Stand at one of the places for a moment. Raises Refused where a wall or a thing is at all of them."""
        for place in places:
            with contextlib.suppress(BadInput):
                await self._stand(place, None)
                await self._ask(RemoveThing(id=self._id))
                return
        raise Refused(NO_ROOM)

    async def _return(self, there: PlacedThing) -> None:
        """Let the inhabitant go back to where they stood."""
        await self._ask(
            PlaceThing("person", there.x_m, there.y_m, there.heading_rad, id=self._id, clothes=self._look, gesture="")
        )

    @property
    def _axis(self) -> float:
        """Bearing [rad] at which the camera looks, seen from the robot."""
        ahead = self._camera.mounting.rotation[:, 2] if self._camera is not None else (1.0, 0.0)
        return math.atan2(float(ahead[1]), float(ahead[0]))

    def _towards(self) -> list[tuple[float, float]]:
        """Return where to stand, seen from the robot: distance [m] and bearing [rad]."""
        return [(far, self._axis + aside) for aside, far in product(ASIDE, AWAY)]

    async def _try(self, enrollment: EnrollmentSession, capture: Capture, place: Pose) -> bool:
        """Take the gesture that is asked for, there → whether the picture was good."""
        try:
            await self._stand(place, enrollment.next)
        except BadInput:
            return False  # a wall or a thing is there
        self._shown = True
        before = len(enrollment.taken)
        await capture(enrollment, "picture")
        return len(enrollment.taken) > before

    async def _stand(self, place: Pose, gesture: Gesture | None) -> None:
        """Face the robot, or turn aside."""
        robot = await self._ask(ReadTruth())
        facing = math.atan2(robot.y_m - place.y, robot.x_m - place.x)
        turned = math.pi / 2 if gesture is not None and gesture.name == "side" else 0.0
        person = PlaceThing(
            what="person",
            id=self._id,
            x_m=place.x,
            y_m=place.y,
            heading_rad=facing + turned,
            clothes=self._look,
            gesture=ARMS[gesture.name] if gesture is not None else "",
        )
        await self._ask(person)


PATIENCE = 20.0  # [s] for a picture: the machine may be busy
ANSWERING = 10.0  # [s] that the driver may take to answer
GAP = 0.03  # [s] between two looks whether the picture is there
WAITS = "I wait for a picture from the robot's camera."
SILENT = "No picture comes from the robot's camera; press Show me again when one does."

Take = Callable[[EnrollmentSession, str, Image], Awaitable[None]]


class EnrollmentDemo:
    """One at a time. Lives on the event loop."""

    def __init__(self, robot: RobotLink, newest: Callable[[], Image | None], take: Take) -> None:
        """`newest` picture of the robot; `take(enrollment, what, picture)` has it judged."""
        self.stands = False  # who showed everything is in the simulated room still
        self._robot, self._newest, self._take = robot, newest, take
        self._runner = DemoRunner()

    async def begin(self, enrollment: EnrollmentSession, look: int, inhabitant: str = "") -> None:
        """Let a person step before the camera, in the clothes of that number, or an inhabitant of the room; a former
        one leaves.
        """
        person = DemoPerson(self._ask, self._robot.profile.camera, look, inhabitant)

        async def run() -> None:
            await person.sit(enrollment, self._capture)
            self.stands = not inhabitant

        def began() -> None:
            self.stands = False
            enrollment.demo, enrollment.trouble = True, ""

        def trouble(words: str) -> None:
            enrollment.trouble = words

        await self._runner.start(Demo(enrollment.id, run, person.leave, began, enrollment.rest, trouble))

    async def stop(self) -> None:
        """Enough is shown: the person leaves."""
        await self._runner.stop()

    def drop(self) -> None:
        """The same without waiting for it."""
        self._runner.cancel()

    async def send_away(self) -> None:
        """Nobody who showed something is in the room any more. Raises Unavailable."""
        await self.stop()
        with contextlib.suppress(BadInput):  # nobody is there
            await self._ask(RemoveThing(id=ID))
        self.stands = False

    async def _capture(self, enrollment: EnrollmentSession, what: str) -> None:
        """Take a picture of how the room is now: none that was on its way already. Raises Problem, BeckonError."""
        enrollment.waits = WAITS
        now = (await self._ask(ReadTruth())).stamp_s
        until = time.monotonic() + PATIENCE
        while (image := self._newest()) is None or image.stamp <= now:
            if time.monotonic() > until:
                raise Problem(503, SILENT)
            await asyncio.sleep(GAP)
        await self._take(enrollment, what, image)

    async def _ask(self, request: RobotRequest[AnswerT]) -> AnswerT:
        return await asyncio.to_thread(self._robot.ask, request, ANSWERING)
