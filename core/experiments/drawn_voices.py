"""Voices that are drawn for every run: their runs together, and the best and the worst of them."""

from collections.abc import Callable, Iterable, Mapping
from typing import TypeVar

T = TypeVar("T")


def by_voice(rows: Iterable[T], voice: Callable[[T], str]) -> dict[str, list[T]]:
    """Rows of every voice, the voices in alphabetical order."""
    found: dict[str, list[T]] = {}
    for row in rows:
        found.setdefault(voice(row), []).append(row)
    return dict(sorted(found.items()))


def best_and_worst(rates: Mapping[str, float]) -> tuple[str, str]:
    """The names of the voices with the highest and the lowest rate; of equal ones the first."""
    return max(rates, key=rates.__getitem__), min(rates, key=rates.__getitem__)
