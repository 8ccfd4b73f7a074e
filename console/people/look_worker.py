"""The worker that looks for people in the robot's pictures: the networks run here and never in the pilot's step."""

from __future__ import annotations

import time

from console.people.look_jobs import LookForPeople, OpenDetector, PeopleSeen, PersonSeen
from console.workers.job import Handler
from core.errors import Unavailable
from core.perception.people.engines import open_detector
from core.perception.people.looking import PersonDetector


class LookWorker:
    """Keeps one detector; of pictures it remembers nothing."""

    def __init__(self) -> None:
        self._detector: PersonDetector | None = None

    @property
    def handlers(self) -> tuple[Handler, ...]:
        """Every job it knows."""
        return OpenDetector.handled_by(self.open), LookForPeople.handled_by(self.look)

    def open(self, job: OpenDetector) -> str:
        """Open a detector."""
        self._detector = open_detector(job.settings)
        return self._detector.says

    def look(self, job: LookForPeople) -> PeopleSeen:
        """Look through a picture."""
        if self._detector is None:
            raise Unavailable("No detector was opened.")
        began = time.perf_counter()
        found = self._detector.look(job.question)
        return PeopleSeen([PersonSeen.of(one) for one in found], time.perf_counter() - began)
