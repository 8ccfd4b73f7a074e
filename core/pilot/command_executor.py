"""Execution of commands: the active command, its progress and its end (Fig. 6: the last command wins).

The dry run of COME HERE and FOLLOW ME says what a robot would do, where a camera looks and nothing can drive.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from core.commands import spec_of
from core.commands.command import Action, Command, Progress
from core.errors import Refused
from core.gate import ZERO, Twist
from core.geometry import Pose, wrap
from core.message import Array
from core.navigation.control_context import ControlContext
from core.perception.people.appearance import alike
from core.perception.people.camera_geometry import eye, ray_of
from core.perception.people.detector import Rectangle
from core.perception.people.fusion import Ray, Sense, along, fuse
from core.perception.people.looking import LookQuestion
from core.perception.people.pose.view import Viewpoint
from core.perception.people.tracked_person import TrackedPerson
from core.perception.people.voice_bearing import VoiceBearing, from_side
from core.sentences import Statement
from core.snapshot import ActiveCommandStatus, Ending

QUESTION_PERIOD_S = 0.18  # between two questions: five a second are enough
MAX_ANSWER_S = 2.0  # after which an answer is expected no more
MAX_HIDDEN_S = 1.0  # without a sight after which the person is hidden …
FORGET_PERSON_S = 3.0  # … and after which anybody who calls is looked for again
LOOK_FOR = 15.0  # [s] until it gives up
MAX_START_S = 60.0  # that a worker with networks may take to start
SHOW_FOUND_S = 15.0  # for which COME HERE shows whom it found
NEAR_SD = 0.1  # [rad] within which someone who was found is looked for again
DISTANCE_SD = 0.15  # share of a distance that only the picture gives


class DryRun:
    """Looks for who called, or for anybody where no direction is known, and says what a robot would do."""

    def __init__(self, command: Command, ctx: ControlContext) -> None:
        """Raises Refused where nothing here sees people."""
        if ctx.camera is None:
            raise Refused("Dry run: there is no camera here to see who spoke.")
        if ctx.look is None:
            raise Refused(
                "Dry run: what looks for people here knows drawn figures only. Get the pose networks first: "
                "beckon models get people."
            )
        self._command = command
        self._began = ctx.stamp
        self._asked: tuple[float, Pose, VoiceBearing | None] | None = None  # the question that waits for its answer
        self._asked_last = -math.inf  # [s]
        self._found_first: float | None = None  # [s]
        self._person: TrackedPerson | None = None
        self._strangers = False
        self._answered = False  # what looks for people has started

    def drive(self, ctx: ControlContext) -> Progress:
        """Take one frame; the twist is always zero."""
        call = self._call(ctx)
        self._take(ctx)
        self._ask(ctx, call)
        person = self._person
        if person is None or ctx.stamp - person.stamp > FORGET_PERSON_S:
            self._person = None
            return self._nobody(ctx, call)
        if ctx.stamp - person.stamp > MAX_HIDDEN_S:
            hidden = replace(person, laser=None, camera=None, used=(), state="hidden")
            return Progress(remark="Dry run: you are hidden; I would wait for you.", person=hidden)
        return self._person_seen(ctx, person)

    def _call(self, ctx: ControlContext) -> VoiceBearing | None:
        call = ctx.call or self._command.call
        known = call is not None and ctx.stamp - call.stamp <= ctx.company.fresh and call.sd <= ctx.company.sure
        return call if known else None

    def _ask(self, ctx: ControlContext, call: VoiceBearing | None) -> None:
        """Ask for the person where they were, else where the voice is, else anywhere."""
        waits = self._asked is not None and ctx.stamp - self._asked_last < MAX_ANSWER_S
        if ctx.image is None or ctx.camera is None or ctx.look is None or waits:
            return
        if ctx.stamp - self._asked_last < QUESTION_PERIOD_S:
            return
        bearing, sd = _towards(ctx, self._person, call)
        question = LookQuestion(
            pixels=ctx.image.pixels, camera=ctx.camera, stamp=ctx.stamp, bearing=bearing, sd=sd, on_floor=False
        )
        self._asked, self._asked_last = (ctx.stamp, ctx.pose, call), ctx.stamp
        ctx.look.ask(question)

    def _take(self, ctx: ControlContext) -> None:
        answer = None if ctx.look is None else ctx.look.answer()
        if answer is None or self._asked is None or ctx.camera is None or answer.stamp != self._asked[0]:
            return
        stamp, pose, call = self._asked
        self._asked, self._answered = None, True
        own = [one for one in answer.found if _is_who(one, ctx)]
        self._strangers = bool(answer.found) and not own
        if own:
            sound = call.ray if call is not None else None
            self._person = _person(own[0], stamp, pose, eye(pose, ctx.camera), sound)
            self._found_first = ctx.stamp if self._found_first is None else self._found_first

    def _nobody(self, ctx: ControlContext, call: VoiceBearing | None) -> Progress:
        """Go on looking, or give up. Raises Refused."""
        heard = "" if call is None else f"I heard you {from_side(call.side(ctx.pose.heading))}"
        if call is not None and not _in_view(ctx, call):
            would = _would(wrap(call.azimuth - ctx.pose.heading), 0.0)
            return Progress(remark=f"Dry run: {heard}; I would {would} and look who spoke.")
        patience = LOOK_FOR if self._answered else MAX_START_S
        if ctx.stamp - self._began > patience and self._found_first is None:
            raise Refused(f"Dry run: {self._missed(ctx, heard)}")
        looks = f"{heard} and look who spoke" if heard else "I know of no direction and look for anybody"
        return Progress(remark=f"Dry run: {looks}.")

    def _missed(self, ctx: ControlContext, heard: str) -> str:
        if not self._answered:
            return "what looks for people has not started yet; the computer is busy. Try again."
        if self._strangers and ctx.who is not None:
            return f"I see someone, but not {ctx.who.name}."
        return f"{heard} but see nobody there." if heard else "I see nobody."

    def _person_seen(self, ctx: ControlContext, person: TrackedPerson) -> Progress:
        x, y = person.position.tolist()
        apart, angle = ctx.pose.distance_to(x, y), wrap(ctx.pose.bearing_to(x, y))
        follows = self._command.name == "follow_me"
        keep = ctx.company.keep if follows else ctx.company.stop_short
        way = max(0.0, apart - keep)
        towards = ctx.pose.heading + angle
        stand = np.array([ctx.pose.x + way * math.cos(towards), ctx.pose.y + way * math.sin(towards)])
        words = f"Dry run: I see you {apart:.1f} m away; I would {_would(angle, way)}."
        over = not follows and self._found_first is not None and ctx.stamp - self._found_first > SHOW_FOUND_S
        return Progress(
            finished="done" if over else "",
            remark=words,
            path=np.array([(ctx.pose.x, ctx.pose.y), stand]),
            goal=stand,
            person=person,
        )


def _towards(
    ctx: ControlContext, person: TrackedPerson | None, call: VoiceBearing | None
) -> tuple[float | None, float]:
    """Return the direction in which to look: the bearing [rad, robot frame] and its sd; None: anywhere."""
    if person is not None and person.camera is not None:
        return wrap(person.camera.azimuth - ctx.pose.heading), NEAR_SD
    if call is not None:
        return wrap(call.azimuth - ctx.pose.heading), math.hypot(call.sd, 0.02)
    return None, NEAR_SD


def _in_view(ctx: ControlContext, call: VoiceBearing) -> bool:
    """Return whether the camera looks to where the voice is."""
    if ctx.camera is None:
        return False
    column = Viewpoint(ctx.camera).column(wrap(call.azimuth - ctx.pose.heading))
    return 0 <= column < ctx.camera.model.width


def _is_who(rectangle: Rectangle, ctx: ControlContext) -> bool:
    """Return whether this may be the only person to come to."""
    if ctx.who is None or rectangle.looks is None:
        return ctx.who is None
    return alike(ctx.who.looks, rectangle.looks) >= ctx.people.alike


def _person(rectangle: Rectangle, stamp: float, pose: Pose, camera: Pose, sound: Ray | None) -> TrackedPerson:
    """A rectangle and a voice → the person: the camera's bearing, its distance by the torso's length, the sound."""
    ray = ray_of(rectangle, camera, pose)
    start = along(ray, rectangle.distance, DISTANCE_SD * rectangle.distance)
    rays: tuple[tuple[Sense, Ray], ...] = () if sound is None else (("sound", sound),)
    fused = fuse(start, rays, "camera")
    return TrackedPerson(
        stamp=stamp,
        position=fused.position,
        covariance=fused.covariance,
        velocity=np.zeros(2),
        rectangle=rectangle,
        rectangle_stamp=stamp,
        camera=ray,
        sound=sound,
        used=fused.used,
    )


def _would(angle: float, way: float) -> str:
    """Describe in words what a robot would do about an angle [rad] and a way [m]."""
    degrees = round(math.degrees(angle))
    turn = f"turn {abs(degrees)}° {'left' if degrees > 0 else 'right'}" if abs(degrees) >= 3 else ""
    come = f"come {way:.1f} m nearer" if way >= 0.05 else ""
    return " and ".join(part for part in (turn, come) if part) or "stay"


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
        """Make this the active command, in place of the other."""
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
        """Begin a command. Raises Refused."""
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
