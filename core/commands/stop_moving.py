"""STOP MOVING, and START of the paper's Fig. 17: the robot stands still."""

from dataclasses import dataclass

from core.commands.command import Action, Command, CommandSpec, Progress
from core.navigation.control_context import ControlContext
from core.sentences import Statement


@dataclass(frozen=True, kw_only=True)
class StopMoving(CommandSpec):
    """Standing still, and that is all."""

    remark: str
    moves: bool = False

    def begin(self, command: Command, ctx: ControlContext) -> Action:
        """Stop at once; whatever ran before has been pre-empted."""
        return StandingStill(command.remark or self.remark)


class StandingStill:
    """Asks for zero speed and is done."""

    def __init__(self, remark: str) -> None:
        self._remark = remark

    def drive(self, ctx: ControlContext) -> Progress:
        """Zero, at once."""
        return Progress(finished="done", remark=self._remark, fraction=1.0)


STOP_MOVING = StopMoving(
    name="stop_moving",
    words=("stop moving", "stop"),
    example="stop moving",
    summary="Stops moving at once. Any sentence with the word stop does, and so does a lone halt, wait, freeze, no …",
    remark=Statement("command.stands_still"),
    icon="stop_moving",
)
START = StopMoving(
    name="start",
    words=("start",),
    example="start",
    summary="Stands still and waits for a command.",
    remark=Statement("command.ready"),
)

STOP_PHRASES = (
    "abort",
    "brake",
    "cancel",
    "don't move",
    "freeze",
    "halt",
    "hold on",
    "wait",
    "abort it",
    "abort that",
    "break",  # as a recognizer writes brake
    "brakes",
    "cancel it",
    "cancel that",
    "cease",
    "do not go",
    "do not move",
    "don't go",
    "enough",
    "estop",
    "hold",
    "hold it",
    "hold still",
    "no",
    "nope",
    "pause",
    "quit",
    "stand still",
    "stay",
    "stay there",
    "stops",
    "stopping",
    "wait a minute",
    "wait a moment",
    "wait a second",
    "whoa",
)
"""Utterances that stop the robot as a whole, typed or spoken: one of these, several, or one again and again. In other
sentences people say these words of something else; there only the word stop stops.
"""
SOUGHT_STOP_PHRASES = tuple(phrase for phrase in STOP_PHRASES if "stop" not in phrase and phrase != "no")
"""Those that a recognizer seeks beside the commands, so that an unclear one is found too; "no" is in every noise."""
AROUND_STOP = ("hey", "now", "ok", "okay", "oh", "please", "robot", "uh", "um")
"""Words around such a phrase that do not change what it asks for."""
