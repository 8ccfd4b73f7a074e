"""Which phrases a misheard or mistyped one resembles. For suggestions only."""

from __future__ import annotations

from collections.abc import Iterable


def nearest(text: str, phrases: Iterable[str], most: int = 3) -> tuple[str, ...]:
    """The phrases at most a third of their letters away from the text, nearest first.

    Words in another order count as one slip: "left turn" resembles "turn left".
    """
    if len(text) > 60:
        return ()
    rated = [(min(slips(text, phrase), 1 + slips(_in_order(text), _in_order(phrase))), phrase) for phrase in phrases]
    return tuple(phrase for count, phrase in sorted(rated) if 3 * count <= max(len(phrase), 3))[:most]


def slips(a: str, b: str) -> int:
    """Letters to insert, drop, change or swap with a neighbour to get from a to b (optimal string alignment)."""
    older: list[int] = []
    old = list(range(len(b) + 1))
    for i, letter in enumerate(a, 1):
        new = [i]
        for j, other in enumerate(b, 1):
            cost = min(old[j] + 1, new[j - 1] + 1, old[j - 1] + (letter != other))
            if i > 1 and j > 1 and letter == b[j - 2] and a[i - 2] == other:
                cost = min(cost, older[j - 2] + 1)
            new.append(cost)
        older, old = old, new
    return old[-1]


def _in_order(text: str) -> str:
    return " ".join(sorted(text.split()))
