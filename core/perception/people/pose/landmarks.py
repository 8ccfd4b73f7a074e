"""Landmarks of a body → head, torso and feet, and how sure each is (eq. 34's K1, K2, K3)."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from core.message import Array, message
from core.perception.people.body import Box, SeenBody

# rows of the 33 landmarks
NOSE_ROW, LEFT_EYE, RIGHT_EYE, LEFT_EAR, RIGHT_EAR = 0, 2, 5, 7, 8
SHOULDERS, HIPS, ANKLES = (11, 12), (23, 24), (27, 28)
LEGS = tuple(range(25, 33))  # knees, ankles, heels, toes
FACE = (NOSE_ROW, LEFT_EYE, RIGHT_EYE, LEFT_EAR, RIGHT_EAR)
TRUNK = (*SHOULDERS, *HIPS)
LANDMARK_ROWS = 33  # of 39: the others are auxiliary
MIN_VISIBILITY = 0.5  # of a landmark's visibility
MAX_LOGIT = 80.0  # the networks reach that far


@message
class BodyLandmarks:
    """The landmarks of one body."""

    points: Array  # (33, 2) [pixel] of the picture
    visibility: Array  # (33,) 0..1: in the picture and not hidden
    confidence: float  # 0..1 that someone is there

    @property
    def seen(self) -> Array:
        """(33, 2) [pixel]; NaN where hidden or out of the picture."""
        return np.where(self.visibility[:, None] >= MIN_VISIBILITY, self.points, np.nan)

    @property
    def shoulders(self) -> Array:
        """(2,) [pixel] the middle of both."""
        return self.points[list(SHOULDERS)].mean(axis=0)

    @property
    def hips(self) -> Array:
        """(2,) [pixel] the middle of both."""
        return self.points[list(HIPS)].mean(axis=0)

    @property
    def face(self) -> Array:
        """(2,) [pixel] the middle of the head: mean of the nose, both ears, and the middle of the eyes."""
        points = self.points
        eyes = (points[LEFT_EYE] + points[RIGHT_EYE]) / 2
        return (points[NOSE_ROW] + points[LEFT_EAR] + points[RIGHT_EAR] + eyes) / 4


def landmarks_of(rows: Array, confidence: float, picture_from_crop: Array) -> BodyLandmarks:
    """The network's rows (39, 5), and the affine map (2, 3) from the crop to the picture → landmarks."""
    points = rows[:LANDMARK_ROWS, :2] @ picture_from_crop[:, :2].T + picture_from_crop[:, 2]
    return BodyLandmarks(points=points, visibility=sigmoid(rows[:LANDMARK_ROWS, 3]), confidence=confidence)


def body_of(found: BodyLandmarks) -> SeenBody:
    """Head, torso and feet around the landmarks, in torso's lengths; they may reach out of the picture."""
    shares = [float(found.visibility[list(group)].mean()) for group in (FACE, TRUNK, LEGS)]
    joints = tuple(found.points[list(rows)] for rows in (SHOULDERS, HIPS, LEGS, ANKLES))
    body = body_around(found.face, joints, shares, found.confidence, 0.05)
    limbs = _around(found.points, (0.04, 0.0, 0.04, 0.04), body.torso_length)
    return replace(body, box=_united(_united(limbs, body.parts[0]), body.parts[1]))


def body_around(
    face: Array, joints: Sequence[Array], shares: Sequence[float], confidence: float, below: float
) -> SeenBody:
    """The same of any model: the middle of the face (2,), and shoulders, hips, legs and ankles (N, 2) each [pixel].

    `shares` 0..1 of head, torso and legs that are seen; `below`: margin below the lowest landmark [torso's lengths].
    The box is around head, torso and feet.
    """
    shoulders, hips = joints[0].mean(axis=0), joints[1].mean(axis=0)
    length = max(float(np.hypot(*(shoulders - hips))), 1e-3)
    head = _around(face[None], (0.24, 0.34, 0.24, 0.28), length)
    trunk = _around(np.concatenate(joints[:2]), (0.14, 0.12, 0.14, 0.12), length)
    middle = float(shoulders[0] + hips[0]) / 2
    torso = (min(trunk[0], middle - 0.26 * length), trunk[1], max(trunk[2], middle + 0.26 * length), trunk[3])
    legs = _around(np.concatenate(joints[1:3]), (0.08, 0.0, 0.08, below), length)
    feet = (legs[0], float(hips[1]), legs[2], max(legs[3], float(hips[1]) + 1.0))
    return SeenBody(
        parts=(head, torso, feet),
        likelihoods=(confidence * shares[0], confidence * shares[1], confidence * shares[2]),
        box=_united(_united(head, torso), feet),
        head_column=float(face[0]),
        foretold_head=float(shoulders[1] + 0.42 * (shoulders[1] - hips[1])),
        hips_row=float(hips[1]),
        torso_length=length,
        legs_length=float(joints[3][:, 1].mean() - hips[1]),
        confidence=confidence,
    )


def sigmoid(logits: Array) -> Array:
    """Logits → 0..1."""
    return 1 / (1 + np.exp(-np.clip(logits, -MAX_LOGIT, MAX_LOGIT)))


def _around(points: Array, margins: tuple[float, float, float, float], length: float) -> Box:
    """A rectangle around points (N, 2), with margins left, above, right, below [torso's lengths]."""
    low, high = points.min(axis=0), points.max(axis=0)
    left, above, right, below = (length * margin for margin in margins)
    return float(low[0] - left), float(low[1] - above), float(high[0] + right), float(high[1] + below)


def _united(one: Box, other: Box) -> Box:
    return min(one[0], other[0]), min(one[1], other[1]), max(one[2], other[2]), max(one[3], other[3])
