"""Pictures on their way to a detector that answers later, and how the robot stood when each was taken."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from core.geometry import Pose
from core.perception.people.camera_geometry import from_eye
from core.perception.people.detector import Rectangle
from core.perception.people.legs import LegCluster
from core.perception.people.looking import LookQuestion, PersonLook
from core.perception.people.pose.view import Viewpoint
from core.sensors import Camera, Image

MAX_ANSWER_S = 2.0  # after which an answer is expected no more
QUESTION_PERIOD_S = 0.18  # between two questions about the followed person: five a second are enough
CHEST_HEIGHT_M = 1.15  # above the floor: of whom less is in view is not asked for
SHOULDER_HEIGHT_M = 1.4  # above the floor: of whom less is in view is found in few pictures
MAX_DISTANCES = 2  # distances of one question
WEDGE_SDS = 2.0  # sd of a direction within which legs may be the caller's
BODY_MARGIN_M = 0.3  # [m] to either side that are added to that
MIDDLE_M = 0.15  # [m] the same where no picture shows whose legs they are


@dataclass(frozen=True)
class AskedPicture:
    """A picture that is looked at."""

    stamp: float  # [s]
    pose: Pose
    camera: Camera
    standers: tuple[LegCluster, ...]
    legs: LegCluster | None  # legs in the direction asked for, above which the camera sees too little


@dataclass(frozen=True)
class AnsweredPicture(AskedPicture):
    """The same with who was found in it."""

    found: tuple[Rectangle, ...]


class PersonPictures:
    """One question at a time."""

    def __init__(self, look: PersonLook) -> None:
        self._look = look
        self._waiting: AskedPicture | None = None
        self._asked = -math.inf  # [s] when the newest question was asked
        self._guess = False  # nobody was found where the laser sees something: the next question names no distance

    def ask_towards(
        self,
        image: Image,
        camera: Camera,
        pose: Pose,
        standers: tuple[LegCluster, ...],
        towards: tuple[float, float],
        stamp: float,
    ) -> None:
        """Ask for anybody `towards` a bearing [rad, robot frame] with its sd [rad]."""
        if self._busy(stamp):
            return
        near = _within(standers, camera, towards, BODY_MARGIN_M)
        hinted = () if self._guess else tuple(from_eye(one, camera)[0] for one in near[:MAX_DISTANCES])
        waiting = AskedPicture(stamp, pose, camera, standers, legs_alone(standers, camera, towards))
        self._ask(waiting, image, towards, hinted)

    def ask_for(
        self,
        image: Image,
        camera: Camera,
        pose: Pose,
        standers: tuple[LegCluster, ...],
        towards: tuple[float, float],
        distance: float,
        stamp: float,
    ) -> bool:
        """Ask for someone who is expected at a bearing and a distance [m] from the camera → whether it was asked."""
        if (
            self._busy(stamp)
            or stamp - self._asked < QUESTION_PERIOD_S
            or only_legs_show(camera, towards[0], distance, CHEST_HEIGHT_M)
        ):
            return False
        self._ask(AskedPicture(stamp, pose, camera, standers, None), image, towards, (distance,))
        return True

    def answer(self) -> AnsweredPicture | None:
        """Return the newest answer; None: it has not come yet."""
        answer, asked = self._look.answer(), self._waiting
        if answer is None or asked is None or answer.stamp != asked.stamp:
            return None
        self._waiting = None
        self._guess = not answer.found and not self._guess
        return AnsweredPicture(asked.stamp, asked.pose, asked.camera, asked.standers, asked.legs, answer.found)

    def _busy(self, stamp: float) -> bool:
        return self._waiting is not None and stamp - self._asked < MAX_ANSWER_S

    def _ask(
        self, waiting: AskedPicture, image: Image, towards: tuple[float, float], distances: tuple[float, ...]
    ) -> None:
        self._waiting, self._asked = waiting, waiting.stamp
        bearing, sd = towards
        question = LookQuestion(
            pixels=image.pixels,
            camera=waiting.camera,
            stamp=waiting.stamp,
            bearing=bearing,
            sd=sd,
            distances=distances,
        )
        self._look.ask(question)


def only_legs_show(camera: Camera, bearing: float, distance: float, height: float = SHOULDER_HEIGHT_M) -> bool:
    """Return whether of someone who stands there less than `height` [m] is in the picture, little but legs."""
    view = Viewpoint(camera)
    if math.isnan(view.column(bearing)):
        return False
    place, _ = view.pixel(bearing, max(distance, 0.1), height)
    return not np.isfinite(place).all() or bool(place[1] < 0)  # so near, it is too steep to be in any picture


def legs_alone(standers: Sequence[LegCluster], camera: Camera, towards: tuple[float, float]) -> LegCluster | None:
    """Legs in a direction [rad, robot frame] with its sd [rad], above which the camera sees too little to tell whose
    they are. What is wider or thinner than legs may be a bin or a chair.
    """
    near = [one for one in _within(standers, camera, towards, MIDDLE_M) if one.distinct]
    return next((one for one in near if only_legs_show(camera, *from_eye(one, camera)[::-1])), None)


def _within(
    standers: Sequence[LegCluster], camera: Camera, towards: tuple[float, float], body: float
) -> list[LegCluster]:
    """Those in a direction or `body` [m] beside it, the nearest to it first."""
    bearing, sd = towards
    found: list[tuple[float, LegCluster]] = []
    for one in standers:
        far, angle = from_eye(one, camera)
        aside = abs(math.remainder(angle - bearing, math.tau))
        if far > 0.2 and aside < WEDGE_SDS * sd + body / far:
            found.append((aside - 0.05 * (one.legs == 2), one))
    return [one for _, one in sorted(found, key=lambda each: each[0])]
