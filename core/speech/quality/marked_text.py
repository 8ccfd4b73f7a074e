"""Texts with marked erroneous words, as in Fig. 17, and that figure itself.

A marked word stands between equal signs: `start; =come=; follow me`. The published texts of Fig. 17 are word for word
the same, for the print lost its yellow; what it states is 6 erroneous words of the person's text and 12 of the
robot's. Those numbers are kept here by marks; which of the words carry them is this file's choice.
"""

import re
from typing import TypedDict

from core.errors import BadInput
from core.speech.quality.osqe import OsqeFigures, score
from core.speech.quality.word_alignment import phrases_of

MARK = re.compile(r"=([^=\n]+)=")

FIGURE_17_PERSON = """\
start; come; follow me; stop moving.
start; go to; turn left; =stop= moving.
start; follow me; turn right; =turn= left; stop moving.
start; =go to=; turn right; turn left; stop moving.
start; go to; stop at; start; turn right; =go= back; stop moving.
start; come; turn left; follow me; stop moving.
start; go to; stop at; start; turn left; turn left; stop moving.
start; follow me; stop at; =start=; turn right; stop moving.
"""
FIGURE_17_ROBOT = """\
start; =come=; follow me; stop moving.
start; go to; turn left; =stop= moving.
start; =follow me=; turn right; =turn= left; stop moving.
start; =go to=; turn right; turn left; stop moving.
start; go to; =stop= at; start; turn right; =go= back; stop moving.
start; come; turn left; follow me; stop =moving=.
start; go to; stop at; start; turn left; turn left; stop moving.
start; follow me; =stop= at; =start=; turn right; stop moving.
"""


def marked_words(text: str) -> list[str]:
    """The words that are marked as erroneous. Raises BadInput where a mark is opened and not closed."""
    if MARK.sub("", text).count("="):
        raise BadInput("A mark is not closed: an erroneous word stands between equal signs on one line, like =come=.")
    return [word for part in MARK.findall(text) for phrase in phrases_of(part) for word in phrase]


def unmarked(text: str) -> str:
    """The same text without marks."""
    return MARK.sub(r"\1", text)


def marked_score(person: str, robot: str) -> OsqeFigures:
    """Two marked texts → OSQE_D and OSQE_R (eq. 41-42)."""
    return score(len(marked_words(person)), len(marked_words(robot)))


class MarkedWord(TypedDict):
    """A word that is marked as erroneous, as JSON."""

    path: str  # "person" | "robot"
    kind: str  # "marked"
    original: None
    heard: str


class MarkedFigures(OsqeFigures):
    """The figures of two marked texts, as JSON."""

    words: int
    differences: list[MarkedWord]


def as_json(person: str, robot: str) -> MarkedFigures:
    """The figures of two marked texts."""
    return {
        **marked_score(person, robot),
        "words": sum(map(len, phrases_of(unmarked(person)))),
        "differences": [
            {"path": name, "kind": "marked", "original": None, "heard": word}
            for name, text in (("person", person), ("robot", robot))
            for word in marked_words(text)
        ],
    }
