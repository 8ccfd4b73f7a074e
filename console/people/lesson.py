"""One person being learnt: the empty picture, then gestures. Everything of it is in memory only, until it is over."""

from __future__ import annotations

import time
from collections import deque
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from core.geometry import Pose
from core.perception.people.enrolment import FEWEST

Told = dict[str, Any]

MOST_PICTURES = 12
FORGOTTEN = 900.0  # [s] without anybody at it, after which a lesson is over
RECENT = 6  # pictures, good or not, that a page which is slow may still ask for
PARTS = ("head", "torso", "feet")


class Gesture(NamedTuple):
    """What is asked for."""

    name: str
    words: str


GESTURES = (
    Gesture("down", "Stand upright with your arms down."),
    Gesture("out", "Stretch both arms out to the sides."),
    Gesture("wave", "Raise one hand, as if you waved."),
    Gesture("side", "Turn sideways."),
)
STEP_OUT = "First the empty room: leave the picture, and take it without anybody."
ENOUGH = "That is enough. Say who you are."


@dataclass
class Judged:
    """A picture and what came of it."""

    number: int
    gesture: str  # that was asked for; "" for the background
    size: list[int]  # [pixel]
    picture: bytes  # JPEG
    wrong: str = ""
    outline: list[list[float]] = field(default_factory=list[list[float]])
    portrait: Told | None = None

    def told(self) -> Told:
        """As the page gets it."""
        words = self.wrong or ("Good." if self.gesture else "Good; now come into the picture.")
        boxes: list[list[float]] = [] if self.portrait is None else self.portrait["boxes"]
        return {
            "number": self.number,
            "gesture": self.gesture,
            "good": not self.wrong,
            "words": words,
            "size": self.size,
            "outline": self.outline,
            "parts": [{"name": name, "box_px": box} for name, box in zip(PARTS, boxes, strict=False)],
        }


@dataclass
class Lesson:
    """Lives on the event loop."""

    id: str
    who: str  # at the console
    owner: str  # the same person, as the console tells people of one name apart
    background: Told | None = None  # as the worker takes it
    stood: Pose | None = None  # the robot when its camera took the background; None: another camera did
    taken: list[Judged] = field(default_factory=list[Judged])
    newest: Judged | None = None
    trouble: str = ""  # why what the assistant did ended
    waits: str = ""  # what is waited for
    showing: bool = False
    number: int = 0
    used: float = field(default_factory=time.monotonic)
    _recent: deque[Judged] = field(default_factory=lambda: deque[Judged](maxlen=RECENT))

    @property
    def stale(self) -> bool:
        """Whether nobody has been at it for long."""
        return not self.showing and time.monotonic() - self.used > FORGOTTEN

    @property
    def next(self) -> Gesture | None:
        """What is asked for now; None: there is enough, or the background is missing."""
        if self.background is None:
            return None
        have = {one.gesture for one in self.taken}
        return next((gesture for gesture in GESTURES if gesture.name not in have), None)

    def begin_anew(self, answer: Told, stood: Pose | None) -> None:
        """Another empty picture: what was learnt beside the former one is left out."""
        self.background, self.stood = answer["kept"], stood
        self.taken.clear()
        self.newest = self._judged("", answer)

    def take(self, answer: Told) -> None:
        """What the worker says of a picture of somebody."""
        gesture = self.next
        self.newest = self._judged(gesture.name if gesture else "more", answer)
        if not self.newest.wrong:
            self.taken.append(self.newest)

    def rest(self) -> None:
        """Nobody shows anything any more."""
        self.showing, self.waits = False, ""

    def drop(self, number: int) -> bool:
        """Leave a picture out → whether there was one."""
        before = len(self.taken)
        self.taken = [one for one in self.taken if one.number != number]
        if self.newest is not None and self.newest.number == number:
            self.newest = None
        self._recent = deque((one for one in self._recent if one.number != number), RECENT)
        return len(self.taken) < before

    def picture(self, number: int) -> bytes | None:
        """A picture that is still in memory."""
        return next((one.picture for one in (*self.taken, *self._recent) if one.number == number), None)

    def told(self) -> Told:
        """As the page gets it."""
        gesture = self.next
        return {
            "id": self.id,
            "who": self.who,
            "owner": self.owner,
            "background": self.background is not None,
            "next": gesture.name if gesture else "",
            "advice": STEP_OUT if self.background is None else gesture.words if gesture else ENOUGH,
            "gestures": [one.name for one in GESTURES],
            "pictures": [one.told() for one in self.taken],
            "newest": None if self.newest is None else self.newest.told(),
            "fewest": FEWEST,
            "ready": len(self.taken) >= FEWEST,
            "showing": self.showing,
            "trouble": self.trouble,
            "waits": self.waits,
        }

    def _judged(self, gesture: str, answer: Told) -> Judged:
        self.used = time.monotonic()
        self.trouble = ""
        self.number += 1
        told = {name: answer[name] for name in ("wrong", "outline", "portrait") if name in answer}
        judged = Judged(self.number, gesture, answer["size"], answer["picture"], **told)
        self._recent.append(judged)
        return judged
