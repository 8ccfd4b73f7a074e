"""When each state was made: what a page sends with the newest that it has cannot be older than that state.

A link that was frozen delivers what was sent long ago as if it were new. A page that names a state dates what it
sends by the console's own clock, and can only make it older.
"""

from collections import deque

MAX_REMEMBERED_STATES = 1200  # states: a minute


class StateTimes:
    """Lives on the event loop."""

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
