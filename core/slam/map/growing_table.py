"""A table of numbers that grows at its end without being built again."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from core.message import Array


class GrowingTable:
    """Rows of numbers in one array, with room to spare."""

    def __init__(self, columns: int) -> None:
        self._rows = np.zeros((64, columns))
        self.count = 0

    def extend(self, rows: Iterable[Sequence[float] | Array]) -> None:
        """Rows at the end."""
        for row in rows:
            if self.count == len(self._rows):
                self._rows = np.vstack((self._rows, np.zeros_like(self._rows)))
            self._rows[self.count] = row
            self.count += 1

    @property
    def array(self) -> Array:
        """All rows (N, columns), as a copy."""
        return self._rows[: self.count].copy()
