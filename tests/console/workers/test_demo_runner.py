import asyncio
from collections.abc import Awaitable, Callable

import pytest

from console.http.problems import Problem
from console.workers.demo_runner import BROKE_OFF, Demo, DemoRunner
from core.errors import Refused


class Room:
    """Notes who does what."""

    def __init__(self) -> None:
        self.seen: list[str] = []

    def demo(self, name: str, run: Callable[[], Awaitable[None]] | None = None) -> Demo:
        note = self.seen.append

        async def forever() -> None:
            note(f"{name} shows")
            await asyncio.Event().wait()

        async def leave() -> None:
            await asyncio.sleep(0)
            note(f"{name} leaves")

        return Demo(
            name,
            run or forever,
            leave,
            lambda: note(f"{name} begins"),
            lambda: note(f"{name} ends"),
            self.seen.append,
        )


async def until_over(runner: DemoRunner, session: str) -> None:
    async with asyncio.timeout(5.0):
        while runner.shows(session):
            await asyncio.sleep(0)


def test_the_former_demonstration_leaves_the_room_before_the_next_begins() -> None:
    room, runner = Room(), DemoRunner()

    async def work() -> None:
        await runner.start(room.demo("a"))
        await asyncio.sleep(0)
        assert runner.shows("a") and not runner.shows("b")
        await runner.start(room.demo("b"))
        assert runner.shows("b") and not runner.shows("a")
        await runner.stop()
        assert not runner.shows("b")

    asyncio.run(work())
    assert room.seen == ["a begins", "a shows", "a leaves", "a ends", "b begins", "b ends"]


def test_two_that_are_started_at_once_follow_each_other() -> None:
    room, runner = Room(), DemoRunner()

    async def work() -> None:
        await runner.start(room.demo("a"))
        await asyncio.sleep(0)
        await asyncio.gather(runner.start(room.demo("b")), runner.start(room.demo("c")))
        assert runner.shows("c")
        await runner.stop()

    asyncio.run(work())
    assert [words for words in room.seen if "shows" not in words and "leaves" not in words] == [
        *("a begins", "a ends", "b begins", "b ends", "c begins", "c ends")
    ]


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (Refused("There is no room."), "There is no room."),
        (Problem(503, "No picture comes."), "No picture comes."),
        (ValueError("a slip of ours"), BROKE_OFF),
    ],
)
def test_a_demonstration_that_fails_says_why_and_leaves_the_room(wrong: Exception, words: str) -> None:
    room, runner = Room(), DemoRunner()

    async def run() -> None:
        raise wrong

    async def work() -> None:
        await runner.start(room.demo("a", run))
        await until_over(runner, "a")

    asyncio.run(work())
    assert room.seen == ["a begins", words, "a leaves", "a ends"]


def test_a_demonstration_that_is_cancelled_leaves_the_room_although_nobody_waits() -> None:
    room, runner = Room(), DemoRunner()

    async def work() -> None:
        await runner.start(room.demo("a"))
        await asyncio.sleep(0)
        runner.cancel()
        await until_over(runner, "a")

    asyncio.run(work())
    assert room.seen == ["a begins", "a shows", "a leaves", "a ends"]
