"""What a command may look at while it is obeyed."""

from __future__ import annotations

from core.geometry import Pose
from core.message import Array, message
from core.navigation.company import CompanySettings
from core.navigation.planner import PlannerSettings
from core.navigation.steering import SteeringSettings
from core.navigation.wall import WallSettings
from core.perception.people.call import Call
from core.perception.people.colours import Enrolled
from core.perception.people.parts import PeopleSettings
from core.perception.people.person import TrackSettings
from core.sensors import Camera, Image
from core.slam.occupancy import Grid


@message
class Body:
    """The body that is steered."""

    radius: float = 0.09  # [m] of the round footprint
    cruise: float = 0.1  # [m/s]
    turn: float = 0.6  # [rad/s] when turning on the spot
    max_speed: float = 0.3  # [m/s]
    max_turn_rate: float = 1.5  # [rad/s]


@message
class Surroundings:
    """The world around the robot by the present estimate."""

    stamp: float  # [s]
    pose: Pose  # world
    speed: float  # [m/s] as the wheels report it
    turn_rate: float  # [rad/s]
    body: Body
    grid: Grid
    scan_points: Array  # (M, 2) [m], robot frame, de-skewed: the newest scan
    planner: PlannerSettings = PlannerSettings()
    steering: SteeringSettings = SteeringSettings()
    wall: WallSettings = WallSettings()
    image: Image | None = None  # the picture that came with this frame
    camera: Camera | None = None
    call: Call | None = None  # the voice that was heard last
    company: CompanySettings = CompanySettings()
    people: PeopleSettings = PeopleSettings()
    tracking: TrackSettings = TrackSettings()
    who: Enrolled | None = None  # the only person who is obeyed with the feet; None: anybody
