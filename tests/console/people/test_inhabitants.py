"""Who stands in the simulated room when the console starts."""

import asyncio
import math

import pytest

from console.people import inhabitants
from console.people.inhabitants import INHABITANTS, move_in
from core.errors import Unavailable
from core.robots.requests import PlacedThing, PlaceThing, ReadPlan
from tests.console.in_process import InProcessRobot


@pytest.mark.parametrize("url", INHABITANTS)
def test_they_have_room_and_stand_clear_of_the_way_ahead(url: str) -> None:
    robot = InProcessRobot(url)

    async def place(person: PlaceThing) -> PlacedThing:
        return robot.ask(person)

    robot.start()
    try:
        asyncio.run(move_in(place, url))
        there = {one.id: one for one in robot.ask(ReadPlan()).things if one.what == "person"}
    finally:
        robot.close()
    assert set(there) == {"Ann", "Bob"}
    for one in there.values():
        assert abs(one.y_m) > 0.8, "the robot drives straight ahead between them"
        assert 1.0 < math.hypot(one.x_m, one.y_m) < 4.0, "near enough to be heard and seen"


def test_a_driver_that_comes_late_is_waited_for_and_other_robots_have_nobody(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(inhabitants, "RETRY_PAUSE_S", 0.0)
    asked: list[str | None] = []

    async def place(person: PlaceThing) -> PlacedThing:
        asked.append(person.id)
        if len(asked) < 3:
            raise Unavailable("not yet")
        return PlacedThing(
            id=person.id or "",
            what="person",
            x_m=0,
            y_m=0,
            heading_rad=0,
            length_m=0,
            depth_m=0,
            height_m=0,
            fixed=False,
        )

    asyncio.run(move_in(place, "sim:lab"))
    assert asked == ["Ann", "Ann", "Ann", "Bob"]
    asyncio.run(move_in(place, "serial:/dev/ttyUSB0"))
    assert len(asked) == 4
