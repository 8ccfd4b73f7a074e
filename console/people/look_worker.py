"""The worker that looks for people in the robot's pictures: the networks run here and never in the pilot's step."""

import time
from dataclasses import replace

import msgspec

from console.workers.job import job
from console.workers.pictures import in_colour
from core.errors import Unavailable
from core.perception.people.detector import Rectangle
from core.perception.people.engines import open_detector
from core.perception.people.looking import LookQuestion, PersonDetector
from core.perception.people.parts import PeopleSettings


class PeopleSeen(msgspec.Struct, frozen=True):
    """Everybody who was found, best first."""

    people: tuple[Rectangle, ...]
    processing_s: float


class LookWorker:
    """Keeps one detector; of pictures it remembers nothing."""

    def __init__(self) -> None:
        self._detector: PersonDetector | None = None

    @job
    def open(self, settings: PeopleSettings) -> str:
        """Open the detector that these settings name → what it is, in a sentence. Raises Unavailable, BadInput."""
        self._detector = open_detector(settings)
        return self._detector.says

    @job
    def look(self, question: LookQuestion) -> PeopleSeen:
        """Look through one picture of the robot's camera. Raises Unavailable before a detector was opened."""
        if self._detector is None:
            raise Unavailable("No detector was opened.")
        began = time.perf_counter()
        found = self._detector.look(replace(question, pixels=in_colour(question.pixels)))
        return PeopleSeen(found, time.perf_counter() - began)
