"""Solids of the robot's body, and how a body is put in its place."""

import math

import numpy as np
from viser import FrameHandle, MeshHandle

from core.geometry import Pose
from core.message import Array

FACET_COUNT = 48  # facets of a turned solid

Profile = list[tuple[float, float]]


def turned(profile: Profile) -> tuple[Array, Array]:
    """Profile of (radius, height) [m] from bottom to top → vertices (V, 3) and faces (F, 3), turned about z."""
    angles = np.linspace(0.0, 2 * np.pi, FACET_COUNT, endpoint=False)
    rings = [np.column_stack((r * np.cos(angles), r * np.sin(angles), np.full(FACET_COUNT, z))) for r, z in profile]
    this, following = np.arange(FACET_COUNT), (np.arange(FACET_COUNT) + 1) % FACET_COUNT
    faces: list[Array] = []
    for ring in range(len(profile) - 1):
        low, high = ring * FACET_COUNT, (ring + 1) * FACET_COUNT
        faces.append(np.column_stack((low + this, low + following, high + following)))
        faces.append(np.column_stack((low + this, high + following, high + this)))
    return np.vstack(rings), np.vstack(faces)


def rounded_disc(radius: float, bottom: float, top: float, edge: float) -> Profile:
    """A disc whose edges are rounded by `edge` [m]."""
    turns = np.linspace(0.0, np.pi / 2, 6)
    low = [(radius - edge + edge * np.sin(t), bottom + edge - edge * np.cos(t)) for t in turns]
    high = [(radius - edge + edge * np.cos(t), top - edge + edge * np.sin(t)) for t in turns]
    return [(1e-4, bottom), *low, *high, (1e-4, top)]


def arrow(length: float, width: float) -> tuple[Array, Array]:
    """A flat arrow head that points along x, its middle at the origin: vertices (4, 3) and faces (2, 3)."""
    vertices = np.array([[length, 0, 0], [-length, width, 0], [-0.45 * length, 0, 0], [-length, -width, 0]])
    return vertices, np.array([[0, 1, 2], [0, 2, 3]])


def place(frame: FrameHandle | MeshHandle, pose: Pose, height: float = 0.0) -> None:
    """Move a frame to a pose on the floor, or `height` [m] above it."""
    frame.position = np.array([pose.x, pose.y, height])
    frame.wxyz = np.array([math.cos(pose.heading / 2), 0.0, 0.0, math.sin(pose.heading / 2)])
