"""COME HERE: the robot moves towards the sound source and stops half a metre from it (Table 2)."""

import math
from dataclasses import dataclass

import numpy as np

from core.commands.command import Action, Command, CommandSpec, Progress, Target
from core.commands.keep_to_person import KeepToPerson, aim_at, following_words, going
from core.commands.turn_to_voice import TurnToVoice, call_for, heard_for
from core.errors import Refused
from core.message import Array
from core.navigation.control_context import ControlContext
from core.navigation.goal_controller import GoalAim, GoalController
from core.perception.people.fusion import Fused, fuse
from core.perception.people.legs import find_standers, nearest_to
from core.perception.people.tracked_person import TrackedPerson
from core.perception.people.voice_bearing import VoiceBearing
from core.perception.sound.triangulation import VoicePlace, cross
from core.sentences import Statement

# COME HERE without a camera: a voice is heard from several places, and a person stands where the bearings cross.

ASIDE_ANGLES_RAD = (0.9, -0.9, 1.3, -1.3, 0.5, -0.5)  # off the voice's direction, to hear it from elsewhere
MIN_BASELINE_M = 0.15  # between two places from which a voice counts as heard from a new place
AGAIN = Statement("come.say_again_here")
LEGS_GATE_CHI2 = 11.8  # chi-square, 2 degrees of freedom
MAX_CROSSING_SD_M = 0.5  # sd of a crossing that is gone to
LEGS_SD_M = 0.3  # sd that is added to a crossing around which legs are searched


class LocateVoice:
    """Steps aside, listens, and goes to the crossing; every word on the way makes it surer."""

    def __init__(self, call: VoiceBearing, ctx: ControlContext) -> None:
        """Raises Refused when there is no room to step aside."""
        self._calls = [call]
        self._place = VoicePlace(position=None, covariance=None)
        self._waits = ctx.stamp + ctx.company.listen_for
        self._aside = self._step_aside(ctx)
        self._approach: GoalController | None = None
        self._person: TrackedPerson | None = None

    def drive(self, ctx: ControlContext) -> Progress:
        """Take one frame."""
        self._listen(ctx)
        if self._person is None:
            return self._wait(ctx)
        aim = aim_at(self._person, ctx.company.stop_short)
        if self._approach is None:
            self._approach = GoalController(aim, ctx, cruise=ctx.company.coming)
        step = self._approach.drive(ctx, aim)
        if step.state == "there":
            remark = Statement("come.here_i_am_heard", apart=f"{ctx.pose.distance_to(aim.x, aim.y):.2f}")
            return Progress(finished="done", remark=remark, fraction=1.0, person=self._person)
        return going(step, self._person, Statement("come.bearings_cross", count=len(self._place.used)))

    def _wait(self, ctx: ControlContext) -> Progress:
        step = self._aside.drive(ctx)
        if step.state == "under way" and step.twist.moves:
            self._waits = ctx.stamp + ctx.company.listen_for
        if ctx.stamp > self._waits or step.state == "stuck":
            return Progress(finished="failed", remark=self._place.reason or step.words or AGAIN)
        return Progress(twist=step.twist, remark=AGAIN, path=step.path, goal=step.stand)

    def _listen(self, ctx: ControlContext) -> None:
        """Cross the bearing of a voice heard from a new place with the others."""
        call = ctx.call
        if call is None or call.stamp <= self._calls[-1].stamp or call.sd > ctx.company.sure:
            return
        last = self._calls[-1]
        if math.hypot(call.x - last.x, call.y - last.y) < MIN_BASELINE_M:
            self._calls[-1] = call if call.sd < last.sd else last
        else:
            self._calls.append(call)
        place = cross([one.ray for one in self._calls])
        self._place = place
        if place.position is not None and place.covariance is not None:
            widest = math.sqrt(float(np.linalg.eigvalsh(place.covariance)[-1]))
            if widest < MAX_CROSSING_SD_M:
                self._person = self._stands(place.position, place.covariance, ctx)

    def _stands(self, position: Array, covariance: Array, ctx: ControlContext) -> TrackedPerson:
        """Return the person where the bearings cross, at the legs that stand there if any do."""
        c, s = math.cos(ctx.pose.heading), math.sin(ctx.pose.heading)
        turn = np.array([[c, -s], [s, c]])
        local = ctx.pose.inverse().apply(position[None])[0]
        spread = turn.T @ covariance @ turn + LEGS_SD_M**2 * np.eye(2)
        legs = nearest_to(find_standers(ctx.scan_points), local, spread, LEGS_GATE_CHI2)
        sound = self._calls[-1].ray
        fused = Fused(position=position, covariance=covariance, used=("sound",))
        laser = None
        if legs is not None:
            laser = ctx.pose.apply(legs.place[None])[0]
            fused = fuse((laser, turn @ legs.covariance @ turn.T), (("sound", sound),))
        return TrackedPerson(
            stamp=ctx.stamp,
            position=fused.position,
            covariance=fused.covariance,
            velocity=np.zeros(2),
            laser=laser,
            sound=sound,
            used=fused.used,
        )

    def _step_aside(self, ctx: ControlContext) -> GoalController:
        """Plan to the first reachable place aside of the way to the voice. Raises Refused when there is none."""
        for angle in ASIDE_ANGLES_RAD:
            away = self._calls[0].azimuth + angle
            x = ctx.pose.x + ctx.company.sidestep * math.cos(away)
            y = ctx.pose.y + ctx.company.sidestep * math.sin(away)
            try:
                return GoalController(GoalAim(x=x, y=y, heading=self._calls[0].azimuth), ctx)
            except Refused:
                continue
        raise Refused(Statement("come.no_room_aside"))


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
