"""Show me: a simulated person steps before the robot's camera and takes the gestures that are asked for."""

from __future__ import annotations

import math
from collections.abc import Awaitable, Callable
from itertools import product
from typing import Any

from console.people.lesson import Gesture, Lesson
from core.errors import BadInput, BeckonError, Refused
from core.geometry import Pose
from core.sensors import Camera

Ask = Callable[[dict[str, Any]], Awaitable[dict[str, Any]]]
Capture = Callable[[Lesson, str], Awaitable[None]]

ID = "show me"
AWAY = (3.7, 4.1, 3.5, 4.5)  # [m] from the camera, the best first
ASIDE = (0.0, 0.1, -0.1, 0.2, -0.2)  # [rad]
LOOKS = ("green/black", "red/blue", "white/brown", "yellow/grey", "blue/white", "black/green")
ARMS = {"down": "", "out": "wide", "wave": "wave", "side": ""}
NO_ROOM = "There is no room to stand whole before the camera. Turn the robot so that some three metres are free."


class Sitter:
    """Owned by one task. `ask(request)` awaits the driver's answer and raises BadInput where one cannot stand."""

    def __init__(self, ask: Ask, camera: Camera | None, look: int) -> None:
        self._ask, self._camera = ask, camera
        self._look = LOOKS[look % len(LOOKS)]
        self._stays = False

    async def sit(self, lesson: Lesson, capture: Capture) -> None:
        """Everything that a lesson asks for; then the person stays, to be come to. Raises Refused, BadInput."""
        await self.leave()
        await capture(lesson, "background")
        robot = await self._ask({"do": "truth"})
        here = Pose(robot["x_m"], robot["y_m"], robot["heading_rad"])
        places = [here @ Pose(far * math.cos(angle), far * math.sin(angle), 0.0) for far, angle in self._towards()]
        standing: Pose | None = None
        for place in places:
            if await self._try(lesson, capture, place):
                standing = place
                break
        if standing is None:
            raise Refused(NO_ROOM)
        while lesson.next is not None:
            if not await self._try(lesson, capture, standing):
                raise Refused(lesson.newest.wrong if lesson.newest else NO_ROOM)
        await self._stand(standing, None)
        self._stays = True

    async def leave(self) -> None:
        """Out of the room, unless everything was shown."""
        if self._stays:
            return
        try:
            await self._ask({"do": "remove", "id": ID})
        except BeckonError:
            return  # was not there

    def _towards(self) -> list[tuple[float, float]]:
        """Where to stand, seen from the robot: distance [m] and bearing [rad]."""
        ahead = self._camera.mounting.rotation[:, 2] if self._camera is not None else (1.0, 0.0)
        axis = math.atan2(float(ahead[1]), float(ahead[0]))
        return [(far, axis + aside) for aside, far in product(ASIDE, AWAY)]

    async def _try(self, lesson: Lesson, capture: Capture, place: Pose) -> bool:
        """Take the gesture that is asked for, there → whether the picture was good."""
        try:
            await self._stand(place, lesson.next)
        except BadInput:
            return False  # a wall or a thing is there
        before = len(lesson.taken)
        await capture(lesson, "picture")
        return len(lesson.taken) > before

    async def _stand(self, place: Pose, gesture: Gesture | None) -> None:
        """Face the robot, or turn aside."""
        robot = await self._ask({"do": "truth"})
        facing = math.atan2(robot["y_m"] - place.y, robot["x_m"] - place.x)
        turned = math.pi / 2 if gesture is not None and gesture.name == "side" else 0.0
        wish = {"id": ID, "x_m": place.x, "y_m": place.y, "heading_rad": facing + turned, "clothes": self._look}
        arms = ARMS[gesture.name] if gesture is not None else ""
        await self._ask({"do": "place", "what": "person", **wish, "gesture": arms})
