"""The pilot's story: for each frame of the robot, obey, perceive, estimate, decide, publish."""

from __future__ import annotations

import math
from dataclasses import replace

from core.calibration.drift import MountWatch
from core.commands.command import Command
from core.errors import Refused
from core.gate import ZERO, Twist
from core.geometry import Pose
from core.navigation.surroundings import Body, Surroundings
from core.pilot.ears import Ears
from core.pilot.eyes import Eyes, Look
from core.pilot.feet import Feet
from core.pilot.notices import Notices
from core.pilot.obedience import Obedience
from core.pilot.trail import NO_POINTS, Trail, frozen
from core.robots import Profile
from core.sensors import SensorFrame
from core.settings import Settings
from core.slam.dead_reckoning import DeadReckoning
from core.slam.ekf import EkfSlam
from core.slam.estimate import Estimate
from core.slam.occupancy import OccupancyMap
from core.snapshot import Ending, Snapshot

LOOKING_AROUND = "Looking around before the first move…"
NO_SCAN = "No scan comes from the laser."
SCAN_LOST_AFTER = 0.5  # [s]


class Pilot:
    """Owns perception, estimators, map and commands. One thread calls `step`; any thread may `tell` and `cancel`."""

    def __init__(self, profile: Profile, settings: Settings | None = None) -> None:
        self._profile = profile
        self._settings = settings or Settings()
        limits, planner = self._settings.limits, self._settings.planner
        self._body = Body(
            radius=profile.radius,
            cruise=min(profile.cruise, profile.max_speed, limits.max_speed),
            turn=min(Body().turn, profile.max_turn_rate, limits.max_turn_rate),
            max_speed=profile.max_speed,
            max_turn_rate=profile.max_turn_rate,
        )
        self._planner = replace(planner, guard=max(planner.guard, limits.margin + 0.005))
        self._obedience = Obedience()
        self._notices = Notices()
        self._wake(math.inf)

    def _wake(self, stamp: float) -> None:
        """Know nothing yet: before the first frame, and after a jump back in a recording."""
        settings = self._settings
        self._stamp = self._scan_stamp = stamp
        self._feet = Feet(self._profile.laser, settings.scan_odometry)
        self._eyes = Eyes(self._profile, settings)
        self._mount = MountWatch(settings.drift)
        self._ears = Ears(self._profile, settings.hearing)
        self._slam = EkfSlam(settings.ekf, settings.motion, self._profile.laser)
        self._dead_reckoning = DeadReckoning(settings.motion)
        self._map = OccupancyMap(settings.occupancy)
        self._trail, self._dead_reckoning_trail = Trail(), Trail()
        self._scan_points = NO_POINTS  # (M, 2) [m], world: the newest scan
        self._contact = False

    def tell(self, undertaking_id: int, command: Command, source: str, who: str) -> None:
        """Obey this command from the next frame on; the one under way is pre-empted. Raises Refused."""
        if not self._profile.drives:
            raise Refused("This is a recording; it cannot be commanded. Connect a robot or the simulator.")
        self._obedience.tell(undertaking_id, command, source, who)

    def cancel(self, state: Ending, why: str) -> None:
        """End what is under way, in that state and for that reason."""
        self._obedience.cancel(state, why)

    def look_through(self, profile: Profile) -> None:
        """See with this profile's camera from the next frame on: it was calibrated. From any thread."""
        self._profile = profile
        self._eyes.camera = profile.camera

    def step(self, frame: SensorFrame) -> Snapshot:
        """One frame further."""
        if frame.stamp < self._stamp - 1e-6:
            self._obedience.end("failed", "The robot's clock began anew.")
            self._wake(frame.stamp)
        self._obedience.open_inbox(frame.stamp)
        frame, move = self._feet.feel(frame)
        look = self._eyes.look(frame)
        estimate = self._slam.update(frame, look.sightings, move)
        dead_reckoning = self._dead_reckoning.update(frame, look.sightings, move)
        self._draw_map(estimate.pose, look)
        self._mount.watch(frame.stamp, estimate.pose, look.pairs, self._eyes.camera)
        self._watch(frame)
        twist = self._decide(frame, estimate.pose)
        self._stamp = frame.stamp
        return self._publish(frame, estimate, dead_reckoning, twist)

    def _draw_map(self, pose: Pose, look: Look) -> None:
        """Put the newest scan on the map, and remember where its points lie."""
        if look.ends is None or look.hits is None:
            return
        world = pose.apply(look.ends)
        mounting = self._profile.laser.mounting if self._profile.laser else Pose()
        self._map.insert(pose @ mounting, world, look.hits)
        self._scan_points = frozen(world[look.hits])

    def _decide(self, frame: SensorFrame, pose: Pose) -> Twist:
        """What to ask of the gate."""
        if self._obedience.undertaking is None:
            return ZERO
        wait_for = LOOKING_AROUND if self._slam.looking_around else ""
        return self._obedience.drive(self._surroundings(frame, pose), wait_for)

    def _surroundings(self, frame: SensorFrame, pose: Pose) -> Surroundings:
        wheels = frame.wheels
        return Surroundings(
            stamp=frame.stamp,
            pose=pose,
            speed=wheels.speed if wheels else 0.0,
            turn_rate=wheels.turn_rate if wheels else 0.0,
            body=self._body,
            grid=self._map.grid(),
            scan_points=frozen(pose.inverse().apply(self._scan_points)),
            planner=self._planner,
            steering=self._settings.steering,
        )

    def _watch(self, frame: SensorFrame) -> None:
        """Tell the operator what goes wrong; a contact ends what is under way."""
        if frame.contact and not self._contact:
            self._obedience.end("failed", "The robot touched something and stopped.")
            self._notices.add(frame.stamp, "warning", "The robot touches something.")
        self._contact = frame.contact
        if frame.scan is not None:
            self._scan_stamp = frame.stamp
        overdue = frame.stamp - self._scan_stamp > SCAN_LOST_AFTER
        blind = overdue and self._profile.drives and self._profile.laser is not None
        self._notices.watch(frame.stamp, "laser", NO_SCAN if blind else "", "error", "The laser is back.")
        self._notices.watch(frame.stamp, "camera", self._eyes.trouble, "warning")
        self._notices.watch(frame.stamp, "picture", self._eyes.poor, "warning", "The camera sees well enough again.")
        self._notices.watch(frame.stamp, "mount", self._mount.alarm, "warning", "The camera sits as calibrated.")
        self._notices.watch(frame.stamp, "microphones", self._ears.trouble, "warning")
        if frame.note:
            self._notices.add(frame.stamp, "info", frame.note)

    def _publish(self, frame: SensorFrame, estimate: Estimate, dead_reckoning: Estimate, twist: Twist) -> Snapshot:
        """All of it in one value."""
        wheels, doing = frame.wheels, self._obedience
        return Snapshot(
            stamp=frame.stamp,
            estimate=estimate,
            dead_reckoning=dead_reckoning,
            velocity=Twist(wheels.speed, wheels.turn_rate) if wheels else ZERO,
            setpoint=twist,
            setpoint_press=doing.undertaking.id if doing.undertaking else 0,
            nonce=frame.nonce,
            scan_points=self._scan_points,
            landmarks=self._slam.landmarks,
            associations=self._slam.associations,
            slam=self._slam.health,
            grid=self._map.grid(),
            trail=self._trail.add(estimate.pose.x, estimate.pose.y),
            dead_reckoning_trail=self._dead_reckoning_trail.add(dead_reckoning.pose.x, dead_reckoning.pose.y),
            path=NO_POINTS if doing.path is None else doing.path,
            goal=doing.goal,
            undertaking=doing.undertaking,
            endings=doing.take_endings(),
            view=self._eyes.view,
            drift=self._mount.drift,
            hearing=self._ears.hear(frame.sound, frame.stamp, estimate),
            notices=self._notices.newest,
            contact=frame.contact,
            running=frame.running,
            progress=frame.progress,
            truth=frame.truth,
        )
