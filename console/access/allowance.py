"""An allowance of entries for one person: some at once, and then so many a minute."""


class EntryAllowance:
    """A bucket that holds `most`, and gains `a_minute` of them every minute."""

    def __init__(self, most: int, a_minute: float) -> None:
        self._most, self._rate = most, a_minute / 60.0
        self._left, self._at = float(most), float("-inf")

    def take(self, now: float) -> bool:
        """One of them at `now` [s] → whether there was one."""
        if self._at > float("-inf"):
            self._left = min(self._most, self._left + self._rate * (now - self._at))
        self._at = now
        if self._left < 1.0:
            return False
        self._left -= 1.0
        return True
