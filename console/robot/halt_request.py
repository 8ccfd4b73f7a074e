"""A halt that was requested: it holds for every later gate, whether or not the present one heard it."""

import logging
from pathlib import Path

from core.errors import Unavailable
from core.gate.latch import Latch

log = logging.getLogger(__name__)


class HaltRequest:
    """`asked` from the halt to its reset. The gate sets the latch itself; when it could not, this does.

    Halts are numbered, so that the latch of an earlier one is never taken for that of the newest.
    """

    def __init__(self, home: Path) -> None:
        self.asked = False
        self.number = 0  # of the newest halt
        self._kept = 0  # number of the newest halt that was latched from here
        self._latch = Latch(home)

    @property
    def stands(self) -> bool:
        """True if the next gate begins halted."""
        return self.asked or self._latch.is_set

    def keep(self) -> None:
        """Set the latch. Raises Unavailable when it cannot be kept."""
        try:
            self._latch.set()
        except OSError as trouble:
            raise Unavailable(f"The halt could not be saved: {trouble.strerror}.") from None
        self._kept = self.number

    def is_latched(self, by_gate: int) -> bool:
        """Return whether the newest halt is on disk, when the gate has latched those up to `by_gate`."""
        return self.asked and max(by_gate, self._kept) >= self.number > 0

    def ask(self) -> int:
        """Another halt → its number."""
        self.asked = True
        self.number += 1
        return self.number

    def outlast(self) -> None:
        """The gate is gone: a halt that it did not write down is written now."""
        if not self.asked:
            return
        try:
            self.keep()
        except Unavailable as trouble:
            log.error("%s A restart of the console may forget it.", trouble)
