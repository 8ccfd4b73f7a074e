"""A halt that was asked for: it holds for every gate from then on, whether or not the one that was told heard it."""

from __future__ import annotations

import logging
from pathlib import Path

from core.errors import Unavailable
from core.gate.latch import Latch

log = logging.getLogger(__name__)


class HaltWish:
    """`asked` from the halt to its reset. The gate sets the latch itself; when it could not, this does."""

    def __init__(self, home: Path) -> None:
        self.asked = False
        self._latch = Latch(home)

    @property
    def stands(self) -> bool:
        """Whether the next gate begins halted."""
        return self.asked or self._latch.is_set

    def keep(self) -> None:
        """Set the latch. Raises Unavailable when it cannot be kept."""
        try:
            self._latch.set()
        except OSError as trouble:
            raise Unavailable(f"The halt could not be saved: {trouble.strerror}.") from None

    def outlast(self) -> None:
        """The gate is gone: a halt that it did not write down is written now."""
        if not self.asked or self._latch.is_set:
            return
        try:
            self.keep()
        except Unavailable as trouble:
            log.error("%s A restart of the console may forget it.", trouble)
