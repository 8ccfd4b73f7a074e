"""The runtime of a console, with the parts that its options ask for."""

from pathlib import Path

from console.access.guard import Access
from console.connection.reach import Reach
from console.connection.service import ConnectionService
from console.control.text_file_commands import TextFileCommands
from console.control.text_files import TextFileReader, TextFileWriter
from console.fleet.member import FleetMember
from console.maps.service import MapService
from console.options import Options, member_options
from console.part import BackgroundTask
from console.people.inhabitants import move_in
from console.recording.recorder import RecorderService
from console.robot.supervisor import RobotSupervisor
from console.runtime import Runtime
from console.service_manager import ServiceManagerWatchdog
from console.speech.room_transcription import RoomTranscriber
from console.speech.spoken_text_files import SpokenTextFiles
from core.pilot import Pilot
from core.settings import Settings


def make_runtime(
    options: Options,
    robot: RobotSupervisor,
    address: str,
    *,
    home: Path,
    access: Access,
    settings: Settings,
    settings_file: Path | None,
) -> Runtime:
    """The runtime; `address` of this console, as a fleet opens it. Raises BadInput."""
    runtime = Runtime(
        robot,
        lambda: Pilot(robot.profile, settings),
        home=home,
        access=access,
        settings=settings,
        settings_file=settings_file,
    )
    runtime.parts.add(ServiceManagerWatchdog())
    add_parts(options, address, runtime)
    runtime.parts[RecorderService].foxglove_port = options.foxglove or 0
    runtime.parts[ConnectionService].reach = Reach(options.connect)
    return runtime


def add_parts(options: Options, address: str, runtime: Runtime) -> None:
    """Add the parts that options ask for; `address` of this console, as a fleet opens it. Raises BadInput."""
    if not options.nobody:
        runtime.parts.add(BackgroundTask(lambda: move_in(runtime.ask, options.robot)))
    exchange_text_files(options, runtime)
    if (member := member_options(options)) is not None:
        certificate = "" if options.tls_cert is None else shown_certificate(options.tls_cert)
        runtime.parts.add(
            FleetMember(
                member,
                address,
                certificate,
                robot=runtime.robot,
                dispatcher=runtime.dispatcher,
                lease=runtime.lease,
                notifications=runtime.notifications,
                logins=runtime.access.logins,
                maps=runtime.parts[MapService],
            )
        )


def exchange_text_files(options: Options, runtime: Runtime) -> None:
    """Obey what another program writes, and write what the robot's microphones understood. Raises BadInput."""
    if options.text_files is not None:
        files = TextFileReader(options.text_files)
        parts = (runtime.dispatcher, runtime.lease, runtime.history, runtime.notifications)
        runtime.parts.add(TextFileCommands(files, *parts, lambda: runtime.snapshot))
    if options.write_text_files is not None:
        writer = SpokenTextFiles(
            TextFileWriter(options.write_text_files, "--write-text-files"), runtime.notifications
        )
        runtime.parts[RoomTranscriber].when_heard.append(writer.heard)
        runtime.parts.add(writer)


def shown_certificate(path: Path) -> str:
    """The certificate (PEM) that a server shows of this file: its first."""
    begin, end = "-----BEGIN CERTIFICATE-----", "-----END CERTIFICATE-----"
    inner = path.read_text(errors="replace").partition(begin)[2].partition(end)[0]
    return f"{begin}{inner}{end}\n"
