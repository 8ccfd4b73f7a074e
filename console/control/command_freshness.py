"""The freshness of words: one rule for every source of words, checked when the motion would begin.

Words older than `MAX_OBEYED_AGE_S` come too late. A stop by anyone, a hand on the keys, a newer command by any
source, a change of who drives, and the closing of the speaker's page make everything before void. All times are of
the console's monotonic clock; where a client's clock takes part, it only ever makes words older. How old words are is
counted by the clock of a simulated robot, which waits for a slow computer.
"""

from __future__ import annotations

import bisect
import math
import time
from collections import deque
from dataclasses import dataclass, replace

from console.access.logins import Person
from console.control.lease import Lease
from console.http.problems import Problem
from core.commands.confirmation_delay import MAX_OBEYED_AGE_S
from core.sentences import Statement

# The robot's clock and ours: when something of the robot's was, and how much time has passed for the robot since.

CLOCK_MEMORY_S = 30.0  # for which the robot's clock is known in ours
MAX_LEAD_S = 1.0  # by which what was sensed may be ahead of the newest frame: later, it is of the clock of before
MAX_REMEMBERED_STATES = 1200  # states: a minute


class RobotTime:
    """Lives on the event loop."""

    def __init__(self) -> None:
        self.simulated = False  # ages are counted by the robot's clock
        self.former_end = -math.inf  # [s] by ours: when the robot was last heard of before its clock began again
        self._moments: deque[tuple[float, float]] = deque()  # [s] by the robot's clock, and by ours

    def note(self, stamp: float, sensed: float) -> None:
        """A frame of this stamp [s], robot's clock, was sensed then [s], by ours."""
        if self._moments and stamp < self._moments[-1][0]:  # another clock: the robot was started again
            self.former_end = self._moments[-1][1]
            self._moments.clear()
        self._moments.append((stamp, sensed))
        while self._moments[0][0] < stamp - CLOCK_MEMORY_S:
            self._moments.popleft()

    def ours(self, stamp: float) -> float:
        """A moment [s] of the robot's clock → of ours."""
        if self.is_former(stamp):
            return self.former_end
        at, sensed = next((known for known in self._moments if known[0] >= stamp), self._moments[-1])
        return sensed - max(at - stamp, 0.0)

    def is_former(self, stamp: float) -> bool:
        """Return whether a moment [s] is one of the robot's clock before that began again."""
        return self.former_end > -math.inf and stamp > self._moments[-1][0] + MAX_LEAD_S

    def elapsed(self, since: float, until: float) -> float:
        """Time [s] that has passed between two moments of our clock, by the robot's where it is simulated."""
        if not self.simulated or not self._moments or since < self._moments[0][1]:
            return until - since
        return min(until - since, self._robots(until) - self._robots(since))

    def _robots(self, moment: float) -> float:
        """A moment [s] of our clock → of the robot's, as of the frame before it."""
        at = bisect.bisect_right(self._moments, moment, key=lambda known: known[1])
        return self._moments[max(at - 1, 0)][0]


class StateTimes:
    """When each state was made: what a page sends with the newest that it has cannot be older than that state.

    A link that was frozen delivers what was sent long ago as if it were new. A page that names a state dates what it
    sends by the console's own clock, and can only make it older. Lives on the event loop.
    """

    def __init__(self) -> None:
        self._made: deque[tuple[int, float]] = deque(maxlen=MAX_REMEMBERED_STATES)

    def note(self, seq: int, now: float) -> None:
        """This state is made now [s], monotonic."""
        self._made.append((seq, now))

    def oldest(self, seen: int, now: float) -> float:
        """The time [s] of a state; `now` where a page names none, or one that was never made here."""
        if not seen or not self._made or seen > self._made[-1][0]:
            return now
        return next((at for seq, at in self._made if seq >= seen), now)


EARS = "ears"  # source of words that the robot itself heard, and dated
SPOKEN_SOURCES = (EARS, "voice")  # sources of words that a person said aloud
READ_SOURCES = (*SPOKEN_SOURCES, "file")  # sources whose words were there before the console knew them
VOID = Statement("command.overtaken")
CLOSED = Statement("command.page_closed")
ABSENT = Statement("command.page_open_first")


@dataclass(frozen=True)
class Spoken:
    """When words were said [s], monotonic."""

    began: float
    ended: float
    taken: float | None = None  # when they became a command that waits: from then on their age does not count
    utterance: object = None  # whose own STOP does not make them void: "stop at x and y" begins with one

    @classmethod
    def now(cls) -> Spoken:
        now = time.monotonic()
        return cls(now, now)


@dataclass(frozen=True)
class _StopEvent:
    """A person stopped the robot, or dropped a pending command."""

    at: float  # [s]
    why: str
    who: str  # id of the person
    utterance: object = None  # that it was part of


class StaleWords(Problem):
    """Words that something overtook, or that came `late`."""

    def __init__(self, why: str, *, late: bool) -> None:
        super().__init__(409, why)
        self.late = late


class CommandFreshness:
    """Knows the newest event of each kind that makes words void. Lives on the event loop."""

    def __init__(self, lease: Lease) -> None:
        self.time = RobotTime()
        self._lease = lease
        self._stood, self._why_stood = -math.inf, ""  # [s] until when the console stood still
        self._stops: deque[_StopEvent] = deque(maxlen=3)
        self._since, self._why = -math.inf, ""  # [s] until when words are void for other reasons, and the newest one
        self._left: dict[str, float] = {}  # [s] when a page of this person closed

    def void(self, why: str, *, objector: Person | None = None, at: float | None = None) -> None:
        """Make all words before `at` [s], or until now, void. `objector`: who stopped; so is what is being said."""
        moment = math.nextafter(time.monotonic(), math.inf) if at is None else at
        if objector is not None:
            self._stops.append(_StopEvent(moment, why, objector.id))
        elif moment >= self._since:
            self._since, self._why = moment, why

    def stood_still(self, seconds: float, until: float) -> None:
        """The console did not run for so long [s]: what came by its sockets by `until` [s] looks newer than it is."""
        self._stood, self._why_stood = until, Statement("console.stood_still", seconds=f"{seconds:.1f}")

    def stopped_by(self, utterance: object) -> None:
        """The newest stop was part of this utterance."""
        newest = self._stops.pop()
        if self._stops and self._stops[-1].utterance is utterance:
            self._stops.pop()
        self._stops.append(replace(newest, utterance=utterance))

    def left(self, who: Person) -> None:
        """A page of this person closed: nothing moves the robot that they had said before."""
        now = time.monotonic()
        self._left = {person: at for person, at in self._left.items() if now - at < 60.0} | {who.id: now}

    def check(self, said: Spoken, source: str, who: Person) -> None:
        """Check that these words may move the robot. Raises StaleWords."""
        if why := self.why_not(said, source, who):
            raise StaleWords(why, late=bool(self.why_late(said, source)))

    def why_late(self, said: Spoken, source: str) -> str:
        """Why words of this age are not obeyed, a sentence; "" when they may be."""
        age = self.time.elapsed(said.ended, time.monotonic() if said.taken is None else said.taken)
        late = Statement("words.too_late") if source in READ_SOURCES else Statement("command.too_late")
        return late(delay=f"{age:.1f}") if age > MAX_OBEYED_AGE_S else ""

    def why_not(self, said: Spoken, source: str, who: Person) -> str:
        """Why these words do not move the robot, a sentence; "" when they may."""
        if late := self.why_late(said, source):
            return late
        if source not in READ_SOURCES:  # the page shows a stop of one's own before its state does
            unseen = (one for one in self._stops if said.ended < one.at and one.who != who.id)
            return next((VOID(what=one.why) for one in unseen), "")
        if said.ended < self._stood and not (source == EARS and self.time.simulated):
            return VOID(what=self._why_stood)
        others = (
            one for one in reversed(self._stops) if one.utterance is None or one.utterance is not said.utterance
        )
        stop = next(others, None)
        if stop is not None and said.began < stop.at:
            return VOID(what=stop.why)
        if said.ended < self._since:
            return VOID(what=self._why)
        if source in SPOKEN_SOURCES and said.ended <= self._left.get(who.id, -math.inf):
            return CLOSED(name=who.name)
        if source in SPOKEN_SOURCES and not self._lease.held_by(who) and not self._lease.is_present(who):
            return ABSENT
        return ""
