"""Search of one picture for a person, a few planes with every frame: no frame of the pilot takes long."""

from collections.abc import Sequence

from core.geometry import Pose
from core.perception.people.appearance import PersonProfile
from core.perception.people.camera_geometry import around
from core.perception.people.detector import Rectangle, apart, every_distance, everybody
from core.perception.people.legs import LegCluster
from core.perception.people.parts import PeopleSettings
from core.perception.people.vertical_plane import VerticalPlanes

MAX_PLANES = 6  # with one frame


class Search:
    """First where the laser sees something that may be legs, then everywhere."""

    def __init__(
        self,
        boards: VerticalPlanes,
        towards: tuple[float, float],
        near: Sequence[float],
        settings: PeopleSettings,
        who: PersonProfile | None,
    ) -> None:
        """`towards`: bearing and half the wedge's width [rad]; `near` [m] from the camera: where something stands."""
        self.boards = boards
        self._towards, self._settings, self._who = towards, settings, who
        hinted = _pieces(around(list(near)))
        self._rest = [*hinted, *_pieces(every_distance(settings).tolist())]
        self._hinted = len(hinted)
        self._found: list[Rectangle] = []
        self._strangers = False

    def go_on(self) -> tuple[Rectangle, ...] | None:
        """A few planes further → who was found, best first, once that is known; None: not yet."""
        planes = self._rest.pop(0)
        self._hinted -= 1
        for one in everybody(self.boards, self._towards, planes, self._settings, self._who):
            self._strangers |= one.stranger
            if not one.stranger:
                self._found.append(one)
        if not self._rest or (self._hinted == 0 and any(map(self._is_enough, self._found))):
            return apart(self._found, self._settings)
        return None

    def _is_enough(self, rectangle: Rectangle) -> bool:
        """Return whether it is a body, or surely its feet: what resembles feet may be a table's legs."""
        settings = self._settings
        return rectangle.shown >= settings.enough or rectangle.value >= settings.threshold_of_feet

    @property
    def strangers(self) -> bool:
        """True when people are there, but none of those searched for."""
        return self._strangers and not self._found


class Glance:
    """A search, and how the robot stood when the picture was taken."""

    def __init__(self, search: Search, stamp: float, pose: Pose, standers: tuple[LegCluster, ...]) -> None:
        self.search, self.stamp, self.pose, self.standers = search, stamp, pose, standers


def _pieces(distances: list[float]) -> list[list[float]]:
    return [distances[begin : begin + MAX_PLANES] for begin in range(0, len(distances), MAX_PLANES)]
