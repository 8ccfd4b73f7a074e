"""Obeying: which command is under way, how it goes, and how it ends (Fig. 6: the last command wins)."""

from __future__ import annotations

import threading
from collections import deque
from dataclasses import dataclass, replace

from core.commands import kind_of
from core.commands.command import Action, Command
from core.errors import Refused
from core.gate import ZERO, Twist
from core.message import Array
from core.navigation.surroundings import Surroundings
from core.perception.people.person import PersonSeen
from core.snapshot import Ending, Undertaking


@dataclass(frozen=True)
class _Order:
    """A command that came in."""

    id: int
    command: Command
    source: str
    who: str


@dataclass(frozen=True)
class _Cancel:
    """An end that came in."""

    state: Ending
    why: str


class Obedience:
    """Owns the undertaking under way. Any thread may `tell` and `cancel`; the pilot's thread does the rest."""

    def __init__(self) -> None:
        self._door = threading.Lock()
        self._inbox: deque[_Order | _Cancel] = deque()
        self._next: tuple[_Order, float] | None = None  # came in while another is under way, at this stamp [s]
        self._command: Command | None = None
        self._action: Action | None = None
        self._paused = 0.0  # [s] for which the undertaking has waited; its clock stood meanwhile
        self._endings: list[Undertaking] = []
        self.undertaking: Undertaking | None = None  # the one under way
        self.path: Array | None = None  # (P, 2) [m], world
        self.goal: Array | None = None  # (2,) [m], world
        self.person: PersonSeen | None = None  # who is looked at

    def tell(self, undertaking_id: int, command: Command, source: str, who: str) -> None:
        """Obey this from the next frame on; whatever is under way then is pre-empted."""
        with self._door:
            self._inbox.append(_Order(undertaking_id, command, source, who))

    def cancel(self, state: Ending, why: str) -> None:
        """End whatever was told before this, in that state and for that reason."""
        with self._door:
            self._inbox.append(_Cancel(state, why))

    def open_inbox(self, stamp: float) -> None:
        """Take in what was told since the last frame, in its order.

        A command that moves waits for `drive` while another one moves the robot: when it cannot begin, it is refused
        and the other goes on.
        """
        with self._door:
            letters = list(self._inbox)
            self._inbox.clear()
        for letter in letters:
            if isinstance(letter, _Cancel):
                self.end(letter.state, letter.why)
                continue
            self._end_next("pre-empted", _came_after(letter))
            if self._action is not None and kind_of(letter.command.name).moves:
                self._next = letter, stamp
            else:
                self._adopt(letter, stamp)

    def drive(self, here: Surroundings, wait_for: str = "") -> Twist:
        """One frame of obeying → what to ask of the gate. `wait_for`: why nothing may begin to move yet."""
        if self._next is not None:
            self._adopt(*self._next) if wait_for else self._begin(*self._next, here)
        if self.undertaking is None or self._command is None:
            return ZERO
        kind = kind_of(self._command.name)
        here = replace(here, stamp=here.stamp - self._paused)
        if wait_for and kind.moves and self._action is None:
            self.undertaking = replace(self.undertaking, remark=wait_for)
            return ZERO
        try:
            if self._action is None:
                self._action = kind.begin(self._command, here)
            progress = self._action.drive(here)
        except Refused as refusal:
            self.end("refused", str(refusal))
            return ZERO
        if progress.path is not None:
            self.path = progress.path
        if progress.goal is not None:
            self.goal = progress.goal
        self.person = progress.person
        self.undertaking = replace(self.undertaking, remark=progress.remark, progress=progress.fraction)
        if progress.finished:
            self.end("done" if progress.finished == "done" else "failed", progress.remark)
            return ZERO
        return Twist(float(progress.twist.v), float(progress.twist.w))  # the gate takes no numpy numbers

    def only_turn(self, rate: float, why: str, passed: float) -> Twist:
        """Wait, and turn on the spot at `rate` [rad/s] by leave of the command under way, for `passed` [s]."""
        if self._next is not None:
            self._adopt(*self._next)
        if self.undertaking is None:
            return ZERO
        self._paused += passed
        self.path = self.goal = self.person = None
        self.undertaking = replace(self.undertaking, remark=why, progress=None)
        return Twist(0.0, rate)

    def end(self, state: Ending, why: str) -> None:
        """The undertaking under way, if any, is over; nothing of it stays, nor of one that would have come next."""
        self._end_next(state, why)
        if self.undertaking is not None:
            self._endings.append(replace(self.undertaking, state=state, remark=why))
        self._paused = 0.0
        self.undertaking = self._command = self._action = self.path = self.goal = self.person = None

    def _end_next(self, state: Ending, why: str) -> None:
        """What came in and has not begun is over."""
        if self._next is not None:
            self._endings.append(replace(_undertaking(*self._next), state=state, remark=why))
        self._next = None

    def _adopt(self, letter: _Order, stamp: float, action: Action | None = None) -> None:
        """This is under way from now on, in place of the other."""
        self._next = None
        self.end("pre-empted", _came_after(letter))
        self._command, self._action, self.undertaking = letter.command, action, _undertaking(letter, stamp)

    def _begin(self, letter: _Order, stamp: float, here: Surroundings) -> None:
        """What came in takes the other's place, if it can begin."""
        try:
            self._adopt(letter, stamp, kind_of(letter.command.name).begin(letter.command, here))
        except Refused as refusal:
            self._end_next("refused", str(refusal))

    def take_endings(self) -> tuple[Undertaking, ...]:
        """Those that ended since the last call: every undertaking exactly once."""
        endings, self._endings = tuple(self._endings), []
        return endings


def _undertaking(letter: _Order, stamp: float) -> Undertaking:
    """A command that came in at `stamp` [s], as it is shown."""
    return Undertaking(
        id=letter.id,
        name=letter.command.name,
        numbers=dict(letter.command.numbers),
        heard_as=letter.command.heard_as,
        source=letter.source,
        who=letter.who,
        stamp=stamp,
    )


def _came_after(letter: _Order) -> str:
    return f"“{letter.command.heard_as}” came after it."
