"""Rate counter, for rate limits: how much within the present second."""

from collections.abc import Mapping
from typing import Any


class RateCounter:
    """Counts within whole seconds that begin with the first of each."""

    def __init__(self) -> None:
        self._second = float("-inf")  # [s] when the present one began
        self._count = 0

    def add(self, now: float, amount: int = 1) -> int:
        """So much more at `now` [s] → how much there was in this second with it."""
        if now - self._second >= 1.0:
            self._second, self._count = now, 0
        self._count += amount
        return self._count


def size_of(message: Mapping[str, Any]) -> int:
    """How much a socket's message holds [bytes]; text counts as UTF-8."""
    return len(message.get("bytes") or (message.get("text") or "").encode(errors="surrogatepass"))
