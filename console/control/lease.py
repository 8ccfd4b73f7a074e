"""The operator lease: one person drives, all may watch, everyone may stop.

Pure logic on the time that is passed in. The caller compares `epoch` before and after: it rises with every
change, and the caller then takes the robot through zero (disarm, cancel, arm again for the holder, if there is one).
"""

from dataclasses import dataclass

from console.access.logins import Person
from core.errors import Refused
from core.sentences import Statement

ANSWER_TIME_S = 10.0  # that the holder has to answer who asks for control
GRACE_S = 5.0  # without a sign of life of the holder: a message of their page, a request of their program
OTHER_DRIVES = Statement("lease.other_drives")


@dataclass(frozen=True)
class ControlRequest:
    """Another operator asks the holder for control."""

    person: Person
    end: float  # [s]


class Lease:
    def __init__(self) -> None:
        self.epoch = 0
        self.holder: Person | None = None
        self.request: ControlRequest | None = None
        self._seen = 0.0
        self._sockets: dict[str, int] = {}

    def held_by(self, person: Person) -> bool:
        return self.holder is not None and self.holder.id == person.id

    def rank(self, person: Person) -> int:
        """Return the priority of a person where only one can be served: who drives, operators, viewers."""
        return 2 if self.held_by(person) else int(person.may("operator"))

    def check_not_anothers(self, person: Person) -> None:
        """Raises Refused with the operator's name while another person drives."""
        if self.holder is not None and not self.held_by(person):
            raise Refused(OTHER_DRIVES(holder=self.holder.name))

    def acquire(self, person: Person, now: float) -> None:
        """Take the lease when it is free; renews it for its holder. Raises Refused with the holder's name."""
        self.check_not_anothers(person)
        if self.holder is None:
            self._change(person)
        self._seen = now

    def take(self, person: Person, now: float) -> None:
        if not self.held_by(person):
            self._change(person)
        self._seen = now

    def ask(self, person: Person, now: float) -> None:
        """Ask the holder for control; a free lease is taken. Raises Refused while another one asks."""
        if self.holder is None or self.held_by(person):
            self.acquire(person, now)
        elif self.request is not None and self.request.person.id != person.id:
            raise Refused(Statement("lease.has_asked", name=self.request.person.name))
        elif self.request is None:
            self.request = ControlRequest(person, now + ANSWER_TIME_S)

    def answer(self, person: Person, now: float, *, give: bool) -> Person:
        """The holder gives control to who asks for it, or keeps it → who asked. Raises Refused."""
        if not self.held_by(person) or self.request is None:
            raise Refused(Statement("lease.nobody_asks"))
        asker, self.request = self.request.person, None
        if give:
            self.take(asker, now)
        return asker

    def tick_request(self, now: float) -> Person | None:
        """End a request that was not answered in time; returns whose it was."""
        if self.request is None or now < self.request.end:
            return None
        asker, self.request = self.request.person, None
        return asker

    def release(self, person: Person) -> None:
        """Give it back. Raises Refused when another person holds it."""
        if self.holder is None:
            return
        if not self.held_by(person):
            raise Refused(Statement("lease.not_yours", holder=self.holder.name))
        self._change(None)

    def forget(self, person: Person) -> None:
        """The person signed out: the lease is free at once."""
        if self.request is not None and self.request.person.id == person.id:
            self.request = None
        if self.held_by(person):
            self._change(None)

    def is_present(self, person: Person) -> bool:
        return person.id in self._sockets

    def connected(self, person: Person, now: float) -> None:
        """One more socket of this person is open."""
        self._sockets[person.id] = self._sockets.get(person.id, 0) + 1
        self.active(person, now)

    def is_last_page(self, person: Person) -> bool:
        """No more than one socket of this person is open."""
        return self._sockets.get(person.id, 0) <= 1

    def disconnected(self, person: Person) -> None:
        """A socket of this person is gone."""
        left = self._sockets.get(person.id, 0) - 1
        if left > 0:
            self._sockets[person.id] = left
        else:
            self._sockets.pop(person.id, None)

    def active(self, person: Person, now: float) -> None:
        """A sign of life: it renews the lease of its holder. A socket that is merely open is none."""
        if self.held_by(person):
            self._seen = now

    def tick(self, now: float, *, obeying: bool) -> Person | None:
        """Free the lease when its holder is gone; returns who lost it.

        `obeying`: a command that the holder sent without a page is still under way; it has bounds of its own and
        keeps the lease until it ends.
        """
        holder = self.holder
        if holder is None:
            return None
        if obeying:
            self._seen = now
        if now - self._seen <= GRACE_S:
            return None
        self._change(None)
        return holder

    def _change(self, person: Person | None) -> None:
        self.epoch += 1
        self.holder = person
        self.request = None
