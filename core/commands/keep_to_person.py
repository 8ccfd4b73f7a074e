"""Keep to a person: the part that COME HERE and FOLLOW ME share once the robot has turned to a voice."""

import numpy as np

from core.commands.command import Progress
from core.commands.turn_to_voice import TurnToVoice
from core.navigation.control_context import ControlContext
from core.navigation.goal_controller import GoalAim, GoalStep
from core.perception.people.tracked_person import TrackedPerson
from core.perception.people.tracking import PersonTrack
from core.sentences import Statement

MAX_PICTURE_GAP_S = 0.5  # without a picture, after which the robot stands
MAX_BLIND_S = 1.0  # without a picture, after which nobody is followed any more
MAX_RECTANGLE_AGE_S = 1.5  # for which a picture that showed more than legs counts
PASSING_BERTH_M = 0.35  # from the body to the middle of who walks by, within which the robot stands
ONLY_LEGS = Statement("come.only_legs")


class KeepToPerson:
    """Finds the person who called, then tracks them frame by frame."""

    def __init__(self, seeking: TurnToVoice, *, stands: bool = False) -> None:
        """`stands`: the caller waits where they called from, so that what is seen on the way may still tell who."""
        self._seeking, self._stands = seeking, stands
        self._track: PersonTrack | None = None

    @property
    def track(self) -> PersonTrack:
        """The person's track, once they were found."""
        assert self._track is not None
        return self._track

    def watch(self, ctx: ControlContext) -> TrackedPerson | Progress:
        """Take one frame → the person, or what to do until they are found. Raises Refused when nobody is there."""
        if self._track is None:
            found = self._seeking.look(ctx)
            if isinstance(found, Progress):
                return found
            self._track = found
        elif self._stands:
            self._track = self._seeking.decide_again(self._track, ctx)
        self.track.follow(ctx.stamp, ctx.pose, ctx.scan_points, ctx.scan_stamp, ctx.image, ctx.camera)
        person, silent = self.track.person, ctx.stamp - self.track.looked
        if person is None or silent > MAX_BLIND_S:
            return Progress(finished="failed", remark=Statement("come.no_picture_stay"))
        if silent > MAX_PICTURE_GAP_S:
            return Progress(remark=Statement("come.no_picture_wait"), person=person)
        own = np.array([ctx.pose.x, ctx.pose.y])
        if self.track.passed_by(own, ctx.stamp, ctx.body.radius + PASSING_BERTH_M):
            return Progress(remark=Statement("come.passed_by"), person=person)
        return person


def following_words(keeping: KeepToPerson, person: TrackedPerson, seen: str, hidden: str) -> str:
    """Return the remark about a person who is kept to: how they are known now."""
    if person.state != "seen":
        return hidden
    pictured = person.stamp - person.rectangle_stamp < MAX_RECTANGLE_AGE_S
    return f"{seen} {ONLY_LEGS}" if keeping.track.only_legs and "laser" in person.used and not pictured else seen


def aim_at(person: TrackedPerson, keep: float) -> GoalAim:
    """Return an aim `keep` [m] in front of a person."""
    x, y = person.position.tolist()
    return GoalAim(x=x, y=y, keep=keep)


def going(step: GoalStep, person: TrackedPerson, words: str, fraction: float | None = None) -> Progress:
    """Return the progress of a step towards a person; `words` is the remark where the step has none."""
    return Progress(
        twist=step.twist,
        finished="failed" if step.state == "stuck" else "",
        remark=step.words or words,
        fraction=fraction,
        path=step.path,
        goal=step.stand,
        person=person,
    )
