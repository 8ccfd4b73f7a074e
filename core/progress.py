"""The progress of longer work: the command line shows it, everything else takes no notice."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sized
from typing import Protocol, TypeVar

ItemT = TypeVar("ItemT", covariant=True)


class SizedItems(Sized, Iterable[ItemT], Protocol[ItemT]):
    """Items whose number is known."""


class WorkProgress:
    """Takes how far work has come; this one takes no notice of it."""

    def at(self, share: float, doing: str = "") -> None:
        """So much of it is done, 0 to 1, and this is being done; a share of 0 begins other work."""

    def __call__(self, line: str) -> None:
        """Say in words how far it has come: work of which the amount is not known."""

    def tell(self, line: str) -> None:
        """Something that was found on the way, and remains to be read."""

    def each(self, items: SizedItems[ItemT], doing: str) -> Iterator[ItemT]:
        """The same items; each that is fetched says that those before it are done."""
        count = max(len(items), 1)
        for number, item in enumerate(items):
            self.at(number / count, doing)
            yield item
        self.at(1.0, doing)

    def part(self, number: int, count: int) -> WorkProgress:
        """The progress of one of `count` pieces of the work."""
        return _PartOfProgress(self, number, count)


class _PartOfProgress(WorkProgress):
    def __init__(self, whole: WorkProgress, number: int, count: int) -> None:
        self._whole, self._number, self._count = whole, number, count

    def at(self, share: float, doing: str = "") -> None:
        """So much of this piece is done."""
        self._whole.at((self._number + share) / self._count, doing)

    def __call__(self, line: str) -> None:
        """Say in words how far it has come."""
        self._whole(line)

    def tell(self, line: str) -> None:
        """Something that remains to be read."""
        self._whole.tell(line)


UNSEEN = WorkProgress()
"""Nobody looks."""
