"""A detection of a model → head, torso and feet."""

from __future__ import annotations

import numpy as np

from core.message import Array
from core.perception.people.body import Box, SeenBody

FACE, SHOULDERS, HIPS, LEGS, ANKLES = (0, 1, 2, 3, 4), (5, 6), (11, 12), (13, 14, 15, 16), (15, 16)
HEAD_SHARE, TORSO_SHARE = 0.16, 0.5  # of the box's height, where there are no landmarks
TORSO_LENGTH = 0.29  # statures


def body_of_box(box: Box, score: float) -> SeenBody:
    """A person of whom only the box is known."""
    left, top, right, bottom = box
    tall, middle = bottom - top, (left + right) / 2
    half = min(0.5 * HEAD_SHARE * tall, (right - left) / 2)
    neck, hips = top + HEAD_SHARE * tall, top + TORSO_SHARE * tall
    return SeenBody(
        parts=((middle - half, top, middle + half, neck), (left, neck, right, hips), (left, hips, right, bottom)),
        likelihoods=(score, score, score),
        box=box,
        head_column=middle,
        foretold_head=top + 0.5 * HEAD_SHARE * tall,
        hips_row=hips,
        torso_length=max(TORSO_LENGTH * tall, 1e-3),
        legs_length=0.45 * tall,
        confidence=score,
    )


def body_of_points(box: Box, score: float, points: Array) -> SeenBody:
    """A person with COCO's 17 landmarks (17, 3): x, y [pixel] and visibility 0..1."""
    shoulders, hips = points[list(SHOULDERS), :2].mean(axis=0), points[list(HIPS), :2].mean(axis=0)
    length = max(float(np.hypot(*(shoulders - hips))), 1e-3)
    face = points[list(FACE), :2].mean(axis=0)
    x, y = face.tolist()
    head = (x - 0.24 * length, y - 0.34 * length, x + 0.24 * length, y + 0.28 * length)
    middle = float(shoulders[0] + hips[0]) / 2
    trunk, legs = points[[*SHOULDERS, *HIPS], :2], points[[*HIPS, *LEGS], :2]
    torso = (
        min(float(trunk[:, 0].min()) - 0.14 * length, middle - 0.26 * length),
        float(trunk[:, 1].min()) - 0.12 * length,
        max(float(trunk[:, 0].max()) + 0.14 * length, middle + 0.26 * length),
        float(trunk[:, 1].max()) + 0.12 * length,
    )
    feet = (
        float(legs[:, 0].min()) - 0.08 * length,
        float(hips[1]),
        float(legs[:, 0].max()) + 0.08 * length,
        max(float(legs[:, 1].max()) + 0.15 * length, float(hips[1]) + 1.0),
    )
    seen = [
        score * float(np.clip(points[list(group), 2], 0, 1).mean()) for group in (FACE, (*SHOULDERS, *HIPS), LEGS)
    ]
    return SeenBody(
        parts=(head, torso, feet),
        likelihoods=(seen[0], seen[1], seen[2]),
        box=box,
        head_column=x,
        foretold_head=float(shoulders[1] + 0.42 * (shoulders[1] - hips[1])),
        hips_row=float(hips[1]),
        torso_length=length,
        legs_length=float(points[list(ANKLES), 1].mean() - hips[1]),
        confidence=score,
    )
