"""From options to a running console: port, tokens, the robot, the server, and an end that is prompt.

What it takes to open the robot is imported here; the web stack, which takes longer, while the robot is being opened.
"""

import contextlib
import gc
import sys
from dataclasses import replace
from pathlib import Path
from typing import Literal

from console.data_folder import home_folder
from console.listening import READABLE_BY_OTHERS_WARNING, announce, listening
from console.options import Options, check, is_readable, settings_file
from console.robot.supervisor import RobotSupervisor
from console.service_manager import notify
from core.errors import BadInput, BeckonError, Unavailable
from core.gate.scheduling import CONSOLE_RANK, come_first
from core.heap import share_arenas
from core.sentences import Statement
from core.settings import load
from core.speech.recognition.engines import chosen
from core.speech.settings import SpeechSettings

SWITCH_INTERVAL_S = 0.001  # after which a computing thread lets the event loop in


def serve(options: Options) -> None:
    """Run the console until a signal ends it. Raises BadInput and Unavailable with a sentence.

    An operator may open a recording or a simulated robot on the page, at the same address; where that does not come,
    the robot before comes back.
    """
    check(options)
    shown: Options | None = None  # the last that came
    trouble = ""
    while True:
        try:
            url, port = serve_robot(options, first=shown is None, trouble=trouble)
        except (BadInput, Unavailable) as why:
            if shown is None or options == shown:
                raise
            options, trouble = shown, Statement("connect.not_opened", robot=options.robot, why=why)
            continue
        if not url:
            return
        shown, trouble = replace(options, port=port, open_browser=False), ""
        options = replace(shown, robot=url)


def serve_robot(options: Options, *, first: bool = True, trouble: str = "") -> tuple[str, int]:
    """Run the console with one robot → the URL of the one to open next, "" after a signal, and the port.

    `first`: with this process; `trouble`: a sentence to show. Raises BadInput and Unavailable with a sentence.
    """
    home = home_folder(options.data)
    file = settings_file(options, home)
    settings = load(file)
    take_precedence(options)
    share_arenas()
    sys.setswitchinterval(SWITCH_INTERVAL_S)
    with listening(options, home, logs=first) as web:
        robot = RobotSupervisor(
            options.robot,
            seed=options.seed,
            limits=settings.limits,
            home=home,
            gate_trace=options.gate_trace,
            settings_file=file,
        )
        with contextlib.closing(robot):
            robot.launch()  # a process of its own
            from console.app import create_app
            from console.assembly import make_runtime
            from console.connection.service import ConnectionService
            from console.http.server import Server, configured, run_until_left
            from console.speech.room_transcription import RoomTranscriber

            runtime = make_runtime(
                options, robot, web.address, home=home, access=web.access, settings=settings, settings_file=file
            )

            def ready() -> None:
                with contextlib.suppress(BeckonError):  # where nothing reads words, who speaks reads so
                    chosen(settings.speech)
                    runtime.parts[RoomTranscriber].warm(robot.profile.microphones)
                gc.enable()
                gc.freeze()  # objects loaded by now stay; to go through it again and again takes 70 ms each time
                if first:
                    announce(options, web.port, web.access)
                    sys.stderr.writelines(f"{sentence}\n" for sentence in robot.profile.notices)
                    warn_without_words(settings.speech)
                notify("READY=1")
                for level, words in first_notices(options, trouble, web.damaged):
                    runtime.notifications.tell(level, words)

            config = configured(create_app(runtime), options.tls_cert, options.tls_key, web.most)
            server = Server(config, runtime, ready)
            connections = runtime.parts[ConnectionService]
            connections.leave = server.leave
            recording = options.robot.removeprefix("log:")
            if recording != options.robot and Path(recording).exists():
                sys.stderr.write(f"Reading {recording}…\n")
            came_to_its_end = run_until_left(server, web.listener, runtime)
            return (connections.other if came_to_its_end else ""), web.port


def first_notices(options: Options, trouble: str, damaged: str) -> list[tuple[Literal["error", "warning"], str]]:
    """The notices of a start: why another robot did not come, that others can read along, which logins were lost."""
    found: list[tuple[Literal["error", "warning"], str]] = [("error", trouble)] if trouble else []
    readable = READABLE_BY_OTHERS_WARNING if is_readable(options) else ""
    return [*found, *(("warning", words) for words in (readable, damaged) if words)]


def warn_without_words(settings: SpeechSettings) -> None:
    """Say where nothing understands speech, and the command that changes it."""
    try:
        chosen(settings)
    except BeckonError as why:
        sys.stderr.write(f"Spoken commands: none. {why}\n")


def take_precedence(options: Options) -> None:
    """Run before other programs where a real robot may move, or where it is asked for."""
    if options.precedence or not options.robot.startswith(("sim:", "log:")):
        come_first(CONSOLE_RANK)  # all threads: each may hold what the pilot needs next
