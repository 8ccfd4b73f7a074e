"""One calibration session as the console keeps it: its worker, its file, and what the page is shown."""

import asyncio
import time
from abc import ABC, abstractmethod
from collections.abc import AsyncGenerator, Callable
from contextlib import asynccontextmanager

import msgspec

from console.calibration import answers
from console.calibration.camera_worker import CameraWorker
from console.calibration.codec import camera_in
from console.calibration.laser_worker import LaserWorker
from console.calibration.session_store import FORM_VERSION, SessionStore, StoredSession
from console.calibration.session_worker import SessionWorker
from console.calibration.solver_worker import SolverWorker
from console.http.problems import Problem
from console.messages.calibration import CalibrationSolving, CalibrationVerdict, VerdictKind
from console.workers.job import Answer, Job, plain
from console.workers.tasks import to_the_end
from console.workers.worker import Worker, WorkerLost
from core.errors import BadInput, BeckonError, Refused
from core.geometry import Pose, Transform

PICTURE_BUDGET_S = 2.0  # of processor time for one picture
BUDGET_S = 10.0  # for anything else at the worker
SOLVE_BUDGET_S = 60.0
SOLVE_PATIENCE_S = 30.0  # by the clock that accepting waits for a solution
DWELL_S = 1.0  # that "counted" stays before the live picture's "same as …" may replace it
MOST_WAITING = 3  # requests that may wait for the worker
COVERED = "The solution is of all these views already. Show more of them, or leave one out; then it is solved again."

Changed = Callable[["CalibrationSession", bool], None]


class CalibrationSession(ABC):
    """Lives on the event loop. Everything that looks at pictures or computes happens in workers."""

    def __init__(
        self, kept: StoredSession, folder: SessionStore, solver: Worker, changed: Changed, tell: Callable[[str], None]
    ) -> None:
        self.card, self.shown = kept.card, kept.shown
        self.pictures, self.exports = kept.pictures, kept.exports
        self.folder, self._writing = folder, asyncio.Lock()  # one writes on its disk
        self._deleted = False  # nothing is written any more
        self.pose: Transform | None = None  # of the board as advised, camera_from_board
        self.stood: Pose | None = None  # by odometry, when the robot began to look at the empty room (live)
        self.solving_task: asyncio.Task[None] | None = None
        self._task: asyncio.Task[None] | None = None  # the solver, and then the measuring of its correction
        self._settled = asyncio.Event()  # no solver is at work
        self._settled.set()
        self.compare: Callable[[], dict[str, tuple[float, float]] | None] = lambda: None
        self.used = self.looked_at = time.monotonic()  # when its worker, and when the session, was last asked for
        self.printed = False  # the chapter's own forms (eq. 13, eq. 44)
        self.last_counted = 0  # number of the newest verdict that counted
        self._state = bytes(kept.state)  # JSON
        self._names: list[str] = []  # of the views that take part
        self._stale = False
        self._given_up: list[str] | None = None  # views that could not be solved
        self._solved: answers.SolvedViews | None = None
        self._solver_worker, self._changed, self._tell, self._worker = solver, changed, tell, Worker(kept.card.kind)
        self._opened = 0  # the worker's start at which the session was laid on it
        self._turn = asyncio.Lock()
        self._waiting = 0
        self._rests = 0  # how often it was put aside
        self._counted_until = 0.0  # [s] of the monotonic clock
        self._number = kept.shown.verdict.number if kept.shown.verdict else 0

    @property
    def pid(self) -> int | None:
        return self._worker.pid

    @property
    def busy(self) -> bool:
        return self._waiting > 0 or self.solving_task is not None

    @abstractmethod
    def _opening(self) -> Job[answers.SessionAnswer]:
        """The job that lays the session before its worker."""

    @abstractmethod
    async def _solution(self) -> answers.CameraSolution | answers.LaserSolution:
        """Have the session solved. Raises BeckonError."""

    @abstractmethod
    async def _acceptance(self, *, force: bool) -> answers.AcceptedCamera | answers.AcceptedMount:
        """Have the solution accepted. Raises Refused with the reason."""

    async def act(
        self,
        job: Job[answers.SessionAnswer],
        *,
        budget: float = BUDGET_S,
        stamp: float | None = None,
        original: bytes | None = None,
        patient: bool = False,
    ) -> answers.SessionAnswer:
        """One job at the worker → its answer, shown and saved already. Raises Problem, BadInput, Refused.

        `original`: the picture as it was sent; `patient`: this caller may wait behind however many others.
        """
        async with self._queued(patient=patient):
            answer = await self._asked(job, budget)
            if answer.counted is not None:
                await self._keep(answer.counted, original)
            self._learn(answer, stamp)
            if answer.change is not None:
                await self.save()
            self._changed(self, answer.counted is not None)
        self.solve_soon()
        return answer

    async def accept(self, *, force: bool) -> answers.AcceptedCamera | answers.AcceptedMount:
        """The document and the report of the solution. Raises Refused with the reason, Problem 503.

        What is being solved is waited for. A restart costs the solution all but what is shown of it; then it is
        solved again first, of the same views.
        """
        if self._solved is None and self.shown.solution is not None:
            await self.act(SessionWorker.refresh())
        try:
            async with asyncio.timeout(SOLVE_PATIENCE_S):
                await self._settled.wait()
        except TimeoutError:
            raise Problem(503, "It is still being solved; try again when the solution is there.") from None
        async with self._queued():
            return await self._acceptance(force=force)

    def trouble(self, words: str, kind: VerdictKind = "trouble") -> None:
        self._show_verdict(CalibrationVerdict(kind, words), None)
        self._changed(self, True)

    def show(self, *, urgent: bool = False) -> None:
        self._changed(self, urgent)

    async def save(self) -> None:
        try:
            async with self._writing:
                if not self._deleted:
                    raw = self._encoded()
                    await to_the_end(lambda: self.folder.save(raw))
        except OSError:
            self._tell("The calibration cannot be saved on disk now; it goes on in memory. Check the data folder.")

    async def remove(self) -> None:
        """Delete the session from the disk for good; waits for a write under way, and nothing is written after it."""
        self._deleted = True
        async with self._writing:
            await to_the_end(self.folder.remove)

    def solve_soon(self, *, again: bool = False) -> None:
        """Solve in the background, when the solution does not cover the views."""
        if again:
            self._given_up = None
        if self._stale and self.solving_task is None and self._names != self._given_up:
            self._settled.clear()
            if self._task is not None:
                self._task.cancel()  # it measures the correction of the solution before
            self.solving_task = self._task = asyncio.get_running_loop().create_task(self._solve())

    async def solve_now(self) -> None:
        """Solve, even what could not be solved before. Raises Refused with too few views, or with nothing new."""
        await self.act(SessionWorker.refresh())
        if not self._stale:
            covered = self._solved is not None and self._solved.names == self._names
            raise Refused(COVERED if covered else self.shown.progress.words)
        self.solve_soon(again=True)

    def close(self) -> None:
        """End the worker; the session stays. A job under way is not done again."""
        self._rests += 1
        if self._task is not None:
            self._task.cancel()
        self.solving_task = self._task = self.shown.solving = None
        self._settled.set()
        self._worker.kill()

    async def gone(self) -> None:
        """Its worker was ended: wait until there is no process any more."""
        await self._worker.gone()

    def _encoded(self) -> bytes:
        whole = StoredSession(
            FORM_VERSION, self.card, self.shown, msgspec.Raw(self._state), self.pictures, self.exports
        )
        return msgspec.json.encode(whole, enc_hook=plain)

    @asynccontextmanager
    async def _queued(self, *, patient: bool = False) -> AsyncGenerator[None]:
        """The worker's turn. Raises Problem 429 where too many wait for it; a failed job has the session solved."""
        if self._waiting >= MOST_WAITING and not patient:
            raise Problem(429, "One thing at a time: wait for the answer before you send the next picture.")
        self._waiting += 1
        self.used, rests = time.monotonic(), self._rests
        try:
            async with self._turn:
                yield
        except (BeckonError, Problem):
            if rests == self._rests:
                self.solve_soon()  # the failed job may have left views that are not solved
            raise
        finally:
            self._waiting -= 1

    async def _asked(self, job: Job[Answer], budget: float = BUDGET_S) -> Answer:
        """The worker's answer. A job whose worker was killed from outside is done again, once."""
        rests = self._rests
        for last in (False, True):
            await self._lay_out()
            try:
                return await self._worker.ask(job, budget=budget)
            except WorkerLost as lost:
                if rests != self._rests:
                    raise Problem(409, "This session was put aside meanwhile.") from None
                if last or not lost.killed:
                    self.trouble(str(lost))
                    raise BadInput(str(lost)) from None
        raise Problem(503, "The calibration's worker does not start; try again.")

    async def _lay_out(self) -> None:
        """The worker has the session before it. Raises Problem when that cannot be."""
        if self._worker.alive and self._opened == self._worker.starts:
            return
        try:
            answer = await self._worker.ask(self._opening(), budget=BUDGET_S)
        except WorkerLost as lost:
            self.trouble(str(lost))
            raise Problem(503, "The calibration's worker does not start; try again.") from None
        self._opened = self._worker.starts
        self._learn(answer)

    def _learn(self, answer: answers.SessionAnswer, stamp: float | None = None) -> None:
        shown = self.shown
        shown.size = answer.size
        shown.scan = answer.scan or shown.scan
        if answer.counted is not None:
            shown.check = answer.check
        if (change := answer.change) is not None:
            shown.progress, shown.uncertainty, shown.views = change.progress, change.uncertainty, change.views
            shown.advice = None if change.advice is None else change.advice.shown
            self.pose = self.pose if change.advice is None else change.advice.pose
            self._state, self._stale, self._names = change.state, change.stale, change.names
        if answer.verdict is not None:
            self._show_verdict(answer.verdict, stamp)

    def _show_verdict(self, verdict: CalibrationVerdict, stamp: float | None) -> None:
        shown = self.shown.verdict
        dwells = stamp is not None and time.monotonic() < self._counted_until
        if shown is not None and verdict.kind == "same" and dwells:
            shown.stamp_s = stamp
            return
        self._number += 1
        verdict.number, verdict.stamp_s = self._number, stamp
        self.shown.verdict = verdict
        if verdict.kind == "counted":
            self.last_counted = self._number
            self._counted_until = time.monotonic() + DWELL_S

    async def _keep(self, counted: answers.CountedPicture, content: bytes | None) -> None:
        picture = counted.picture or content
        if not picture:
            return
        try:
            async with self._writing:
                if self._deleted:
                    return
                number = len(self.pictures) + 1
                name = await to_the_end(lambda: self.folder.save_picture(number, picture, counted.small))
        except OSError:
            self._tell("A view's picture cannot be saved on disk; its corners are kept. Check the data folder.")
            return
        self.pictures[counted.name] = name

    async def _solve(self) -> None:
        try:
            while self._stale and self._names != self._given_up:
                names = list(self._names)
                self.shown.solving = CalibrationSolving(time.time(), f"Solving with {len(names)} views.")
                self._changed(self, True)
                await self._solve_once(names)
        finally:
            if self.solving_task is asyncio.current_task():
                self.shown.solving = self.solving_task = None
                self._settled.set()
            self._changed(self, True)
        await self._measure_correction()

    async def _solve_once(self, names: list[str]) -> None:
        try:
            result = await self._solution()
            self._solved = result.solved
            self.shown.solution = dict(result.report)
            self.shown.active_compare = self.compare()
            self.exports = result.exports
            await self.act(SessionWorker.adopt(result.solved), patient=True)
        except (BeckonError, Problem) as wrong:
            self._given_up = names
            self.trouble(f"Not solved: {wrong}")

    async def _measure_correction(self) -> None:
        """How well Table 1 straightens this camera's pictures; takes longer than solving, so it comes last."""
        camera = camera_in(self.shown)
        if camera is None or self.shown.solution is None or "correction" in self.shown.solution:
            return
        solution = self.shown.solution
        try:
            solution["correction"] = await self._solver_worker.ask(SolverWorker.correction(camera), budget=BUDGET_S)
        except BeckonError:
            return
        await self.save()
        self._changed(self, False)


class CameraCalibrationSession(CalibrationSession):
    def _opening(self) -> Job[answers.SessionAnswer]:
        return CameraWorker.open(self.card.board, self._state, self._solved)

    async def _solution(self) -> answers.CameraSolution:
        job = SolverWorker.solve_camera(self.card.board, self._state, printed=self.printed)
        return await self._solver_worker.ask(job, budget=SOLVE_BUDGET_S)

    async def _acceptance(self, *, force: bool) -> answers.AcceptedCamera:
        return await self._asked(CameraWorker.accept(force=force))


class LaserCalibrationSession(CalibrationSession):
    def _opening(self) -> Job[answers.SessionAnswer]:
        camera, mount = self.card.camera, self.card.mount
        assert camera is not None and mount is not None
        return LaserWorker.open(self.card.board, self._state, self._solved, camera, mount.mount)

    async def _solution(self) -> answers.LaserSolution:
        camera, mount = self.card.camera, self.card.mount
        assert camera is not None and mount is not None
        job = SolverWorker.solve_laser(self.card.board, self._state, camera, mount.mount, printed=self.printed)
        return await self._solver_worker.ask(job, budget=SOLVE_BUDGET_S)

    async def _acceptance(self, *, force: bool) -> answers.AcceptedMount:
        return await self._asked(LaserWorker.accept(force=force))
