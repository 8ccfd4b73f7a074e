"""Counts of the records that were read and skipped in a log, reported in sentences afterwards."""

from collections import Counter
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

from core.errors import BadInput
from core.recording.recording import RecordingReport
from core.sensors.checks import Fault, distinct, fault


class BadRecord(Exception):
    """One record of a log cannot be used; the words say why. Never leaves the readers."""


class ReadReport:
    """Counts records while a log is read."""

    def __init__(self, path: Path):
        self.path = path
        self.read = 0
        self.declared: int | None = None
        self.topics: list[str] = []
        self.files = 0  # that were begun, where a recording has several
        self._skipped: Counter[str] = Counter()
        self._first: dict[str, str] = {}
        self._warnings: dict[str, None] = {}
        self._faults: list[Fault] = []

    @property
    def skipped(self) -> int:
        """Records that were left out so far."""
        return sum(self._skipped.values())

    def skip(self, why: str, where: str = "", count: int = 1) -> None:
        """Leave out `count` records because of `why` ("the time goes backwards"), first at `where` ("line 3")."""
        if count:
            self._skipped[why] += count
            self._first.setdefault(why, where)

    def drop(self, why: str, count: int) -> None:
        """Leave out `count` records after all that had been taken in."""
        self.read -= count
        self.skip(why, count=count)

    @contextmanager
    def reading(self, topic: str) -> Generator[None]:
        """Leave out a message of this topic that cannot be decoded or used: the next one may be fine."""
        try:
            yield
        except (BadRecord, BadInput) as problem:
            self.skip(str(problem), f"a message of {topic}")
        except Exception:  # whatever a decoder raises on hostile bytes
            self.skip("it cannot be decoded", f"a message of {topic}")

    def warn(self, sentence: str) -> None:
        """Add a warning for the reader of the result; the same sentence is reported once."""
        if len(self._warnings) < 20:
            self._warnings[sentence] = None

    def fault(self, code: str, sensor: str = "", *, used: bool = False, **values: object) -> None:
        """Add what a check of the readings found; its sentence is a warning, too."""
        self.note(fault(code, sensor, used=used, **values))

    def note(self, found: Fault) -> None:
        """Add a fault that was found; its sentence is a warning, too."""
        self._faults.append(found)
        self.warn(found.sentence)

    def has_fault(self, code: str) -> bool:
        """Return whether a check has found this."""
        return any(one.code == code for one in self._faults)

    def report(self, form: str) -> RecordingReport:
        """Everything counted, as sentences."""
        warnings = list(self._warnings)
        if self._skipped:
            reasons = [f"{n} because {why}{self._at(why)}" for why, n in self._skipped.most_common(8)]
            total = self.read + self.skipped
            warnings.insert(0, f"{self.skipped} of {total} records skipped: {'; '.join(reasons)}.")
        return RecordingReport(
            form=form,
            read=self.read,
            skipped=self.skipped,
            declared=self.declared,
            topics=tuple(self.topics),
            warnings=tuple(warnings),
            faults=distinct(self._faults),
        )

    def reasons(self) -> str:
        """The reasons of all that was skipped in half a sentence; "" when nothing was."""
        return "; ".join(f"{n} × {why}{self._at(why)}" for why, n in self._skipped.most_common(3))

    def _at(self, why: str) -> str:
        first = self._first[why]
        return f" (first at {first})" if first else ""
