"""COME HERE: the robot moves towards the sound source and stops half a metre from it (Table 2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from core.commands.command import Action, Command, Number, Progress
from core.commands.locating import Locating
from core.commands.seeking import Seeking, blind, call_for
from core.navigation.approach import Aim, Approach
from core.navigation.surroundings import Surroundings
from core.perception.people.person import PersonSeen

MISSED = 3.0  # [s] without a sight of somebody, after which the robot says so when it has come


@dataclass(frozen=True)
class ComeHere:
    """To who called."""

    name: str = "come_here"
    words: tuple[str, ...] = ("come here", "come")
    numbers: tuple[Number, ...] = ()
    example: str = "come here"
    summary: str = "Turns to the voice, looks who spoke, comes and stops half a metre before them."
    moves: bool = True

    def begin(self, command: Command, here: Surroundings) -> Action:
        """Turn to who spoke. Raises Refused with a sentence without a fresh, sure direction."""
        call = call_for(command, here)
        return Coming(Seeking(call, here)) if here.company.mode == "person" else Locating(call, here)


class Coming:
    """On the way to somebody who was seen."""

    def __init__(self, seeking: Seeking) -> None:
        self._seeking: Seeking | None = seeking
        self._track = seeking.track
        self._approach: Approach | None = None
        self._whole = 1.0

    def drive(self, here: Surroundings) -> Progress:
        """One frame further."""
        if self._seeking is not None:
            told = self._seeking.look(here)
            if not isinstance(told, PersonSeen):
                return told
            self._seeking = None
            self._approach = Approach(_aim(told, here), here, cruise=here.company.coming)
            self._whole = max(here.pose.distance_to(*told.position.tolist()) - here.company.stop_short, 0.05)
        assert self._approach is not None
        self._track.follow(here.stamp, here.pose, here.scan_points, here.image, here.camera)
        if why := blind(self._track, here):
            return Progress(finished="failed", remark=why)
        person = self._track.person
        assert person is not None
        step = self._approach.drive(here, _aim(person, here))
        x, y = person.position.tolist()
        apart = here.pose.distance_to(x, y)
        fraction = float(np.clip(1 - (apart - here.company.stop_short) / self._whole, 0.0, 1.0))
        if step.state == "there":
            if here.stamp - self._track.measured > MISSED:
                return Progress(finished="failed", remark="I came to where you stood, but I see you there no more.")
            return Progress(
                finished="done", remark=f"Here I am, {apart:.2f} m from you.", fraction=1.0, person=person
            )
        return Progress(
            twist=step.twist,
            finished="failed" if step.state == "stuck" else "",
            remark=step.words or ("I come." if person.state == "seen" else "I come to where I saw you last."),
            fraction=fraction,
            path=step.path,
            goal=step.stand,
            person=person,
        )


def _aim(person: PersonSeen, here: Surroundings) -> Aim:
    x, y = person.position.tolist()
    return Aim(x=x, y=y, keep=here.company.stop_short)


COME_HERE = ComeHere()
