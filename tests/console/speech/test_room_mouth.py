"""A browser's microphone at the mouth of someone in the simulated room."""

import asyncio
import math
from collections.abc import Callable, Coroutine
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from console.access.logins import Person
from console.speech.room_mouth import NEAREST, NOBODY, RoomMouth, hidden, speaker_in_room
from console.speech.voice_commands import ROOM
from core.errors import Refused
from core.robots.requests import FloorPlan, GroundTruth, PlacedThing, PlaceThing, Speak
from core.simulation.robot import SimulatedRobot
from tests.console.live import until

TONE = np.sin(np.arange(16_000) / 5)


class Room:
    """A simulated robot with people around it, and what its driver was asked for."""

    def __init__(self, *people: tuple[str, float, float]) -> None:
        self.robot = SimulatedRobot("lab")
        self.asked: list[Any] = []
        for name, x, y in people:
            self.robot.ask(PlaceThing("person", x, y, id=name))

    async def ask(self, request: Any) -> Any:
        self.asked.append(request)
        return self.robot.ask(request)

    @property
    def said(self) -> list[Speak]:
        return [one for one in self.asked if isinstance(one, Speak)]


def spoken(room: Room, act: Callable[[RoomMouth], Coroutine[Any, Any, None]]) -> tuple[list[str], Any]:
    """One turn to speak → the sentences of trouble, and the voice commands."""
    troubles: list[str] = []
    commands: Any = SimpleNamespace(at_console=False, operator=Person("a", "anna"))
    transcriber: Any = SimpleNamespace(stamp=0.0, read_to=-math.inf, trouble="", speaker=None)

    async def turn() -> None:
        mouth = RoomMouth(NEAREST, room.ask, transcriber, commands, troubles.append)
        await act(mouth)
        for _ in range(20):
            await asyncio.sleep(0.01)

    asyncio.run(turn())
    return troubles, commands


def test_what_is_said_sounds_from_the_nearest_person_until_the_button_is_released() -> None:
    room = Room(("Ann", 2.0, 1.2), ("Bob", 1.0, -0.8))

    async def act(mouth: RoomMouth) -> None:
        for piece in np.split(TONE, 50):
            mouth.add(piece)
            await asyncio.sleep(0)
        mouth.rest()
        mouth.add(TONE)

    troubles, commands = spoken(room, act)
    assert troubles == [] and commands.at_console
    assert {one.id for one in room.said} == {"Bob"}
    assert [one.more for one in room.said] == [True] * (len(room.said) - 1) + [False]
    assert sum(len(one.pcm or b"") for one in room.said) == pytest.approx(2 * len(TONE), abs=1000)


def test_after_a_stop_nothing_more_of_it_sounds() -> None:
    room = Room(("Ann", 2.0, 1.2))

    async def act(mouth: RoomMouth) -> None:
        mouth.add(TONE)
        await until(lambda: room.robot._voices._microphones and room.robot._voices._microphones.talking)
        mouth.hush()

    troubles, commands = spoken(room, act)
    assert troubles == [] and not commands.at_console
    assert room.robot._voices._microphones is not None and not room.robot._voices._microphones.talking


def test_after_a_turn_that_ended_before_its_speaker_was_known_nobody_speaks_through_a_mouth() -> None:
    troubles, commands = spoken(Room(("Ann", 2.0, 1.2)), stopped_at_once)
    assert troubles == [] and commands.speaker is ROOM


async def stopped_at_once(mouth: RoomMouth) -> None:
    mouth.hush()


def test_an_empty_room_is_said() -> None:
    async def act(mouth: RoomMouth) -> None:
        mouth.add(TONE)

    assert spoken(Room(), act)[0] == [NOBODY]
    with pytest.raises(Refused, match="Nobody"):
        asyncio.run(speaker_in_room(Room(("Ann", 2.0, 1.2)).ask, "Bob"))


def test_what_goes_wrong_with_a_turn_that_is_over_ends_no_later_one() -> None:
    async def act(mouth: RoomMouth) -> None:
        mouth.close()  # another press

    assert spoken(Room(), act)[0] == []


def test_a_wall_between_hides_a_person() -> None:
    wall = (1.0, -1.0, 1.0, 1.0)
    plan = FloorPlan(name="", segments=(wall,), circles=(), things=())
    robot = GroundTruth(x_m=0, y_m=0, heading_rad=0, stamp_s=0, clearance_m=1, contact=False)

    def person(x: float, y: float) -> PlacedThing:
        return PlacedThing(
            id="", what="person", x_m=x, y_m=y, heading_rad=0, length_m=0.3, depth_m=0.3, height_m=1.7, fixed=False
        )

    assert hidden(plan, robot, person(2.0, 0.0))
    assert not hidden(plan, robot, person(0.6, 0.0)) and not hidden(plan, robot, person(0.0, 2.0))
