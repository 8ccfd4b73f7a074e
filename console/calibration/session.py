"""One calibration session as the console keeps it: its worker, its file, and what the page is shown."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from typing import Any, get_type_hints

import msgspec

from console import messages
from console.calibration.codec import camera_in
from console.calibration.storage import VERSION, SessionStore, StoredSession
from console.http.problems import Problem
from console.messages.calibration import VerdictKind
from console.workers.tasks import to_the_end
from console.workers.worker import Worker, WorkerLost
from core.errors import BadInput, BeckonError, Refused
from core.geometry import Pose


class SessionWriter:
    """Lives on the event loop; the disk is waited for in threads."""

    def __init__(self, folder: SessionStore) -> None:
        self._folder = folder
        self._turn = asyncio.Lock()
        self._gone = False

    async def save(self, encoded: Callable[[], bytes]) -> None:
        """Replace the session's file by the `encoded` content when its turn comes. Raises OSError."""
        async with self._turn:
            if not self._gone:
                raw = encoded()
                await to_the_end(lambda: self._folder.save(raw))

    async def picture(self, number: int, picture: bytes, small: bytes) -> str | None:
        """A view's picture and its thumbnail → the file's name; None: the session is gone. Raises OSError."""
        async with self._turn:
            if self._gone:
                return None
            return await to_the_end(lambda: self._folder.save_picture(number, picture, small))

    async def remove(self) -> None:
        """Delete everything for good; later content is not written any more."""
        self._gone = True
        async with self._turn:
            await to_the_end(self._folder.remove)


PICTURE_BUDGET = 2.0  # [s] of processor time for one picture
BUDGET = 10.0  # [s] for anything else at the worker
SOLVE_BUDGET = 60.0  # [s]
SOLVE_PATIENCE = 30.0  # [s] by the clock that accepting waits for a solution
DWELL = 1.0  # [s] that "counted" stays before the live picture's "same as …" may replace it
MOST_WAITING = 3  # requests that may wait for the worker
COVERED = "The solution is of all these views already. Show more of them, or leave one out; then it is solved again."
PARTS = get_type_hints(messages.CalibrationSessionState)

Shown = Callable[["CalibrationSession", bool], None]


class CalibrationSession:
    """Lives on the event loop. Everything that looks at pictures or computes happens in workers."""

    def __init__(
        self, kept: StoredSession, folder: SessionStore, solver: Worker, shown: Shown, tell: Callable[[str], None]
    ) -> None:
        self.card, self.shown = kept.card, kept.shown
        self.pictures, self.exports = kept.pictures, kept.exports
        self.folder, self._writing = folder, SessionWriter(folder)
        self.pose: dict[str, Any] | None = None  # of the board as advised, camera_from_board
        self.stood: Pose | None = None  # by odometry, when the robot began to look at the empty room (live)
        self.solver: asyncio.Task[None] | None = None
        self._task: asyncio.Task[None] | None = None  # the solver, and then the measuring of its correction
        self._settled = asyncio.Event()  # no solver is at work
        self._settled.set()
        self.compare: Callable[[], dict[str, tuple[float, float]] | None] = lambda: None
        self.used = self.looked_at = time.monotonic()  # when its worker, and when the session, was last asked for
        self.last_counted = 0  # number of the newest verdict that counted
        self._state = kept.state
        self._names: list[str] = []  # of the views that take part
        self._stale = False
        self._given_up: list[str] | None = None  # views that could not be solved
        self._calibration: tuple[bytes, list[str]] | None = None
        self._solver, self._shown, self._tell, self._worker = solver, shown, tell, Worker(kept.card.kind)
        self._opened = 0  # the worker's start at which the session was laid on it
        self._turn = asyncio.Lock()
        self._waiting = 0
        self._rests = 0  # how often it was put aside
        self._counted_until = 0.0  # [s] of the monotonic clock
        self._number = kept.shown.verdict.number if kept.shown.verdict else 0

    @property
    def pid(self) -> int | None:
        """Of its worker, while there is one."""
        return self._worker.pid

    @property
    def busy(self) -> bool:
        """True while a job is under way."""
        return self._waiting > 0 or self.solver is not None

    async def act(
        self,
        do: str,
        given: dict[str, Any],
        *,
        budget: float = BUDGET,
        stamp: float | None = None,
        patient: bool = False,
    ) -> dict[str, Any]:
        """One job at the worker → its answer, shown and saved already. Raises Problem, BadInput, Refused.

        `patient`: this caller may wait behind however many others.
        """
        if self._waiting >= MOST_WAITING and not patient:
            raise Problem(429, "One thing at a time: wait for the answer before you send the next picture.")
        self._waiting += 1
        self.used, rests = time.monotonic(), self._rests
        try:
            async with self._turn:
                answer = await self._asked(do, given, budget)
                await self._took(answer, given.get("content"), stamp)
        except (BeckonError, Problem):
            if rests == self._rests:
                self.solve_soon()  # the failed job may have left views that are not solved
            raise
        finally:
            self._waiting -= 1
        self.solve_soon()
        return answer

    async def accept(self, *, force: bool) -> dict[str, Any]:
        """The document and the report of the solution. Raises Refused with the reason, Problem 503.

        What is being solved is waited for. A restart costs the solution all but what is shown of it; then it is
        solved again first, of the same views.
        """
        if self._calibration is None and self.shown.solution is not None:
            await self.act("refresh", {})
        try:
            async with asyncio.timeout(SOLVE_PATIENCE):
                await self._settled.wait()
        except TimeoutError:
            raise Problem(503, "It is still being solved; try again when the solution is there.") from None
        return await self.act("accept", {"force": force})

    def trouble(self, words: str, kind: VerdictKind = "trouble") -> None:
        """Tell the person what went wrong."""
        self._adopt({"verdict": {"kind": kind, "words": words}}, None)
        self._shown(self, True)

    def show(self, *, urgent: bool = False) -> None:
        """Something about the session has changed."""
        self._shown(self, urgent)

    async def save(self) -> None:
        """Write all of it."""
        try:
            await self._writing.save(self._encoded)
        except OSError:
            self._tell("The calibration cannot be saved on disk now; it goes on in memory. Check the data folder.")

    async def remove(self) -> None:
        """Delete the session from the disk for good; waits for a write under way, and nothing is written after it."""
        await self._writing.remove()

    def solve_soon(self, *, again: bool = False) -> None:
        """Solve in the background, when the solution does not cover the views."""
        if again:
            self._given_up = None
        if self._stale and self.solver is None and self._names != self._given_up:
            self._settled.clear()
            self.solver = self._task = asyncio.get_running_loop().create_task(self._solve())

    async def solve_now(self) -> None:
        """Solve, even what could not be solved before. Raises Refused with too few views, or with nothing new."""
        await self.act("refresh", {})
        if not self._stale:
            covered = self._calibration is not None and self._calibration[1] == self._names
            raise Refused(COVERED if covered else self.shown.progress.words)
        self.solve_soon(again=True)

    def close(self) -> None:
        """End the worker; the session stays. A job under way is not done again."""
        self._rests += 1
        if self._task is not None:
            self._task.cancel()
        self.solver = self._task = self.shown.solving = None
        self._settled.set()
        self._worker.kill()

    async def gone(self) -> None:
        """Its worker was ended: wait until there is no process any more."""
        await self._worker.gone()

    def _encoded(self) -> bytes:
        """All of it, as it is now."""
        return msgspec.json.encode(
            StoredSession(VERSION, self.card, self.shown, self._state, self.pictures, self.exports)
        )

    async def _asked(self, do: str, given: dict[str, Any], budget: float) -> dict[str, Any]:
        """The worker's answer. A job whose worker was killed from outside is done again, once."""
        rests = self._rests
        for last in (False, True):
            await self._lay_out()
            try:
                return await self._worker.ask(do, given, budget=budget)
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
        calibration, names = self._calibration or (None, [])
        given = {**self._job(), "calibration": calibration, "names": names}
        try:
            answer = await self._worker.ask("open", given, budget=BUDGET)
        except WorkerLost as lost:
            self.trouble(str(lost))
            raise Problem(503, "The calibration's worker does not start; try again.") from None
        self._opened = self._worker.starts
        self._learn(answer)

    async def _took(self, answer: dict[str, Any], content: bytes | None, stamp: float | None) -> None:
        counted = answer.get("kept")
        if counted is not None:
            await self._keep(counted, content)
        self._learn(answer, stamp)
        if "state" in answer:
            await self.save()
        self._shown(self, counted is not None)

    def _learn(self, answer: dict[str, Any], stamp: float | None = None) -> None:
        self._adopt(answer.get("parts", {}), stamp)
        if "state" in answer:
            self._state, self._stale, self._names = answer["state"], answer["stale"], answer["names"]

    def _adopt(self, parts: dict[str, Any], stamp: float | None) -> None:
        """Update what the page is shown; anything from a worker is checked."""
        verdict, stamped = parts.get("verdict"), stamp is not None
        shown = self.shown.verdict
        if verdict and shown and stamped and verdict["kind"] == "same" and time.monotonic() < self._counted_until:
            shown.stamp_s = stamp
            parts = {name: value for name, value in parts.items() if name != "verdict"}
        for name, value in parts.items():
            setattr(self.shown, name, msgspec.convert(value, PARTS[name]))
        if parts.get("advice") is not None:
            self.pose = parts["advice"]
        if parts.get("verdict") is not None and self.shown.verdict is not None:
            self._number += 1
            self.shown.verdict.number, self.shown.verdict.stamp_s = self._number, stamp
            if self.shown.verdict.kind == "counted":
                self.last_counted = self._number
                self._counted_until = time.monotonic() + DWELL

    async def _keep(self, counted: dict[str, Any], content: bytes | None) -> None:
        """The picture of a view that was counted."""
        picture = counted["picture"] or content
        if not picture:
            return
        try:
            name = await self._writing.picture(len(self.pictures) + 1, picture, counted["small"])
        except OSError:
            self._tell("A view's picture cannot be saved on disk; its corners are kept. Check the data folder.")
            return
        if name is not None:
            self.pictures[counted["name"]] = name

    async def _solve(self) -> None:
        try:
            while self._stale and self._names != self._given_up:
                names = list(self._names)
                self.shown.solving = messages.CalibrationSolving(time.time(), f"Solving with {len(names)} views.")
                self._shown(self, True)
                await self._solve_once(names)
        finally:
            if self.solver is asyncio.current_task():
                self.shown.solving = self.solver = None
                self._settled.set()
            self._shown(self, True)
        await self._measure_correction()

    async def _solve_once(self, names: list[str]) -> None:
        try:
            result = await self._solver.ask(f"solve_{self.card.kind}", self._job(), budget=SOLVE_BUDGET)
            self._calibration = result["calibration"], result["names"]
            self.shown.solution = result["report"]
            self.shown.active_compare = self.compare()
            self.exports = {form: (name, text) for form, (name, text) in result["exports"].items()}
            await self.act("adopt", {"calibration": result["calibration"], "names": result["names"]}, patient=True)
        except (BeckonError, Problem) as wrong:
            self._given_up = names
            self.trouble(f"Not solved: {wrong}")

    def _job(self) -> dict[str, Any]:
        job: dict[str, Any] = {"board": msgspec.to_builtins(self.card.board), "state": self._state}
        if self.card.kind == "laser":
            job |= {"camera": self.card.camera, "mount": self.card.mount}
        return job

    async def _measure_correction(self) -> None:
        """How well Table 1 straightens this camera's pictures; takes longer than solving, so it comes last."""
        camera = camera_in(self.shown)
        if camera is None or self.shown.solution is None or "correction" in self.shown.solution:
            return
        solution = self.shown.solution
        try:
            solution["correction"] = await self._solver.ask("correction", {"camera": camera}, budget=BUDGET)
        except BeckonError:
            return
        await self.save()
        self._shown(self, False)
