"""From options to a running console: port, tokens, the robot, the server, and an end that is prompt.

What it takes to open the robot is imported here; the web stack, which takes longer, while the robot is being opened.
"""

import contextlib
import ctypes
import gc
import os
import sys
import threading
import time
from dataclasses import replace
from pathlib import Path
from typing import Literal

from console.access.browser import browse
from console.access.guard import Access
from console.access.logins import LINK_LIFE, Logins, new_token
from console.access.records import AccessFile
from console.access.token_file import read_token
from console.data_folder import home_folder, locked
from console.http import qr
from console.http.connection_limits import raise_file_limit
from console.logging_setup import start_logging
from console.options import (
    LOOPBACK,
    Options,
    address_of,
    bound,
    check,
    hosts_of,
    in_address,
    is_readable,
    is_wildcard,
    settings_file,
)
from console.robot.supervisor import RobotSupervisor
from console.service_manager import notify
from core.errors import BadInput, BeckonError, Unavailable
from core.gate.scheduling import CONSOLE_RANK, come_first
from core.sentences import Statement
from core.settings import load
from core.speech.recognition.engines import chosen
from core.speech.settings import SpeechSettings

SWITCH_INTERVAL_S = 0.001  # after which a computing thread lets the event loop in
ONCE_LIFE = 120.0  # [s] in which the browser that is opened here has to come
M_ARENA_MAX = -8  # of glibc's mallopt
READABLE = (
    "Others on the network can read along and take over: this is plain HTTP, and phones give it no microphone. "
    "Start with --tls-cert and --tls-key, or put TLS in front of it."
)


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
    os.umask(0o077)  # what the console writes is its owner's alone
    take_precedence(options)
    share_arenas()
    sys.setswitchinterval(SWITCH_INTERVAL_S)
    most = raise_file_limit()
    with locked(home) as lock, bound(options.host, options.port) as listener:
        if first:
            start_logging(options.log or home / "console.log", as_json=options.log_json)
        port = int(listener.getsockname()[1])
        address = address_of(options, port)
        lock.announce(port, address)
        logins = Logins(AccessFile(home), time.time() - time.monotonic())
        damaged = logins.open_file()
        hosts = hosts_of(options.host, *options.allow_hosts)
        elsewhere = "" if in_address(options.host) in LOOPBACK else address
        access = Access(logins, hosts, f"beckon_{port}", elsewhere, options.no_auth)
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
                options, robot, address, home=home, access=access, settings=settings, settings_file=file
            )

            def listening() -> None:
                with contextlib.suppress(BeckonError):  # where nothing reads words, who speaks reads so
                    chosen(settings.speech)
                    runtime.parts[RoomTranscriber].warm(robot.profile.microphones)
                gc.enable()
                gc.freeze()  # objects loaded by now stay; to go through it again and again takes 70 ms each time
                if first:
                    announce(options, port, access)
                    warn_without_words(settings.speech)
                notify("READY=1")
                for level, words in first_notices(options, trouble, damaged):
                    runtime.notifications.tell(level, words)

            config = configured(create_app(runtime), options.tls_cert, options.tls_key, most)
            server = Server(config, runtime, listening)
            connections = runtime.parts[ConnectionService]
            connections.leave = server.leave
            recording = options.robot.removeprefix("log:")
            if recording != options.robot and Path(recording).exists():
                sys.stderr.write(f"Reading {recording}…\n")
            came_to_its_end = run_until_left(server, listener, runtime)
            return (connections.other if came_to_its_end else ""), port


def first_notices(options: Options, trouble: str, damaged: str) -> list[tuple[Literal["error", "warning"], str]]:
    """The notices of a start: why another robot did not come, that others can read along, which logins were lost."""
    found: list[tuple[Literal["error", "warning"], str]] = [("error", trouble)] if trouble else []
    readable = READABLE if is_readable(options) else ""
    return [*found, *(("warning", words) for words in (readable, damaged) if words)]


def share_arenas() -> None:
    """Let all threads share two arenas: glibc keeps what each has freed in its own one, 27 MB after a single page."""
    with contextlib.suppress(AttributeError, TypeError):  # another C library
        ctypes.CDLL(None).mallopt(M_ARENA_MAX, 2)


def announce(options: Options, port: int, access: Access) -> None:
    """Tell the address, with a key behind the #, which no server and no log ever sees."""
    address, logins, now = address_of(options, port), access.logins, time.monotonic()
    if access.no_auth:
        sys.stdout.write(f"Beckon is at {address}\n")
    else:
        driving, watching = operator_key(options, access, now), new_token()
        logins.admit(watching, "viewer", "viewer", "start", now, end=now + LINK_LIFE)
        sys.stdout.write(f"Beckon is at {address}#t={driving}\nTo watch only: {address}#t={watching}\n")
        if access.address and sys.stdout.isatty():
            sys.stdout.write(f"On a phone:\n{qr.drawn(f'{address}#t={driving}')}")
    sys.stdout.flush()
    if is_readable(options):
        sys.stderr.write(f"{READABLE}\n")
    if options.open_browser:
        scheme = address.partition(":")[0]
        here = f"{scheme}://127.0.0.1:{port}/" if is_wildcard(options.host) else address
        once = "" if access.no_auth else f"#t={logins.issue('operator', 'admin', once=True, end=now + ONCE_LIFE)}"
        opening = (here + once, home_folder(options.data), ONCE_LIFE)
        threading.Thread(target=browse, args=opening, name="browser", daemon=True).start()


def warn_without_words(settings: SpeechSettings) -> None:
    """Say where nothing understands speech, and the command that changes it."""
    try:
        chosen(settings)
    except BeckonError as why:
        sys.stderr.write(f"Spoken commands: none. {why}\n")


def operator_key(options: Options, access: Access, now: float) -> str:
    """The operator's key of --token-file, else a new one of the administrator: who started the console has read it.

    What such a file held before opens nothing more.
    """
    if options.token_file is None:
        token = new_token()
        access.logins.supersede("file")
        access.logins.admit(token, "operator", "admin", "start", now, end=now + LINK_LIFE)
        return token
    token = read_token(options.token_file)
    access.logins.supersede("file", access.logins.admit(token, "operator", "operator", "file", now))
    return token


def take_precedence(options: Options) -> None:
    """Run before other programs where a real robot may move, or where it is asked for."""
    if options.precedence or not options.robot.startswith(("sim:", "log:")):
        come_first(CONSOLE_RANK)  # all threads: each may hold what the pilot needs next
