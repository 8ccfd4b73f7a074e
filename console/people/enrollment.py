"""One person being learnt: the empty picture, then gestures. Everything of it is in memory only, until it is over."""

import time
from collections import deque
from dataclasses import dataclass, field
from typing import NamedTuple

import msgspec

from console.messages import filled
from console.people.worker import SeenBackground, SeenPerson
from core.geometry import Pose
from core.message import Array
from core.perception.people.enrollment import MIN_PICTURES, PersonImage

MOST_PICTURES = 12
FORGET_ENROLLMENT_S = 900.0  # without anybody at it, after which an enrollment is over
RECENT_PICTURES = 6  # pictures, good or not, that a page which is slow may still ask for
PARTS = ("head", "torso", "feet")


class Gesture(NamedTuple):
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


class PersonPart(msgspec.Struct, frozen=True):
    """A part of a person in a picture."""

    name: str
    box_px: tuple[float, float, float, float]  # left, top, right, bottom


class JudgedPictureState(msgspec.Struct, frozen=True, kw_only=True):
    """A picture and what came of it, as the page gets it."""

    number: int
    gesture: str  # that was asked for; "" for the background
    good: bool
    words: str  # what to do better, where it is not
    size: tuple[int, int]  # width, height [pixel]
    outline: list[list[float]]  # x, y [pixel]
    parts: list[PersonPart]


class EnrollmentState(msgspec.Struct, frozen=True, kw_only=True):
    """An enrollment, as the page gets it."""

    id: str
    who: str  # at the console
    owner: str
    background: bool  # the empty picture is there
    next: str  # the gesture that is asked for
    advice: str
    gestures: list[str]
    pictures: list[JudgedPictureState]
    newest: JudgedPictureState | None
    fewest: int
    ready: bool
    demo: bool
    trouble: str
    waits: str


@dataclass
class JudgedPicture:
    number: int
    gesture: str  # that was asked for; "" for the background
    size: list[int]  # [pixel]
    picture: bytes  # JPEG
    wrong: str = ""
    outline: list[list[float]] = field(default_factory=list[list[float]])
    person_image: PersonImage | None = None

    @property
    def shown(self) -> JudgedPictureState:
        words = self.wrong or ("Good." if self.gesture else "Good; now come into the picture.")
        boxes = [] if self.person_image is None else self.person_image.boxes
        return JudgedPictureState(
            number=self.number,
            gesture=self.gesture,
            good=not self.wrong,
            words=words,
            size=(self.size[0], self.size[1]),
            outline=self.outline,
            parts=[PersonPart(name, box) for name, box in zip(PARTS, boxes, strict=False)],
        )


@dataclass
class EnrollmentSession:
    """Lives on the event loop."""

    id: str
    who: str  # at the console
    owner: str  # the same person, as the console tells people of one name apart
    background: Array | None = None  # (H, W, 3) uint8, as the worker takes it
    stood: Pose | None = None  # the robot when its camera took the background; None: another camera did
    taken: list[JudgedPicture] = field(default_factory=list[JudgedPicture])
    newest: JudgedPicture | None = None
    trouble: str = ""  # why what the demo did ended
    waits: str = ""  # what is waited for
    demo: bool = False
    number: int = 0
    used: float = field(default_factory=time.monotonic)
    _recent: deque[JudgedPicture] = field(default_factory=lambda: deque[JudgedPicture](maxlen=RECENT_PICTURES))

    @property
    def stale(self) -> bool:
        return not self.demo and time.monotonic() - self.used > FORGET_ENROLLMENT_S

    @property
    def next(self) -> Gesture | None:
        """The gesture that is asked for now; None: there is enough, or the background is missing."""
        if self.background is None:
            return None
        have = {one.gesture for one in self.taken}
        return next((gesture for gesture in GESTURES if gesture.name not in have), None)

    @property
    def person_images(self) -> list[PersonImage]:
        return [one.person_image for one in self.taken if one.person_image is not None]

    def restart(self, answer: SeenBackground, stood: Pose | None) -> None:
        """Take another empty picture: pictures that were taken with the former one are left out."""
        self.background, self.stood = answer.kept, stood
        self.taken.clear()
        self.newest = self._judged("", answer.size, answer.picture)

    def take(self, answer: SeenPerson) -> None:
        gesture = self.next
        self.newest = self._judged(gesture.name if gesture else "more", answer.size, answer.picture)
        self.newest.wrong, self.newest.outline = answer.wrong, answer.outline
        self.newest.person_image = answer.person_image
        if not self.newest.wrong:
            self.taken.append(self.newest)

    def rest(self) -> None:
        """Nobody shows anything any more."""
        self.demo, self.waits = False, ""

    def drop(self, number: int) -> bool:
        """Leave a picture out → whether there was one."""
        before = len(self.taken)
        self.taken = [one for one in self.taken if one.number != number]
        if self.newest is not None and self.newest.number == number:
            self.newest = None
        self._recent = deque((one for one in self._recent if one.number != number), RECENT_PICTURES)
        return len(self.taken) < before

    def picture(self, number: int) -> bytes | None:
        """A picture that is still in memory."""
        return next((one.picture for one in (*self.taken, *self._recent) if one.number == number), None)

    @property
    def shown(self) -> EnrollmentState:
        gesture = self.next
        return filled(
            EnrollmentState,
            self,
            background=self.background is not None,
            next=gesture.name if gesture else "",
            advice=STEP_OUT if self.background is None else gesture.words if gesture else ENOUGH,
            gestures=[one.name for one in GESTURES],
            pictures=[one.shown for one in self.taken],
            newest=None if self.newest is None else self.newest.shown,
            fewest=MIN_PICTURES,
            ready=len(self.taken) >= MIN_PICTURES,
        )

    def _judged(self, gesture: str, size: list[int], picture: bytes) -> JudgedPicture:
        self.used = time.monotonic()
        self.trouble = ""
        self.number += 1
        judged = JudgedPicture(self.number, gesture, size, picture)
        self._recent.append(judged)
        return judged
