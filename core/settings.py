"""All settings in one value, and the TOML file that changes some of them.

[steering]
lookahead = 0.3
[simulation]
wheel_noise = "paper"
"""

import dataclasses
import difflib
import logging
import tomllib
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal

from core.calibration.laser.drift import DriftSettings
from core.errors import BadInput, BadSettings
from core.files import text_of
from core.gate import Limits
from core.navigation.person_following import PersonFollowingSettings
from core.navigation.planner import PlannerSettings
from core.navigation.steering import SteeringSettings
from core.navigation.wall import WallSettings
from core.perception.image_quality.quality import PictureSettings
from core.perception.landmarks.corners import CornerSettings
from core.perception.landmarks.edges import EdgeSettings
from core.perception.people.parts import PeopleSettings
from core.perception.people.tracked_person import TrackSettings
from core.perception.sound.settings import DirectionFindingSettings
from core.recording import LogSettings
from core.recording.settings import RecordingSettings
from core.setting import Meta, Section, declared_settings, thresholds_of
from core.simulation.settings import SimulationSettings
from core.slam.bearings.bearing_landmarks import BearingSettings, VoiceLandmarkSettings
from core.slam.ekf_slam import EkfSettings
from core.slam.map.closure import ClosureSettings
from core.slam.map.occupancy import OccupancySettings
from core.slam.map.submap import SubmapSettings
from core.slam.motion import MotionSettings
from core.slam.relocalization.kidnap_detector import KidnapSettings
from core.slam.scan_matching.field_matching import ScanMatchingSettings
from core.slam.scan_matching.scan_odometry import ScanOdometrySettings
from core.slam.scan_matching.time_offset import TimeOffsetSettings
from core.speech.settings import SpeechSettings
from core.speech.synthesis import VoiceSettings

log = logging.getLogger(__name__)

MAX_SETTINGS_BYTES = 1_000_000  # bytes of a settings file
FORMER = {
    "company": "person_following",
    "floor": "submaps",
    "alarm": "localization_monitor",
    "picture": "image_quality",
    "hearing": "direction_finding",
}
"""Sections under their former names, read for one version more."""


PRINTED_GATE = 9.21  # χ² of range and bearing at 99 %; the chapter says "a threshold"
PRINTED_MISSES = 10.0  # of a landmark that is suppressed; the chapter says "a specific number"
ChapterMode = Literal["ours", "printed"]
NEVER_FOUND_AGAIN, NEVER_SLIPS = 1000, 50  # the largest values: what needs so many together does not happen


@dataclass(frozen=True)
class ChapterSettings(Section):
    """The chapter's forms, or ours.

    Watch:
        mode: the pose's error, and NIS
        laser_reference: *Laser alone* in Estimate, and the time of an update in SLAM
    """

    mode: Annotated[
        ChapterMode, Meta(meaning="printed: the chapter's own equations in the place of our forms", common=True)
    ] = "ours"
    laser_reference: Annotated[
        bool, Meta(meaning="a second position by laser and wheels alone, for comparison", common=True)
    ] = False


@dataclass(frozen=True)
class Settings:
    """One section per room; every section stands with its algorithm."""

    corners: CornerSettings = field(default_factory=CornerSettings)
    edges: EdgeSettings = field(default_factory=EdgeSettings)
    image_quality: PictureSettings = field(default_factory=PictureSettings)
    drift: DriftSettings = field(default_factory=DriftSettings)
    direction_finding: DirectionFindingSettings = field(default_factory=DirectionFindingSettings)
    speech: SpeechSettings = field(default_factory=SpeechSettings)
    voice: VoiceSettings = field(default_factory=VoiceSettings)
    motion: MotionSettings = field(default_factory=MotionSettings)
    ekf: EkfSettings = field(default_factory=EkfSettings)
    edge_landmarks: BearingSettings = field(default_factory=BearingSettings)
    voice_landmarks: VoiceLandmarkSettings = field(default_factory=VoiceLandmarkSettings)
    scan_odometry: ScanOdometrySettings = field(default_factory=ScanOdometrySettings)
    time_offset: TimeOffsetSettings = field(default_factory=TimeOffsetSettings)
    occupancy: OccupancySettings = field(default_factory=OccupancySettings)
    submaps: SubmapSettings = field(default_factory=SubmapSettings)
    matching: ScanMatchingSettings = field(default_factory=ScanMatchingSettings)
    closures: ClosureSettings = field(default_factory=ClosureSettings)
    localization_monitor: KidnapSettings = field(default_factory=KidnapSettings)
    planner: PlannerSettings = field(default_factory=PlannerSettings)
    steering: SteeringSettings = field(default_factory=SteeringSettings)
    wall: WallSettings = field(default_factory=WallSettings)
    person_following: PersonFollowingSettings = field(default_factory=PersonFollowingSettings)
    people: PeopleSettings = field(default_factory=PeopleSettings)
    tracking: TrackSettings = field(default_factory=TrackSettings)
    log: LogSettings = field(default_factory=LogSettings)
    recording: RecordingSettings = field(default_factory=RecordingSettings)
    simulation: SimulationSettings = field(default_factory=SimulationSettings)
    limits: Limits = field(default_factory=Limits)
    chapter: ChapterSettings = field(default_factory=ChapterSettings)


def load(path: Path | str | None) -> Settings:
    """Settings with what the file changes; None: the defaults. Raises BadInput with a sentence for every fault."""
    if path is None:
        return Settings()
    path = Path(path)
    try:
        if path.stat().st_size > MAX_SETTINGS_BYTES:
            raise BadInput(f"{path.name} is too large for settings.")
        text = text_of(path.read_bytes(), path.name)
    except OSError as trouble:
        raise BadInput(f"The settings {path.name} cannot be read: {trouble.strerror or trouble}.") from None
    try:
        return read(text, path.name)
    except BadInput as wrong:
        raise BadSettings(str(wrong)) from None


def read(text: str, name: str = "settings") -> Settings:
    """TOML text → settings. `name` is what the sentences call it. Raises BadInput."""
    try:
        document = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError, ValueError) as trouble:
        raise BadInput(f"{name} is not valid TOML: {trouble}.") from None
    document = {_renamed(section, document, name): values for section, values in document.items()}
    defaults = Settings()
    for key, value in document.items():
        if key not in vars(defaults) and not isinstance(value, dict | list):
            owners = [f"[{one}]" for one, kind in vars(defaults).items() if key in _names_of(kind)]
            if owners:
                raise BadInput(
                    f"{name}: {_shown(key)} stands before any section; write it under {' or '.join(owners)}."
                )
    sections = _checked(document, vars(defaults), f"{name}: there is no section", "[{}]")
    changed = {key: _section(getattr(defaults, key), values, f"{name}: [{key}]") for key, values in sections.items()}
    settings = dataclasses.replace(defaults, **changed)
    return as_printed(settings) if settings.chapter.mode == "printed" else settings


def section_kinds() -> dict[str, type[Section]]:
    """Name of every section of a settings file → its class."""
    return {name: type(section) for name, section in vars(Settings()).items()}


def changed(settings: Settings, values: Mapping[str, Any]) -> Settings:
    """Settings with others by name ("ekf.gate"). Raises BadSettings, with the nearest names of one that is not."""
    sections: dict[str, Section] = dict(vars(settings))
    for name, value in values.items():
        section, _, key = name.partition(".")
        default = sections.get(section)
        if default is None or key not in vars(default):
            raise BadSettings(f"There is no setting {_shown(name)}; near are {', '.join(_near(name, sections))}.")
        if key in thresholds_of(type(default)):
            raise BadSettings(no_longer(name, default, [key]))
        try:
            sections[section] = _section(default, {key: value}, f"[{section}]")
        except BadInput as wrong:
            raise BadSettings(str(wrong)) from None
    return dataclasses.replace(settings, **sections)


def _names_of(section: Section) -> list[str]:
    return [one.name for one in declared_settings(type(section))]


def _near(name: str, sections: Mapping[str, Section]) -> list[str]:
    known = [f"{section}.{one.name}" for section, kind in sections.items() for one in declared_settings(type(kind))]
    own = [one for one in known if one.partition(".")[2] == name.rpartition(".")[2]]
    close = difflib.get_close_matches(name, known, 3, 0.5)
    return list(dict.fromkeys((*own, *close)))[:3] or ["`beckon settings` lists them"]


def no_longer(where: str, section: Section, names: list[str]) -> str:
    """A sentence about thresholds of a section that a file or an option, `where`, still names."""
    values = ", ".join(_shown(str(getattr(section, name))) for name in names)
    if len(names) == 1:
        return f"{where} is no longer a setting: it is fixed at {values}; remove it."
    return f"{where} are no longer settings: they are fixed at {values}; remove them."


def as_printed(settings: Settings) -> Settings:
    """The chapter's own forms in the place of ours; noises, limits, planning and everything else stay.

    Eq. 14-33 alone: no scan matching and no loop closure, plain gated nearest neighbour, R of eq. 43 for every
    sighting, hits and misses counted to fixed numbers, a vertical edge required of every corner, no landmark that is
    no corner; eq. 35-40 for the direction of a voice. The numbers of hits and misses are not in the print.
    """
    ekf = dataclasses.replace(
        settings.ekf,
        mode="paper",
        sighting_noise="paper",
        form="nearest",
        gate=PRINTED_GATE,
        soft_gate=0.0,
        still_scans=0,
        at_once=0,
        misses=PRINTED_MISSES,
        misses_share=0.0,
        double_reach=0.0,
        found_again=NEVER_FOUND_AGAIN,
        slip_fewest=NEVER_SLIPS,
    )
    return dataclasses.replace(
        settings,
        chapter=dataclasses.replace(settings.chapter, mode="printed"),
        ekf=ekf,
        edge_landmarks=dataclasses.replace(settings.edge_landmarks, used=False),
        voice_landmarks=dataclasses.replace(settings.voice_landmarks, used=False),
        edges=dataclasses.replace(settings.edges, edge_required=True, on_walls=False),
        matching=dataclasses.replace(settings.matching, corrects=False),
        direction_finding=dataclasses.replace(settings.direction_finding, form="paper"),
    )


def _renamed(section: str, document: Mapping[str, Any], name: str) -> str:
    """Return a section's present name; a former one is reported. Raises BadInput where both stand in the file."""
    present = FORMER.get(section, section)
    if present != section:
        if present in document:
            raise BadInput(f"{name} has [{present}] and its former name [{section}]; leave only [{present}].")
        log.warning("%s: [%s] is now [%s]; the former name is read for one version more.", name, section, present)
    return present


def _section(default: Section, given: Any, where: str) -> Section:
    if not isinstance(given, dict):
        raise BadInput(f"{where} must be a section with settings under it.")
    fixed = [name for name in given if name in thresholds_of(type(default))]
    if fixed:
        _notice(no_longer(f"{where} {', '.join(fixed)}", default, fixed))
    declared = {setting.name: setting for setting in declared_settings(type(default))}
    values = _checked(
        {name: given[name] for name in given if name not in fixed}, declared, f"{where} has no setting", "{}"
    )
    try:
        return dataclasses.replace(default, **{key: declared[key].fit(value) for key, value in values.items()})
    except BadInput as trouble:
        raise BadInput(f"{where} {trouble}") from None


@cache
def _notice(sentence: str) -> None:
    """Say it once, however often the file is read."""
    log.warning(sentence)


def _checked(given: dict[str, Any], known: Collection[str], complaint: str, form: str) -> dict[str, Any]:
    for key in given:
        if key not in known:
            close = difflib.get_close_matches(key, known, 1)
            advice = f"did you mean {form.format(close[0])}?" if close else f"known are {', '.join(known)}."
            raise BadInput(f"{complaint} {form.format(_shown(key))}; {advice}")
    return given


def _shown(key: str) -> str:
    """A key from a file, harmless and short."""
    return "".join(letter if letter.isprintable() else "?" for letter in key[:40])
