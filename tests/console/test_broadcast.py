"""The newest wins; nobody waits for anybody."""

import asyncio

from console.broadcast import MAX_ANSWERS, Broadcaster, Subscriber


def run(story) -> None:
    asyncio.run(asyncio.wait_for(story(), 10))


def test_a_slow_viewer_skips_to_the_newest() -> None:
    async def story() -> None:
        hub, viewer = Broadcaster(), Subscriber("state")
        hub.viewers.add(viewer)
        for number in range(1000):
            hub.publish("state", str(number))
        assert await viewer.next(hub) == "999"
        waiting = asyncio.create_task(viewer.next(hub))
        await asyncio.sleep(0.01)
        assert not waiting.done()
        hub.publish("state", "new")
        assert await waiting == "new"

    run(story)


def test_a_viewer_that_comes_late_gets_the_newest_at_once() -> None:
    async def story() -> None:
        hub, first, late = Broadcaster(), Subscriber("state"), Subscriber("state")
        hub.join(first)
        hub.publish("state", "newest")
        hub.join(late)
        assert await late.next(hub) == "newest"

    run(story)


def test_what_was_made_when_someone_looked_last_is_not_shown_to_who_comes_next() -> None:
    async def story() -> None:
        hub, first, next_one = Broadcaster(), Subscriber("state", "camera"), Subscriber("state")
        hub.join(first)
        hub.publish("state", "old")
        hub.publish("camera", b"old")
        hub.viewers.discard(first)
        hub.join(next_one)
        waiting = asyncio.create_task(next_one.next(hub))
        await asyncio.sleep(0.01)
        assert not waiting.done()
        hub.publish("state", "new")
        assert await waiting == "new"
        hub.want(next_one, "camera", wanted=True)
        hub.publish("camera", b"new")
        assert await next_one.next(hub) == b"new"

    run(story)


def test_every_kind_has_its_turn_however_often_the_other_changes() -> None:
    async def story() -> None:
        hub, viewer = Broadcaster(), Subscriber("state", "camera")
        hub.viewers.add(viewer)
        seen: list[object] = []
        for number in range(20):
            hub.publish("state", f"s{number}")
            hub.publish("camera", b"c")
            seen.append(await viewer.next(hub))
        assert seen.count(b"c") == 10

    run(story)


def test_answers_come_first_and_none_is_lost() -> None:
    async def story() -> None:
        hub, viewer = Broadcaster(), Subscriber("state")
        hub.viewers.add(viewer)
        hub.publish("state", "state")
        viewer.tell("one")
        viewer.tell("two")
        assert [await viewer.next(hub) for _ in range(3)] == ["one", "two", "state"]

    run(story)


def test_one_who_asks_and_never_reads_is_closed_and_memory_stays_bounded() -> None:
    async def story() -> None:
        hub, viewer = Broadcaster(), Subscriber("state")
        for _ in range(MAX_ANSWERS + 10):
            viewer.tell("answer")
        assert viewer.closing is not None and viewer.closing.code == 1008
        assert await viewer.next(hub) is None

    run(story)


def test_the_first_reason_to_close_is_the_one_told() -> None:
    viewer = Subscriber("state")
    viewer.close(1012, "The console is ending.")
    viewer.close(1000, "")
    assert viewer.closing is not None and viewer.closing.code == 1012


def test_what_nobody_wants_need_not_be_made() -> None:
    hub, viewer = Broadcaster(), Subscriber("state", "camera")
    assert not hub.watched("camera")
    hub.viewers.add(viewer)
    assert hub.watched("camera")
    viewer.want("camera", False)
    assert not hub.watched("camera") and hub.watched("state")


def test_a_viewer_that_comes_while_the_pilot_asks_who_watches_disturbs_nothing() -> None:
    hub, viewer = Broadcaster(), Subscriber("state")

    class Wants(set[str]):
        def __contains__(self, kind: object) -> bool:
            hub.viewers.add(Subscriber("state"))  # as the event loop does between two looks of the pilot's thread
            return super().__contains__(kind)

    viewer.wants = Wants(("state",))
    hub.join(viewer)
    assert not hub.watched("camera") and len(hub.viewers) > 1
