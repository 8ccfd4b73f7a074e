"""FOLLOW ME: the robot turns to the sound source and tracks the human who is seen there (Table 2)."""

from dataclasses import dataclass

from core.commands.command import Action, Command, CommandSpec, Progress, Target
from core.commands.keep_to_person import KeepToPerson, aim_at, following_words, going
from core.commands.turn_to_voice import TurnToVoice, heard_for
from core.navigation.control_context import ControlContext
from core.navigation.goal_controller import GoalController
from core.sentences import Statement


@dataclass(frozen=True, kw_only=True)
class FollowMe(CommandSpec):
    """Follow the person who called, until another command."""

    name: str = "follow_me"
    words: tuple[str, ...] = ("follow me",)
    example: str = "follow me"
    summary: str = "Turns to the voice and follows who spoke, a metre behind, until another command."
    target: Target = "person"
    endless: bool = True
    already: str = Statement("command.already_following")
    icon: str = "follow_me"

    def begin(self, command: Command, ctx: ControlContext) -> Action:
        """Turn to the person who spoke. Raises Refused with a sentence without a fresh, sure direction."""
        return FollowingPerson(TurnToVoice(heard_for(command, ctx), ctx))


class FollowingPerson:
    """Following a person."""

    def __init__(self, seeking: TurnToVoice) -> None:
        self._attending = KeepToPerson(seeking)
        self._approach: GoalController | None = None

    def drive(self, ctx: ControlContext) -> Progress:
        """Take one frame."""
        person = self._attending.watch(ctx)
        if isinstance(person, Progress):
            return person
        if self._attending.track.lost(ctx.stamp):
            return Progress(finished="failed", remark=Statement("come.lost"))
        aim = aim_at(person, ctx.company.keep)
        if self._approach is None:
            cruise = min(ctx.company.following, ctx.body.max_speed)
            self._approach = GoalController(aim, ctx, lasting=True, cruise=cruise)
        step = self._approach.drive(ctx, aim)
        hidden = Statement("come.hidden")
        return going(step, person, following_words(self._attending, person, Statement("come.follow"), hidden))


FOLLOW_ME = FollowMe()
