"""Show me: the simulated assistant holds the board as a session advises."""

from __future__ import annotations

import asyncio
from typing import Any

import msgspec
import numpy as np

from console.calibration.assistant import Ask, Assistant, Sight
from console.calibration.sitting import Sitting
from console.calibration.values import board_of
from console.problems import Problem
from core.errors import BeckonError
from core.geometry import Transform

STEP = 0.1  # [s]
PANEL = 0.02  # [m] of rim around the print that the assistant's board has, when nobody measured it
PATIENCE = 600.0  # [s] after which the assistant gives up


async def show(sitting: Sitting, ask: Ask, seed: int) -> None:
    """Until the session is ready, or this task is cancelled; then the board is taken away."""

    board = board_of(msgspec.to_builtins(sitting.card.board))
    loop = asyncio.get_running_loop()
    assistant = Assistant(ask, lambda another: advised(sitting, another), board, seed=seed)
    began, heard = loop.time(), sitting.last_counted
    try:
        while not assistant.done and loop.time() - began < PATIENCE:
            counted = sitting.last_counted != heard
            heard = sitting.last_counted
            await assistant.step(loop.time(), sight_of(sitting, counted))
            await asyncio.sleep(STEP)
    except (BeckonError, Problem) as wrong:
        sitting.trouble(f"The assistant gave up: {wrong}")
    finally:
        await asyncio.shield(assistant.leave())


async def advised(sitting: Sitting, another: bool) -> Transform | None:
    """The advised pose of the board, camera_from_board; a new suggestion when `another`."""
    if another:
        await sitting.act("another", {}, patient=True)
    pose: dict[str, Any] | None = sitting.pose
    if pose is None:
        return None
    return Transform(rotation=np.array(pose["rotation"]), translation=np.array(pose["translation_m"]))


def sight_of(sitting: Sitting, counted: bool) -> Sight:
    """What the assistant is told; a view that counted since the last time is not overlooked."""
    verdict = sitting.session.verdict
    kind = "" if verdict is None else verdict.kind
    return Sight(
        number=sitting.last_counted if counted else 0 if verdict is None else verdict.number,
        kind="counted" if counted else kind,
        ready=sitting.session.progress.ready,
        empty=sitting.card.kind == "laser" and kind in ("", "background"),
        busy=sitting.session.solving is not None,
    )
