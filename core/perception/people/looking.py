"""The protocol of detectors of people: a question about one picture, and who was found."""

from __future__ import annotations

from typing import Protocol

from core.message import Array, message
from core.perception.people.detector import Rectangle
from core.sensors import Camera

ASKED_SD_RAD = 0.05  # of a direction of which no sd is known


@message
class LookQuestion:
    """Question about a picture: who is in it, and where is the person who is asked for?"""

    pixels: Array  # (H, W, 3) uint8, blue-green-red
    camera: Camera
    stamp: float = 0.0  # [s] of the picture
    bearing: float | None = None  # [rad] robot frame, from the camera; None: anywhere in the picture
    sd: float = ASKED_SD_RAD  # [rad] of that bearing
    distances: tuple[float, ...] = ()  # [m] from the camera: where the laser sees something; (): not known
    on_floor: bool = True  # the camera's height above a level floor is that of its mounting; else it is not known


class PersonDetector(Protocol):
    """A detector that finds people in pictures."""

    @property
    def name(self) -> str:
        """The engine as the settings name it: "pose"."""
        ...

    @property
    def says(self) -> str:
        """A sentence on the detector and its knowledge."""
        ...

    def look(self, question: LookQuestion) -> tuple[Rectangle, ...]:
        """Find people, best first; in a direction only those in whose head it falls."""
        ...


class PersonLook(Protocol):
    """A detector that is asked now and answers later: the newest question replaces one that waits."""

    def ask(self, question: LookQuestion) -> None:
        """Take a question."""
        ...

    def answer(self) -> LookAnswer | None:
        """The newest answer that was not returned yet; None: there is none."""
        ...


@message
class LookAnswer:
    """Answer with the people who were found."""

    stamp: float  # [s] of the picture
    found: tuple[Rectangle, ...]  # best first


class ImmediateLook:
    """Answers as soon as it is asked: for recordings and experiments, where time comes with the data."""

    def __init__(self, detector: PersonDetector) -> None:
        self._detector = detector
        self._answer: LookAnswer | None = None

    def ask(self, question: LookQuestion) -> None:
        """Look at once."""
        self._answer = LookAnswer(stamp=question.stamp, found=self._detector.look(question))

    def answer(self) -> LookAnswer | None:
        """Return what was found."""
        answer, self._answer = self._answer, None
        return answer
