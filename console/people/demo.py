"""Show me: a simulated person steps before the robot's camera and takes the gestures that are asked for.

It is someone who comes in for that, or someone who stands in the room already and goes back afterwards. Who else is
before the camera leaves the room for that time: the first picture is of the empty room.
"""

import asyncio
import contextlib
import logging
import math
import time
from collections.abc import Awaitable, Callable
from itertools import product

from console.http.problems import Problem
from console.people.enrollment import EnrollmentSession, Gesture
from console.robot.supervisor import RobotSupervisor
from console.workers.demo_runner import Demo, DemoRunner
from core.errors import BadInput, BeckonError, Refused
from core.geometry import Pose
from core.perception.people.camera_geometry import axis
from core.robots import requests
from core.sensors import Camera, Image

log = logging.getLogger(__name__)

Capture = Callable[[EnrollmentSession, str], Awaitable[None]]

ID = "show me"
DISTANCES_M = (3.7, 4.1, 3.5, 4.5)  # from the camera, the best first
BESIDE_PICTURE_RAD = 0.15  # beside the picture, where a part of someone would be in it
ASIDE_ANGLES_RAD = (0.0, 0.1, -0.1, 0.2, -0.2)
LOOKS = ("green/black", "red/blue", "white/brown", "yellow/grey", "blue/white", "black/green")
ARMS = {"down": "", "out": "wide", "wave": "wave", "side": ""}
NO_ROOM = "There is no room to stand whole before the camera. Turn the robot so that some four metres are free."
RETURN_DISTANCES_M = (0.0, 0.5, 1.0)  # from where they were that people come back to
RETURN_SIDES = 8  # in which they look for a place there


class DemoPerson:
    """Owned by one task. `ask(request)` awaits the driver's answer and raises BadInput where one cannot stand."""

    def __init__(self, ask: requests.Ask, camera: Camera | None, look: int, person: str = "") -> None:
        """`person`: the one in the room who shows themselves; "": one comes in, in the clothes of that number."""
        self._ask, self._camera = ask, camera
        self._look = LOOKS[look % len(LOOKS)]
        self._id, self._inhabitant = person or ID, bool(person)
        self._out: list[requests.PlacedThing] = []  # people who left the room, as they were before
        self._shown = False  # someone stands before the camera

    async def sit(self, enrollment: EnrollmentSession, capture: Capture) -> None:
        """Show every gesture of the enrollment; then who came in stays, to be come to. Raises Refused, BadInput."""
        robot = await self._ask(requests.ReadTruth())
        here = Pose(robot.x_m, robot.y_m, robot.heading_rad)
        await self._empty(here)
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
        if not self._inhabitant:
            await self._stand(standing, None)
            self._shown = False

    async def leave(self) -> None:
        """Out of the room, unless everything was shown; and everybody else is back where they were."""
        if self._shown:
            with contextlib.suppress(BeckonError):  # was taken away
                await self._ask(requests.RemoveThing(id=self._id))
        for one in self._out:
            with contextlib.suppress(BeckonError):
                await self._return(one)

    async def _empty(self, here: Pose) -> None:
        """Let all people whom the camera sees leave the room, and who shows themselves. Raises Refused."""
        things = (await self._ask(requests.ReadPlan())).things
        people = [one for one in things if isinstance(one, requests.PlacedThing) and one.what == "person"]
        if self._inhabitant:
            shows = next((one for one in people if one.id == self._id), None)
            if shows is None:
                raise Refused(f"There is no {self._id} in the simulated room.")
            self._look = shows.clothes or self._look
        for one in people:
            if one.id == self._id or self._sees(here, one):
                if self._inhabitant or one.id != ID:  # that one is left over from an earlier demonstration
                    self._out.append(one)  # first: it may be stopped at any request
                await self._ask(requests.RemoveThing(id=one.id))

    def _sees(self, here: Pose, one: requests.PlacedThing) -> bool:
        """Return whether a robot `here` has them, or a part of them, in its picture."""
        if self._camera is None:
            return False
        half = math.atan(self._camera.model.width / 2 / self._camera.model.fx) + BESIDE_PICTURE_RAD
        bearing = math.remainder(here.bearing_to(one.x_m, one.y_m) - self._axis, math.tau)
        return abs(bearing) < half

    async def _return(self, one: requests.PlacedThing) -> None:
        """Let a person come back to where they were, or near to it where the robot or a thing is now."""
        for away in RETURN_DISTANCES_M:
            for side in range(RETURN_SIDES if away else 1):
                x = one.x_m + away * math.cos(side * math.tau / RETURN_SIDES)
                y = one.y_m + away * math.sin(side * math.tau / RETURN_SIDES)
                with contextlib.suppress(BadInput):
                    await self._ask(
                        requests.PlaceThing(
                            "person",
                            x,
                            y,
                            one.heading_rad,
                            id=one.id,
                            size_m=one.height_m,
                            clothes=one.clothes or None,
                            gesture=one.gesture or "",
                            path_m=one.path_m or None,
                            speed_m_s=one.speed_m_s or None,
                            again=one.again or None,
                        )
                    )
                    return
        log.warning("There is no place in the room any more for %s", one.id)

    async def _check_room(self, places: list[Pose]) -> None:
        """Stand at one of the places for a moment. Raises Refused where a wall or a thing is at all of them."""
        for place in places:
            with contextlib.suppress(BadInput):
                await self._stand(place, None)
                await self._ask(requests.RemoveThing(id=self._id))
                self._shown = False
                return
        raise Refused(NO_ROOM)

    @property
    def _axis(self) -> float:
        """Bearing [rad] at which the camera looks, seen from the robot."""
        return 0.0 if self._camera is None else axis(self._camera)

    def _towards(self) -> list[tuple[float, float]]:
        """Return where to stand, seen from the robot: distance [m] and bearing [rad]."""
        return [(far, self._axis + aside) for aside, far in product(ASIDE_ANGLES_RAD, DISTANCES_M)]

    async def _try(self, enrollment: EnrollmentSession, capture: Capture, place: Pose) -> bool:
        """Take the gesture that is asked for, there → whether the picture was good."""
        try:
            await self._stand(place, enrollment.next)
        except BadInput:
            return False  # a wall or a thing is there
        before = len(enrollment.taken)
        await capture(enrollment, "picture")
        return len(enrollment.taken) > before

    async def _stand(self, place: Pose, gesture: Gesture | None) -> None:
        robot = await self._ask(requests.ReadTruth())
        facing = math.atan2(robot.y_m - place.y, robot.x_m - place.x)
        turned = math.pi / 2 if gesture is not None and gesture.name == "side" else 0.0
        person = requests.PlaceThing(
            what="person",
            id=self._id,
            x_m=place.x,
            y_m=place.y,
            heading_rad=facing + turned,
            clothes=self._look,
            gesture=ARMS[gesture.name] if gesture is not None else "",
        )
        self._shown = True  # first: it may be stopped at any request
        await self._ask(person)


PICTURE_TIMEOUT_S = 20.0  # for a picture: the machine may be busy
ANSWER_TIMEOUT_S = 10.0  # that the driver may take to answer
LOOK_PERIOD_S = 0.03  # between two looks whether the picture is there
WAITS = "I wait for a picture from the robot's camera."

Take = Callable[[EnrollmentSession, str, Image], Awaitable[None]]


class EnrollmentDemo:
    """One at a time. Lives on the event loop."""

    def __init__(self, robot: RobotSupervisor, newest: Callable[[], Image | None], take: Take) -> None:
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
            self.stands = self.stands or not inhabitant

        def began() -> None:
            self.stands = self.stands and bool(inhabitant)  # a former one leaves for a new one
            enrollment.demo, enrollment.trouble = True, ""

        def trouble(words: str) -> None:
            enrollment.trouble = words

        await self._runner.start(Demo(enrollment.id, run, person.leave, began, enrollment.rest, trouble))

    async def stop(self) -> None:
        """Enough is shown: the person leaves."""
        await self._runner.stop()

    def drop(self) -> None:
        self._runner.cancel()

    async def send_away(self) -> None:
        """Nobody who showed something is in the room any more. Raises Unavailable."""
        await self.stop()
        with contextlib.suppress(BadInput):  # nobody is there
            await self._ask(requests.RemoveThing(id=ID))
        self.stands = False

    async def _capture(self, enrollment: EnrollmentSession, what: str) -> None:
        """Take a picture of how the room is now: none that was on its way already. Raises Problem, BeckonError."""
        enrollment.waits = WAITS
        now = (await self._ask(requests.ReadTruth())).stamp_s
        until = time.monotonic() + PICTURE_TIMEOUT_S
        while (image := self._newest()) is None or image.stamp <= now:
            if time.monotonic() > until:
                raise Problem(503, "No picture comes from the robot's camera; press Show me again when one does.")
            await asyncio.sleep(LOOK_PERIOD_S)
        await self._take(enrollment, what, image)

    async def _ask(self, request: requests.RobotRequest[requests.AnswerT]) -> requests.AnswerT:
        return await asyncio.to_thread(self._robot.ask, request, ANSWER_TIMEOUT_S)
