"""COME HERE without a camera: a voice is heard from several places, and a person stands where the bearings cross."""

from __future__ import annotations

import math

import numpy as np

from core.commands.command import Progress
from core.commands.keep_to_person import aim_at, going
from core.errors import Refused
from core.message import Array
from core.navigation.control_context import ControlContext
from core.navigation.goal_controller import GoalAim, GoalController
from core.perception.people.fusion import Fused, fuse
from core.perception.people.legs import find_standers, nearest_to
from core.perception.people.tracked_person import TrackedPerson
from core.perception.people.voice_bearing import VoiceBearing
from core.perception.sound.triangulation import Bearing, VoicePlace, cross
from core.sentences import Statement

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
            apart = ctx.pose.distance_to(aim.x, aim.y)
            remark = Statement("come.here_i_am_heard", apart=f"{apart:.2f}")
            return Progress(finished="done", remark=remark, fraction=1.0, person=self._person)
        return going(step, self._person, Statement("come.bearings_cross", count=len(self._place.used)))

    def _wait(self, ctx: ControlContext) -> Progress:
        """Step aside and wait until the voice is heard from there."""
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
        place = cross([Bearing(x=one.x, y=one.y, azimuth=one.azimuth, sd=one.sd) for one in self._calls])
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
