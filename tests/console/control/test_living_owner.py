"""Who keeps the robot going: signs of life renew the lease, an endless command needs them, and what is repeated."""

import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from console.access.logins import Person
from console.control.command_freshness import MAX_REMEMBERED_STATES, Spoken, StaleWords, StateTimes
from console.control.dispatcher import CommandDispatcher
from console.control.history import History
from console.control.lease import GRACE_S, Lease
from console.control.notices import Notifications
from console.control.text_file_commands import WRITER
from console.http.problems import Problem
from core.commands.command import Command
from core.errors import Refused
from core.gate.status import GateStatus
from core.perception.people.voice_bearing import VoiceBearing
from tests.console.live import Live, hear, say

ANNA, BERT = Person("a", "Anna", "operator"), Person("b", "Bert", "operator")


class Robot:
    """A robot and its pilot that do as they are told."""

    profile = SimpleNamespace(drives=True)
    trouble = ""

    def __init__(self) -> None:
        self.cancelled: list[str] = []
        self.told: list[str] = []
        self.refuses = False

    def __getattr__(self, name: str) -> Any:
        return lambda *_: None

    def status(self) -> GateStatus:
        return GateStatus(state="armed")

    def link(self) -> tuple[str, float]:
        return "live", 0.0

    def tell(self, number: int, command: Command, source: str, who: str) -> None:
        if self.refuses:
            raise Refused("Not now.")
        self.told.append(command.heard_as)

    def cancel(self, state: str, why: str) -> None:
        self.cancelled.append(why)


@pytest.fixture
def robot() -> Robot:
    return Robot()


@pytest.fixture
def lease() -> Lease:
    return Lease()


@pytest.fixture
def dispatcher(robot: Robot, lease: Lease, tmp_path: Path) -> CommandDispatcher:
    dispatcher = CommandDispatcher(robot, lease, History(tmp_path, lambda _: None), Notifications())  # type: ignore[arg-type]
    dispatcher.pilot = robot  # type: ignore[assignment]
    return dispatcher


@pytest.mark.parametrize(
    ("words", "source", "who", "goes_on"),
    [
        ("follow wall", "rest", ANNA, False),
        ("follow me", "rest", ANNA, False),
        ("continue 20 meters", "rest", ANNA, True),
        ("stop at 1 and 0.5", "rest", ANNA, True),
        ("follow wall", "file", WRITER, False),
        ("continue 3 meters", "file", WRITER, True),
        ("follow wall", "typed", ANNA, False),
        ("continue 20 meters", "typed", ANNA, False),
    ],
)
def test_what_goes_on_without_a_sign_of_life(
    dispatcher: CommandDispatcher, robot: Robot, lease: Lease, words: str, source: str, who: Person, goes_on: bool
) -> None:
    entry = dispatcher.submit(words, source, who)
    begun = time.monotonic()
    dispatcher.tick(begun + GRACE_S - 0.5)
    assert robot.cancelled == [] and lease.held_by(who)
    dispatcher.tick(begun + GRACE_S + 0.5)
    assert lease.held_by(who) == goes_on
    assert robot.cancelled == [] if goes_on else f"{who.name} is gone" in robot.cancelled[0]
    if source != "typed" and not goes_on:
        assert entry.heard_as in robot.cancelled[0]
        assert ("POST /api/lease" if source == "rest" else "touch speech.txt") in robot.cancelled[0]


def test_an_endless_command_goes_on_while_its_owner_renews_the_lease(
    dispatcher: CommandDispatcher, robot: Robot, lease: Lease
) -> None:
    dispatcher.submit("follow wall", "rest", ANNA)
    now = time.monotonic()
    for second in range(60):
        lease.active(ANNA, now + second)
        dispatcher.tick(now + second + 0.9)
    assert robot.cancelled == []
    dispatcher.tick(now + 59 + GRACE_S + 0.1)
    assert len(robot.cancelled) == 1 and lease.holder is None


@pytest.mark.parametrize("words", ["follow wall", "follow me", "come here", "stop at 1 and 0.5"])
def test_the_same_command_again_is_under_way_already(dispatcher: CommandDispatcher, robot: Robot, words: str) -> None:
    dispatcher.submit(words, "rest", ANNA)
    with pytest.raises(Problem, match="The robot is already") as again:
        dispatcher.submit(words, "typed", ANNA)
    assert again.value.status == 409 and robot.told == [words] and robot.cancelled == []
    dispatcher.stop(BERT, "rest")  # the pilot has not said yet that it ended
    dispatcher.submit(words, "rest", ANNA)
    assert robot.told == [words, words]


@pytest.mark.parametrize("words", ["turn left", "continue 1 meters"])
def test_a_motion_that_has_an_end_of_its_own_is_made_again(
    dispatcher: CommandDispatcher, robot: Robot, words: str
) -> None:
    for _ in range(2):
        dispatcher.submit(words, "rest", ANNA)
    assert robot.told == [words, words]


def test_another_goal_and_a_new_call_are_other_commands(dispatcher: CommandDispatcher, robot: Robot) -> None:
    call = VoiceBearing(stamp=1.0, azimuth=0.5, sd=0.05, x=0.0, y=0.0)
    dispatcher.submit("stop at 1 and 0.5", "rest", ANNA)
    dispatcher.submit("stop at 1 and 0.6", "rest", ANNA)
    for _ in range(2):
        dispatcher.dispatch(Command(name="come_here", numbers={}, heard_as="come here", call=call), "ears", ANNA)
    assert len(robot.told) == 4


def test_what_is_refused_leaves_alone_what_is_under_way(dispatcher: CommandDispatcher, robot: Robot) -> None:
    ended: list[str] = []
    dispatcher.when_cancelled.append(lambda state, why, objected: ended.append(why))
    dispatcher.submit("follow wall", "rest", ANNA)
    ended.clear()
    robot.refuses = True
    for words, who in (("come here", ANNA), ("turn left", BERT), ("levitate", ANNA)):
        with pytest.raises(Problem):
            dispatcher.submit(words, "rest", who)
    assert ended == [] and robot.cancelled == []


def test_a_page_keeps_the_lease_by_what_it_says_and_not_by_being_open(
    live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("console.control.lease.GRACE_S", 1.5)
    with live.open() as line:
        say(line, kind="lease", do="acquire", ref=1)
        assert hear(line, "answer")["ok"]
        for _ in range(15):
            say(line, kind="echo", t=1.0)
            hear(line, "echo")
            time.sleep(0.2)
        assert live.runtime.lease.holder is not None
        hear(line, "state", true=lambda state: state["lease"]["holder"] is None)


def test_a_program_renews_the_lease_that_it_holds(live: Live) -> None:
    def ask(do: str, token: str) -> Any:
        return live.ask("POST", "/api/lease", {"do": do}, token=token)

    nobody = ask("renew", live.operator)
    assert nobody.status == 409 and "Ask for control" in nobody.json["detail"]
    epoch = ask("acquire", live.operator).json["epoch"]
    assert ask("renew", live.operator).json["epoch"] == epoch
    assert ask("renew", live.viewer).status == 403
    other = live.runtime.access.logins.issue("other", "operator")
    assert ask("renew", other).status == 409


def test_a_command_that_was_long_on_its_way_moves_nothing_and_stop_always_acts(live: Live) -> None:
    with live.open() as line:
        old = hear(line, "state")["seq"]
        for number in range(3):
            say(
                line,
                kind="command",
                text="turn left",
                source="typed",
                ref=number + 1,
                seen=hear(line, "state")["seq"],
            )
            assert hear(line, "answer")["ok"]
        begun = hear(line, "state")["stamp_s"]
        hear(line, "state", true=lambda state: state["stamp_s"] > begun + 2.1)  # by its own clock
        say(line, kind="command", text="turn left", source="typed", ref=4, seen=old)
        refused = hear(line, "answer")
        assert (refused["status"], "on its way" in refused["detail"]) == (409, True)
        say(line, kind="command", text="stop", source="typed", ref=5, seen=old)
        assert hear(line, "answer")["ok"]
        say(line, kind="command", text="turn left", source="typed", ref=6, seen=10**9)  # of another console's life
        assert hear(line, "answer")["ok"]


def test_what_was_typed_before_a_stop_that_its_sender_had_not_seen_moves_nothing(
    dispatcher: CommandDispatcher, robot: Robot
) -> None:
    now = time.monotonic()
    dispatcher.stop(ANNA, "page")
    dispatcher.submit("turn left", "typed", ANNA, Spoken(now, now))  # her own stop she knows, whatever her page shows
    dispatcher.stop(BERT, "page")
    with pytest.raises(StaleWords, match="Bert"):
        dispatcher.submit("turn right", "typed", ANNA, Spoken(now, now))
    dispatcher.submit("turn right", "typed", ANNA, Spoken.now())
    assert robot.told == ["turn left", "turn right"]


def test_what_names_a_state_is_as_old_as_that_and_never_younger_than_its_arrival() -> None:
    states = StateTimes()
    assert states.oldest(3, 50.0) == 50.0
    for seq in range(1, MAX_REMEMBERED_STATES + 10):
        states.note(seq, seq / 20)
    assert states.oldest(100, 99.0) == 5.0
    assert states.oldest(1, 99.0) == 0.5  # forgotten: not younger than the oldest that is known
    assert states.oldest(0, 99.0) == states.oldest(MAX_REMEMBERED_STATES + 10, 99.0) == 99.0


def test_control_is_given_to_who_asks_through_zero(dispatcher: CommandDispatcher, robot: Robot, lease: Lease) -> None:
    dispatcher.submit("follow wall", "rest", ANNA)
    dispatcher.change_lease("ask", BERT)
    assert lease.held_by(ANNA) and robot.cancelled == [], "asking changes nothing"
    dispatcher.change_lease("give", ANNA)
    assert lease.held_by(BERT) and robot.cancelled == ["Anna gave control to Bert."]
    dispatcher.change_lease("ask", ANNA)
    dispatcher.change_lease("keep", BERT)
    assert lease.held_by(BERT) and len(robot.cancelled) == 1
    dispatcher.change_lease("ask", ANNA)
    dispatcher.tick(time.monotonic() + 10.1)
    assert lease.request is None
