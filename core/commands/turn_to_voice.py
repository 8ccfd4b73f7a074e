"""Find who called: turn to the voices that were heard with the words and look for people there.

The start of COME HERE and FOLLOW ME. A room sends a voice back from its walls, and someone else may have spoken, so
that more than one direction may be heard. The robot looks in all that may be the caller's; the coordinates of all
senses from all its poses then decide.
"""

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
CHANCE_TURN_RAD = 0.2  # within which it need not turn
SETTLING_S = 0.15  # at rest before pictures count
RIVAL_STRENGTH_SHARE = 0.4  # of a voice's strength, from which another one may be the caller's as well
MIN_LOOKS = 3  # pictures that have to be judged before nobody is there
MAX_WAITS = 5.0  # times the time of a search that they may take on a slow computer
MOST_VOICES = 4  # that are looked at


def call_for(command: Command, ctx: ControlContext) -> VoiceBearing:
    """Return the voice bearing of the person who gave a command. Raises Refused when it is unknown, old or vague."""
    if ctx.misheard:
        raise Refused(f"I heard you, but cannot tell from where. {ctx.misheard}")
    call, company = command.call or ctx.call, ctx.company
    if call is None:
        raise Refused(Statement("come.heard_nobody"))
    age = ctx.stamp - call.stamp
    if age > (company.spoken_fresh if command.call is not None else company.fresh):
        raise Refused(Statement("come.heard_long_ago", age=f"{age:.0f}"))
    if call.sd > company.sure:
        degrees = math.degrees(call.sd)
        raise Refused(Statement("come.heard_vaguely", degrees=f"{degrees:.0f}"))
    return call


def heard_for(command: Command, ctx: ControlContext) -> tuple[VoiceBearing, ...]:
    """Return the bearings of all voices that were heard in a command's words. Raises Refused as `call_for` does."""
    call = call_for(command, ctx)
    return command.others or (call,)


class TurnToVoice:
    """Turns to every voice in turn and looks for a person there, until it is known who called."""

    def __init__(self, heard: Sequence[VoiceBearing], ctx: ControlContext) -> None:
        """`heard`: bearings in the words of the command. Raises Refused on a robot without a camera."""
        if ctx.camera is None:
            raise Refused(Statement("come.no_camera"))
        self._calls = likeliest(heard)[:MOST_VOICES]
        self._who = ctx.who.name if ctx.who is not None else ""
        self._side = self._calls[0].side(ctx.pose.heading)
        self._looked = 0
        self._coordinates = GatheredCoordinates(heard)
        self._found: list[PersonTrack] = []
        self._strangers = False
        self._best = 0.0  # strength of the strongest voice where someone was found
        self._next(0, ctx)

    def _next(self, number: int, ctx: ControlContext) -> None:
        self._number, self.call = number, self._calls[number]
        self._track = PersonTrack(ctx.people, ctx.tracking, ctx.who, ctx.look)
        self._facing = abs(self._error(ctx)) < CHANCE_TURN_RAD
        self._arrival = Arrival(HEADING_TOLERANCE_RAD, ctx.steering)
        self._headway = StallDetector(0.05, ctx.steering.stalled_after)
        self._since = ctx.stamp

    def look(self, ctx: ControlContext) -> PersonTrack | Progress:
        """Take one frame → who called, or what to do until they are found. Raises Refused when nobody is there."""
        if self._coordinates.is_new(ctx.pose):
            self._coordinates.add_legs(ctx.stamp, ctx.pose, ctx.scan_points)
        self._keep_to(self._found, ctx)
        if not self._facing:
            return self._turn(ctx)
        if ctx.camera is not None and ctx.stamp - self._since > SETTLING_S:
            self._looked += ctx.image is not None
            self._track.begin(self.call, ctx.stamp, ctx.pose, ctx.scan_points, ctx.image, ctx.camera)
            if self._looked and not self._judged and self._lasted(ctx) > ctx.company.look_for:
                self._track.begin_by_legs(self.call, ctx.stamp, ctx.pose, ctx.scan_points, ctx.camera)
        person = self._track.person
        if person is not None:
            self._found.append(self._track)
            self._coordinates.add_person(person)
            self._best = max(self._best, self.call.strength)
        elif self._is_looking(ctx):
            return Progress(remark=Statement("come.look_who_spoke"))
        self._strangers |= self._track.strangers
        following = self._following()
        if following is not None:
            self._next(following, ctx)
            return Progress(remark=Statement("come.voice_elsewhere"))
        return self._chosen(ctx)

    def _is_looking(self, ctx: ControlContext) -> bool:
        """Return whether the search goes on: for its time, on a slow computer until enough pictures were judged."""
        waits = MAX_WAITS if self._looked and not self._judged else 1.0
        return self._lasted(ctx) <= waits * ctx.company.look_for

    @property
    def _judged(self) -> bool:
        return self._track.judged >= MIN_LOOKS

    def _lasted(self, ctx: ControlContext) -> float:
        """Return for how long [s] the robot has looked at the voice."""
        return ctx.stamp - self._since - SETTLING_S

    def _following(self) -> int | None:
        """The next voice that has to be looked at; None: there is none."""
        for number in range(self._number + 1, len(self._calls)):
            if self._calls[number].strength >= RIVAL_STRENGTH_SHARE * self._best:
                return number
        return None

    def decide_again(self, track: PersonTrack, ctx: ControlContext) -> PersonTrack:
        """Choose the caller among the people who stand where they were found, by the sights from here, too; `track`:
        the person whom the robot keeps to.
        """
        if len(self._found) < 2:
            return track
        self._keep_to([one for one in self._found if one is not track], ctx)
        if not self._coordinates.is_new(ctx.pose):
            return track
        self._coordinates.add_legs(ctx.stamp, ctx.pose, ctx.scan_points)
        if track.person is not None:
            self._coordinates.add_person(track.person)
        chosen = self._agreed_on(track, ctx)
        if chosen is not track:
            self._found = [chosen]  # it changes its mind once
        return chosen

    def _keep_to(self, tracks: Sequence[PersonTrack], ctx: ControlContext) -> None:
        for one in tracks:
            one.follow(ctx.stamp, ctx.pose, ctx.scan_points, ctx.scan_stamp, None, None)

    def _chosen(self, ctx: ControlContext) -> PersonTrack:
        """Choose the caller among the people who were found. Raises Refused when nobody was."""
        if not self._found:
            raise Refused(self._nobody())
        return self._found[0] if len(self._found) == 1 else self._agreed_on(self._found[0], ctx)

    def _agreed_on(self, otherwise: PersonTrack, ctx: ControlContext) -> PersonTrack:
        agreed = self._coordinates.agreed()
        if agreed is None:
            return otherwise
        place = agreed.position
        chosen = min(self._found, key=lambda one: one.apart_from(place))
        chosen.looked = max(chosen.looked, ctx.stamp)
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

    def _turn(self, ctx: ControlContext) -> Progress:
        """Turn on the spot towards the voice; a person who speaks meanwhile is heard better."""
        error = self._error(ctx)
        soon = error - ctx.turn_rate * ctx.steering.turn_lead
        if self._arrival.reached(min(abs(soon), abs(error)), ctx.stamp) and abs(ctx.turn_rate) < 0.05:
            self._facing, self._since = True, ctx.stamp
            return Progress(remark=Statement("come.look_who_spoke"))
        if self._headway.lost(abs(error), ctx.stamp):
            return Progress(finished="failed", remark=why_no_headway(ctx.scan_points, ctx.body.radius))
        return Progress(
            twist=Twist(0.0, spin(soon, ctx.body.turn, ctx.steering)), remark=Statement("come.turn_to_voice")
        )

    def _error(self, ctx: ControlContext) -> float:
        return wrap(self.call.azimuth - ctx.pose.heading)
