"""Keeping to somebody: what COME HERE and FOLLOW ME do alike once the robot has turned to a voice."""

from __future__ import annotations

from core.commands.command import Progress
from core.commands.seeking import Seeking
from core.navigation.approach import Advance, Aim
from core.navigation.surroundings import Surroundings
from core.perception.people.person import PersonSeen

WAITING = 0.5  # [s] without a picture, after which the robot stands …
BLIND = 1.0  # [s] … and after which nobody is followed any more


class Attending:
    """Looks who called, then where they are, frame by frame."""

    def __init__(self, seeking: Seeking) -> None:
        self.track = seeking.track
        self._seeking: Seeking | None = seeking

    def watch(self, here: Surroundings) -> PersonSeen | Progress:
        """One frame further: who called, or what to do until they are found. Raises Refused when nobody is there."""
        if self._seeking is not None:
            told = self._seeking.look(here)
            if isinstance(told, Progress):
                return told
            self._seeking = None
        self.track.follow(here.stamp, here.pose, here.scan_points, here.image, here.camera)
        person, silent = self.track.person, here.stamp - self.track.looked
        if person is None or silent > BLIND:
            return Progress(finished="failed", remark="No picture comes from the camera any more; I stay here.")
        if silent > WAITING:
            return Progress(remark="No picture comes from the camera; I wait.", person=person)
        return person


def aim_at(person: PersonSeen, keep: float) -> Aim:
    """A place `keep` [m] before somebody."""
    x, y = person.position.tolist()
    return Aim(x=x, y=y, keep=keep)


def going(step: Advance, person: PersonSeen, words: str, fraction: float | None = None) -> Progress:
    """What the way to somebody gives; `words` where it has none of its own."""
    return Progress(
        twist=step.twist,
        finished="failed" if step.state == "stuck" else "",
        remark=step.words or words,
        fraction=fraction,
        path=step.path,
        goal=step.stand,
        person=person,
    )
