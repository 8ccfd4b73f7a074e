"""The pilot: hear and see, estimate, decide, publish, for each frame of the robot."""

import math
import threading
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import field, replace

import numpy as np

from core.calibration.laser.drift import MountWatch
from core.commands import spec_of
from core.commands.command import Command
from core.errors import Refused
from core.gate import ZERO, Twist
from core.geometry import Pose
from core.message import Array, message
from core.navigation.control_context import ControlContext, SteeredBody
from core.navigation.zones import KeepOuts, SlowZones
from core.perception.people.appearance import PersonProfile
from core.perception.people.looking import PersonLook
from core.perception.people.voice_bearing import likeliest
from core.pilot.command_executor import AcceptedCommand, CommandExecutor
from core.pilot.landmark_perception import LandmarkPerception
from core.pilot.laser_reference import LaserReference
from core.pilot.notices import KEEPS_UP, SLOW, Notices
from core.pilot.scan_timing import ScanTiming
from core.pilot.sensor_watch import SensorWatch, loss, recovery
from core.pilot.sound_perception import SoundPerception
from core.pilot.trail import NO_POINTS, MapTrail, Trail, frozen
from core.recording.frame_record import ClosureAct, EditAct, PlaceAct, TurnAct
from core.robots import Profile
from core.robots.repeated_readings import RepeatedReadings
from core.sensors import Fault, SensorFrame, Wheels
from core.sensors.checks import distinct
from core.sentences import Statement
from core.settings import Settings
from core.slam.dead_reckoning import DeadReckoning
from core.slam.estimate import Estimate, Landmark
from core.slam.map.edits import MapEdit, MapEdits
from core.slam.map.map_file import SavedMap
from core.slam.map.occupancy import OccupancyGrid
from core.slam.mapper import AnchoredPose, Mapper
from core.slam.motion import Motion
from core.slam.odometry import Odometry
from core.slam.scan_matching.agreement import MoveAgreement
from core.slam.submap_manager import MapperSettings
from core.snapshot import Ending, Hearing, Level, PilotAct, PilotInputs, Snapshot

AGAIN = Statement("pilot.strayed")
BLIND = Statement("pilot.blind")
NO_ODOMETRY = Statement("pilot.no_odometry")
MAX_WAIT_S = 2.0  # [s] that a command waits for odometry


@message
class BegunDrive:
    """State of a pilot in the middle of a drive, where a recording of it begins."""

    used: Profile  # as calibrated
    saved: SavedMap | None = None  # its map
    pose: Pose = Pose()  # in that map
    covariance: Array = field(default_factory=lambda: np.zeros((3, 3)))


class Inbox:
    """Requests of other threads to the pilot, in the order in which they came."""

    def __init__(self) -> None:
        self.between_frames = threading.Lock()  # held while a frame is worked on
        self._waiting: deque[tuple[Callable[[float], object], PilotAct | None]] = deque()

    def put(self, request: Callable[[float], object], act: PilotAct | None = None) -> None:
        """Call this with the stamp [s] of the next frame, before anything else is made of it. From any thread.

        `act`: what it is, where it changes the estimate.
        """
        self._waiting.append((request, act))

    def open(self, stamp: float) -> tuple[PilotAct, ...]:
        """Do what was asked for until now → what of it changes the estimate. From the pilot's thread."""
        acts: list[PilotAct] = []
        for _ in range(len(self._waiting)):
            request, act = self._waiting.popleft()
            request(stamp)
            acts += [] if act is None else [act]
        return tuple(acts)


class Pilot:
    """Owns perception, estimators, map and commands. One thread calls `step`; any thread may `tell` and `cancel`."""

    def __init__(self, profile: Profile, settings: Settings | None = None) -> None:
        self._profile = profile
        self._settings = of_robot(settings or Settings(), profile)
        limits, planner = self._settings.limits, self._settings.planner
        self._body = SteeredBody(
            radius=profile.radius,
            cruise=min(profile.cruise, profile.max_speed, limits.max_speed),
            turn=min(SteeredBody().turn, profile.max_turn_rate, limits.max_turn_rate),
            max_speed=profile.max_speed,
            max_turn_rate=profile.max_turn_rate,
        )
        self._planner = replace(planner, guard=max(planner.guard, limits.margin + 0.005))
        self._executor = CommandExecutor(dry=not profile.drives)
        self._notices = Notices()
        self._inbox = Inbox()
        self._who: PersonProfile | None = None
        self._keep_outs, self._slow_zones = KeepOuts(), SlowZones()
        self._ground: tuple[OccupancyGrid, KeepOuts, OccupancyGrid] | None = None  # a grid and the same with zones
        self._edited: tuple[OccupancyGrid, MapEdits, OccupancyGrid] | None = None  # what was seen, and with edits
        self._hidden: tuple[tuple[Landmark, ...], OccupancyGrid, tuple[Landmark, ...]] | None = None
        self._look: PersonLook | None = None
        self.frame = SensorFrame(stamp=-math.inf)  # the newest, for the console: what is used, with its own stamps
        self._doing = ""  # name of the command that was under way when the newest frame came
        self._first = True  # no frame was taken yet
        self._reset(math.inf)

    def _reset(self, stamp: float) -> None:
        settings = self._settings
        self._stamp = stamp
        self._sensors, self._repeats = SensorWatch(self._profile, stamp), RepeatedReadings(self._profile)
        self._wheels: Wheels | None = None  # of the frame before
        self._rolls = False  # there are wheels; without, only scans that repeat say that the robot stands
        self._odometry = Odometry(self._profile.laser, settings.motion, settings.scan_odometry)
        self._timing = ScanTiming(self._profile, settings.time_offset)
        self._vision = LandmarkPerception(self._profile, settings)
        self._hearing = SoundPerception(self._profile, settings.direction_finding)
        self._mount = MountWatch(settings.drift)
        self._mapper = Mapper(parts_of(settings), self._profile.laser, watched=self._profile.drives)
        self._edits = MapEdits()
        self._reference = self._compare_with_laser(None, None)
        self._dead_reckoning = DeadReckoning()
        self._trail, self._dead_reckoning_trail = MapTrail(), Trail()
        self._contact = self._lost = False
        self._scanned = -math.inf  # [s] of the newest scan

    # from any thread

    def tell(self, command_id: int, command: Command, source: str, who: str) -> None:
        """Execute this command from the next frame on; the one under way is pre-empted. Raises Refused."""
        if why := self._profile.refusal(spec_of(command.name)):
            raise Refused(why)
        if self._is_blind and spec_of(command.name).moves:
            raise Refused(BLIND)
        lost = self._mapper.lost
        if lost is not None and self._profile.drives and _goes_to_a_place(command.name):
            raise Refused(Statement("command.not_now", why=lost.words))
        if why := self._forbidden(command):
            raise Refused(why)
        accepted = AcceptedCommand(command_id, command, source, who)
        self._inbox.put(lambda stamp: self._executor.accept(self._located(accepted), stamp))

    def cancel(self, state: Ending, why: str) -> None:
        """End every command that came before this, in that state and for that reason."""
        self._inbox.put(lambda _: self._executor.end(state, why))

    def look_through(self, profile: Profile) -> None:
        """See and hear with this profile from the next frame on: it was calibrated."""
        self._act(profile)

    def obey_only(self, who: PersonProfile | None) -> None:
        """Come to and follow only this person from the next frame on; None: anybody."""
        self._inbox.put(lambda _: setattr(self, "_who", who))

    def heed(self, keep_outs: KeepOuts, slow: SlowZones) -> None:
        """Enter none of the first zones and be slow in the others from now on: the next command is judged by them."""
        self._keep_outs, self._slow_zones = keep_outs, slow

    def drive_with(self, settings: Settings) -> None:
        """Take the settings of driving, walls and people, which are read with every frame, from the next frame on."""
        self._inbox.put(lambda _: setattr(self, "_settings", live(self._settings, settings)))

    def find_people_with(self, look: PersonLook | None) -> None:
        """Ask this for people in pictures, from the next command on; None: the embedded detector."""
        self._inbox.put(lambda _: setattr(self, "_look", look))

    def believe_closure(self, number: int, believed: bool) -> None:
        """Take back a place that was recognised, or believe it again, from the next frame on."""
        self._act(ClosureAct(number, believed))

    def place_at(self, x: float, y: float, heading: float | None = None) -> None:
        """The operator says "I am here": world [m], [rad]."""
        self._act(PlaceAct(x, y, heading))

    def edit_map(self, edits: MapEdits) -> None:
        """Lay these edits over what was seen, and no others, from the next frame on."""
        self._act(
            EditAct(
                tuple(
                    (edit.kind, float(edit.width), tuple((x, y) for x, y in edit.points.tolist()))
                    for edit in edits.edits
                )
            )
        )

    def turn_map(self, angle: float) -> None:
        """Turn the map, and the robot in it, about the origin of the world by `angle` [rad]."""
        self._act(TurnAct(angle))

    def enter_map(self, saved: SavedMap) -> None:
        """Go on in this map from the next frame on; the robot looks for its place in it."""
        self._act(saved)

    def _act(self, act: PilotAct) -> None:
        self._inbox.put(lambda _: self._perform(act), act)

    def keep_map(self) -> SavedMap:
        """The whole map as it is between two frames. Raises Refused while there is none."""
        with self._inbox.between_frames:
            saved = self._mapper.saved()
        if saved is None:
            raise Refused(Statement("pilot.no_map_yet"))
        return saved

    # from the pilot's thread

    def finish(self) -> tuple[tuple[Landmark, ...], OccupancyGrid]:
        """The log is over: let the map settle → its landmarks and its grid."""
        self._mapper.finish()
        self._odometry.agreement.finish()
        return self._mapper.landmarks, self._mapper.grid

    @property
    def faults(self) -> tuple[Fault, ...]:
        """Faults found in the readings over time: contradictions between the senses, sensors that hang."""
        return (*self._disagreements, *self._repeats.faults)

    @property
    def agreement(self) -> MoveAgreement:
        """Moves by the wheels over those by the scans, with their deviations."""
        return self._odometry.agreement.compared

    @property
    def _disagreements(self) -> tuple[Fault, ...]:
        """Return what wheels and scans do not agree on; of one fault that both find, the finer figure."""
        return distinct((*self._odometry.faults, *self._timing.faults))

    @property
    def anchored_pose(self) -> AnchoredPose:
        """The robot's pose, anchored so that `where` finds it on the map as it will be."""
        return self._mapper.anchored_pose

    def where(self, stand: AnchoredPose) -> Pose:
        """Return an earlier anchored pose on the present map."""
        return self._mapper.where(stand)

    def step(self, frame: SensorFrame, *, deaf: bool = False) -> Snapshot:
        """Take one frame → its snapshot; `deaf`: its sound is not listened to."""
        with self._inbox.between_frames:
            self._begin_again_after_a_seek(frame.stamp)
            acts, first, self._first = self._inbox.open(frame.stamp), self._first, False
            doing = self._executor.active_command
            name = "" if doing is None else doing.name
            return self._take(PilotInputs(frame=frame, deaf=deaf, doing=name, acts=acts, first=first))

    def repeat(self, inputs: PilotInputs, begun: BegunDrive | None = None) -> Snapshot:
        """Take a recorded frame with all that the pilot of that day took with it → its snapshot.

        Nothing is obeyed again: which command was under way stands in the inputs. `begun`: what a pilot that was
        under way then held before this frame. Raises BadInput where its map does not suit the settings.
        """
        with self._inbox.between_frames:
            self._begin_again_after_a_seek(inputs.frame.stamp)
            if begun is not None:
                self._adopt(begun.used)
                if begun.saved is not None:
                    self._enter(begun.saved)
                    self._mapper.resume_at(begun.pose, begun.covariance)
            for act in inputs.acts:
                self._perform(act)
            return self._take(inputs)

    def _take(self, inputs: PilotInputs) -> Snapshot:
        frame, self._doing = inputs.frame, inputs.doing
        frame = replace(frame, sound=None) if inputs.deaf else frame
        self._rolls |= frame.wheels is not None
        frame = self._repeats.taken_out(frame, self._wheels if self._rolls or self._profile.drives else None)
        self._sensor_status = self._sensors.update(frame)
        frame = self._sensors.believed(frame)
        self._vision.take_second(frame.image)
        self.frame = frame = self._profile.first_view(frame)
        motion = self._odometry.update(frame)
        self._wheels = motion.wheels
        frame = self._timing.correct(frame, motion, self._odometry.agreement.lateness)
        seen = self._vision.look(frame, motion, self._is_idle)
        voices = self._hearing.listen(frame.sound, frame.stamp, motion.increment)
        self._scanned = self._scanned if frame.scan is None else frame.stamp
        estimate = self._mapper.update(frame, seen, motion, voices, self._needs_a_place)
        reference = self._reference and self._reference.update(frame, motion, self._is_idle)
        dead_reckoning = self._dead_reckoning.update(motion.increment)
        self._mount.watch(frame.stamp, estimate.pose, seen.pairs, self._vision.camera)
        hearing = self._hearing.hear(frame.stamp, estimate)
        self._report(frame)
        twist = self._decide(frame, motion, estimate.pose)
        self._stamp = frame.stamp
        snapshot = self._publish(frame, motion, estimate, dead_reckoning, hearing, twist)
        return replace(snapshot, inputs=inputs, by_laser=reference)

    def _located(self, accepted: AcceptedCommand) -> AcceptedCommand:
        """A command to a person with the directions that were heard in its words, where that is remembered."""
        command = accepted.command
        if command.said is None or spec_of(command.name).target != "person":
            return accepted
        if self._sensors.untimely("microphones"):
            return replace(accepted, command=replace(command, call=None, others=()))
        sure = self._settings.person_following.sure
        heard = tuple(one for one in self._hearing.heard_in(*command.said) if one.sd <= sure)
        if not heard:
            return accepted
        newest = command.said[1] if command.call is None else max(command.said[1], command.call.stamp)
        call = replace(likeliest(heard)[0], strength=1.0, stamp=newest)  # as old as the voice: others may talk on
        return replace(accepted, command=replace(command, call=call, others=heard))

    def _begin_again_after_a_seek(self, stamp: float) -> None:
        """A recording that jumped back in time, or a robot whose clock began again, starts from the beginning."""
        if stamp < self._stamp - 1e-6:
            if not self._first:
                self._keep_outs, self._slow_zones = KeepOuts(), SlowZones()  # which lay on the map that is gone
            self._executor.end("failed", Statement("pilot.clock_reset"))
            self._reset(stamp)

    def _perform(self, act: PilotAct) -> None:
        match act:
            case PlaceAct(x, y, heading):
                for mapper in self._mappers:
                    mapper.place_at(x, y, heading)
            case ClosureAct(number, believed):
                self._mapper.believe(number, believed)
            case EditAct(edits):
                self._edits = MapEdits(tuple(MapEdit(kind, np.array(at), width) for kind, width, at in edits))
            case TurnAct(angle):
                self._executor.end("failed", Statement("pilot.other_map"))
                for mapper in self._mappers:
                    mapper.turn_map(angle)
            case SavedMap():
                self._enter(act)
            case _:
                self._adopt(act)

    def _adopt(self, profile: Profile) -> None:
        self._profile = profile
        self._vision.camera = profile.camera
        self._hearing.hear_with(profile.microphones)

    def _enter(self, saved: SavedMap) -> None:
        self._executor.end("failed", Statement("pilot.other_map"))
        self._trail, self._dead_reckoning_trail, self._edits = MapTrail(), Trail(), MapEdits()
        believed = self._mapper.pose_in(saved)
        former = self._mapper.graph.revision
        self._mapper = Mapper(parts_of(self._settings), self._profile.laser, self._profile.drives, saved, believed)
        self._mapper.graph.revision += former + 1  # another map, whatever the number of its own changes
        self._reference = self._compare_with_laser(saved, believed)

    def _compare_with_laser(self, saved: SavedMap | None, believed: Pose | None) -> LaserReference | None:
        """The reference by laser alone, in the same map; None: it is not asked for, or there is no laser."""
        profile, settings = self._profile, self._settings
        if not settings.chapter.laser_reference or profile.laser is None:
            return None
        mapper = Mapper(parts_of(settings), profile.laser, profile.drives, saved, believed)
        return LaserReference(profile, settings, mapper)

    @property
    def _mappers(self) -> tuple[Mapper, ...]:
        return (self._mapper,) if self._reference is None else (self._mapper, self._reference.mapper)

    @property
    def _is_idle(self) -> bool:
        """True while a robot that could drive has nothing to do and knows where it is."""
        nothing = not self._doing and not self._mapper.looking_around
        return nothing and self._profile.drives and self._mapper.lost is None

    @property
    def _is_blind(self) -> bool:
        return self._profile.drives and not self._profile.odometry and not self._profile.lasers

    def _decide(self, frame: SensorFrame, motion: Motion, pose: Pose) -> Twist:
        if self._executor.active_command is None:
            return ZERO
        if self._waits_for_odometry(frame.stamp):
            return self._executor.only_turn(0.0, NO_ODOMETRY, frame.stamp - self._stamp)
        lost = self._mapper.lost
        if lost is not None and self._needs_a_place:
            return self._executor.only_turn(self._mapper.turn, lost.words, frame.stamp - self._stamp)
        waits = self._mapper.looking_around and self._profile.drives
        wait_for = Statement("pilot.looking_around") if waits else ""
        twist = self._executor.drive(self._surroundings(frame, motion, pose), wait_for)
        zone = self._keep_outs.ahead(pose, twist, self._body.radius)
        if zone is not None:
            self._executor.end("failed", Statement("zones.ahead", name=zone.name))
            return ZERO
        cap = self._slow_zones.cap(pose if lost is None else None, self._body.radius, self._body.max_speed)
        return twist if cap is None else twist.clamped(cap, self._body.max_turn_rate)

    def _forbidden(self, command: Command) -> str:
        """Return why a command may not be obeyed: its goal lies in a zone; "": it may."""
        numbers = command.numbers
        if "x_m" not in numbers or "y_m" not in numbers:
            return ""
        zone = self._keep_outs.around(numbers["x_m"], numbers["y_m"], self._body.radius)
        return "" if zone is None else Statement("zones.inside", name=zone.name)

    @property
    def _grid(self) -> OccupancyGrid:
        seen, known = self._mapper.grid, self._edited
        if known is None or known[0] is not seen or known[1] is not self._edits:
            self._edited = known = seen, self._edits, self._edits.on(seen)
        return known[2]

    @property
    def _landmarks(self) -> tuple[Landmark, ...]:
        """The landmarks but those where people erased the map."""
        marks, grid, known = self._mapper.landmarks, self._grid, self._hidden
        if not self._edits.edits or not marks:
            return marks
        if known is None or known[0] is not marks or known[1] is not grid:
            hidden = self._edits.hides(grid, np.array([mark.position for mark in marks]))
            left = tuple(mark for mark, gone in zip(marks, hidden.tolist(), strict=True) if not gone)
            self._hidden = known = marks, grid, left
        return known[2]

    def _planned_on(self, pose: Pose) -> OccupancyGrid:
        """The map with the zones to keep out of as walls, but for the one in which the robot stands."""
        grid, zones = self._grid, self._keep_outs.left_by(pose)
        known = self._ground
        if known is None or known[0] is not grid or known[1] != zones:
            self._ground = known = grid, zones, zones.on(grid)
        return known[2]

    def _waits_for_odometry(self, stamp: float) -> bool:
        """Return whether a command that moves waits for odometry; one that has waited for too long ends."""
        doing, since = self._executor.active_command, self._sensors.blind_since
        if since is None or doing is None or not spec_of(doing.name).moves:
            return False
        if stamp - since > MAX_WAIT_S:
            self._executor.end("failed", NO_ODOMETRY)
        return True

    @property
    def _needs_a_place(self) -> bool:
        return bool(self._doing) and self._profile.drives and _goes_to_a_place(self._doing)

    def _surroundings(self, frame: SensorFrame, motion: Motion, pose: Pose) -> ControlContext:
        wheels = motion.wheels
        return ControlContext(
            stamp=frame.stamp,
            pose=pose,
            speed=wheels.speed if wheels else 0.0,
            turn_rate=wheels.turn_rate if wheels else 0.0,
            body=self._body,
            grid=self._planned_on(pose),
            anchored=self._mapper.anchored,
            scan_points=frozen(pose.inverse().apply(self._mapper.points)),
            scan_stamp=self._scanned,
            planner=self._planner,
            steering=self._settings.steering,
            wall=self._settings.wall,
            image=None if self._sensors.untimely("camera") else frame.image,
            camera=self._vision.camera_of(frame.image, frame.stamp),
            call=None if self._sensors.untimely("microphones") else self._hearing.call,
            misheard=self._hearing.contradiction,
            company=self._settings.person_following,
            people=self._settings.people,
            tracking=self._settings.tracking,
            look=self._look,
            who=self._who,
        )

    def _report(self, frame: SensorFrame) -> None:
        """Tell the operator what goes wrong; a contact ends what is under way."""
        if frame.contact and not self._contact:
            self._executor.end("failed", Statement("pilot.touched"))
            self._notices.add(frame.stamp, "warning", Statement("pilot.touches"))
        self._contact = frame.contact
        if frame.trouble:
            self._executor.end("failed", frame.trouble)
        lost = self._mapper.lost
        if self._needs_a_place and lost is None and self._lost and self._mapper.strayed:
            self._executor.end("failed", AGAIN)
        elif self._needs_a_place and lost is not None and lost.phase == "asking":
            self._executor.end("failed", lost.words)
        self._lost = lost is not None
        for trouble in self._troubles(frame):
            self._notices.watch(frame.stamp, *trouble)
        for one in frame.faults:
            self._notices.add(frame.stamp, "warning", one.statement, cause=f"{one.code} {one.sensor}")
        for note in frame.notes:
            self._notices.add(frame.stamp, "info", note)

    def _troubles(self, frame: SensorFrame) -> Iterator[tuple[str, str, Level, str]]:
        """Everything that is watched: its cause, the trouble in this frame ("" = none), its level, its relief."""
        vision, hearing, lost = self._vision, self._hearing, self._mapper.lost
        yield "blind", BLIND if self._is_blind else "", "warning", ""
        yield "base", frame.trouble, "error", Statement("pilot.base_answers")
        expected = lost is not None and lost.asked and lost.phase != "asking"
        place = lost.words if lost else ""
        yield "place", place, "info" if expected else "warning", self._mapper.found or Statement("pilot.found")
        for (kind, name), trouble in self._repeats.troubles():
            yield f"hanging {kind} {name}", trouble, "warning", Statement("sensor.shows_new", kind=kind, name=name)
        yield from self._lost_sensors()
        yield "camera", vision.trouble, "warning", Statement("pilot.pictures_usable")
        yield "microphones", hearing.trouble, "warning", Statement("pilot.sound_usable")
        yield "array", hearing.contradiction, "warning", Statement("pilot.microphones_agree")
        yield "picture", vision.poor, "warning", Statement("pilot.camera_sees")
        yield "mount", self._mount.alarm, "warning", Statement("pilot.camera_sits")
        # a simulated robot's clock waits, and the page shows it
        slow = frame.pace < 1 and not self._profile.simulated
        yield "pace", SLOW if slow else "", "warning", KEEPS_UP
        for fault in self._disagreements:
            yield fault.code, fault.statement, "warning", ""

    def _lost_sensors(self) -> Iterator[tuple[str, str, Level, str]]:
        for status in self._sensor_status:
            alone = sum(other.kind == status.kind for other in self._sensor_status) == 1
            cause = f"silent {status.kind} {status.name}"
            lost = status.state == "lost" and not self._repeats.hangs(status.kind, status.name)
            trouble = loss(status, alone) if lost else self._sensors.untimely(status.kind, status.name)
            yield cause, trouble, "error", recovery(status, alone)

    def _publish(
        self,
        frame: SensorFrame,
        motion: Motion,
        estimate: Estimate,
        dead_reckoning: Estimate,
        hearing: Hearing | None,
        twist: Twist,
    ) -> Snapshot:
        wheels, doing = motion.wheels, self._executor
        return Snapshot(
            stamp=frame.stamp,
            estimate=estimate,
            dead_reckoning=dead_reckoning,
            increment=motion.increment,
            velocity=Twist(wheels.speed, wheels.turn_rate) if wheels else ZERO,
            setpoint=twist,
            setpoint_command_id=doing.active_command.id if doing.active_command else 0,
            nonce=frame.nonce,
            scan_points=frozen(self._mapper.points),
            landmarks=self._landmarks,
            associations=self._mapper.associations,
            slam=self._mapper.slam,
            floor=self._mapper.health,
            grid=self._grid,
            trail=self._trail.add(self._mapper),
            dead_reckoning_trail=self._dead_reckoning_trail.add(dead_reckoning.pose.x, dead_reckoning.pose.y),
            path=NO_POINTS if doing.path is None else doing.path,
            goal=doing.goal,
            active_command=doing.active_command,
            endings=doing.take_endings(),
            view=self._vision.view,
            hearing=hearing,
            person=doing.person,
            drift=self._mount.drift,
            timings=self._timing.offsets,
            agreement=self._odometry.agreement.compared,
            notices=self._notices.newest,
            sensors=self._sensor_status,
            contact=frame.contact,
            pace=frame.pace,
            battery=frame.battery,
            running=frame.running,
            progress=frame.progress,
            truth=frame.truth,
        )


def _goes_to_a_place(name: str) -> bool:
    return spec_of(name).moves and spec_of(name).needs_pose


def of_robot(settings: Settings, profile: Profile) -> Settings:
    """The settings with what the robot itself knows better: its wheelbase. A recording does not know it."""
    if not profile.drives:
        return settings
    return replace(settings, motion=replace(settings.motion, wheelbase=profile.wheelbase))


def live(present: Settings, wanted: Settings) -> Settings:
    """The present settings with the wanted ones of the sections that may change at any frame."""
    return replace(present, steering=wanted.steering, wall=wanted.wall, person_following=wanted.person_following)


def parts_of(settings: Settings) -> MapperSettings:
    """Return the settings of the mapper."""
    return MapperSettings(
        floor=settings.submaps,
        matching=settings.matching,
        closures=settings.closures,
        ekf=settings.ekf,
        occupancy=settings.occupancy,
        kidnap=settings.localization_monitor,
        edges=settings.edge_landmarks,
        voices=settings.voice_landmarks,
    )
