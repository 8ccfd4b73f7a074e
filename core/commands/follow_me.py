"""FOLLOW ME: the robot turns to the sound source and tracks the human who is seen there (Table 2)."""

from __future__ import annotations

from dataclasses import dataclass

from core.commands.command import Action, Command, Number, Progress
from core.commands.seeking import Seeking, blind, call_for
from core.navigation.approach import Aim, Approach
from core.navigation.surroundings import Surroundings
from core.perception.people.person import PersonSeen


@dataclass(frozen=True)
class FollowMe:
    """After who called, until another command."""

    name: str = "follow_me"
    words: tuple[str, ...] = ("follow me",)
    numbers: tuple[Number, ...] = ()
    example: str = "follow me"
    summary: str = "Turns to the voice and follows who spoke, a metre behind, until another command."
    moves: bool = True

    def begin(self, command: Command, here: Surroundings) -> Action:
        """Turn to who spoke. Raises Refused with a sentence without a fresh, sure direction."""
        return Following(Seeking(call_for(command, here), here))


class Following:
    """After somebody."""

    def __init__(self, seeking: Seeking) -> None:
        self._seeking: Seeking | None = seeking
        self._track = seeking.track
        self._approach: Approach | None = None

    def drive(self, here: Surroundings) -> Progress:
        """One frame further."""
        if self._seeking is not None:
            told = self._seeking.look(here)
            if not isinstance(told, PersonSeen):
                return told
            self._seeking = None
            cruise = min(here.company.following, here.body.max_speed)
            self._approach = Approach(_aim(told, here), here, lasting=True, cruise=cruise)
        assert self._approach is not None
        self._track.follow(here.stamp, here.pose, here.scan_points, here.image, here.camera)
        if why := blind(self._track, here):
            return Progress(finished="failed", remark=why)
        person = self._track.person
        assert person is not None
        if self._track.lost(here.stamp):
            return Progress(finished="failed", remark="I lost you. I stay here; call me again.")
        step = self._approach.drive(here, _aim(person, here))
        return Progress(
            twist=step.twist,
            finished="failed" if step.state == "stuck" else "",
            remark=step.words or ("I follow you." if person.state == "seen" else "You are hidden; I wait for you."),
            path=step.path,
            goal=step.stand,
            person=person,
        )


def _aim(person: PersonSeen, here: Surroundings) -> Aim:
    x, y = person.position.tolist()
    return Aim(x=x, y=y, keep=here.company.keep)


FOLLOW_ME = FollowMe()
