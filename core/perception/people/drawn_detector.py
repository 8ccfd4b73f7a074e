"""The embedded detector behind the protocol: it was taught with drawn figures, and knows nothing else."""

from __future__ import annotations

from core.perception.people.brightness import levelled
from core.perception.people.camera_geometry import around, axis
from core.perception.people.detector import Rectangle, find_people
from core.perception.people.looking import LookQuestion
from core.perception.people.parts import PeopleSettings
from core.perception.people.vertical_plane import VerticalPlanes

SAYS = (
    "The embedded detector looks for people: it was taught with drawn figures and knows those of the simulator only. "
    "For real people run: beckon models get people"
)
ANYWHERE_HALF_RAD = 0.5  # to either side where no direction is known


class DrawnDetector:
    """Part models of general.npz on vertical planes."""

    name = "drawn"
    says = SAYS

    def __init__(self, settings: PeopleSettings | None = None) -> None:
        self._settings = settings or PeopleSettings()

    def look(self, question: LookQuestion) -> tuple[Rectangle, ...]:
        """Search the planes where someone may stand."""
        camera = question.camera
        boards = VerticalPlanes(levelled(question.pixels), camera)
        bearing = axis(camera) if question.bearing is None else question.bearing
        half = ANYWHERE_HALF_RAD if question.bearing is None else self._settings.wedge * question.sd
        planes = around(list(question.distances)) or None
        return find_people(boards, bearing, half, self._settings, distances=planes)
