"""The simulated robot: a world, a base, and what its sensors make of them. Time is counted in frames."""

import math
from collections import deque
from dataclasses import replace
from typing import Any, cast

import msgspec
import numpy as np

from core.errors import BadInput
from core.gate import Twist
from core.geometry import Pose
from core.robots import Profile
from core.robots.requests import (
    AnswerT,
    CarryRobot,
    FloorPlan,
    GroundTruth,
    Hush,
    PlaceBoard,
    PlacedBoard,
    PlacedThing,
    PlaceThing,
    ReadPlan,
    ReadTruth,
    RemovedThing,
    RemoveThing,
    Requests,
    RobotRequest,
    SetListening,
    Speak,
    not_taken,
)
from core.sensors import Camera, Image, Laser, Scan, SensorFrame
from core.sentences import Statement, plain
from core.simulation.actors.board_holder import BoardMotion
from core.simulation.actors.pedestrians import Pedestrians
from core.simulation.actors.requests import BOARD, HOLDER, pose_asked_for, thing_asked_for
from core.simulation.actors.speakers import Speakers
from core.simulation.camera import SimulatedCamera
from core.simulation.differential_drive import (
    DifferentialDrive,
    EncoderWheels,
    PaperWheels,
    PerfectWheels,
    SimulatedWheels,
)
from core.simulation.laser import SimulatedLaser
from core.simulation.settings import LASER_NOISE, SimulationSettings
from core.simulation.world import World, world_named

POSE_MEMORY_S = 0.3  # for which poses are kept: longer than a turn of the mirror


class SimulatedRobot:
    """A robot in a floor plan, as `core.robots.Robot` has it; `truth` in its frames is exact."""

    def __init__(self, place: str, *, seed: int = 0, settings: SimulationSettings | None = None) -> None:
        settings = settings or SimulationSettings()
        self._world = world_named(place)
        self.profile = Profile(
            name=f"simulated robot in the {place}",
            url=f"sim:{place}",
            capabilities=frozenset({"drive", "simulate"}),
            failsafe=plain(Statement("robot.stops_by_itself", seconds="0.5")),
            cruise=settings.cruise,
            max_speed=settings.max_speed,
            max_turn_rate=settings.max_turn_rate,
            lasers=(Laser(),),
            cameras=_cameras(settings),
            arrays=() if settings.array is None else (settings.array,),
        )
        seeds = np.random.SeedSequence(seed).spawn(4)
        chance = [np.random.default_rng(one) for one in seeds[:3]]
        self._base = DifferentialDrive(
            self._world,
            radius=self.profile.radius,
            max_speed=settings.max_speed,
            max_turn_rate=settings.max_turn_rate,
            response=settings.response,
        )
        self._wheels = _wheels(settings, self.profile.wheelbase, chance[0])
        floor_sd, share_sd = LASER_NOISE[settings.laser_noise]
        self._laser = SimulatedLaser(
            self.profile.laser or Laser(), chance[1], floor_sd=floor_sd, share_sd=share_sd, dropout=settings.dropout
        )
        self._cameras = tuple(
            SimulatedCamera(
                camera,
                self._world,
                chance[2],
                light=settings.light,
                snr=settings.picture_snr,
                exposure=settings.exposure,
                defocus=settings.defocus,
            )
            for camera in self.profile.cameras
        )
        self._others: deque[Image] = deque()  # pictures of the other cameras that were not delivered yet
        self._frames = self._scans = self._images = 0
        self._hands, self._walkers = BoardMotion(self.profile), Pedestrians(self.profile.radius)
        self._voices = Speakers(settings, seeds[3], self.profile.rate, self.profile.wheelbase)
        self._heading = 0.0  # [rad], running on without jumps
        self._past: deque[tuple[float, float, float, float]] = deque([(0.0, 0.0, 0.0, 0.0)])

    @property
    def _stamp(self) -> float:
        return self._frames / self.profile.rate

    def drive(self, twist: Twist) -> None:
        """Set the speed that holds until the next call, for half a second at most."""
        self._base.drive(twist)

    def read(self) -> SensorFrame:
        """Live on for one frame and sense."""
        step = 1 / self.profile.rate
        self._frames += 1
        stamp = self._stamp
        moves = self._base.advance(step)
        for move in moves:
            self._wheels.roll(move.forward, move.turn)
            self._heading += move.turn
        speed, turn_rate = sum(move.forward for move in moves) / step, sum(move.turn for move in moves) / step
        self._change(self._hands.in_world(self._walkers.in_world(self._world, stamp, self._base.pose), stamp))
        pose = self._base.pose
        self._past.append((stamp, pose.x, pose.y, self._heading))
        while self._past[0][0] < stamp - POSE_MEMORY_S:
            self._past.popleft()
        scan = self._scan(stamp)
        return SensorFrame(
            stamp=stamp,
            wheels=self._wheels.read(step),
            scan=scan,
            image=None if scan else self._image(stamp, pose),
            sound=self._voices.read(self._world, stamp, pose, speed, turn_rate),
            contact=self._base.contact,
            truth=pose,
        )

    @property
    def requests(self) -> Requests:
        """Requests to the simulated room and its robot."""
        return (PlaceThing, CarryRobot, PlaceBoard, RemoveThing, ReadTruth, ReadPlan, Speak, Hush, SetListening)

    def ask(self, request: RobotRequest[AnswerT]) -> AnswerT:
        """Change the room, or read what is true in it → an answer; BadInput says what is wrong."""
        return cast(AnswerT, self._answer(request))

    def _answer(self, request: RobotRequest[Any]) -> msgspec.Struct:
        match request:
            case CarryRobot():
                return self._carry(request)
            case PlaceBoard():
                return self._hold(request)
            case PlaceThing():
                return self._place(request)
            case RemoveThing(id=name):
                return self._remove(name)
            case ReadTruth():
                return self._truth()
            case ReadPlan():
                return self._plan()
            case Speak():
                return self._voices.say(request, self._world, self._base.pose, self._stamp)
            case Hush():
                return self._voices.hush(request)
            case SetListening():
                return self._voices.listen(request)
            case _:
                raise not_taken(self.requests)

    def _place(self, request: PlaceThing) -> PlacedThing:
        thing = thing_asked_for(request, self._world, self._base.pose, self.profile.radius)
        answer = self._walkers.send(request, thing, self._world)
        self._change(self._world.with_thing(thing))
        return answer

    def _hold(self, request: PlaceBoard) -> PlacedBoard:
        answer = self._hands.hold(request, self._world, self._base.pose, self._stamp)
        self._change(self._hands.in_world(self._world, self._stamp))
        return answer

    def _remove(self, name: str) -> RemovedThing:
        if name in (BOARD, HOLDER):
            self._hands.put_down(name)
            self._change(self._hands.in_world(self._world, self._stamp))
        else:
            self._change(self._world.without(name))
            self._walkers.forget(name)
        return RemovedThing(name)

    def _plan(self) -> FloorPlan:
        seen = self._world.surfaces(self._laser.laser.height)
        things = (self._walkers.described(thing) for thing in self._world.things)
        return FloorPlan(
            name=self._world.name,
            segments=tuple(map(tuple, seen.faces.tolist())),
            circles=tuple(map(tuple, seen.posts.tolist())),
            things=(*things, *self._hands.described(self._stamp)),
        )

    def close(self) -> None:
        """Close nothing: the simulator holds no resource."""

    def _carry(self, request: CarryRobot) -> GroundTruth:
        pose = pose_asked_for(request)
        if not self._world.free(pose.x, pose.y, self.profile.radius):
            raise BadInput(
                "The robot does not fit there; choose a place on the free floor, away from walls and things."
            )
        self._base.carry(pose)
        self._heading = pose.heading
        self._past = deque([(self._stamp, pose.x, pose.y, pose.heading)])
        return self._truth()

    def _change(self, world: World) -> None:
        if world is not self._world:
            self._world = world
            self._base.enter(world)

    def _truth(self) -> GroundTruth:
        pose = self._base.pose
        return GroundTruth(
            x_m=pose.x,
            y_m=pose.y,
            heading_rad=pose.heading,
            stamp_s=self._stamp,
            clearance_m=self._world.clearance(pose.x, pose.y) - self.profile.radius,
            contact=self._base.contact,
        )

    def _scan(self, stamp: float) -> Scan | None:
        """The newest scan whose last beam has come back, if it was not delivered yet."""
        laser = self._laser.laser
        assert laser.rate is not None
        done = math.floor((stamp - self._laser.duration) * laser.rate + 1e-9) + 1
        if done <= self._scans:
            return None
        self._scans = done
        past = np.array(self._past)
        return self._laser.scan(self._world, (done - 1) / laser.rate, past[:, 0], past[:, 1:])

    def _image(self, stamp: float, pose: Pose) -> Image | None:
        """Render the picture that is due. It waits where a scan comes with the frame, to spread the load."""
        if not self._cameras or self._others:
            return self._others.popleft() if self._others else None
        rate = self._cameras[0].camera.rate
        assert rate is not None
        due = math.floor(stamp * rate - 0.25 + 1e-9) + 1
        if due <= self._images:
            return None
        self._images = due
        first, *others = (camera.take(self._world, stamp, pose, self._base.turn_rate) for camera in self._cameras)
        self._others.extend(
            replace(image, camera=camera.camera.name) for camera, image in zip(self._cameras[1:], others, strict=True)
        )
        return first


def _cameras(settings: SimulationSettings) -> tuple[Camera, ...]:
    first = Camera(rate=settings.camera_rate)
    shift = np.array([0.0, -settings.second_camera, 0.0])
    mounting = replace(first.mounting, translation=first.mounting.translation + shift)
    second = (replace(first, name="second", mounting=mounting),) if settings.second_camera else ()
    return (first, *second) if settings.camera else ()


def _wheels(settings: SimulationSettings, wheelbase: float, rng: np.random.Generator) -> SimulatedWheels:
    if settings.wheel_noise == "none":
        return PerfectWheels()
    if settings.wheel_noise == "paper":
        return PaperWheels(rng, wheelbase=wheelbase, cruise=settings.cruise)
    return EncoderWheels(
        rng,
        wheelbase=wheelbase,
        scale_error=settings.scale_error,
        mismatch=settings.mismatch,
        wheelbase_error=settings.wheelbase_error,
        slip=settings.slip,
    )
