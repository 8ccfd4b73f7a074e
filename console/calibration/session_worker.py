"""Common part of the workers of the camera's and of the laser's session."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, Generic, TypeVar

from console.calibration import answers
from console.workers.job import job
from core.calibration.board.session import BoardSession
from core.errors import Refused
from core.message import Array

SessionT = TypeVar("SessionT", bound=BoardSession[Any, Any])

OTHER_VIEWS = (
    "The solution is of other views than those that take part now. Take the views back that it was made of, or show "
    "more until it is solved again."
)


class SessionWorker(ABC, Generic[SessionT]):
    """One session. Every job but accepting is answered with what has changed."""

    def __init__(self, session: SessionT) -> None:
        self._session = session

    @job
    @abstractmethod
    def look(self, grey: Array, stamp: float) -> answers.SessionAnswer:
        """A live picture of the robot (H, W) uint8, taken when it is sharp, still and new; `stamp` [s]."""
        ...

    @job
    @abstractmethod
    def refresh(self) -> answers.SessionAnswer:
        """All of it, as it is."""
        ...

    @job
    def adopt(self, solved: answers.SolvedViews) -> answers.SessionAnswer:
        self._session.adopt(solved.calibration, solved.names)
        return self.refresh()

    @job
    def drop(self, name: str) -> answers.SessionAnswer:
        """Leave a view out. Raises BadInput."""
        self._session.drop(name)
        return self.refresh()

    @job
    def restore(self, name: str) -> answers.SessionAnswer:
        """Take a view back in. Raises BadInput."""
        self._session.restore(name)
        return self.refresh()

    @job
    def skip(self) -> answers.SessionAnswer:
        """Suggest another view."""
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
