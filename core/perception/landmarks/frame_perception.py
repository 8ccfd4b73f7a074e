"""The content of one frame: beams, corners and landmarks, in the robot frame of its stamp."""

from core.geometry import Pose
from core.message import Array, message
from core.perception.landmarks.edge_pairs import EdgePair
from core.perception.landmarks.landmarks import Sighting
from core.sensors import Camera


@message
class Beams:
    """A scan without the robot's motion in it."""

    ends: Array  # (N, 2) [m], NaN where nothing was measured
    hits: Array  # (N,) bool: ends that are something
    viewpoint: Pose = Pose()  # robot_from_laser of the laser that took it

    @property
    def points(self) -> Array:
        """The ends that are something, (M, 2) [m]."""
        return self.ends[self.hits]


@message
class BearingSet:
    """Directions in which something is seen or heard from one place at one time; how far it is nobody measured."""

    stamp: float  # [s]
    eye: Pose  # robot_from_eye (or ear), at that time in the robot frame of the frame that it comes with
    bearings: Array  # (M,) [rad] in the eye's axes
    sds: Array  # (M,) [rad]
    looks: Array  # (M,) what distinguishes one from another: an edge's step in brightness, left to right; 0: nothing


@message
class FramePerception:
    """Beams, sightings and edge pairs of one frame."""

    beams: Beams | None = None  # None: no scan came with this frame
    sightings: tuple[Sighting, ...] | None = None  # of landmarks; None: no scan came
    camera: Camera | None = None  # that had to see a corner, too; None: the laser alone says what is missing
    edges: BearingSet | None = None  # vertical edges that confirm no corner; None: no picture was looked at
    pairs: tuple[EdgePair, ...] = ()  # corners and the edges near them: whether the camera's mount has moved
