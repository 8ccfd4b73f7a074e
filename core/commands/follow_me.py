"""FOLLOW ME: the robot turns to the sound source and tracks the human who is seen there (Table 2)."""

from __future__ import annotations

from dataclasses import dataclass

from core.commands.attending import Attending, aim_at, going
from core.commands.command import Action, Command, Number, Progress
from core.commands.seeking import Seeking, call_for
from core.navigation.approach import Approach
from core.navigation.surroundings import Surroundings


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
        self._attending = Attending(seeking)
        self._approach: Approach | None = None

    def drive(self, here: Surroundings) -> Progress:
        """One frame further."""
        person = self._attending.watch(here)
        if isinstance(person, Progress):
            return person
        if self._attending.track.lost(here.stamp):
            return Progress(finished="failed", remark="I lost you. I stay here; call me again.")
        aim = aim_at(person, here.company.keep)
        if self._approach is None:
            cruise = min(here.company.following, here.body.max_speed)
            self._approach = Approach(aim, here, lasting=True, cruise=cruise)
        step = self._approach.drive(here, aim)
        return going(step, person, "I follow you." if person.state == "seen" else "You are hidden; I wait for you.")


FOLLOW_ME = FollowMe()
