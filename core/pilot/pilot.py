"""The pilot: for each frame of the robot, take commands, perceive, estimate, decide, publish."""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import replace

from core.calibration.laser.drift import MountWatch
from core.commands import spec_of
from core.commands.command import Command
from core.errors import Refused
from core.gate import ZERO, Twist
from core.geometry import Pose
from core.navigation.control_context import ControlContext, SteeredBody
from core.perception.people.colours import PersonProfile
from core.pilot.command_executor import CommandExecutor
from core.pilot.landmark_perception import LandmarkPerception
from core.pilot.motion_input import OdometrySource
from core.pilot.notices import Notices
from core.pilot.sound_perception import SoundPerception
from core.pilot.trail import NO_POINTS, MapTrail, Trail, frozen
from core.robots import Profile
from core.sensors import SensorFrame
from core.settings import Settings
from core.slam.dead_reckoning import DeadReckoning
from core.slam.estimate import Estimate, Landmark
from core.slam.map.map_file import SavedMap
from core.slam.map.occupancy import OccupancyGrid
from core.slam.mapper import AnchoredPose, Mapper
from core.slam.relocalization.monitor import LocalizationSettings
from core.slam.submap_manager import MapperSettings
from core.snapshot import Ending, Hearing, Snapshot


class DeferredCalls:
    """`put` from any thread; the pilot's thread opens them between two frames."""

    def __init__(self) -> None:
        self.between_frames = threading.Lock()  # held while a frame is worked on
        self._waiting: deque[Callable[[], object]] = deque()

    def put(self, request: Callable[[], object]) -> None:
        """Run this before the next frame."""
        self._waiting.append(request)

    def open(self) -> None:
        """Run the requests, in their order."""
        for _ in range(len(self._waiting)):
            self._waiting.popleft()()


LOOKING_AROUND = "Looking around before the first move…"
NO_SCAN = "No scan comes from the laser."
SCAN_LOST_AFTER = 0.5  # [s]
FOUND = "I know where I am again."
AGAIN = "The robot was somewhere else than it believed, and knows its place again; give the command once more."
NOTHING_YET = "There is no map yet; drive a little first."


class Pilot:
    """Owns perception, estimators, map and commands. One thread calls `step`; any thread may `tell` and `cancel`."""

    def __init__(self, profile: Profile, settings: Settings | None = None) -> None:
        self._profile = profile
        self._settings = settings or Settings()
        limits, planner = self._settings.limits, self._settings.planner
        self._body = SteeredBody(
            radius=profile.radius,
            cruise=min(profile.cruise, profile.max_speed, limits.max_speed),
            turn=min(SteeredBody().turn, profile.max_turn_rate, limits.max_turn_rate),
            max_speed=profile.max_speed,
            max_turn_rate=profile.max_turn_rate,
        )
        self._planner = replace(planner, guard=max(planner.guard, limits.margin + 0.005))
        self._executor = CommandExecutor()
        self._notices = Notices()
        self._doors = DeferredCalls()
        self._who: PersonProfile | None = None
        self._wake(math.inf)

    def _wake(self, stamp: float) -> None:
        """Reset everything: before the first frame, and after a jump back in a recording."""
        settings = self._settings
        self._stamp = self._scan_stamp = stamp
        self._feet = OdometrySource(self._profile.laser, settings.scan_odometry)
        self._eyes = LandmarkPerception(self._profile, settings)
        self._ears = SoundPerception(self._profile, settings.direction_finding)
        self._mount = MountWatch(settings.drift)
        self._floor = Mapper(parts_of(settings), self._profile.laser, watched=self._profile.drives)
        self._dead_reckoning = DeadReckoning(settings.motion)
        self._trail, self._dead_reckoning_trail = MapTrail(), Trail()
        self._contact = self._lost = False

    def tell(self, command_id: int, command: Command, source: str, who: str) -> None:
        """Execute this command from the next frame on; the one under way is pre-empted. Raises Refused."""
        if not self._profile.drives:
            raise Refused("This is a recording; it cannot be commanded. Connect a robot or the simulator.")
        lost = self._floor.lost
        if lost is not None and spec_of(command.name).moves and spec_of(command.name).needs_pose:
            raise Refused(f"Not now: {lost.words}")
        self._executor.tell(command_id, command, source, who)

    def cancel(self, state: Ending, why: str) -> None:
        """End the active command, in that state and for that reason."""
        self._executor.cancel(state, why)

    def look_through(self, profile: Profile) -> None:
        """See and hear with this profile from the next frame on: it was calibrated. From any thread."""
        self._profile = profile
        self._eyes.camera = profile.camera
        self._ears.hear_with(profile.microphones)

    def obey_only(self, who: PersonProfile | None) -> None:
        """Come to and follow only this person from the next frame on; None: anybody. From any thread."""
        self._doors.put(lambda: setattr(self, "_who", who))

    def undo_closure(self, number: int) -> None:
        """Take back a place that was recognised, from the next frame on. From any thread."""
        self._doors.put(lambda: self._floor.undo(number))

    def redo_closure(self, number: int) -> None:
        """Believe it again. From any thread."""
        self._doors.put(lambda: self._floor.redo(number))

    def place_at(self, x: float, y: float, heading: float | None = None) -> None:
        """The operator says "I am here": world [m], [rad]. From any thread."""
        self._doors.put(lambda: self._floor.place_at(x, y, heading))

    def enter_map(self, saved: SavedMap) -> None:
        """Go on in this map from the next frame on; the robot looks for its place in it. From any thread."""
        self._doors.put(lambda: self._enter(saved))

    def keep_map(self) -> SavedMap:
        """The whole map as it is between two frames. From any thread. Raises Refused while there is none."""
        with self._doors.between_frames:
            saved = self._floor.saved()
        if saved is None:
            raise Refused(NOTHING_YET)
        return saved

    def finish(self) -> tuple[tuple[Landmark, ...], OccupancyGrid]:
        """The log is over: let the map settle → its landmarks and its grid."""
        self._floor.finish()
        return self._floor.landmarks, self._floor.grid

    @property
    def stand(self) -> AnchoredPose:
        """The robot's pose, anchored so that `where` finds it on the map as it will be."""
        return self._floor.stand

    def where(self, stand: AnchoredPose) -> Pose:
        """Return an earlier anchored pose on the present map."""
        return self._floor.where(stand)

    def step(self, frame: SensorFrame) -> Snapshot:
        """Take one frame → its snapshot."""
        with self._doors.between_frames:
            self._doors.open()
            return self._step(frame)

    def _step(self, frame: SensorFrame) -> Snapshot:
        if frame.stamp < self._stamp - 1e-6:
            self._executor.end("failed", "The robot's clock was reset.")
            self._wake(frame.stamp)
        self._executor.open_inbox(frame.stamp)
        frame, move = self._feet.feel(frame)
        frame = self._eyes.without_repeats(frame)
        look = self._eyes.look(frame)
        self._floor.may_turn = self._needs_a_place
        estimate = self._floor.update(frame, look.sightings, look.ends, look.hits, move)
        dead_reckoning = self._dead_reckoning.update(frame, look.sightings, move)
        self._mount.watch(frame.stamp, estimate.pose, look.pairs, self._eyes.camera)
        hearing = self._ears.hear(frame.sound, frame.stamp, estimate)
        self._watch(frame)
        twist = self._decide(frame, estimate.pose)
        self._stamp = frame.stamp
        return self._publish(frame, estimate, dead_reckoning, hearing, twist)

    def _enter(self, saved: SavedMap) -> None:
        """Forget the present map and take this one."""
        self._executor.end("failed", "Another map was loaded.")
        self._trail, self._dead_reckoning_trail = MapTrail(), Trail()
        self._floor = Mapper(parts_of(self._settings), self._profile.laser, self._profile.drives, saved)

    def _decide(self, frame: SensorFrame, pose: Pose) -> Twist:
        """Return the twist to ask of the gate."""
        if self._executor.active_command is None:
            return ZERO
        lost = self._floor.lost
        if lost is not None and self._needs_a_place:
            return self._executor.only_turn(self._floor.turn, lost.words, frame.stamp - self._stamp)
        wait_for = LOOKING_AROUND if self._floor.looking_around else ""
        return self._executor.drive(self._surroundings(frame, pose), wait_for)

    @property
    def _needs_a_place(self) -> bool:
        """True while a command is under way that moves the robot to a place."""
        doing = self._executor.active_command
        return doing is not None and spec_of(doing.name).moves and spec_of(doing.name).needs_pose

    def _surroundings(self, frame: SensorFrame, pose: Pose) -> ControlContext:
        wheels = frame.wheels
        return ControlContext(
            stamp=frame.stamp,
            pose=pose,
            speed=wheels.speed if wheels else 0.0,
            turn_rate=wheels.turn_rate if wheels else 0.0,
            body=self._body,
            grid=self._floor.grid,
            scan_points=frozen(pose.inverse().apply(self._floor.points)),
            planner=self._planner,
            steering=self._settings.steering,
            wall=self._settings.wall,
            image=frame.image,
            camera=self._eyes.camera,
            call=self._ears.call,
            company=self._settings.person_following,
            people=self._settings.people,
            tracking=self._settings.tracking,
            who=self._who,
        )

    def _watch(self, frame: SensorFrame) -> None:
        """Tell the operator what goes wrong; a contact ends what is under way."""
        if frame.contact and not self._contact:
            self._executor.end("failed", "The robot touched something and stopped.")
            self._notices.add(frame.stamp, "warning", "The robot touches something.")
        self._contact = frame.contact
        lost = self._floor.lost
        if self._needs_a_place and lost is None and self._lost and self._floor.strayed:
            self._executor.end("failed", AGAIN)
        elif self._needs_a_place and lost is not None and lost.phase == "asking":
            self._executor.end("failed", lost.words)
        self._lost = lost is not None
        self._notices.watch(frame.stamp, "place", lost.words if lost else "", "warning", self._floor.found or FOUND)
        if frame.scan is not None:
            self._scan_stamp = frame.stamp
        overdue = frame.stamp - self._scan_stamp > SCAN_LOST_AFTER
        blind = overdue and self._profile.drives and self._profile.laser is not None
        self._notices.watch(frame.stamp, "laser", NO_SCAN if blind else "", "error", "The laser is back.")
        self._notices.watch(frame.stamp, "camera", self._eyes.trouble, "warning", "The pictures can be used again.")
        sound = self._ears.trouble
        self._notices.watch(frame.stamp, "microphones", sound, "warning", "The sound can be used again.")
        self._notices.watch(frame.stamp, "picture", self._eyes.poor, "warning", "The camera sees well enough again.")
        self._notices.watch(frame.stamp, "mount", self._mount.alarm, "warning", "The camera sits as calibrated.")
        self._notices.watch_pace(frame.stamp, frame.pace)
        if frame.note:
            self._notices.add(frame.stamp, "info", frame.note)

    def _publish(
        self, frame: SensorFrame, estimate: Estimate, dead_reckoning: Estimate, hearing: Hearing | None, twist: Twist
    ) -> Snapshot:
        """All of it in one value."""
        wheels, doing = frame.wheels, self._executor
        return Snapshot(
            stamp=frame.stamp,
            estimate=estimate,
            dead_reckoning=dead_reckoning,
            velocity=Twist(wheels.speed, wheels.turn_rate) if wheels else ZERO,
            setpoint=twist,
            setpoint_press=doing.active_command.id if doing.active_command else 0,
            nonce=frame.nonce,
            scan_points=frozen(self._floor.points),
            landmarks=self._floor.landmarks,
            associations=self._floor.associations,
            slam=self._floor.slam,
            floor=self._floor.health,
            grid=self._floor.grid,
            trail=self._trail.add(self._floor),
            dead_reckoning_trail=self._dead_reckoning_trail.add(dead_reckoning.pose.x, dead_reckoning.pose.y),
            path=NO_POINTS if doing.path is None else doing.path,
            goal=doing.goal,
            active_command=doing.active_command,
            endings=doing.take_endings(),
            view=self._eyes.view,
            hearing=hearing,
            person=doing.person,
            drift=self._mount.drift,
            notices=self._notices.newest,
            contact=frame.contact,
            running=frame.running,
            progress=frame.progress,
            truth=frame.truth,
        )


def parts_of(settings: Settings) -> MapperSettings:
    """Return the settings of the mapper."""
    return MapperSettings(
        floor=settings.submaps,
        matching=settings.matching,
        closures=settings.closures,
        ekf=settings.ekf,
        motion=settings.motion,
        occupancy=settings.occupancy,
        lost=LocalizationSettings(alarm=settings.localization_monitor),
    )
