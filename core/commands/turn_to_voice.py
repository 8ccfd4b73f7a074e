"""Turn to a voice and look for the person who spoke: the start of COME HERE and FOLLOW ME."""

from __future__ import annotations

import math

from core.commands.command import Command, Progress
from core.errors import Refused
from core.gate import Twist
from core.geometry import wrap
from core.navigation.control_context import ControlContext
from core.navigation.obstacle import why_no_headway
from core.navigation.steering import Arrival, StallDetector, spin
from core.perception.people.tracked_person import TrackedPerson
from core.perception.people.tracking import PersonTrack
from core.perception.people.voice_bearing import VoiceBearing, from_side

TOWARDS = 0.06  # [rad] within which the robot looks at the voice
BY_CHANCE = 0.2  # [rad] within which it need not turn
SETTLED = 0.15  # [s] at rest before pictures count


def call_for(command: Command, here: ControlContext) -> VoiceBearing:
    """Return the voice bearing of the person who gave a command. Raises Refused when it is unknown, old or vague."""
    call, company = command.call or here.call, here.company
    if call is None:
        raise Refused("I do not know where you are: I heard nobody. Speak to me, and I hear from where.")
    age = here.stamp - call.stamp
    if age > (company.spoken_fresh if command.call is not None else company.fresh):
        raise Refused(
            f"I do not know where you are: the last voice that I heard is {age:.0f} s old. Speak to me again."
        )
    if call.sd > company.sure:
        degrees = math.degrees(call.sd)
        raise Refused(f"I heard you, but not well enough to tell from where (±{degrees:.0f}°). Say it again, please.")
    return call


class TurnToVoice:
    """Turns to a call, then looks for a person there."""

    def __init__(self, call: VoiceBearing, here: ControlContext) -> None:
        """Raises Refused on a robot without a camera."""
        if here.camera is None:
            raise Refused("I have no camera to see who spoke; set company.mode to voice to be come to by ear alone.")
        self.call = call
        self.track = PersonTrack(here.people, here.tracking, here.who, here.look)
        self._who = here.who.name if here.who is not None else ""
        self.side = call.side(here.pose.heading)
        self._facing = abs(self._error(here)) < BY_CHANCE
        self._arrival = Arrival(TOWARDS, here.steering)
        self._headway = StallDetector(0.05, here.steering.stalled_after)
        self._since = here.stamp
        self._looked = 0

    def look(self, here: ControlContext) -> TrackedPerson | Progress:
        """Take one frame → the person, or what to do until they are found. Raises Refused when nobody is there."""
        if not self._facing:
            return self._turn(here)
        if here.camera is not None and here.stamp - self._since > SETTLED:
            self._looked += here.image is not None
            self.track.begin(self.call, here.stamp, here.pose, here.scan_points, here.image, here.camera)
        found = self.track.person
        if found is not None:
            return found
        if here.stamp - self._since > here.company.look_for + SETTLED:
            raise Refused(self._nobody())
        return Progress(remark="I look who spoke.")

    def _nobody(self) -> str:
        if not self._looked:
            return "I heard you, but no picture comes from the camera."
        where = from_side(self.side)
        if not self._who:
            return f"I heard you {where} but see nobody there."
        if self.track.strangers:
            return f"I heard you {where} but see somebody else there; I come only to {self._who}."
        return f"I heard you {where} but do not see {self._who} there, and I come to nobody else."

    def _turn(self, here: ControlContext) -> Progress:
        """Turn on the spot towards the voice; a person who speaks meanwhile is heard better."""
        error = self._error(here)
        soon = error - here.turn_rate * here.steering.turn_lead
        if self._arrival.reached(min(abs(soon), abs(error)), here.stamp) and abs(here.turn_rate) < 0.05:
            self._facing, self._since = True, here.stamp
            return Progress(remark="I look who spoke.")
        if self._headway.lost(abs(error), here.stamp):
            return Progress(finished="failed", remark=why_no_headway(here.scan_points, here.body.radius))
        return Progress(twist=Twist(0.0, spin(soon, here.body.turn, here.steering)), remark="I turn to your voice.")

    def _error(self, here: ControlContext) -> float:
        """Return the angle from the robot's heading to the voice [rad]."""
        return wrap(self.call.azimuth - here.pose.heading)
