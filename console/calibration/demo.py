"""The simulated person: holds the board as advised, with a person's aim, until the session has enough."""

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy

from console.calibration.codec import board_of
from console.calibration.session import CalibrationSession
from console.calibration.session_worker import SessionWorker
from console.workers.demo_runner import Demo
from core.calibration.board.board import Board
from core.errors import BadInput, BeckonError, Refused
from core.geometry import Transform
from core.robots.requests import Ask, BoardInCamera, PlaceBoard, RemoveThing

Suggest = Callable[[bool], Awaitable[Transform | None]]
Phase = Literal["beside", "holding", "done"]

SETTLED = ("same", "refused")  # verdicts after which holding on is no use


@dataclass(frozen=True)
class SessionView:
    number: int = 0  # of the newest verdict
    kind: str = ""  # of the newest verdict
    ready: bool = False  # the calibration can be accepted
    empty: bool = False  # the laser looks at the empty room: stay out of it
    busy: bool = False  # a solution is on its way, after which the advice will be better


# How well and how patiently the board is held.
AIM_SD_RAD = np.deg2rad(5)  # [rad] by which the aim misses, standard deviation
AIM_SD_M = 0.05  # [m] likewise, in space
MOVING_TIME_S = 1.2  # [s] from one pose to the next
SETTLING_TIME_S = 0.15  # [s] after arriving before verdicts are listened to
MAX_HOLD_S = 4.0  # [s] that a pose is held while nothing comes of it
MAX_UNSEEN_S = 1.2  # [s] that a pose is held while no board is seen
MAX_GATHERING_S = 8.0  # [s] that a pose is held while scans are gathered
MAX_SOLVING_S = 3.0  # [s] waited at most for a solution before the next pose
LIFT_STEP_M = 0.03  # [m] higher with every refusal of the room: low poses end at the floor
MAX_LIFT_M = 0.36  # [m] of all these steps, after which it is low again
TRIES_PER_ADVICE = 4  # poses asked of the room before another suggestion is asked for
MAX_BARRED_ADVICES = 40  # suggestions in a row that the room refuses before the demo gives up
CARE_SHARES = (1.0, 0.5, 0.25)  # share of the misses in the first and the following tries at an advice


class BoardDemo:
    """Follows a session's advice in the simulated room. Owned by one task, which calls `step` ten times a second.

    `ask(request)` awaits the driver's answer (`Runtime.ask`) and raises BadInput where a pose cannot be taken;
    `advice(another)` awaits the advised pose camera_from_board, a new suggestion when `skip` is True, or None
    while there is none; `board` is what is held, with its panel. Time comes with `step`, chance from `seed`.

        demo = BoardDemo(runtime.ask, advice, session.board, seed=1)
        while not demo.done:
            await demo.step(loop.time(), Sight(number, kind, ready, empty, busy))
            await asyncio.sleep(0.1)
        await demo.leave()                    # also when it is switched off before
    """

    def __init__(self, ask: Ask, advice: Suggest, board: Board, *, seed: int = 0) -> None:
        self._ask, self._advice, self._board = ask, advice, board
        self._rng = np.random.default_rng(seed)
        self._phase: Phase = "beside"
        self._shown = False  # the board is in the room
        self._arrived = self._freed = 0.0  # [s]
        self._left = self._heard = 0  # numbers of the newest verdicts on departure and on arrival
        self._tries = 0  # at the present advice
        self._barred = 0  # suggestions in a row that the room has refused
        self.held = 0  # poses so far

    @property
    def done(self) -> bool:
        """The session has enough views; the board is gone."""
        return self._phase == "done"

    async def step(self, now: float, sight: SessionView) -> None:
        """Do the next step at `now` [s]: hold on, move on, stay away, or leave.

        Raises Refused with a sentence when there is no room for the board, whatever is suggested.
        """
        if sight.ready:
            await self.leave()
            self._phase = "done"
        elif sight.empty:
            await self.leave()
            self._freed = now
        elif self._phase == "beside" or self._through(now, sight):
            await self._move_on(now, sight)

    async def leave(self) -> None:
        if self._shown:
            self._shown, self._phase = False, "beside"
            try:
                await self._ask(RemoveThing(id="board"))
            except BeckonError:
                return  # another viewer was quicker, or there is no room any more

    def _through(self, now: float, sight: SessionView) -> bool:
        """Return whether holding the present pose is over, for better or worse."""
        held = now - self._arrived
        counted = sight.kind == "counted" and sight.number != self._left
        if held < SETTLING_TIME_S and not counted:
            self._heard = sight.number
            return False
        settled = sight.kind in SETTLED and sight.number != self._heard
        waits = {"gathering": MAX_GATHERING_S, "nothing": MAX_UNSEEN_S}
        if not (counted or settled) and held < waits.get(sight.kind, MAX_HOLD_S):
            return False
        self._phase, self._freed = "beside", now
        self._tries = 0 if counted else self._tries + 1
        return True

    async def _move_on(self, now: float, sight: SessionView) -> None:
        """To the advised pose, more carefully the more often that has failed, then to another one."""
        if sight.busy and now - self._freed < MAX_SOLVING_S:
            return
        skip = self._tries > 0 and self._tries % len(CARE_SHARES) == 0
        pose = await self._advice(skip)
        if pose is None:
            return
        barred = await self._barred_from(now, pose)
        if not barred:
            self._left, self._barred = sight.number, 0
            return
        self._barred += 1
        self._tries += len(CARE_SHARES) - self._tries % len(CARE_SHARES)
        if self._barred >= MAX_BARRED_ADVICES:
            raise Refused(f"{barred} Drive the robot to where there is room before it, and begin again.")

    async def _barred_from(self, now: float, advised: Transform) -> str:
        """Ask the room for the advised pose, missed a little, higher each time it says no → its reason, or ''."""
        turns, which = divmod(self._tries, len(CARE_SHARES))
        words = ""
        for number in range(TRIES_PER_ADVICE):
            higher = LIFT_STEP_M * (number + turns * TRIES_PER_ADVICE) % MAX_LIFT_M if number else 0.0
            pose = self._missed(advised, CARE_SHARES[which], higher)
            try:
                await self._ask(self._request(pose))
            except BadInput as reason:
                words = str(reason)
                continue
            self._arrived = now + (MOVING_TIME_S if self._shown else 0.0)
            self._shown, self._phase = True, "holding"
            self.held += 1
            return ""
        return words

    def _missed(self, advised: Transform, care: float, lift: float) -> Transform:
        """The pose as a hand finds it: turned and shifted by chance, lifted by `lift` [m]; camera_from_board."""
        rng = self._rng
        about = rng.normal(size=3)
        about *= care * AIM_SD_RAD * abs(rng.normal()) / np.linalg.norm(about)
        rotation = scipy.spatial.transform.Rotation.from_rotvec(about).as_matrix() @ advised.rotation
        shift = rng.normal(0.0, care * AIM_SD_M / np.sqrt(3), 3) + np.array([0.0, -lift, 0.0])
        middle = advised.apply(self._board.centre[None])[0] + shift
        return Transform(rotation=rotation, translation=middle - rotation @ self._board.centre)

    def _request(self, pose: Transform) -> PlaceBoard:
        board = self._board
        return PlaceBoard(
            columns=board.columns,
            rows=board.rows,
            square_m=board.square,
            panel_m=board.panel,
            in_camera=BoardInCamera(tuple(map(tuple, pose.rotation.tolist())), tuple(pose.translation.tolist())),
            seconds=MOVING_TIME_S,
            holder=True,
        )


STEP_S = 0.1
MAX_DEMO_S = 600.0  # after which the demo gives up


def demo_of(session: CalibrationSession, ask: Ask, seed: int) -> Demo:
    """The demonstration that holds the session's board until the session is ready, then takes the board away."""
    board = board_of(session.card.board)
    board_demo = BoardDemo(ask, lambda skip: advised(session, skip), board, seed=seed)

    async def run() -> None:
        loop = asyncio.get_running_loop()
        began, heard = loop.time(), session.last_counted
        while not board_demo.done and loop.time() - began < MAX_DEMO_S:
            counted = session.last_counted != heard
            heard = session.last_counted
            await board_demo.step(loop.time(), sight_of(session, counted))
            await asyncio.sleep(STEP_S)

    def show(*, on: bool) -> None:
        session.shown.demo = on
        session.show(urgent=True)

    return Demo(
        session=session.card.id,
        run=run,
        leave=board_demo.leave,
        began=lambda: show(on=True),
        ended=lambda: show(on=False),
        trouble=session.trouble,
    )


async def advised(session: CalibrationSession, skip: bool) -> Transform | None:
    """The advised pose of the board, camera_from_board; a new suggestion when `skip`."""
    if skip:
        await session.act(SessionWorker.skip(), patient=True)
    return session.pose


def sight_of(session: CalibrationSession, counted: bool) -> SessionView:
    """Return the demo's view of the session; a view that counted since the last time is not overlooked."""
    verdict = session.shown.verdict
    kind = "" if verdict is None else verdict.kind
    return SessionView(
        number=session.last_counted if counted else 0 if verdict is None else verdict.number,
        kind="counted" if counted else kind,
        ready=session.shown.progress.ready,
        empty=session.card.kind == "laser" and kind in ("", "background"),
        busy=session.shown.solving is not None,
    )
