"""Common part of the workers of the camera's and of the laser's session."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

from console.calibration import jobs
from core.errors import Refused

if TYPE_CHECKING:  # a worker loads its own kind alone
    from core.calibration.camera.session import CameraSession
    from core.calibration.laser.session import LaserSession

OTHER_VIEWS = (
    "The solution is of other views than those that take part now. Take the views back that it was made of, or show "
    "more until it is solved again."
)


class SessionWorker(ABC):
    """One session. Every job but accepting is answered with what has changed."""

    def __init__(self) -> None:
        self._solved: tuple[str, ...] = ()  # names of the views in the solution

    @property
    @abstractmethod
    def _wizard(self) -> CameraSession | LaserSession:
        """The session."""

    @property
    @abstractmethod
    def _names(self) -> list[str]:
        """Names of the views that take part."""

    @abstractmethod
    def adopt(self, job: jobs.AdoptSolution) -> jobs.SessionAnswer:
        """Take over a solution of the solver worker."""

    @abstractmethod
    def refresh(self, _: jobs.RefreshSession | None = None) -> jobs.SessionAnswer:
        """All of it, as it is."""

    def drop(self, job: jobs.DropView) -> jobs.SessionAnswer:
        """Leave a view out."""
        self._wizard.drop(job.name)
        return self.refresh()

    def restore(self, job: jobs.RestoreView) -> jobs.SessionAnswer:
        """Take it back in."""
        self._wizard.restore(job.name)
        return self.refresh()

    def skip(self, _: jobs.SkipAdvice) -> jobs.SessionAnswer:
        """Another suggestion."""
        self._wizard.skip()
        return self.refresh()

    def check_acceptable(self, *, solved: bool, force: bool) -> None:
        """Raise Refused unless there is a solution of the present views, and a good one or `force`."""
        if not force:
            self._wizard.accept()
        if not solved or self._wizard.stale:
            raise Refused(self._wizard.progress().words)
        if self._solved != tuple(self._names):
            raise Refused(OTHER_VIEWS)
