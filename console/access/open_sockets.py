"""Every open socket, whose it is, and how to close it."""

from collections.abc import Callable, Generator
from contextlib import contextmanager

from console.access.logins import Person

MAX_SOCKETS = 200
MOST_OF_ONE = 64  # of one person
RESERVED_SOCKETS = 16  # of all, for those who may drive
SERVICE_RESTART = 1012  # close code of RFC 6455: come again

Close = Callable[[int, str], None]


class TooMany(Exception):
    """There is no room for another socket; the text says why."""


class OpenSockets:
    """Lives on the event loop."""

    def __init__(self) -> None:
        self._open: dict[object, tuple[Person, Close]] = {}

    @contextmanager
    def room_for(self, person: Person, close: Close) -> Generator[None]:
        """Count a socket while it is open; `close(code, reason)` ends it. Raises TooMany."""
        of_one = sum(1 for other, _ in self._open.values() if other.id == person.id)
        if of_one >= MOST_OF_ONE:
            raise TooMany("You have too many sockets open; close some tabs.")
        if len(self._open) >= MAX_SOCKETS - (0 if person.may("operator") else RESERVED_SOCKETS):
            raise TooMany("Too many people watch now; try again later.")
        key = object()
        self._open[key] = (person, close)
        try:
            yield
        finally:
            del self._open[key]

    def close_of(self, person: Person, code: int, reason: str) -> None:
        for other, close in list(self._open.values()):
            if other.id == person.id:
                close(code, reason)

    def are_open(self, person: Person) -> bool:
        return any(other.id == person.id for other, _ in self._open.values())

    @property
    def people(self) -> int:
        """How many people have sockets open, however many each has."""
        return len({person.id for person, _ in self._open.values()})

    def close_all(self, reason: str) -> None:
        for _, close in list(self._open.values()):
            close(SERVICE_RESTART, reason)

    def __len__(self) -> int:
        return len(self._open)
