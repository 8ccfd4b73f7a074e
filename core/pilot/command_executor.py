"""Execution of commands: the active command, its progress and its end (Fig. 6: the last command wins)."""

from dataclasses import dataclass, replace

from core.commands import spec_of
from core.commands.command import Action, Command
from core.commands.dry_run import DryRun
from core.errors import Refused
from core.gate import ZERO, Twist
from core.message import Array
from core.navigation.control_context import ControlContext
from core.perception.people.tracked_person import TrackedPerson
from core.sentences import Statement
from core.snapshot import ActiveCommandStatus, Ending


@dataclass(frozen=True)
class AcceptedCommand:
    """A command that came in."""

    id: int
    command: Command
    source: str
    who: str


class CommandExecutor:
    """Owns the active command."""

    def __init__(self, *, dry: bool = False) -> None:
        """`dry`: nothing here moves, so commands to a person show what they would do."""
        self._dry = dry
        self._next: tuple[AcceptedCommand, float] | None = (
            None  # came in while another is under way, at this stamp [s]
        )
        self._command: Command | None = None
        self._action: Action | None = None
        self._paused = 0.0  # [s] for which the active command has waited; its clock stood meanwhile
        self._endings: list[ActiveCommandStatus] = []
        self.active_command: ActiveCommandStatus | None = None  # the one under way
        self.path: Array | None = None  # (P, 2) [m], world
        self.goal: Array | None = None  # (2,) [m], world
        self.person: TrackedPerson | None = None  # who is looked at

    def accept(self, accepted: AcceptedCommand, stamp: float) -> None:
        """Take in a command at `stamp` [s].

        One that moves waits for `drive` while another one moves the robot: when it cannot begin, it is refused and
        the other goes on.
        """
        self._end_next("pre-empted", _came_after(accepted))
        if self._action is not None and spec_of(accepted.command.name).moves:
            self._next = accepted, stamp
        else:
            self._adopt(accepted, stamp)

    def drive(self, ctx: ControlContext, wait_for: str = "") -> Twist:
        """Execute one frame → the twist to ask of the gate. `wait_for`: why nothing may begin to move yet."""
        if self._next is not None:
            self._begin(*self._next, ctx, wait=bool(wait_for))
        if self.active_command is None or self._command is None:
            return ZERO
        kind = spec_of(self._command.name)
        ctx = replace(ctx, stamp=ctx.stamp - self._paused)
        if wait_for and kind.moves and self._action is None:
            self.active_command = replace(self.active_command, remark=wait_for)
            return ZERO
        try:
            if self._action is None:
                self._action = self._action_of(self._command, ctx)
            progress = self._action.drive(ctx)
        except Refused as refusal:
            self.end("refused", str(refusal))
            return ZERO
        if progress.path is not None:
            self.path = progress.path
        if progress.goal is not None:
            self.goal = progress.goal
        self.person = progress.person
        self.active_command = replace(self.active_command, remark=progress.remark, progress=progress.fraction)
        if progress.finished:
            self.end("done" if progress.finished == "done" else "failed", progress.remark)
            return ZERO
        return Twist(float(progress.twist.v), float(progress.twist.w))  # the gate takes no numpy numbers

    def only_turn(self, rate: float, why: str, passed: float) -> Twist:
        """Wait, and turn on the spot at `rate` [rad/s] by leave of the command under way, for `passed` [s]."""
        if self._next is not None:
            self._adopt(*self._next)
        if self.active_command is None:
            return ZERO
        self._paused += passed
        self.path = self.goal = self.person = None
        self.active_command = replace(self.active_command, remark=why, progress=None)
        return Twist(0.0, rate)

    def end(self, state: Ending, why: str) -> None:
        """End the active command, if any, and the one that would have come next."""
        self._end_next(state, why)
        if self.active_command is not None:
            self._endings.append(replace(self.active_command, state=state, remark=why))
        self._paused = 0.0
        self.active_command = self._command = self._action = self.path = self.goal = self.person = None

    def _end_next(self, state: Ending, why: str) -> None:
        if self._next is not None:
            self._endings.append(replace(_active_command(*self._next), state=state, remark=why))
        self._next = None

    def _adopt(self, accepted: AcceptedCommand, stamp: float, action: Action | None = None) -> None:
        self._next = None
        self.end("pre-empted", _came_after(accepted))
        self._command, self._action, self.active_command = accepted.command, action, _active_command(accepted, stamp)

    def _begin(self, accepted: AcceptedCommand, stamp: float, ctx: ControlContext, *, wait: bool) -> None:
        """Let the command that came in take the other's place if it can begin; `wait`: it does so later."""
        try:
            action = self._action_of(accepted.command, ctx)
            self._adopt(accepted, stamp, None if wait else action)
        except Refused as refusal:
            self._end_next("refused", str(refusal))

    def _action_of(self, command: Command, ctx: ControlContext) -> Action:
        kind = spec_of(command.name)
        if self._dry and kind.target == "person":
            return DryRun(command, ctx)
        return kind.begin(command, ctx)

    def take_endings(self) -> tuple[ActiveCommandStatus, ...]:
        """Return the commands that ended since the last call: every one exactly once."""
        endings, self._endings = tuple(self._endings), []
        return endings


def _active_command(accepted: AcceptedCommand, stamp: float) -> ActiveCommandStatus:
    return ActiveCommandStatus(
        id=accepted.id,
        name=accepted.command.name,
        numbers=dict(accepted.command.numbers),
        heard_as=accepted.command.heard_as,
        source=accepted.source,
        who=accepted.who,
        stamp=stamp,
    )


def _came_after(accepted: AcceptedCommand) -> str:
    return Statement("command.pre_empted", words=accepted.command.heard_as)
