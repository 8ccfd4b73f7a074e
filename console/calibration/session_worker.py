"""Common part of the workers of the camera's and of the laser's session."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, Generic, TypeVar

from console.calibration import jobs
from core.calibration.board.session import BoardSession
from core.errors import Refused

SessionT = TypeVar("SessionT", bound=BoardSession[Any, Any])

OTHER_VIEWS = (
    "The solution is of other views than those that take part now. Take the views back that it was made of, or show "
    "more until it is solved again."
)


class SessionWorker(ABC, Generic[SessionT]):
    """One session. Every job but accepting is answered with what has changed."""

    def __init__(self, session: SessionT) -> None:
        self._session = session

    @abstractmethod
    def refresh(self, _: jobs.RefreshSession | None = None) -> jobs.SessionAnswer:
        """All of it, as it is."""

    def adopt(self, job: jobs.AdoptSolution) -> jobs.SessionAnswer:
        self._session.adopt(job.solved.calibration, job.solved.names)
        return self.refresh()

    def drop(self, job: jobs.DropView) -> jobs.SessionAnswer:
        self._session.drop(job.name)
        return self.refresh()

    def restore(self, job: jobs.RestoreView) -> jobs.SessionAnswer:
        self._session.restore(job.name)
        return self.refresh()

    def skip(self, _: jobs.SkipAdvice) -> jobs.SessionAnswer:
        self._session.skip()
        return self.refresh()

    def check_acceptable(self, *, solved: bool, force: bool) -> None:
        """Raise Refused unless there is a solution of the present views, and a good one or `force`."""
        if not force:
            self._session.accept()
        if not solved or self._session.stale:
            raise Refused(self._session.progress().words)
        if self._session.solved != self._session.names:
            raise Refused(OTHER_VIEWS)
