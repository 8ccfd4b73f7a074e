"""The simulated robot: a world, a base, and what its sensors make of them. Time is counted in frames."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from core.errors import BadInput
from core.gate import Twist
from core.geometry import Pose
from core.robots import Profile
from core.sensors import Camera, Image, Laser, Scan, SensorFrame
from core.simulation.actors.board_motion import BoardMotion
from core.simulation.actors.pedestrians import Pedestrians
from core.simulation.actors.requests import BOARD, HOLDER, describe, number, thing_asked_for
from core.simulation.actors.speakers import Speakers
from core.simulation.camera import SimulatedCamera
from core.simulation.differential_drive import DifferentialDrive
from core.simulation.laser import SimulatedLaser
from core.simulation.microphones import MicrophoneSettings
from core.simulation.wheels import EncoderWheels, PaperWheels, PerfectWheels, SimulatedWheels
from core.simulation.world import World, world_named

WheelNoise = Literal["encoder", "paper", "none"]
LaserNoise = Literal["1%", "3%", "none"]
WHEEL_NOISE: tuple[WheelNoise, ...] = ("encoder", "paper", "none")
LASER_NOISE: dict[LaserNoise, tuple[float, float]] = {"1%": (0.010, 0.01), "3%": (0.030, 0.03), "none": (0.0, 0.0)}
"""Standard deviation of a range: at least the first [m], else the second times the range."""

SINCE = 0.3  # [s] for which poses are kept: longer than a turn of the mirror


@dataclass(frozen=True)
class SimulationSettings(MicrophoneSettings):
    """Noise and equipment of the simulated robot."""

    wheel_noise: WheelNoise = "encoder"  # "paper": eq. 43
    scale_error: float = 0.003  # of the size of both wheels together, relative, standard deviation
    mismatch: float = 0.0002  # of one wheel against the other, relative
    wheelbase_error: float = 0.003  # relative
    slip: float = 0.0007  # [m/√m] per wheel
    laser_noise: LaserNoise = "1%"
    dropout: float = 0.004  # share of beams that fail at random
    camera: bool = True
    camera_rate: float = 10.0  # [Hz]
    light: float = 1.0  # brightness of the pictures
    picture_snr: float = 42.0  # [dB] of the sensor (section 6)
    exposure: float = 0.0  # [s] of a picture: turning meanwhile smears it
    defocus: float = 0.0  # [pixel] sd of the lens's blur
    cruise: float = 0.1  # [m/s] (section 6.2)
    max_speed: float = 0.3  # [m/s]
    max_turn_rate: float = 1.5  # [rad/s]
    response: float = 0.06  # [s] until the base has followed 63 % of a change of speed

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.wheel_noise not in WHEEL_NOISE:
            raise BadInput(f"wheel_noise must be one of {', '.join(WHEEL_NOISE)}.")
        if self.laser_noise not in LASER_NOISE:
            raise BadInput(f"laser_noise must be one of {', '.join(LASER_NOISE)}.")
        for name, (low, high) in BOUNDS.items():
            if not low <= getattr(self, name) <= high:
                raise BadInput(f"{name} must lie between {low:g} and {high:g}.")


BOUNDS = {
    "scale_error": (0.0, 0.1),
    "mismatch": (0.0, 0.1),
    "wheelbase_error": (0.0, 0.1),
    "slip": (0.0, 0.1),
    "dropout": (0.0, 1.0),
    "camera_rate": (0.1, 40.0),
    "light": (0.05, 3.0),
    "picture_snr": (10.0, 100.0),
    "exposure": (0.0, 0.1),
    "defocus": (0.0, 5.0),
    "cruise": (0.01, 1.0),
    "max_speed": (0.01, 1.0),
    "max_turn_rate": (0.01, 6.0),
    "response": (0.0, 1.0),
}


class SimulatedRobot:
    """A robot in a floor plan, as `core.robots.Robot` has it; `truth` in its frames is exact."""

    def __init__(self, place: str, *, seed: int = 0, settings: SimulationSettings | None = None) -> None:
        settings = settings or SimulationSettings()
        self._world = world_named(place)
        self._profile = Profile(
            name=f"simulated robot in the {place}",
            kind="SIM",
            url=f"sim:{place}",
            cruise=settings.cruise,
            max_speed=settings.max_speed,
            max_turn_rate=settings.max_turn_rate,
            laser=Laser(),
            camera=Camera(rate=settings.camera_rate) if settings.camera else None,
            microphones=settings.array,
        )
        seeds = np.random.SeedSequence(seed).spawn(4)
        chance = [np.random.default_rng(one) for one in seeds[:3]]
        self._base = DifferentialDrive(
            self._world,
            radius=self._profile.radius,
            max_speed=settings.max_speed,
            max_turn_rate=settings.max_turn_rate,
            response=settings.response,
        )
        self._wheels = _wheels(settings, self._profile.wheelbase, chance[0])
        floor_sd, share_sd = LASER_NOISE[settings.laser_noise]
        self._laser = SimulatedLaser(
            self._profile.laser or Laser(), chance[1], floor_sd=floor_sd, share_sd=share_sd, dropout=settings.dropout
        )
        self._camera: SimulatedCamera | None = None
        if self._profile.camera:
            self._camera = SimulatedCamera(
                self._profile.camera,
                self._world,
                chance[2],
                light=settings.light,
                snr=settings.picture_snr,
                exposure=settings.exposure,
                defocus=settings.defocus,
            )
        self._frames = self._scans = self._images = 0
        self._hands, self._walkers = BoardMotion(self._profile), Pedestrians(self._profile.radius)
        self._voices = Speakers(settings, seeds[3], self._profile.rate, self._profile.wheelbase)
        self._heading = 0.0  # [rad], running on without jumps
        self._past: deque[tuple[float, float, float, float]] = deque([(0.0, 0.0, 0.0, 0.0)])

    @property
    def profile(self) -> Profile:
        """The profile of this robot."""
        return self._profile

    @property
    def _stamp(self) -> float:
        return self._frames / self._profile.rate

    def drive(self, twist: Twist) -> None:
        """Set the speed that holds until the next call, for half a second at most."""
        self._base.drive(twist)

    def read(self) -> SensorFrame:
        """Live on for one frame and sense."""
        step = 1 / self._profile.rate
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
        while self._past[0][0] < stamp - SINCE:
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

    def ask(self, request: dict[str, Any]) -> dict[str, Any]:
        """`{"do": "place" | "remove" | "truth" | "plan"}` → an answer; BadInput says what is wrong.

        place: `what` person, box or robot (this one: it is carried, its wheels do not notice), `x_m`, `y_m`,
        `heading_rad`?, `id`? (one that exists is moved), `size_m`? (a box's edge, a person's height). A person:
        `clothes`? ("red/blue"), `gesture`?, and to walk `path_m`? [[x, y], …], `speed_m_s`?, `again`? (in a round).
        A chessboard: see `core.simulation.actors.board_holder`; its id is board. say, listen: see
        `core.simulation.actors.speakers`.
        """
        match request.get("do"):
            case "place" if request.get("what") == "robot":
                return self._carry(request)
            case "place" if request.get("what") == "board":
                board = self._hands.hold(request, self._world, self._base.pose, self._stamp)
                self._change(self._hands.in_world(self._world, self._stamp))
                return {**board}
            case "place":
                thing = thing_asked_for(request, self._world, self._base.pose, self._profile.radius)
                walks = self._walkers.send(request, thing, self._world)
                self._change(self._world.with_thing(thing))
                return describe(thing) | walks
            case "remove":
                name = str(request.get("id", ""))
                if name in (BOARD, HOLDER):
                    gone = self._hands.put_down(name)
                    self._change(self._hands.in_world(self._world, self._stamp))
                    return {**gone}
                self._change(self._world.without(name))
                self._walkers.forget(name)
                return {"id": name}
            case "truth":
                return self._truth()
            case "plan":
                seen = self._world.surfaces(self._laser.laser.height)
                return {
                    "name": self._world.name,
                    "segments": seen.faces.tolist(),
                    "circles": seen.posts.tolist(),
                    "things": [
                        *(describe(thing) for thing in self._world.things),
                        *self._hands.described(self._stamp),
                    ],
                }
            case "say" | "listen":
                return self._voices.ask(request, self._world, self._base.pose, self._stamp)
            case _:
                raise BadInput(
                    "The simulated robot understands the requests place, remove, truth, plan, say and listen."
                )

    def close(self) -> None:
        """Close nothing: the simulator holds no resource."""

    def _carry(self, request: dict[str, Any]) -> dict[str, Any]:
        pose = Pose(
            number(request, "x_m"),
            number(request, "y_m"),
            math.remainder(number(request, "heading_rad", 0.0), math.tau),
        )
        if not self._world.free(pose.x, pose.y, self._profile.radius):
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

    def _truth(self) -> dict[str, Any]:
        pose = self._base.pose
        return {
            "x_m": pose.x,
            "y_m": pose.y,
            "heading_rad": pose.heading,
            "stamp_s": self._stamp,
            "clearance_m": self._world.clearance(pose.x, pose.y) - self._profile.radius,
            "contact": self._base.contact,
        }

    def _scan(self, stamp: float) -> Scan | None:
        """The newest scan whose last beam has come back, if it was not delivered yet."""
        laser = self._laser.laser
        done = math.floor((stamp - self._laser.duration) * laser.rate + 1e-9) + 1
        if done <= self._scans:
            return None
        self._scans = done
        past = np.array(self._past)
        return self._laser.scan(self._world, (done - 1) / laser.rate, past[:, 0], past[:, 1:])

    def _image(self, stamp: float, pose: Pose) -> Image | None:
        """Render the picture that is due. It waits where a scan comes with the frame, to spread the load."""
        if self._camera is None:
            return None
        due = math.floor(stamp * self._camera.camera.rate - 0.25 + 1e-9) + 1
        if due <= self._images:
            return None
        self._images = due
        return self._camera.take(self._world, stamp, pose, self._base.turn_rate)


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


def open_robot(rest: str, *, seed: int = 0, settings: SimulationSettings | None = None) -> SimulatedRobot:
    """`sim:<rest>` → the robot in that world; BadInput for a world that does not exist."""
    return SimulatedRobot(rest or "lab", seed=seed, settings=settings)
