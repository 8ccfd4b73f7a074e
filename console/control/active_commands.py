"""Commands that are under way: who gave them, by which way, and what follows from that."""

from collections.abc import Container, Iterator
from dataclasses import dataclass

from console.access.logins import Person
from core.commands import spec_of
from core.commands.command import Command

# sources without a page, and how their sender shows that it still lives
RENEWED_BY = {"rest": 'send POST /api/lease {"do": "renew"} every second', "file": "touch speech.txt every second"}


@dataclass(frozen=True)
class ActiveCommand:
    person: Person
    source: str
    given: float  # [s]
    command: Command


@dataclass
class ActiveJog:
    """A press of the drive keys that is under way."""

    person: Person
    press: int
    entry: int
    seen: float  # [s] of its newest moving frame


class ActiveCommands:
    """By the number of their row in the history."""

    def __init__(self) -> None:
        self._commands: dict[int, ActiveCommand] = {}
        self._cancelled: set[int] = set()  # of them: the pilot has not said yet that they ended

    def __iter__(self) -> Iterator[int]:
        return iter(tuple(self._commands))

    def __len__(self) -> int:
        return len(self._commands)

    def begin(self, number: int, active: ActiveCommand) -> None:
        self._commands[number] = active

    def end(self, number: int) -> None:
        self._commands.pop(number, None)
        self._cancelled.discard(number)

    def cancel(self) -> None:
        self._cancelled |= self._commands.keys()

    def clear(self) -> None:
        self._commands.clear()
        self._cancelled.clear()

    def given(self) -> list[float]:
        """When each was given [s]."""
        return [active.given for active in self._commands.values()]

    def busy_besides(self, sources: Container[str]) -> bool:
        """Return whether a goal is under way that came another way than these; an endless command has no goal."""
        return any(
            not spec_of(active.command.name).endless and active.source not in sources
            for active in self._commands.values()
        )

    def obeys(self, number: int) -> bool:
        """Return whether this is the newest, and not cancelled."""
        return number == next(reversed(self._commands), None) and number not in self._cancelled

    def does(self, command: Command) -> bool:
        """Return whether the newest is this very command, so that saying it again asks for nothing new."""
        number = next(reversed(self._commands), 0)
        newest = self._commands.get(number)
        return (
            newest is not None
            and self.obeys(number)
            and spec_of(command.name).idempotent
            and command.call is None
            and (newest.command.name, newest.command.numbers) == (command.name, command.numbers)
        )

    def keeps_lease(self, holder: Person | None) -> bool:
        """Return whether the holder sent a command without a page that has bounds of its own and is not over."""
        return any(
            active.person == holder and active.source in RENEWED_BY and not spec_of(active.command.name).endless
            for active in self._commands.values()
        )

    def how_to_renew(self) -> str:
        """How to keep an endless command going that was sent without a page, a sentence; "" where there is none."""
        for active in self._commands.values():
            if spec_of(active.command.name).endless and active.source in RENEWED_BY:
                said, how = active.command.heard_as, RENEWED_BY[active.source]
                return f" “{said}” goes on only while its sender renews it: {how}."
        return ""
