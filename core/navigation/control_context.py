"""The context of a command under way: the pose, the map and the readings that it may use."""

from collections.abc import Callable

from core.geometry import Pose
from core.message import Array, message
from core.navigation.person_following import PersonFollowingSettings
from core.navigation.planner import PlannerSettings
from core.navigation.steering import SteeringSettings
from core.navigation.wall import WallSettings
from core.perception.people.appearance import PersonProfile
from core.perception.people.looking import PersonLook
from core.perception.people.parts import PeopleSettings
from core.perception.people.tracked_person import TrackSettings
from core.perception.people.voice_bearing import VoiceBearing
from core.sensors import Camera, Image
from core.slam.map.occupancy import OccupancyGrid


@message
class SteeredBody:
    """The body that is steered."""

    radius: float = 0.09  # [m] of the round footprint
    cruise: float = 0.1  # [m/s]
    turn: float = 0.6  # [rad/s] when turning on the spot
    max_speed: float = 0.3  # [m/s]
    max_turn_rate: float = 1.5  # [rad/s]


def as_it_is(pose: Pose) -> Callable[[], Pose]:
    """The pose [m], [rad] on a map that nothing bends."""
    return lambda: pose


@message
class ControlContext:
    """The world around the robot by the present estimate."""

    stamp: float  # [s]
    pose: Pose  # world
    speed: float  # [m/s] as the wheels report it
    turn_rate: float  # [rad/s]
    body: SteeredBody
    grid: OccupancyGrid
    scan_points: Array  # (M, 2) [m], robot frame, de-skewed: the newest scan
    scan_stamp: float = 0.0  # [s] of that scan
    anchored: Callable[[Pose], Callable[[], Pose]] = as_it_is  # a pose → where it is once a closed loop bent the map
    planner: PlannerSettings = PlannerSettings()
    steering: SteeringSettings = SteeringSettings()
    wall: WallSettings = WallSettings()
    image: Image | None = None  # the picture that came with this frame
    camera: Camera | None = None
    call: VoiceBearing | None = None  # the voice that was heard last
    misheard: str = ""  # why no direction of a voice can be believed
    company: PersonFollowingSettings = PersonFollowingSettings()
    people: PeopleSettings = PeopleSettings()
    tracking: TrackSettings = TrackSettings()
    look: PersonLook | None = None  # what finds people in pictures; None: the embedded detector
    who: PersonProfile | None = None  # the only person to come to or follow; None: anybody

    @property
    def is_full(self) -> bool:
        """True for a frame with a picture or a scan: perception has taken its time from this step."""
        return self.image is not None or self.scan_stamp == self.stamp
