"""Sentences for people that have a code, so that a page can say them in another language."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

Value = str | int | float


@dataclass(frozen=True)
class CodedSentence:
    """An English sentence as a pattern, and the values in the place of their names in braces.

    `static/i18n/<language>.json` has it under `console.<code>`; a code keeps its meaning.
    """

    code: str  # "lease.other_drives"
    pattern: str
    values: Mapping[str, Value] = field(default_factory=dict[str, Value])

    def __str__(self) -> str:
        """Return the sentence in English."""
        return self.pattern.format_map(self.values)

    def of(self, **values: Value) -> CodedSentence:
        """Return this sentence with values."""
        return CodedSentence(self.code, self.pattern, values)
