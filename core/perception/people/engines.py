"""The detectors behind the protocol, and the factory that opens the one that the settings ask for."""

from pathlib import Path

from core.errors import Unavailable
from core.models import MODELS, checked_folder, find
from core.perception.people.brightness import levelled
from core.perception.people.camera_geometry import around, axis
from core.perception.people.detector import Rectangle, find_people
from core.perception.people.looking import LookQuestion, PersonDetector
from core.perception.people.onnx.detector import open_own_model
from core.perception.people.parts import PeopleSettings
from core.perception.people.pose.detector import open_pose
from core.perception.people.vertical_plane import VerticalPlanes
from core.sentences import Statement, plain

# The embedded detector behind the protocol: it was taught with drawn figures, and knows nothing else.

DRAWN_DETECTOR_SENTENCE = plain(Statement("people.embedded"))
ANYWHERE_HALF_RAD = 0.5  # to either side where no direction is known


class DrawnDetector:
    """Part models of general.npz on vertical planes."""

    name = "drawn"
    says = DRAWN_DETECTOR_SENTENCE

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


MODEL = "people"  # of core.models.MODELS


def open_detector(settings: PeopleSettings) -> PersonDetector:
    """Open the detector that the settings name. Raises Unavailable or BadInput with a sentence."""
    if not sees_people(settings):
        return DrawnDetector(settings)
    if settings.model:
        return open_own_model(Path(settings.model).expanduser(), settings)
    found = find(MODEL)
    if found is None:
        raise Unavailable(f"The pose networks are not here. {how_to_get()}")
    return open_pose(checked_folder(found, MODEL), settings)


def sees_people(settings: PeopleSettings) -> bool:
    """Return whether the detector that the settings name knows real people."""
    if settings.engine == "auto":
        return bool(settings.model) or find(MODEL) is not None
    return settings.engine == "pose"


def engine_of(settings: PeopleSettings) -> str:
    """Return the name of that detector."""
    return "pose" if sees_people(settings) else "drawn"


def says(settings: PeopleSettings) -> str:
    """Return a sentence on the detector that looks for people now."""
    return Statement("people.pose_networks") if sees_people(settings) else DRAWN_DETECTOR_SENTENCE


def how_to_get() -> str:
    """How to get the networks that see real people, in a sentence."""
    return f"Run: beckon models get {MODEL} ({MODELS[MODEL].megabytes} MB)."
