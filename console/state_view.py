"""The view model, or serializer: a Snapshot and the console's own state → the state message of every viewer."""

import math
from dataclasses import dataclass

import msgspec
import numpy as np

from console.access.open_sockets import OpenSockets
from console.control.command_preview import caller, preview
from console.control.history import History
from console.control.lease import Lease
from console.control.notices import Notifications
from console.control.pending_commands import LateCommand, PendingCommand, PendingCommands
from console.control.picture_floor import PictureFloor
from console.control.pilot_supervisor import PilotSupervisor
from console.control.playback import PlaybackController
from console.maps.routes import RouteRun, RouteService
from console.maps.service import MapService
from console.messages import filled, hearing, person, picture
from console.messages import state as messages
from console.messages.map import accuracy, floor
from console.part import Parts
from console.people.service import EnrollmentService
from console.recording.recorder import RecorderService
from console.recording.store import RecordingStore
from console.robot.supervisor import RobotSupervisor
from console.speech.robot_voice import RobotVoice
from console.speech.room_transcription import RoomTranscriber
from console.speech.voice_commands import VoiceCommands
from core.commands import spec_of
from core.gate.status import GateStatus
from core.message import Array
from core.robots import Profile
from core.robots.requests import PlaybackState
from core.sensors import Camera
from core.sentences import code_of
from core.settings import ChapterMode
from core.slam.consistency import faded_band
from core.slam.ekf_slam import NIS_FADE
from core.slam.estimate import Estimate, Landmark
from core.slam.scan_matching.agreement import MoveAgreement
from core.snapshot import ActiveCommandStatus, CameraView, Comparison, Snapshot


@dataclass(frozen=True)
class StateContext:
    robot: RobotSupervisor
    lease: Lease
    history: History
    notifications: Notifications
    sockets: OpenSockets
    pilots: PilotSupervisor
    parts: Parts
    chapter: ChapterMode

    @property
    def situation(self) -> tuple[object, ...]:
        """All whose change is sent to every viewer at once."""
        gate, pending = self.robot.status(), self.parts[PendingCommands]
        return (
            gate.state,
            gate.reason,
            gate.source,
            self.lease.epoch,
            self.lease.request,
            self.history.revision,
            self.notifications.shown,
            self.sockets.people,
            self.parts[VoiceCommands].operator,
            pending.waiting,
            pending.late,
            self.parts[RoomTranscriber].status.starting,
            self.robot.link()[0],
            self.parts[RecordingStore].revision,
            route(self.parts[RouteService].run_now),
        )


def state_message(snapshot: Snapshot, around: StateContext, seq: int, now: float) -> messages.State:
    """Everything that may be shown at one instant, `now` [s] on the monotonic clock."""
    goal, profile, parts = snapshot.goal, around.robot.profile, around.parts
    pending, chosen = parts[PendingCommands], parts[EnrollmentService].chosen
    pace = around.pilots.pace.measured(now)
    return messages.State(
        seq=seq,
        stamp_s=snapshot.stamp,
        pose=pose(snapshot.estimate),
        dead_reckoning=pose(snapshot.dead_reckoning),
        velocity=messages.Velocity(near(snapshot.velocity.v), near(snapshot.velocity.w)),
        landmarks=[landmark(row) for row in snapshot.landmarks],
        slam=slam(snapshot, pace[1]),
        floor=floor(snapshot.floor),
        map=parts[MapService].shown,
        direction=hearing.direction(snapshot.hearing, profile.camera),
        ears=hearing.ears(
            snapshot.hearing,
            profile.camera,
            muted=parts[RobotVoice].muted,
            voice_control=parts[VoiceCommands].operator is not None,
            words=parts[RoomTranscriber].status,
        ),
        person=person.person(snapshot.person, snapshot.stamp, "" if chosen is None else chosen.name),
        goal=None if goal is None else messages.PointState(near(goal[0]), near(goal[1])),
        path=[(x, y) for x, y in rounded(snapshot.path, 3)],
        command=None if snapshot.active_command is None else command(snapshot.active_command),
        pending_command=pending_command(pending.waiting, snapshot, profile.radius, now),
        late_command=late_command(pending.late),
        camera=None if snapshot.view is None else camera(snapshot.view, *parts[PictureFloor].drawn(snapshot)),
        calibration_drift=picture.drift(snapshot.drift),
        robot=robot(snapshot, around, pace[0]),
        gate=gate(around.robot.status(), snapshot),
        lease=lease(around.lease, now),
        recording=recorder(around),
        playback=playback(parts[PlaybackController].state, snapshot.other),
        viewers=around.sockets.people,
        notices=[
            messages.NoticeLine(one.id, one.stamp, near(one.at), one.level, one.text, one.cause, *code_of(one.text))
            for one in around.notifications.shown
        ],
        history_revision=around.history.revision,
        truth=None if snapshot.truth is None else filled(messages.TruePose, snapshot.truth, 4),
        by_laser=by_laser(snapshot),
        route=route(parts[RouteService].run_now),
        chapter=around.chapter,
    )


def near(value: float) -> float:
    """A tenth of a millimetre, or of a milliradian, is near enough to be shown."""
    return round(float(value), 4)


def rounded(values: Array, digits: int) -> list[tuple[float, ...]]:
    return np.round(values.astype(np.float64), digits).tolist()


def short(covariance: Array) -> list[list[float]]:
    """Four digits of each element: half of every message would be the others."""
    return [[float(f"{value:.4g}") for value in row] for row in covariance.tolist()]


def pose(estimate: Estimate) -> messages.PoseState:
    at = estimate.pose
    return messages.PoseState(near(at.x), near(at.y), near(at.heading), short(estimate.covariance))


def by_laser(snapshot: Snapshot) -> messages.LaserReferenceState | None:
    """The position by laser and wheels alone, and how far it lies from the estimate."""
    if snapshot.by_laser is None:
        return None
    other, at = snapshot.by_laser.pose, snapshot.estimate.pose
    turn = math.remainder(other.heading - at.heading, math.tau)
    return messages.LaserReferenceState(pose(snapshot.by_laser), near(at.distance_to(other.x, other.y)), near(turn))


def landmark(row: Landmark) -> messages.LandmarkRow:
    x, y = row.position.tolist()
    return messages.LandmarkRow(row.id, near(x), near(y), short(row.covariance), row.hits, row.misses, row.kind)


def slam(snapshot: Snapshot, step_ms: float | None) -> messages.SlamState:
    """How the filter fares; without a time of its own, how long the step took that had most to see."""
    health = snapshot.slam
    error_m, error_rad, squared = accuracy(snapshot.estimate, snapshot.truth)
    update_ms = step_ms if health.update_ms is None else health.update_ms
    own = {"nees": squared, "error_m": error_m, "error_rad": error_rad, "update_ms": update_ms}
    return msgspec.convert({**vars(health), "nis_band": faded_band(NIS_FADE), **own}, messages.SlamState)


def command(status: ActiveCommandStatus) -> messages.CommandState:
    return msgspec.convert({**vars(status), **code_of(status.remark)._asdict()}, messages.CommandState)


def route(run: RouteRun | None) -> messages.RouteUnderWay | None:
    if run is None:
        return None
    place, stops, found = run.here.place, len(run.route.stops), code_of(run.reason)
    noted = run.notes[-1].at_s if run.notes else None
    return messages.RouteUnderWay(run.route.name, place, run.stop + 1, stops, run.state, run.reason, noted, *found)


def camera(view: CameraView, way: list[Array], goal: Array) -> messages.CameraOverlay:
    """Return all that is drawn on the newest picture; `way` and `goal` as `PictureFloor.drawn`."""
    edges: list[messages.EdgeLine] = []
    for edge in view.edges:
        (u0, v0), (u1, v1) = rounded(np.stack((edge.top, edge.bottom)), 1)
        edges.append(messages.EdgeLine(u0, v0, u1, v1, near(edge.bearing), edge.matched))
    laser = [(u, v, distance) for u, v, distance in rounded(view.laser, 2)]
    quality = picture.quality(view.quality)
    parts = [[(u, v, far) for u, v, far in rounded(part, 1)] for part in way]
    ring = [(u, v) for u, v in rounded(goal, 1)]
    return messages.CameraOverlay(view.stamp, view.width, view.height, edges, laser, quality, parts, ring)


def robot(snapshot: Snapshot, around: StateContext, rate_hz: float) -> messages.RobotState:
    """The robot and the link to it; `rate_hz`: frames per second that the pilot takes."""
    (link, age), profile = around.robot.link(), around.robot.profile
    return messages.RobotState(
        url=profile.url,
        kind=profile.kind,
        name=profile.name,
        link=link,
        age_s=round(age, 3),
        rate_hz=round(rate_hz, 1),
        pace=round(snapshot.pace, 2),
        contact=snapshot.contact,
        running=snapshot.running,
        progress=snapshot.progress,
        speed=around.parts[PlaybackController].speed,
        sensors=[
            messages.SensorLine(one.kind, one.name, one.state, round(one.age, 2), one.rate)
            for one in snapshot.sensors
        ],
        timings=[filled(messages.LaserTiming, one, 4) for one in snapshot.timings],
        agreement=agreement(snapshot.agreement),
        battery=snapshot.battery,
    )


def agreement(found: MoveAgreement | None) -> messages.MoveAgreementState | None:
    if found is None:
        return None
    scales = (found.turn_scale, found.turn_sd, found.way_scale, found.way_sd)
    return messages.MoveAgreementState(
        found.laser, found.turns, found.ways, *(None if scale is None else near(scale) for scale in scales)
    )


def gate(status: GateStatus, snapshot: Snapshot) -> messages.GateState:
    """The setpoint that the gate lets through; what blocks it, in the world frame."""
    blocked = None
    if status.blocked_by is not None:
        x, y = snapshot.estimate.pose.apply(np.array([status.blocked_by]))[0]
        blocked = messages.PointState(near(x), near(y))
    return filled(messages.GateState, status, 4, blocked_by=blocked, **code_of(status.reason)._asdict())


def lease(held: Lease, now: float) -> messages.LeaseState:
    """The lease at `now` [s]: the operator who drives, and who asks for control."""
    holder, request = held.holder, held.request
    shown = messages.LeaseState(holder and holder.name, holder and holder.id, held.epoch)
    if request is not None:
        shown.asked_by, shown.asked_by_id = request.person.name, request.person.id
        shown.answer_within_s = round(max(0.0, request.end - now), 1)
    return shown


def recorder(around: StateContext) -> messages.RecorderState | None:
    if "replay" in around.robot.profile.capabilities:
        return None
    service, revision = around.parts[RecorderService], around.parts[RecordingStore].revision
    now = service.state
    return messages.RecorderState(
        now.name, round(now.seconds, 1), now.bytes, round(now.ring_s, 1), service.ring_limit_s, revision
    )


def playback(state: PlaybackState | None, other: Comparison | None) -> messages.PlaybackView | None:
    """The ways of a recording, and how they differ."""
    if state is None:
        return None
    own = {"reached_speed": state.reached, "comparison": None if other is None else comparison(other)}
    return filled(messages.PlaybackView, state, **own)


def comparison(other: Comparison) -> messages.ComparisonState:
    """The other way, thinned for the page."""
    at, step = other.pose, max(1, math.ceil(len(other.trail) / MAX_TRAIL_POINTS))
    return filled(
        messages.ComparisonState,
        other,
        4,
        pose=filled(messages.TruePose, at, 4),
        trail=rounded(other.trail[::-step][::-1], DECIMAL_DIGITS),
        landmarks=rounded(other.landmarks, DECIMAL_DIGITS),
        recorded_landmarks=other.landmark_counts[0],
        computed_landmarks=other.landmark_counts[1],
        recorded_edges=other.edge_counts[0],
        computed_edges=other.edge_counts[1],
    )


def camera_view(camera: Camera) -> tuple[float, float]:
    """Azimuths [rad] in the robot frame of the picture's right and left edge, at the height of its middle."""
    model = camera.model
    across = (np.array([model.width, 0.0]) - model.cx) / model.fx
    rays = camera.mounting.rotation @ np.vstack([across, np.zeros(2), np.ones(2)])
    right, left = np.arctan2(rays[1], rays[0]).tolist()
    return right, left


def card(profile: Profile) -> messages.RobotCard:
    view = None if profile.camera is None else camera_view(profile.camera)
    own = {"camera_view_rad": view, "capabilities": sorted(profile.capabilities)}
    return filled(messages.RobotCard, profile, **own)


DECIMAL_DIGITS = 3
MAX_TRAIL_POINTS = 200  # of the other way of a recording


def late_command(late: LateCommand | None) -> messages.LateCommandState | None:
    return None if late is None else messages.LateCommandState(late.id, late.command.heard_as)


def pending_command(
    waiting: PendingCommand | None, snapshot: Snapshot, radius: float, now: float
) -> messages.PendingCommandState | None:
    """The pending command and its preview as the robot stands; `radius` [m] of the robot, `now` [s] monotonic."""
    if waiting is None:
        return None
    command = waiting.command
    seen, call = preview(command, snapshot, radius), caller(command, snapshot)
    heading = snapshot.estimate.pose.heading
    bearing = None if call is None else math.remainder(call.azimuth - heading, math.tau)
    return messages.PendingCommandState(
        id=waiting.id,
        name=command.name,
        numbers=dict(command.numbers),
        heard_as=command.heard_as,
        source=waiting.source,
        who=waiting.person.name,
        begins_in_s=round(max(0.0, waiting.when.begins - now), DECIMAL_DIGITS),
        delay_s=waiting.delay,
        target=spec_of(command.name).target,
        confidence=round(waiting.decision.confidence, 3),
        uncertain=waiting.decision.verdict == "confirm",
        alternatives=[one.heard_as for one in waiting.decision.alternatives],
        way=[(round(x, DECIMAL_DIGITS), round(y, DECIMAL_DIGITS)) for x, y in seen.path.tolist()],
        goal=None
        if seen.goal is None
        else (round(seen.goal[0], DECIMAL_DIGITS), round(seen.goal[1], DECIMAL_DIGITS)),
        heading_rad=None if seen.heading is None else round(seen.heading, DECIMAL_DIGITS),
        bearing_rad=None if bearing is None else round(bearing, DECIMAL_DIGITS),
        bearing_sd_rad=None if call is None else round(call.sd, DECIMAL_DIGITS),
    )
