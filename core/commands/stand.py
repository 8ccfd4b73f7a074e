"""STOP MOVING, and START of the paper's Fig. 17: the robot stands still."""

from __future__ import annotations

from dataclasses import dataclass

from core.commands.command import Action, Command, Number, Progress
from core.navigation.surroundings import Surroundings


@dataclass(frozen=True)
class Stand:
    """Standing still, and that is all."""

    name: str
    words: tuple[str, ...]
    summary: str
    remark: str
    numbers: tuple[Number, ...] = ()
    moves: bool = False

    @property
    def example(self) -> str:
        """Words that are understood as they stand."""
        return self.words[0]

    def begin(self, command: Command, here: Surroundings) -> Action:
        """Stop at once; whatever ran before has been pre-empted."""
        return Standing(command.remark or self.remark)


class Standing:
    """Asks for zero speed and is done."""

    def __init__(self, remark: str) -> None:
        self._remark = remark

    def drive(self, here: Surroundings) -> Progress:
        """Zero, at once."""
        return Progress(finished="done", remark=self._remark, fraction=1.0)


STOP_MOVING = Stand(
    name="stop_moving",
    words=("stop moving", "stop"),
    summary="Stops moving at once. Any sentence with the word stop does.",
    remark="The robot stands still.",
)
START = Stand(
    name="start",
    words=("start",),
    summary="Stands still and waits for a command.",
    remark="Ready for a command.",
)
