"""The capabilities of the console: every part, and what it is made of. A new one is one row."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from console.broadcast import Broadcaster
from console.calibration.microphones import MicrophoneCalibration
from console.calibration.service import CalibrationService
from console.connection.service import ConnectionService
from console.control.dispatcher import CommandDispatcher
from console.control.history import History
from console.control.lease import Lease
from console.control.notices import Notifications
from console.control.own_navigation import OwnNavigationService
from console.control.pending_commands import PendingCommands
from console.control.picture_floor import PictureFloor
from console.control.playback import PlaybackController
from console.control.settings_in_use import SettingsInUse
from console.data_folder import SETTINGS_FILE
from console.experiments.runs import ExperimentRuns
from console.maps.edits import EditService
from console.maps.places import PlaceService
from console.maps.routes import RouteService
from console.maps.service import MapService
from console.maps.zones import ZoneService
from console.part import Part, Parts
from console.people.look_service import LookService
from console.people.service import EnrollmentService
from console.recording.recorder import RecorderService
from console.recording.store import RecordingStore
from console.robot.supervisor import RobotSupervisor
from console.speech.browser_microphone import BrowserMicrophone
from console.speech.listener import SpokenOutcome
from console.speech.quality_runs import QualityRuns
from console.speech.robot_voice import RobotVoice
from console.speech.room_transcription import RoomTranscriber
from console.speech.voice_commands import VoiceCommands
from core.sensors import SensorFrame
from core.sensors.microphones import MicrophoneArray, Sound
from core.settings import Settings
from core.snapshot import VoiceDirection


@dataclass(frozen=True, kw_only=True)
class ConsoleBase:
    home: Path
    settings: Settings
    settings_file: Path | None  # None: in the data folder
    robot: RobotSupervisor
    lease: Lease
    history: History
    dispatcher: CommandDispatcher
    notifications: Notifications
    broadcaster: Broadcaster
    recalibrated: Callable[[], None]  # a part sees the robot otherwise: the pilot looks through it from now on
    adopted: Callable[[Settings], None]  # settings that are declared live have changed


def drive_recorder(base: ConsoleBase, parts: Parts) -> RecorderService:
    """The words near the robot go into its recordings, too."""
    calibrations = (base.home / "calibration", base.settings_file or base.home / SETTINGS_FILE)
    recorder = RecorderService(
        base.settings.recording,
        parts[RecordingStore],
        base.robot,
        base.history,
        base.notifications,
        base.lease,
        calibrations,
    )

    def heard(outcome: SpokenOutcome, _: VoiceDirection | None) -> None:
        decision = outcome.utterance.decision
        if outcome.utterance.final:
            recorder.heard(decision.words, decision.verdict, decision.command and decision.command.heard_as)

    parts[RoomTranscriber].when_heard.append(heard)
    parts[RouteService].when_noted.append(recorder.note)
    parts[RouteService].recorder = recorder
    return recorder


def own_navigation(base: ConsoleBase, _: Parts) -> OwnNavigationService:
    """Its goals end with everything that ends a command of Beckon's."""
    service = OwnNavigationService(base.robot, base.dispatcher, base.history, base.notifications)
    base.dispatcher.when_cancelled.append(service.stop_soon)
    return service


def room_transcriber(base: ConsoleBase, parts: Parts) -> RoomTranscriber:
    """It reads no words while the microphones are checked: what is said then is no order."""
    array = parts[MicrophoneCalibration]

    def source(frame: SensorFrame) -> tuple[Sound | None, MicrophoneArray | None]:
        return None if array.helped else frame.sound, base.robot.profile.microphones

    transcriber = RoomTranscriber(
        parts[VoiceCommands],
        parts[PendingCommands],
        base.dispatcher,
        base.notifications,
        base.settings.speech,
        source,
    )
    transcriber.keep_up = partial(base.robot.reach, part="ears")
    return transcriber


def places(base: ConsoleBase, parts: Parts) -> PlaceService:
    """Everything that reads words learns their names."""
    service = PlaceService(parts[MapService], base.dispatcher)
    service.when_changed += [parts[RoomTranscriber].learn, parts[BrowserMicrophone].learn]
    return service


CAPABILITIES: tuple[Callable[[ConsoleBase, Parts], Part], ...] = (
    lambda base, _: CalibrationService(
        base.home,
        base.robot,
        base.broadcaster,
        base.notifications.tell,
        base.recalibrated,
        printed=base.settings.chapter.mode == "printed",
    ),
    lambda base, _: MicrophoneCalibration(base.home, base.robot, base.recalibrated),
    lambda base, _: PictureFloor(base.robot, base.broadcaster),
    lambda base, _: MapService(base.home, base.settings, base.robot, base.dispatcher, base.lease, base.history),
    own_navigation,
    lambda base, parts: EnrollmentService(
        base.home, base.robot, base.dispatcher, base.notifications.tell, lambda: parts[CalibrationService].newest
    ),
    lambda base, _: LookService(base.settings.people, lambda words: base.notifications.tell("warning", words)),
    lambda base, _: PendingCommands(base.dispatcher, base.lease, base.history, base.notifications),
    lambda base, parts: VoiceCommands(
        base.dispatcher, base.lease, parts[PendingCommands], base.history, base.notifications
    ),
    room_transcriber,
    lambda base, _: BrowserMicrophone(base.settings.speech),
    places,
    lambda base, parts: ZoneService(parts[MapService], base.robot, base.dispatcher, base.lease),
    lambda base, parts: EditService(parts[MapService], base.dispatcher, base.lease),
    lambda base, _: RobotVoice(settings=base.settings.voice),
    lambda base, parts: RouteService(
        base.home,
        parts[MapService],
        parts[PlaceService],
        base.dispatcher,
        base.lease,
        base.history,
        base.notifications,
        parts[RobotVoice],
    ),
    lambda base, _: SettingsInUse(base.settings, base.settings_file or base.home / SETTINGS_FILE, base.adopted),
    lambda base, parts: ConnectionService(base.home, base.robot, parts[MapService], base.settings.log),
    lambda base, _: QualityRuns(base.home, base.settings.simulation, base.settings.speech),
    lambda base, _: ExperimentRuns(base.home),
    lambda base, _: RecordingStore(base.home, base.settings.recording, base.history, base.notifications),
    drive_recorder,
    lambda base, _: PlaybackController(base.robot, base.history, base.notifications),
)
"""In the order in which they see each snapshot, and the robot's profile; each may use those before it."""


def make_parts(base: ConsoleBase) -> Parts:
    parts = Parts()
    for make in CAPABILITIES:
        parts.add(make(base, parts))
    return parts
