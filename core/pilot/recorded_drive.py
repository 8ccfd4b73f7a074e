"""A recorded drive in its two ways: as recorded, and as computed now from the raw readings.

Both are snapshots of one stamp. What is computed now takes each frame with all that the pilot of that day took with
it, so the same settings give the same poses, map, edges and directions to the last bit.
"""

import math
from dataclasses import dataclass, field, replace
from typing import Any

import msgspec
import numpy as np

from core.errors import BadInput
from core.gate import ZERO, Twist
from core.geometry import Pose, wrap
from core.message import Array, message
from core.perception.landmarks.deskew import beam_ends
from core.pilot.drive_record import (
    MAP_NAME,
    command_of,
    digest_of,
    edges_of,
    inputs_of,
    landmarks_of,
    path_of,
    voices_of,
)
from core.pilot.pilot import BegunDrive, Pilot
from core.pilot.trail import NO_POINTS, Trail, frozen
from core.recording.drive import DriveMoment, DriveRecording, text_of
from core.recording.frame_record import ROBOT, WHOLE_MAP, ResultRecord, RobotRecord, TakenRecord
from core.recording.ros import Envelope, decode
from core.robots import Profile
from core.robots.profile_json import profile_from_json
from core.robots.requests import PlaybackState
from core.sensors import Laser, SensorFrame
from core.sentences import Statement
from core.settings import Settings
from core.slam.estimate import Estimate, Landmark, SlamHealth
from core.slam.map.map_file import SavedMap
from core.slam.map.occupancy import OccupancyGrid
from core.slam.motion import Increment
from core.snapshot import ActiveCommandStatus, CameraView, Comparison, Hearing, PilotInputs, Snapshot

COMPUTING_BUDGET_S = 0.05  # [s] of computing for one frame of the page; then the page is shown where it has come to
MAP = "/map"  # topic
MAP_DELAY_S = 1.0  # [s] after the beginning of a recording by which its map may come
MAX_ODDS = 8.0  # log odds of a cell that is held to be sure
AS_RECORDED = SlamHealth(mode="recorded")
EMPTY_GRID = OccupancyGrid(revision=0, resolution=0.05, origin=np.zeros(2), log_odds=np.zeros((0, 0), np.float32))
NO_COVARIANCE = np.zeros((3, 3))


@message
class ReplayFrame(SensorFrame):
    """A frame with what is shown of it: nothing is left to be computed."""

    shown: Snapshot
    playback: PlaybackState


@dataclass(frozen=True)
class RecordedRobot:
    """The robot of a recording, as built and as calibrated then."""

    built: Profile
    used: Profile


def robot_of(drive: DriveRecording, at: float = 0.0) -> RecordedRobot:
    """The robot as it was `at` [s] from the start. Raises BadInput where the recording does not describe it."""
    found = drive.latest(ROBOT, at) or next(drive.every(ROBOT), None)
    if found is None:
        raise BadInput(f"{drive.path.name} does not say which robot it was recorded of.")
    try:
        record = msgspec.json.decode(text_of(found), type=RobotRecord)
    except (msgspec.MsgspecError, ValueError):
        raise BadInput(f"The robot's description in {drive.path.name} is damaged.") from None
    return RecordedRobot(profile_from_json(bytes(record.built)), profile_from_json(bytes(record.used)))


class AsRecorded:
    """The results of that day, from moment to moment."""

    def __init__(self, profile: Profile) -> None:
        self._lasers = {laser.name: laser for laser in profile.lasers}
        self._laser = profile.laser or Laser()
        self._trail, self._drifted = Trail(), Trail()
        self._points, self._landmarks, self._grid = NO_POINTS, (), EMPTY_GRID
        self._view: CameraView | None = None
        self._endings: tuple[ActiveCommandStatus, ...] = ()  # since the newest snapshot
        self.digest = ""  # of the newest map that was sent, as it was then

    def begin(self, grid: Envelope | None, landmarks: tuple[Landmark, ...], trail: Array = NO_POINTS) -> None:
        """Go on from another place in the recording, with what was known there."""
        self._trail, self._drifted = Trail(), Trail()
        self._trail.follow(trail)
        self._points, self._landmarks, self._view = NO_POINTS, landmarks, None
        self._grid = EMPTY_GRID if grid is None else self._decoded(grid)

    def take(self, moment: DriveMoment, *, newest: bool = True) -> Snapshot | None:
        """One moment → what was shown of it; None where nothing was computed that day, or it is not the newest.

        Of a moment that is not, no picture and no scan is decoded.
        """
        results = moment.results
        if results is None:
            return None
        for one in moment.others:
            if one.topic == MAP:
                self._grid, self.digest = self._decoded(one), results.map_digest
        if results.landmarks is not None:
            self._landmarks = landmarks_of(results.landmarks)
        pose, dead = Pose(*results.pose), Pose(*results.dead_reckoning)
        self._endings = (*self._endings, *(end for row in results.endings if (end := command_of(row)) is not None))
        if not newest:
            self._trail.add(pose.x, pose.y)
            self._drifted.add(dead.x, dead.y)
            return None
        frame = moment.frame
        self._see(frame, pose)
        image = frame.image
        if results.edges is not None and image is not None:
            height, width = image.pixels.shape[:2]
            edges = edges_of(results.edges)
            self._view = CameraView(
                stamp=image.stamp, width=width, height=height, edges=edges, laser=np.zeros((0, 3))
            )
        return self._snapshot(frame, results, pose, dead)

    def _snapshot(self, frame: SensorFrame, results: ResultRecord, pose: Pose, dead: Pose) -> Snapshot:
        voices, endings, self._endings = voices_of(results.voices), self._endings, ()
        return Snapshot(
            stamp=frame.stamp,
            estimate=Estimate(pose=pose, covariance=np.array(results.covariance).reshape(3, 3)),
            dead_reckoning=Estimate(pose=dead, covariance=NO_COVARIANCE),
            increment=Increment(),
            velocity=Twist(*results.velocity),
            setpoint=ZERO,
            scan_points=self._points,
            landmarks=self._landmarks,
            slam=AS_RECORDED,
            grid=self._grid,
            trail=self._trail.add(pose.x, pose.y),
            dead_reckoning_trail=self._drifted.add(dead.x, dead.y),
            path=path_of(results.path),
            goal=None if results.goal is None else np.array(results.goal),
            active_command=command_of(results.command),
            endings=endings,
            view=self._view,
            hearing=Hearing(listening=frame.sound is not None, speaking=False, level_db=None, voices=voices),
            contact=frame.contact,
            battery=frame.battery,
            truth=frame.truth,
        )

    def _see(self, frame: SensorFrame, pose: Pose) -> None:
        if frame.scan is None:
            return
        laser = self._lasers.get(frame.scan.laser, self._laser)
        ends, hits = beam_ends(frame.scan, laser, frame.wheels, frame.stamp)
        self._points = frozen(pose.apply(ends[hits]))

    def _decoded(self, one: Envelope) -> OccupancyGrid:
        content: Any = decode(one, one.kind)
        info, place = content.info, content.info.origin
        chance = np.asarray(content.data, np.float32).reshape(info.height, info.width)
        share = np.clip(chance / 100, 0.02, 0.98)
        odds = np.where(chance < 0, 0.0, np.clip(np.log(share / (1 - share)), -MAX_ODDS, MAX_ODDS))
        corner = place.position
        return OccupancyGrid(
            revision=self._grid.revision + 1,
            resolution=float(info.resolution),
            origin=np.array([corner.x, corner.y]),
            log_odds=odds.astype(np.float32),
        )


class ComputedNow:
    """Everything estimated again from the raw readings, from one moment on."""

    def __init__(self, drive: DriveRecording, settings: Settings) -> None:
        self._drive, self._settings = drive, settings
        self._pilot: Pilot | None = None
        self.recorded_from_computed = Pose()  # not equal where what is computed began in the middle of a drive
        self.since = 0.0  # [s] from the start of the recording
        self.whole = False  # it began with the first frame of a pilot, as that day
        self.resumed = False  # it began in the map that was there
        self.why_empty = ""  # why it did not, where one was under way

    def take(self, moment: DriveMoment) -> Snapshot:
        """One moment → what is computed of it. Raises BadInput where the recording does not describe its robot."""
        taken = TakenRecord() if moment.record is None else moment.record.taken or TakenRecord()
        inputs = inputs_of(moment.frame, taken)
        begins = self._pilot is None
        if self._pilot is None or taken.first:
            self.since = moment.logged - self._drive.start
            self.whole = taken.first and (begins or self.whole)
            snapshot = self._begin(inputs, None if taken.first else moment)
        else:
            snapshot = self._pilot.repeat(inputs)
        if begins:
            self.recorded_from_computed = self._found(moment, snapshot.estimate.pose)
        return snapshot

    def _begin(self, inputs: PilotInputs, moment: DriveMoment | None) -> Snapshot:
        """Begin with a new pilot; `moment`: one was under way then."""
        robot = robot_of(self._drive, self.since)
        self._pilot = Pilot(robot.built, self._settings)
        if moment is None:
            return self._pilot.repeat(inputs)
        try:
            begun = self._held(moment, robot.used)
            snapshot = self._pilot.repeat(inputs, begun)
            self.resumed = begun.saved is not None
            self.why_empty = "" if self.resumed else Statement("recording.no_map")
        except BadInput as trouble:  # the map is damaged, or does not suit these settings
            self.why_empty = str(trouble)
            self._pilot = Pilot(robot.built, self._settings)
            snapshot = self._pilot.repeat(inputs, BegunDrive(used=robot.used))
        return snapshot

    def _held(self, moment: DriveMoment, used: Profile) -> BegunDrive:
        """Return what the pilot of that day held, in the newest map that was kept. Raises BadInput: it is damaged."""
        results, kept = moment.results, self._drive.latest(WHOLE_MAP, self.since + MAP_DELAY_S)
        if kept is None or results is None:
            return BegunDrive(used=used)
        content = decode(kept, kept.kind).data.tobytes()
        return BegunDrive(
            used=used,
            saved=SavedMap.from_bytes(content, MAP_NAME),
            pose=Pose(*results.pose),
            covariance=np.array(results.covariance).reshape(3, 3),
        )

    def _found(self, moment: DriveMoment, pose: Pose) -> Pose:
        """Return where the computed world lies in the recorded one: the robot stood at one place."""
        if moment.results is None or self.whole or self.resumed:
            return Pose()
        return Pose(*moment.results.pose) @ pose.inverse()

    def settle(self) -> tuple[tuple[Landmark, ...], OccupancyGrid]:
        """The drive is over → landmarks and map."""
        return ((), EMPTY_GRID) if self._pilot is None else self._pilot.finish()


@dataclass
class Comparer:
    """The difference of the two ways in numbers, since what is computed began."""

    frames: int = 0
    worst: float = 0.0  # [m]
    same: bool = True  # poses, edges, directions and maps until now, to the last bit
    _digest: str = field(default="", repr=False)  # of the recorded map that was compared last
    _maps: tuple[str, str] = ("", "")

    def compare(self, moment: DriveMoment, recorded: Snapshot, computed: Snapshot, drawn: Pose) -> Comparison:
        """Compare two snapshots of one moment; `drawn`: recorded_from_computed."""
        results, computed_pose = moment.results, computed.estimate.pose
        there = drawn @ computed_pose
        here = recorded.estimate.pose
        apart = here.distance_to(there.x, there.y)
        edges, directions = _edges(recorded), _directions(recorded)
        edges_now, directions_now = _edges(computed), _directions(computed)
        same = (
            here == computed_pose
            and np.array_equal(recorded.estimate.covariance, computed.estimate.covariance)
            and directions == directions_now
            and (results is None or results.edges is None or edges == edges_now)
        )
        if results is not None and results.map_digest:
            self._maps = results.map_digest, digest_of(computed.grid)
            same = same and self._maps[0] == self._maps[1]
        self.frames, self.worst, self.same = self.frames + 1, max(self.worst, apart), self.same and same
        return Comparison(
            pose=there,
            trail=frozen(drawn.apply(computed.trail)),
            landmarks=frozen(drawn.apply(_places(computed))),
            distance=apart,
            turn=wrap(there.heading - here.heading),
            worst=self.worst,
            landmark_counts=(len(recorded.landmarks), len(computed.landmarks)),
            edge_counts=(len(edges), len(edges_now)),
            direction=_direction_apart(recorded, computed),
            frames=self.frames,
            same=self.same,
        )


def seen_from_computed(comparison: Comparison, recorded: Snapshot, drawn: Pose) -> Comparison:
    """The same comparison where what is computed is shown, and what was recorded lies over it."""
    back = drawn.inverse()
    return replace(
        comparison,
        pose=back @ recorded.estimate.pose,
        trail=frozen(back.apply(recorded.trail)),
        landmarks=frozen(back.apply(_places(recorded))),
        turn=-comparison.turn,
    )


def landmarks_with(drive: DriveRecording, grid: Envelope) -> tuple[Landmark, ...]:
    """The landmarks that were written with a map."""
    moment = drive.moment_of(grid)
    results = None if moment is None else moment.results
    return () if results is None or results.landmarks is None else landmarks_of(results.landmarks)


def _edges(snapshot: Snapshot) -> list[tuple[float, ...]]:
    view = snapshot.view
    return [] if view is None else [(*edge.top, *edge.bottom, edge.bearing, edge.step) for edge in view.edges]


def _directions(snapshot: Snapshot) -> list[tuple[float, ...]]:
    voices = () if snapshot.hearing is None else snapshot.hearing.voices
    return [(one.id, one.stamp, one.azimuth_world, one.sd, one.strength) for one in voices]


def _direction_apart(recorded: Snapshot, computed: Snapshot) -> float | None:
    """The angle [rad] between the voices that were heard last, in the robot's frame; None where one is missing."""
    ours, theirs = (() if one.hearing is None else one.hearing.voices for one in (recorded, computed))
    return math.remainder(theirs[0].azimuth - ours[0].azimuth, math.tau) if ours and theirs else None


def _places(snapshot: Snapshot) -> Array:
    return np.array([one.position for one in snapshot.landmarks]).reshape(-1, 2)
