"""Find who called: turn to the voices that were heard with the words and look for people there.

The start of COME HERE and FOLLOW ME. A room sends a voice back from its walls, and someone else may have spoken, so
that more than one direction may be heard. The robot looks in all that may be the caller's; the coordinates of all
senses from all its poses then decide.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from core.commands.command import Command, Progress
from core.errors import Refused
from core.gate import Twist
from core.geometry import wrap
from core.navigation.control_context import ControlContext
from core.navigation.obstacle import why_no_headway
from core.navigation.steering import Arrival, StallDetector, spin
from core.perception.people.consensus import GatheredCoordinates
from core.perception.people.tracking import PersonTrack
from core.perception.people.voice_bearing import VoiceBearing, from_side, likeliest
from core.sentences import Statement

HEADING_TOLERANCE_RAD = 0.06  # within which the robot looks at the voice
BY_CHANCE = 0.2  # [rad] within which it need not turn
SETTLING_S = 0.15  # at rest before pictures count
RIVAL_STRENGTH_SHARE = 0.4  # of a voice's strength, from which another one may be the caller's as well
MIN_LOOKS = 3  # pictures that have to be judged before nobody is there
MAX_WAITS = 5.0  # times the time of a search that they may take on a slow computer
MOST_VOICES = 4  # that are looked at


def call_for(command: Command, here: ControlContext) -> VoiceBearing:
    """Return the voice bearing of the person who gave a command. Raises Refused when it is unknown, old or vague."""
    if here.misheard:
        raise Refused(f"I heard you, but cannot tell from where. {here.misheard}")
    call, company = command.call or here.call, here.company
    if call is None:
        raise Refused(Statement("come.heard_nobody"))
    age = here.stamp - call.stamp
    if age > (company.spoken_fresh if command.call is not None else company.fresh):
        raise Refused(Statement("come.heard_long_ago", age=f"{age:.0f}"))
    if call.sd > company.sure:
        degrees = math.degrees(call.sd)
        raise Refused(Statement("come.heard_vaguely", degrees=f"{degrees:.0f}"))
    return call


def heard_for(command: Command, here: ControlContext) -> tuple[VoiceBearing, ...]:
    """Return the bearings of all voices that were heard in a command's words. Raises Refused as `call_for` does."""
    call = call_for(command, here)
    return command.others or (call,)


class TurnToVoice:
    """Turns to every voice in turn and looks for a person there, until it is known who called."""

    def __init__(self, heard: Sequence[VoiceBearing], here: ControlContext) -> None:
        """`heard`: bearings in the words of the command. Raises Refused on a robot without a camera."""
        if here.camera is None:
            raise Refused(Statement("come.no_camera"))
        self._calls = likeliest(heard)[:MOST_VOICES]
        self._who = here.who.name if here.who is not None else ""
        self._side = self._calls[0].side(here.pose.heading)
        self._looked = 0
        self._coordinates = GatheredCoordinates(heard)
        self._found: list[PersonTrack] = []
        self._strangers = False
        self._best = 0.0  # strength of the strongest voice where someone was found
        self._next(0, here)

    def _next(self, number: int, here: ControlContext) -> None:
        """Look at that voice from now on."""
        self._number, self.call = number, self._calls[number]
        self._track = PersonTrack(here.people, here.tracking, here.who, here.look)
        self._facing = abs(self._error(here)) < BY_CHANCE
        self._arrival = Arrival(HEADING_TOLERANCE_RAD, here.steering)
        self._headway = StallDetector(0.05, here.steering.stalled_after)
        self._since = here.stamp

    def look(self, here: ControlContext) -> PersonTrack | Progress:
        """Take one frame → who called, or what to do until they are found. Raises Refused when nobody is there."""
        if self._coordinates.is_new(here.pose):
            self._coordinates.add_legs(here.stamp, here.pose, here.scan_points)
        self._keep_to(self._found, here)
        if not self._facing:
            return self._turn(here)
        if here.camera is not None and here.stamp - self._since > SETTLING_S:
            self._looked += here.image is not None
            self._track.begin(self.call, here.stamp, here.pose, here.scan_points, here.image, here.camera)
            if self._looked and not self._judged and self._lasted(here) > here.company.look_for:
                self._track.begin_by_legs(self.call, here.stamp, here.pose, here.scan_points, here.camera)
        person = self._track.person
        if person is not None:
            self._found.append(self._track)
            self._coordinates.add_person(person)
            self._best = max(self._best, self.call.strength)
        elif self._is_looking(here):
            return Progress(remark=Statement("come.look_who_spoke"))
        self._strangers |= self._track.strangers
        following = self._following()
        if following is not None:
            self._next(following, here)
            return Progress(remark=Statement("come.voice_elsewhere"))
        return self._chosen(here)

    def _is_looking(self, here: ControlContext) -> bool:
        """Return whether the search goes on: for its time, on a slow computer until enough pictures were judged."""
        waits = MAX_WAITS if self._looked and not self._judged else 1.0
        return self._lasted(here) <= waits * here.company.look_for

    @property
    def _judged(self) -> bool:
        """True when enough pictures were judged to tell that nobody is there."""
        return self._track.judged >= MIN_LOOKS

    def _lasted(self, here: ControlContext) -> float:
        """Return for how long [s] the robot has looked at the voice."""
        return here.stamp - self._since - SETTLING_S

    def _following(self) -> int | None:
        """The next voice that has to be looked at; None: there is none."""
        for number in range(self._number + 1, len(self._calls)):
            if self._calls[number].strength >= RIVAL_STRENGTH_SHARE * self._best:
                return number
        return None

    def decide_again(self, track: PersonTrack, here: ControlContext) -> PersonTrack:
        """Choose the caller among the people who stand where they were found, by the sights from here, too; `track`:
        the person whom the robot keeps to.
        """
        if len(self._found) < 2:
            return track
        self._keep_to([one for one in self._found if one is not track], here)
        if not self._coordinates.is_new(here.pose):
            return track
        self._coordinates.add_legs(here.stamp, here.pose, here.scan_points)
        if track.person is not None:
            self._coordinates.add_person(track.person)
        chosen = self._agreed_on(track, here)
        if chosen is not track:
            self._found = [chosen]  # it changes its mind once
        return chosen

    def _keep_to(self, tracks: Sequence[PersonTrack], here: ControlContext) -> None:
        """Follow people by the laser alone: the pictures are of someone else."""
        for one in tracks:
            one.follow(here.stamp, here.pose, here.scan_points, here.scan_stamp, None, None)

    def _chosen(self, here: ControlContext) -> PersonTrack:
        """Choose the caller among the people who were found. Raises Refused when nobody was."""
        if not self._found:
            raise Refused(self._nobody())
        return self._found[0] if len(self._found) == 1 else self._agreed_on(self._found[0], here)

    def _agreed_on(self, otherwise: PersonTrack, here: ControlContext) -> PersonTrack:
        """Of those who were found the one on whom most coordinates agree."""
        agreed = self._coordinates.agreed()
        if agreed is None:
            return otherwise
        place = agreed.position
        chosen = min(self._found, key=lambda one: one.apart_from(place))
        chosen.looked = max(chosen.looked, here.stamp)
        return chosen

    def _nobody(self) -> str:
        if not self._looked:
            return Statement("come.heard_no_picture")
        where = from_side(self._side)
        if not self._who:
            return Statement("come.heard_saw_nobody", where=where)
        if self._strangers:
            return Statement("come.heard_saw_other", where=where, who=self._who)
        return Statement("come.heard_saw_not", where=where, who=self._who)

    def _turn(self, here: ControlContext) -> Progress:
        """Turn on the spot towards the voice; a person who speaks meanwhile is heard better."""
        error = self._error(here)
        soon = error - here.turn_rate * here.steering.turn_lead
        if self._arrival.reached(min(abs(soon), abs(error)), here.stamp) and abs(here.turn_rate) < 0.05:
            self._facing, self._since = True, here.stamp
            return Progress(remark=Statement("come.look_who_spoke"))
        if self._headway.lost(abs(error), here.stamp):
            return Progress(finished="failed", remark=why_no_headway(here.scan_points, here.body.radius))
        return Progress(
            twist=Twist(0.0, spin(soon, here.body.turn, here.steering)), remark=Statement("come.turn_to_voice")
        )

    def _error(self, here: ControlContext) -> float:
        """Return the angle from the robot's heading to the voice [rad]."""
        return wrap(self.call.azimuth - here.pose.heading)
