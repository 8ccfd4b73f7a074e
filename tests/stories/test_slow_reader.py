"""Words that are read late, and the rest of a sentence with STOP in it: at the page's microphone and in the room."""

import asyncio
import random
from pathlib import Path
from typing import Any

import pytest

from tests.stories.virtual_time import virtual_time
from tests.stories.words_in_time import ANNA, GUEST, Page, Story, Uttered


def told(folder: Path, tell: Any) -> Story:
    """A console at which Anna drives, with her page open, and what `tell` does there."""
    with virtual_time(random.Random(1)) as (loop, clock):
        story = Story(1, folder, loop, clock)
        story.slow = 0.2
        story.chance.random = lambda: 0.5  # type: ignore[method-assign]  # nothing stalls, the pilot refuses nothing

        async def all_of_it() -> None:
            story.pages["a"] = Page(story, ANNA, control=True)
            story.voice_commands.take_on(ANNA)
            tasks = [asyncio.ensure_future(one) for one in (story.room(), story.ticks())]
            await asyncio.sleep(1.0)
            await tell(story)
            await asyncio.sleep(20.0)
            for task in tasks:
                task.cancel()

        loop.run_until_complete(all_of_it())
        return story


async def say(story: Story, source: str, words: str, *, stop: bool = False) -> Uttered:
    """A person says this in one second, with STOP in the middle of it or not."""
    one = Uttered(words, source, "a", story.now, story.now + 1.0, story.now + 0.5 if stop else float("inf"))
    story.seen.uttered[words] = one
    if source == "voice":
        story.pages["a"].speak(one)
    else:
        story.room_reader.say(one, -50.0)
    await asyncio.sleep(1.1)
    return one


def rows(story: Story) -> list[tuple[str, str, str]]:
    """Of the history, oldest first: words, state, remark."""
    entries = story.history.newest_first(commands_only=True)
    return [(entry.heard_as or entry.words, entry.state, entry.remark) for entry in reversed(entries)]


@pytest.mark.parametrize("source", ["voice", "ears"])
@pytest.mark.parametrize("frozen", [0.0, 10.0])
def test_words_that_were_read_late_move_nothing(tmp_path: Path, source: str, frozen: float) -> None:
    async def tell(story: Story) -> None:
        story.frozen = story.now + frozen
        await say(story, source, "turn left")

    story = told(tmp_path, tell)
    assert [words for _, words in story.seen.motions] == ([] if frozen else ["turn left"])
    if frozen:
        assert rows(story)[-1][1] == "refused" and "too late to act on them" in rows(story)[-1][2]


async def stopped(story: Story) -> None:
    story.dispatcher.stop(GUEST, "rest")


async def typed(story: Story) -> None:
    story.seen.uttered["turn right"] = Uttered("turn right", "typed", "a", story.now, story.now)
    story.dispatcher.submit("turn right", "typed", ANNA)


async def took_over(story: Story) -> None:
    story.dispatcher.change_lease("release", ANNA)


async def closed(story: Story) -> None:
    story.pages["a"].close()


@pytest.mark.parametrize("source", ["voice", "ears"])
@pytest.mark.parametrize("what", [stopped, typed, took_over, closed])
def test_whatever_comes_after_the_words_makes_them_void(tmp_path: Path, source: str, what: Any) -> None:
    async def tell(story: Story) -> None:
        story.frozen = story.now + 1.8
        await say(story, source, "turn left")
        await what(story)

    assert "turn left" not in [words for _, words in told(tmp_path, tell).seen.motions]


@pytest.mark.parametrize("source", ["voice", "ears"])
def test_the_rest_of_a_sentence_with_stop_is_neither_obeyed_nor_offered(tmp_path: Path, source: str) -> None:
    async def tell(story: Story) -> None:
        for words in ("turn left", "start"):
            await say(story, source, words, stop=True)
            await asyncio.sleep(1.0)

    story = told(tmp_path, tell)
    assert story.seen.motions == [] and len(story.seen.stops) >= 2
    assert {state for words, state, _ in rows(story) if words not in ("stop moving", "")} <= {"refused"}
    if source == "voice":
        final = [one for one in story.pages["a"].heard if one["kind"] == "transcript" and one["final"]]
        assert [(one["accepted"], one["heard_as"], one["suggestions"]) for one in final] == [
            (True, "stop moving", [])
        ] * 2
    else:
        assert [(one.accepted, one.command, one.suggested_commands) for one in story.transcriber.utterances] == [
            (True, "stop moving", ())
        ] * 2


@pytest.mark.parametrize("source", ["voice", "ears"])
def test_stop_at_a_place_stops_first_and_then_goes_there(tmp_path: Path, source: str) -> None:
    async def tell(story: Story) -> None:
        await say(story, source, "stop at 1 and 0.5", stop=True)

    story = told(tmp_path, tell)
    assert [words for _, words in story.seen.motions] == ["stop at 1 and 0.5"]
    assert story.seen.stops and story.seen.wrong == []


def test_a_stop_in_another_turn_is_obeyed_although_the_clock_of_the_sound_began_anew(tmp_path: Path) -> None:
    async def tell(story: Story) -> None:
        page = story.pages["a"]
        for ahead in (5000.0, 0.0):
            page.ahead = ahead - story.now
            await say(story, "voice", "stop", stop=True)
            await asyncio.sleep(1.0)

    assert len(told(tmp_path, tell).seen.stops) == 2


@pytest.mark.parametrize("source", ["voice", "ears"])
def test_what_waited_in_the_sockets_of_a_console_that_stood_still_is_not_obeyed(tmp_path: Path, source: str) -> None:
    """When the words came nobody knows: their sound looks as if it had come just now."""

    async def tell(story: Story) -> None:
        story.dispatcher.tick(story.now + 4.0)
        await say(story, source, "turn left")

    story = told(tmp_path, tell)
    assert story.seen.motions == [] and "stood still for 4." in rows(story)[-1][2]


@pytest.mark.parametrize("held_up", [0.0, 4.0])
def test_sound_of_a_link_that_held_it_up_is_as_old_as_the_state_that_its_page_had(
    tmp_path: Path, held_up: float
) -> None:
    async def tell(story: Story) -> None:
        story.state_times.note(7, story.now - held_up)
        story.pages["a"].seen = 7
        await say(story, "voice", "turn left")

    story = told(tmp_path, tell)
    assert bool(story.seen.motions) == (held_up == 0.0)
    assert not held_up or "too late to act on them" in rows(story)[-1][2]
