"""A Snapshot and the console's own state → the message that every viewer gets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from console import hearing_portrait, intent_portrait, people_portrait, sight_portrait, wire
from console.floor_portrait import accuracy, floor
from console.intent import Intent
from console.lease import Lease
from core.gate.status import GateStatus
from core.message import Array
from core.robots import Profile
from core.slam.consistency import faded_band
from core.slam.ekf import FADE
from core.slam.estimate import Estimate, Landmark
from core.snapshot import CameraView, Notice, Snapshot, Undertaking

Link = Literal["connecting", "live", "stale", "lost"]

NIS_BAND = faded_band(FADE)


@dataclass(frozen=True)
class Circumstances:
    """What the console knows beside the snapshot."""

    profile: Profile
    link: Link
    age: float | None  # [s] since the newest frame
    pace: tuple[float, float | None]  # frames per second [Hz], and the longest of the newest steps [ms]
    speed: float  # of the playback, times real time
    gate: GateStatus
    lease: Lease
    viewers: int
    notices: Sequence[Notice]
    history_revision: int
    map: wire.MapState
    words: hearing_portrait.Words  # of the room
    muted: bool = False  # the robot speaks: nobody is listened to
    obeyed: bool = False  # a driver has taken the words of the room on
    intent: Intent | None = None  # a spoken order that waits
    now: float = 0.0  # [s] on the monotonic clock


def draw(snapshot: Snapshot, around: Circumstances, seq: int) -> wire.State:
    """Everything that may be shown at one instant."""
    goal = snapshot.goal
    return wire.State(
        seq=seq,
        stamp_s=snapshot.stamp,
        pose=pose(snapshot.estimate),
        dead_reckoning=pose(snapshot.dead_reckoning),
        velocity=wire.Velocity(near(snapshot.velocity.v), near(snapshot.velocity.w)),
        landmarks=[landmark(row) for row in snapshot.landmarks],
        slam=slam(snapshot, around.pace[1]),
        floor=floor(snapshot.floor),
        map=around.map,
        direction=hearing_portrait.direction(snapshot.hearing, around.profile.camera),
        ears=hearing_portrait.ears(
            snapshot.hearing,
            around.profile.camera,
            muted=around.muted,
            obeyed=around.obeyed,
            words=around.words,
        ),
        person=people_portrait.person(snapshot.person, snapshot.stamp),
        goal=None if goal is None else wire.Place(near(goal[0]), near(goal[1])),
        path=[(x, y) for x, y in rounded(snapshot.path, 3)],
        command=None if snapshot.undertaking is None else command(snapshot.undertaking),
        intent=intent_portrait.intent(around.intent, snapshot, around.profile.radius, around.now),
        camera=None if snapshot.view is None else camera(snapshot.view),
        calibration_drift=sight_portrait.drift(snapshot.drift),
        robot=robot(snapshot, around),
        gate=gate(around.gate, snapshot),
        lease=lease(around.lease),
        viewers=around.viewers,
        notices=[wire.NoticeLine(told.id, told.stamp, told.level, told.text) for told in around.notices],
        history_revision=around.history_revision,
        truth=None if snapshot.truth is None else true_pose(snapshot),
    )


def near(value: float) -> float:
    """A tenth of a millimetre, or of a milliradian, is near enough to be shown."""
    return round(float(value), 4)


def rounded(values: Array, digits: int) -> list[tuple[float, ...]]:
    """Rows of an array, rounded."""
    return np.round(values.astype(np.float64), digits).tolist()


def short(covariance: Array) -> list[list[float]]:
    """Four digits of each element: half of every message would be the others."""
    return [[float(f"{value:.4g}") for value in row] for row in covariance.tolist()]


def pose(estimate: Estimate) -> wire.Pose:
    """A pose and its covariance."""
    at = estimate.pose
    return wire.Pose(near(at.x), near(at.y), near(at.heading), short(estimate.covariance))


def true_pose(snapshot: Snapshot) -> wire.TruePose | None:
    """Where the simulated robot really is."""
    at = snapshot.truth
    return None if at is None else wire.TruePose(near(at.x), near(at.y), near(at.heading))


def landmark(row: Landmark) -> wire.LandmarkRow:
    """A row of the table of landmarks."""
    x, y = row.position.tolist()
    return wire.LandmarkRow(row.id, near(x), near(y), short(row.covariance), row.hits, row.misses, row.kind)


def slam(snapshot: Snapshot, step_ms: float | None) -> wire.Slam:
    """How the filter fares; without a time of its own, how long the step took that had most to see."""
    health = snapshot.slam
    error_m, error_rad, squared = accuracy(snapshot.estimate, snapshot.truth)
    return wire.Slam(
        mode=health.mode,
        updates=health.updates,
        nis=health.nis,
        nis_band=NIS_BAND,
        nees=squared,
        error_m=error_m,
        error_rad=error_rad,
        matched=health.matched,
        ignored=health.ignored,
        tentative=health.tentative,
        update_ms=step_ms if health.update_ms is None else health.update_ms,
        looking_around=health.looking_around,
    )


def command(told: Undertaking) -> wire.CommandState:
    """A command and how it goes."""
    return wire.CommandState(
        id=told.id,
        name=told.name,
        numbers=dict(told.numbers),
        heard_as=told.heard_as,
        source=told.source,
        who=told.who,
        state=told.state,
        remark=told.remark,
        progress=told.progress,
    )


def camera(view: CameraView) -> wire.CameraOverlay:
    """What perception drew on the newest picture."""
    edges: list[wire.EdgeLine] = []
    for edge in view.edges:
        (u0, v0), (u1, v1) = rounded(np.stack((edge.top, edge.bottom)), 1)
        edges.append(wire.EdgeLine(u0, v0, u1, v1, near(edge.bearing), edge.matched))
    laser = [(u, v, distance) for u, v, distance in rounded(view.laser, 2)]
    quality = sight_portrait.quality(view.quality)
    return wire.CameraOverlay(view.stamp, view.width, view.height, edges, laser, quality)


def robot(snapshot: Snapshot, around: Circumstances) -> wire.RobotState:
    """The robot and the link to it."""
    return wire.RobotState(
        url=around.profile.url,
        kind=around.profile.kind,
        name=around.profile.name,
        link=around.link,
        age_s=around.age,
        rate_hz=round(around.pace[0], 1),
        contact=snapshot.contact,
        running=snapshot.running,
        progress=snapshot.progress,
        speed=around.speed,
    )


def gate(status: GateStatus, snapshot: Snapshot) -> wire.GateState:
    """What the gate lets through; what blocks it is told in the world frame."""
    blocked = None
    if status.blocked_by is not None:
        x, y = snapshot.estimate.pose.apply(np.array([status.blocked_by]))[0]
        blocked = wire.Place(near(x), near(y))
    return wire.GateState(
        state=status.state,
        reason=status.reason,
        v_m_s=near(status.v),
        w_rad_s=near(status.w),
        source=status.source,
        nonce=status.nonce,
        epoch=status.epoch,
        limit_v_m_s=status.limit_v,
        blocked_by=blocked,
        need_neutral=status.need_neutral,
    )


def lease(held: Lease) -> wire.LeaseState:
    """Who drives."""
    holder = held.holder
    return wire.LeaseState(holder and holder.name, holder and holder.id, held.epoch)


def card(profile: Profile) -> wire.RobotCard:
    """What the robot is."""
    return wire.RobotCard(
        url=profile.url,
        kind=profile.kind,
        name=profile.name,
        radius_m=profile.radius,
        cruise_m_s=profile.cruise,
        max_speed_m_s=profile.max_speed,
        max_turn_rate_rad_s=profile.max_turn_rate,
        drives=profile.drives,
        duration_s=profile.duration,
    )
