"""The dry run of COME HERE and FOLLOW ME, where a camera looks and nothing can drive: what a robot would do."""

import math
from dataclasses import replace

import numpy as np

from core.commands.command import Command, Progress
from core.errors import Refused
from core.geometry import Pose, Ray, wrap
from core.navigation.control_context import ControlContext
from core.perception.people.appearance import alike
from core.perception.people.camera_geometry import eye, ray_of
from core.perception.people.detector import Rectangle
from core.perception.people.fusion import Sense, along, fuse
from core.perception.people.looking import LookQuestion
from core.perception.people.pose.view import Viewpoint
from core.perception.people.tracked_person import TrackedPerson
from core.perception.people.voice_bearing import VoiceBearing, from_side

QUESTION_PERIOD_S = 0.18  # between two questions: five a second are enough
MAX_ANSWER_S = 2.0  # after which an answer is expected no more
MAX_HIDDEN_S = 1.0  # without a sight after which the person is hidden
FORGET_PERSON_S = 3.0  # without a sight after which anybody who calls is looked for again
SEARCH_TIME_S = 15.0  # until it gives up
MAX_START_S = 60.0  # that a worker with networks may take to start
SHOW_FOUND_S = 15.0  # for which COME HERE shows whom it found
NEAR_SD_RAD = 0.1  # within which someone who was found is looked for again
DISTANCE_SD = 0.15  # share of a distance that only the picture gives


class DryRun:
    """Looks for who called, or for anybody where no direction is known, and says what a robot would do."""

    def __init__(self, command: Command, ctx: ControlContext) -> None:
        """Raises Refused where nothing here sees people."""
        if ctx.camera is None:
            raise Refused("Dry run: there is no camera here to see who spoke.")
        if ctx.look is None:
            raise Refused(
                "Dry run: what looks for people here knows drawn figures only. Get the pose networks first: "
                "beckon models get people."
            )
        self._command = command
        self._began = ctx.stamp
        self._asked: tuple[float, Pose, VoiceBearing | None] | None = None  # the question that waits for its answer
        self._asked_last = -math.inf  # [s]
        self._found_first: float | None = None  # [s]
        self._person: TrackedPerson | None = None
        self._strangers = False
        self._answered = False  # what looks for people has started

    def drive(self, ctx: ControlContext) -> Progress:
        """Take one frame; the twist is always zero."""
        call = self._call(ctx)
        self._take(ctx)
        self._ask(ctx, call)
        person = self._person
        if person is None or ctx.stamp - person.stamp > FORGET_PERSON_S:
            self._person = None
            return self._nobody(ctx, call)
        if ctx.stamp - person.stamp > MAX_HIDDEN_S:
            hidden = replace(person, laser=None, camera=None, used=(), state="hidden")
            return Progress(remark="Dry run: you are hidden; I would wait for you.", person=hidden)
        return self._person_seen(ctx, person)

    def _call(self, ctx: ControlContext) -> VoiceBearing | None:
        call = ctx.call or self._command.call
        known = call is not None and ctx.stamp - call.stamp <= ctx.company.fresh and call.sd <= ctx.company.sure
        return call if known else None

    def _ask(self, ctx: ControlContext, call: VoiceBearing | None) -> None:
        """Ask for the person where they were, else where the voice is, else anywhere."""
        waits = self._asked is not None and ctx.stamp - self._asked_last < MAX_ANSWER_S
        if ctx.image is None or ctx.camera is None or ctx.look is None or waits:
            return
        if ctx.stamp - self._asked_last < QUESTION_PERIOD_S:
            return
        bearing, sd = _towards(ctx, self._person, call)
        question = LookQuestion(
            pixels=ctx.image.pixels, camera=ctx.camera, stamp=ctx.stamp, bearing=bearing, sd=sd, on_floor=False
        )
        self._asked, self._asked_last = (ctx.stamp, ctx.pose, call), ctx.stamp
        ctx.look.ask(question)

    def _take(self, ctx: ControlContext) -> None:
        answer = None if ctx.look is None else ctx.look.answer()
        if answer is None or self._asked is None or ctx.camera is None or answer.stamp != self._asked[0]:
            return
        stamp, pose, call = self._asked
        self._asked, self._answered = None, True
        own = [one for one in answer.found if _is_who(one, ctx)]
        self._strangers = bool(answer.found) and not own
        if own:
            sound = call.ray if call is not None else None
            self._person = _person(own[0], stamp, pose, eye(pose, ctx.camera), sound)
            self._found_first = ctx.stamp if self._found_first is None else self._found_first

    def _nobody(self, ctx: ControlContext, call: VoiceBearing | None) -> Progress:
        """Go on looking, or give up. Raises Refused."""
        heard = "" if call is None else f"I heard you {from_side(call.side(ctx.pose.heading))}"
        if call is not None and not _in_view(ctx, call):
            would = _would(wrap(call.azimuth - ctx.pose.heading), 0.0)
            return Progress(remark=f"Dry run: {heard}; I would {would} and look who spoke.")
        patience = SEARCH_TIME_S if self._answered else MAX_START_S
        if ctx.stamp - self._began > patience and self._found_first is None:
            raise Refused(f"Dry run: {self._missed(ctx, heard)}")
        looks = f"{heard} and look who spoke" if heard else "I know of no direction and look for anybody"
        return Progress(remark=f"Dry run: {looks}.")

    def _missed(self, ctx: ControlContext, heard: str) -> str:
        if not self._answered:
            return "what looks for people has not started yet; the computer is busy. Try again."
        if self._strangers and ctx.who is not None:
            return f"I see someone, but not {ctx.who.name}."
        return f"{heard} but see nobody there." if heard else "I see nobody."

    def _person_seen(self, ctx: ControlContext, person: TrackedPerson) -> Progress:
        x, y = person.position.tolist()
        apart, angle = ctx.pose.distance_to(x, y), wrap(ctx.pose.bearing_to(x, y))
        follows = self._command.name == "follow_me"
        keep = ctx.company.keep if follows else ctx.company.stop_short
        way = max(0.0, apart - keep)
        towards = ctx.pose.heading + angle
        stand = np.array([ctx.pose.x + way * math.cos(towards), ctx.pose.y + way * math.sin(towards)])
        words = f"Dry run: I see you {apart:.1f} m away; I would {_would(angle, way)}."
        over = not follows and self._found_first is not None and ctx.stamp - self._found_first > SHOW_FOUND_S
        return Progress(
            finished="done" if over else "",
            remark=words,
            path=np.array([(ctx.pose.x, ctx.pose.y), stand]),
            goal=stand,
            person=person,
        )


def _towards(
    ctx: ControlContext, person: TrackedPerson | None, call: VoiceBearing | None
) -> tuple[float | None, float]:
    """Return the direction in which to look: the bearing [rad, robot frame] and its sd; None: anywhere."""
    if person is not None and person.camera is not None:
        return wrap(person.camera.azimuth - ctx.pose.heading), NEAR_SD_RAD
    if call is not None:
        return wrap(call.azimuth - ctx.pose.heading), math.hypot(call.sd, 0.02)
    return None, NEAR_SD_RAD


def _in_view(ctx: ControlContext, call: VoiceBearing) -> bool:
    if ctx.camera is None:
        return False
    return 0 <= Viewpoint(ctx.camera).column(wrap(call.azimuth - ctx.pose.heading)) < ctx.camera.model.width


def _is_who(rectangle: Rectangle, ctx: ControlContext) -> bool:
    if ctx.who is None or rectangle.looks is None:
        return ctx.who is None
    return alike(ctx.who.looks, rectangle.looks) >= ctx.people.alike


def _person(rectangle: Rectangle, stamp: float, pose: Pose, camera: Pose, sound: Ray | None) -> TrackedPerson:
    """A rectangle and a voice → the person: the camera's bearing, its distance by the torso's length, the sound."""
    ray = ray_of(rectangle, camera, pose)
    start = along(ray, rectangle.distance, DISTANCE_SD * rectangle.distance)
    rays: tuple[tuple[Sense, Ray], ...] = () if sound is None else (("sound", sound),)
    fused = fuse(start, rays, "camera")
    return TrackedPerson(
        stamp=stamp,
        position=fused.position,
        covariance=fused.covariance,
        velocity=np.zeros(2),
        rectangle=rectangle,
        rectangle_stamp=stamp,
        camera=ray,
        sound=sound,
        used=fused.used,
    )


def _would(angle: float, way: float) -> str:
    """Describe in words what a robot would do about an angle [rad] and a way [m]."""
    degrees = round(math.degrees(angle))
    turn = f"turn {abs(degrees)}° {'left' if degrees > 0 else 'right'}" if abs(degrees) >= 3 else ""
    come = f"come {way:.1f} m nearer" if way >= 0.05 else ""
    return " and ".join(part for part in (turn, come) if part) or "stay"
