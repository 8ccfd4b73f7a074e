"""The lease: one drives, taking over is explicit, whoever is gone loses it after five seconds."""

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from console.access.logins import Person
from console.control.lease import GRACE_S, Lease
from core.errors import Refused

ANNA, BERT = Person("a", "Anna"), Person("b", "Bert")


def test_a_free_lease_is_taken_by_whoever_asks_first() -> None:
    lease = Lease()
    lease.acquire(ANNA, 0.0)
    assert lease.held_by(ANNA) and lease.epoch == 1
    with pytest.raises(Refused, match="Anna drives now"):
        lease.acquire(BERT, 0.1)


def test_asking_again_renews_and_changes_nothing() -> None:
    lease = Lease()
    lease.acquire(ANNA, 0.0)
    lease.acquire(ANNA, 4.9)
    assert lease.epoch == 1
    assert lease.tick(9.8, obeying=False) is None
    assert lease.tick(10.0, obeying=False) == ANNA


def test_taking_over_raises_the_epoch_and_the_former_driver_is_stale() -> None:
    lease = Lease()
    lease.acquire(ANNA, 0.0)
    lease.take(BERT, 1.0)
    assert lease.held_by(BERT) and lease.epoch == 2


def test_who_asks_gets_control_only_from_its_holder_and_within_ten_seconds() -> None:
    lease = Lease()
    lease.ask(ANNA, 0.0)
    assert lease.held_by(ANNA), "what is free needs no question"
    lease.ask(BERT, 1.0)
    assert lease.held_by(ANNA) and lease.epoch == 1 and lease.request is not None
    with pytest.raises(Refused, match="Bert has asked already"):
        lease.ask(Person("c", "Cleo"), 1.0)
    with pytest.raises(Refused, match="Nobody asks you"):
        lease.answer(BERT, 1.0, give=True)
    assert lease.answer(ANNA, 2.0, give=False) == BERT and lease.held_by(ANNA)
    lease.ask(BERT, 3.0)
    lease.ask(BERT, 12.0)
    assert lease.tick_request(12.9) is None and lease.tick_request(13.0) == BERT, "asking again wins no time"
    lease.ask(BERT, 14.0)
    assert lease.answer(ANNA, 15.0, give=True) == BERT
    assert lease.held_by(BERT) and lease.epoch == 2 and lease.request is None


@pytest.mark.parametrize("end", ["release", "take", "forget"])
def test_a_request_ends_with_the_lease_it_asks_for(end: str) -> None:
    lease, cleo = Lease(), Person("c", "Cleo")
    lease.acquire(ANNA, 0.0)
    lease.ask(BERT, 0.0)
    {
        "release": lambda: lease.release(ANNA),
        "take": lambda: lease.take(cleo, 1.0),
        "forget": lambda: lease.forget(BERT),
    }[end]()
    assert lease.request is None


def test_only_the_driver_can_give_the_wheel_back() -> None:
    lease = Lease()
    lease.acquire(ANNA, 0.0)
    with pytest.raises(Refused, match="Anna drives now"):
        lease.release(BERT)
    lease.release(ANNA)
    assert lease.holder is None and lease.epoch == 2
    lease.release(BERT)
    assert lease.epoch == 2


def test_a_reload_within_the_grace_keeps_the_lease() -> None:
    lease = Lease()
    lease.connected(ANNA, 0.0)
    lease.acquire(ANNA, 0.0)
    lease.disconnected(ANNA)
    assert lease.tick(GRACE_S - 0.1, obeying=False) is None
    lease.connected(ANNA, GRACE_S - 0.1)
    assert lease.tick(2 * GRACE_S - 0.2, obeying=False) is None and lease.epoch == 1


def test_an_open_socket_whose_page_says_nothing_keeps_no_lease() -> None:
    lease = Lease()
    lease.connected(ANNA, 0.0)
    lease.acquire(ANNA, 0.0)
    for second in range(20):
        lease.active(ANNA, float(second))
        assert lease.tick(second + 0.9, obeying=False) is None
    assert lease.tick(19.0 + GRACE_S + 0.01, obeying=False) == ANNA
    assert lease.holder is None and lease.epoch == 2 and lease.is_present(ANNA)


def test_who_has_a_socket_left_is_present() -> None:
    lease = Lease()
    for _ in range(2):
        lease.connected(ANNA, 0.0)
    assert not lease.is_last_page(ANNA)
    lease.disconnected(ANNA)
    assert lease.is_last_page(ANNA) and lease.is_present(ANNA) and not lease.is_present(BERT)
    lease.disconnected(ANNA)
    assert not lease.is_present(ANNA)


def test_an_order_sent_without_a_socket_keeps_the_lease_until_it_ends() -> None:
    lease = Lease()
    lease.acquire(ANNA, 0.0)
    assert lease.tick(60.0, obeying=True) is None
    assert lease.tick(60.0 + GRACE_S + 0.01, obeying=False) == ANNA


def test_others_activity_does_not_renew() -> None:
    lease = Lease()
    lease.acquire(ANNA, 0.0)
    lease.active(BERT, 5.0)
    assert lease.tick(5.1, obeying=False) == ANNA


class AnyOrderOfThings(RuleBasedStateMachine):
    """Whatever happens: one holder, and every change of holder raises the epoch by one."""

    def __init__(self) -> None:
        super().__init__()
        self.lease = Lease()
        self.now = 0.0
        self.before: tuple[Person | None, int] = (None, 0)

    people = st.sampled_from([ANNA, BERT, Person("c", "Cleo")])

    @rule(
        who=people, what=st.sampled_from(["acquire", "ask", "take", "release", "forget", "connected", "disconnected"])
    )
    def act(self, who: Person, what: str) -> None:
        untimed = {"release", "forget", "disconnected"}
        try:
            getattr(self.lease, what)(who, *(() if what in untimed else (self.now,)))
        except Refused:
            assert self.lease.holder is not None and not self.lease.held_by(who)

    @rule(who=people, give=st.booleans())
    def answer(self, who: Person, give: bool) -> None:
        asked = self.lease.request
        try:
            asker = self.lease.answer(who, self.now, give=give)
        except Refused:
            assert asked is None or not self.lease.held_by(who)
        else:
            assert self.lease.held_by(asker if give else who) and self.lease.request is None

    @rule(seconds=st.floats(0, 8), obeying=st.booleans())
    def wait(self, seconds: float, obeying: bool) -> None:
        self.now += seconds
        self.lease.tick(self.now, obeying=obeying)
        self.lease.tick_request(self.now)

    @invariant()
    def every_change_is_counted(self) -> None:
        holder, epoch = self.before
        request = self.lease.request
        assert request is None or (self.lease.holder is not None and not self.lease.held_by(request.person))
        assert self.lease.epoch == epoch + (self.lease.holder != holder)
        self.before = (self.lease.holder, self.lease.epoch)


AnyOrderOfThings.TestCase.settings = settings(max_examples=60, stateful_step_count=40, deadline=None)
TestAnyOrderOfThings = AnyOrderOfThings.TestCase
