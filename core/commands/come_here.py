"""COME HERE: the robot moves towards the sound source and stops half a metre from it (Table 2)."""

from __future__ import annotations

from dataclasses import dataclass

from core.commands.command import Action, Command, CommandSpec, Progress, Target
from core.commands.keep_to_person import KeepToPerson, aim_at, following_words, going
from core.commands.locate_voice import LocateVoice
from core.commands.turn_to_voice import TurnToVoice, call_for, heard_for
from core.errors import Refused
from core.navigation.control_context import ControlContext
from core.navigation.goal_controller import GoalController
from core.sentences import Statement

MAX_UNSEEN_S = 3.0  # without a sight of the person, after which the robot says so when it has come


@dataclass(frozen=True, kw_only=True)
class ComeHere(CommandSpec):
    """Drive to the person who called."""

    name: str = "come_here"
    words: tuple[str, ...] = ("come here", "come")
    example: str = "come here"
    summary: str = "Turns to the voice, looks who spoke, comes and stops half a metre before them."
    target: Target = "person"
    already: str = Statement("command.already_coming")
    icon: str = "come_here"

    def begin(self, command: Command, ctx: ControlContext) -> Action:
        """Turn to the person who spoke. Raises Refused with a sentence without a fresh, sure direction."""
        if ctx.company.mode == "person":
            return Coming(TurnToVoice(heard_for(command, ctx), ctx))
        call = call_for(command, ctx)
        if ctx.who is not None:
            raise Refused(Statement("come.only_to_by_ear", name=ctx.who.name))
        return LocateVoice(call, ctx)


class Coming:
    """The way to a person who was seen."""

    def __init__(self, seeking: TurnToVoice) -> None:
        self._attending = KeepToPerson(seeking, stands=True)
        self._approach: GoalController | None = None
        self._whole = 1.0

    def drive(self, ctx: ControlContext) -> Progress:
        """Take one frame."""
        person = self._attending.watch(ctx)
        if isinstance(person, Progress):
            return person
        short = ctx.company.stop_short
        aim = aim_at(person, short)
        apart = ctx.pose.distance_to(aim.x, aim.y)
        if self._approach is None:
            self._approach = GoalController(aim, ctx, cruise=ctx.company.coming)
            self._whole = max(apart - short, 0.05)
        step = self._approach.drive(ctx, aim)
        if step.state == "there":
            if ctx.stamp - self._attending.track.measured > MAX_UNSEEN_S:
                return Progress(finished="failed", remark=Statement("come.gone"))
            return Progress(
                finished="done", remark=Statement("come.here_i_am", apart=f"{apart:.2f}"), fraction=1.0, person=person
            )
        words = following_words(self._attending, person, Statement("come.i_come"), Statement("come.i_come_to_last"))
        return going(step, person, words, min(max(1 - (apart - short) / self._whole, 0.0), 1.0))


COME_HERE = ComeHere()
