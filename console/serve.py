"""From options to a running console: port, tokens, uvicorn, and an end that is prompt."""

import asyncio
import contextlib
import ctypes
import gc
import ipaddress
import os
import signal
import socket
import ssl
import sys
import threading
import time
from collections.abc import Callable, Generator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from types import FrameType
from typing import Any, Protocol

import uvicorn
from starlette.types import ASGIApp

from console.access.browser import browse
from console.access.guard import HOST_NAME, Access
from console.access.logins import LINK_LIFE, Logins, new_token
from console.access.records import AccessFile
from console.access.token_file import read_token
from console.app import create_app
from console.connection.reach import Reach
from console.connection.service import ConnectionService
from console.control.settings_in_use import NAME as SETTINGS
from console.control.text_file_commands import TextFileCommands
from console.control.text_file_reader import TextFileReader
from console.control.text_file_writer import TextFileWriter
from console.data_folder import home_folder, locked
from console.fleet.authority import CertificateFiles
from console.fleet.bus import FleetAddress
from console.fleet.member import FleetMember, MemberOptions
from console.http import qr
from console.http.connection_limits import MAX_CONNECTIONS, ConnectionLimits, raise_file_limit
from console.http.timeouts import HEADER_TIME, ServerConfig, TimeoutHttp, TimeoutSocket
from console.logging_setup import start_logging
from console.maps.service import MapService
from console.part import BackgroundTask
from console.people.inhabitants import move_in
from console.recording.service import RecordingService
from console.robot.supervisor import RobotSupervisor
from console.runtime import Runtime
from console.service_manager import ServiceManagerWatchdog, notify
from console.speech.room_transcription import RoomTranscriber
from console.speech.spoken_text_files import SpokenTextFiles
from core.errors import BadInput, BeckonError, Unavailable
from core.gate.scheduling import CONSOLE_RANK, come_first
from core.pilot import Pilot
from core.recording.foxglove_server import LOOPBACK_ADDRESS, check_installed
from core.robots.ros.zenoh_session import load_zenoh
from core.sentences import Statement
from core.settings import load
from core.speech.recognition.engines import chosen
from core.speech.settings import SpeechSettings

LOOPBACK = frozenset({"127.0.0.1", "localhost", "[::1]"})
SOCKET_MESSAGE = 16384  # [bytes] at most in one message: the longest sentence takes 12,000
ACCEPTED_AT_ONCE = 16  # connections: each is read before a crowd of strangers behind it can push it out again
MAX_WAITING_CONNECTIONS = 1024  # that wait to be accepted; beyond, a client tries again after a whole second
SWITCH_INTERVAL_S = 0.001  # after which a computing thread lets the event loop in
ONCE_LIFE = 120.0  # [s] in which the browser that is opened here has to come
M_ARENA_MAX = -8  # of glibc's mallopt
PING_PERIOD_S = 5.0  # between pings, and for an answer to one
READABLE = (
    "Others on the network can read along and take over: this is plain HTTP, and phones give it no microphone. "
    "Start with --tls-cert and --tls-key, or put TLS in front of it."
)


@dataclass(frozen=True)
class Options:
    """The options of `beckon run`."""

    robot: str = "sim:lab"
    host: str = "127.0.0.1"
    allow_hosts: tuple[str, ...] = ()  # further names that the console answers to
    port: int = 8420  # 0: any free one
    no_auth: bool = False
    seed: int = 0
    data: Path | None = None  # None: $BECKON_HOME, else the user's data folder
    gate_trace: Path | None = None
    settings: Path | None = None
    open_browser: bool = True
    log: Path | None = None  # None: console.log in the data folder
    log_json: bool = False  # a JSON object a line, on the terminal too
    tls_cert: Path | None = None  # PEM; with it and its key it is HTTPS, which microphones of phones want
    tls_key: Path | None = None
    connect: tuple[str, ...] = ()  # what operators may connect to
    token_file: Path | None = None  # holds the operator's key; None: a new one with every start
    text_files: Path | None = None  # the folder of speech.txt and source.txt
    precedence: bool = False  # run before other programs with a simulated robot, too
    nobody: bool = False  # nobody stands in the simulated room
    foxglove: int | None = None  # the port where Foxglove watches live
    write_text_files: Path | None = None  # another one, for what the robot's microphones understood
    fleet: str = ""  # tls/HOST:PORT of the fleet to join; "": none
    fleet_name: str = ""  # of the robot in it
    fleet_cert: Path | None = None  # folder of its certificate; None: in the data folder


class Endable(Protocol):
    """The work behind a server, which hears of its end."""

    trouble: str  # why it could not start, a sentence

    def shut_down(self) -> None:
        """It is about to end."""
        ...

    def shut_down_soon(self) -> None:
        """The same from a signal handler or any thread."""
        ...


class Server(uvicorn.Server):
    """uvicorn that tells every stream first when it is asked to end."""

    def __init__(self, config: uvicorn.Config, runtime: Endable, listening: Callable[[], None]) -> None:
        super().__init__(config)
        self._runtime = runtime
        self._listening = listening

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Listening; now the address can be shown."""
        loop: Any = asyncio.get_running_loop()
        if self.config.ssl is not None:  # uvicorn hands no such bound on
            loop.create_server = partial(loop.create_server, ssl_handshake_timeout=HEADER_TIME)
        await super().startup(sockets)
        for listener in (each for server in self.servers for each in server.sockets):
            with socket.socket(fileno=os.dup(listener.fileno())) as own:
                own.listen(MAX_WAITING_CONNECTIONS)  # asyncio made the queue as long as what is accepted at once
        self._listening()

    @contextlib.contextmanager
    def capture_signals(self) -> Generator[None]:
        """The terminal that was closed ends the console as orderly as Ctrl-C, unless it was started by nohup."""
        on_main = threading.current_thread() is threading.main_thread()
        if on_main and signal.getsignal(signal.SIGHUP) == signal.SIG_DFL:
            signal.signal(signal.SIGHUP, self.handle_exit)
        with super().capture_signals():
            yield

    def leave(self) -> None:
        """End as after a signal; on the event loop."""
        self._runtime.shut_down()
        self.should_exit = True

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """A signal arrived: only word is left here, the event loop does the rest."""
        self._runtime.shut_down_soon()
        super().handle_exit(sig, frame)


def settings_file(options: Options, home: Path) -> Path | None:
    """The file with changed settings: the one that was named, else that of the data folder where there is one."""
    own = home / SETTINGS
    return options.settings or (own if own.is_file() else None)


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
        runtime = Runtime(
            robot,
            lambda: Pilot(robot.profile, settings),
            home=home,
            access=access,
            settings=settings,
            settings_file=file,
        )
        runtime.parts.add(ServiceManagerWatchdog())
        add_parts(options, address, runtime)
        config = configured(create_app(runtime), options.tls_cert, options.tls_key, most)

        def listening() -> None:
            with contextlib.suppress(BeckonError):  # where nothing reads words, who speaks reads so
                chosen(settings.speech)
                runtime.parts[RoomTranscriber].warm(robot.profile.microphones)
            gc.enable()
            gc.freeze()  # objects loaded by now stay; to go through it again and again would take 70 ms each time
            if first:
                announce(options, port, access)
                warn_without_words(settings.speech)
            if trouble:
                runtime.notifications.tell("error", trouble)
            notify("READY=1")
            if is_readable(options):
                runtime.notifications.tell("warning", READABLE)
            if damaged:
                runtime.notifications.tell("warning", damaged)

        server = Server(config, runtime, listening)
        runtime.parts[RecordingService].foxglove_port = options.foxglove or 0
        runtime.parts[ConnectionService].leave = server.leave
        runtime.parts[ConnectionService].reach = Reach(options.connect)
        recording = options.robot.removeprefix("log:")
        if recording != options.robot and Path(recording).exists():
            sys.stderr.write(f"Reading {recording}…\n")
        came_to_its_end = run_until_left(server, listener, runtime)
        return (runtime.parts[ConnectionService].other if came_to_its_end else ""), port


def run_until_left(server: Server, listener: socket.socket, runtime: Endable) -> bool:
    """Serve → True; False after an interrupt. Raises Unavailable with a sentence where the robot does not come."""
    try:
        server.run(sockets=[listener])
    except KeyboardInterrupt:
        return False
    except SystemExit:
        if server.should_exit:  # a signal came while the robot was being opened
            return False
        raise Unavailable(runtime.trouble or "The console could not start; the log says why.") from None
    return True


def share_arenas() -> None:
    """Let all threads share two arenas: glibc keeps what each has freed in its own one, 27 MB after a single page."""
    with contextlib.suppress(AttributeError, TypeError):  # another C library
        ctypes.CDLL(None).mallopt(M_ARENA_MAX, 2)


def configured(
    app: ASGIApp, certificate: Path | None = None, key: Path | None = None, most: int = MAX_CONNECTIONS
) -> ServerConfig:
    """How uvicorn runs this application; by HTTPS where there is a certificate; `most` connections at a time."""
    config = ServerConfig(
        app,
        ssl_certfile=certificate,
        ssl_keyfile=key,
        http=TimeoutHttp,
        ws=TimeoutSocket,
        ws_per_message_deflate=False,
        ws_max_size=SOCKET_MESSAGE,
        backlog=ACCEPTED_AT_ONCE,
        ws_ping_interval=PING_PERIOD_S,
        ws_ping_timeout=PING_PERIOD_S,
        timeout_graceful_shutdown=3,
        access_log=False,
        server_header=False,
        proxy_headers=False,  # the guard reads the one that counts
        log_config=None,
        lifespan="on",
    )
    config.crowd = ConnectionLimits(most)
    return config


def address_of(options: Options, port: int) -> str:
    """The address by which browsers open this console."""
    scheme = "http" if options.tls_cert is None else "https"
    return f"{scheme}://{in_address(options.allow_hosts[0] if is_wildcard(options.host) else options.host)}:{port}/"


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


def add_parts(options: Options, address: str, runtime: Runtime) -> None:
    """Add the parts that options ask for; `address` of this console, as a fleet opens it. Raises BadInput."""
    if not options.nobody:
        runtime.parts.add(BackgroundTask(lambda: move_in(runtime.ask, options.robot)))
    exchange_text_files(options, runtime)
    if (member := member_options(options)) is not None:
        certificate = "" if options.tls_cert is None else shown_certificate(options.tls_cert)
        runtime.parts.add(fleet_member(member, address, certificate, runtime))


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


def member_options(options: Options) -> MemberOptions | None:
    """How this console joins a fleet; None: it joins none. Raises BadInput."""
    if not options.fleet:
        if options.fleet_name or options.fleet_cert is not None:
            raise BadInput(Statement("fleet.options_belong_together"))
        return None
    folder = options.fleet_cert or home_folder(options.data) / "fleet" / options.fleet_name
    return MemberOptions(FleetAddress.parse(options.fleet), options.fleet_name, CertificateFiles(folder))


def shown_certificate(path: Path) -> str:
    """The certificate (PEM) that a server shows of this file: its first."""
    begin, end = "-----BEGIN CERTIFICATE-----", "-----END CERTIFICATE-----"
    inner = path.read_text(errors="replace").partition(begin)[2].partition(end)[0]
    return f"{begin}{inner}{end}\n"


def fleet_member(options: MemberOptions, address: str, certificate: str, runtime: Runtime) -> FleetMember:
    """The part that joins a fleet; `address` of this console, as the fleet opens it, `certificate` as it shows it."""
    return FleetMember(
        options,
        address,
        certificate,
        robot=runtime.robot,
        dispatcher=runtime.dispatcher,
        lease=runtime.lease,
        notifications=runtime.notifications,
        logins=runtime.access.logins,
        maps=runtime.parts[MapService],
    )


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


def check(options: Options) -> None:
    """Raises BadInput for options that would not be safe."""
    if options.no_auth and (options.host not in {"127.0.0.1", "localhost", "::1"} or not is_simulated(options.robot)):
        raise BadInput("--no-auth works only on 127.0.0.1 and with the simulated robot; leave one of them away.")
    if not 0 <= options.port <= 65535:
        raise BadInput("--port takes a number from 0 to 65535; 0 means any free port.")
    if is_wildcard(options.host) and not options.allow_hosts:
        raise BadInput(
            f"--host {options.host} says nothing about the address that browsers open: give this machine's own "
            "address or name instead, or add --allow-host NAME for every name it is opened by."
        )
    for name in options.allow_hosts:
        if not HOST_NAME.fullmatch(in_address(name)) or is_wildcard(name):
            raise BadInput("--allow-host takes a host's name or address as it stands in the browser, without a port.")
    Reach(options.connect)
    _check_foxglove(options.foxglove)
    _check_tls(options)
    if (member := member_options(options)) is not None:
        load_zenoh()
        member.check()
    if options.token_file is not None:
        read_token(options.token_file)
    _check_text_files(options)
    if options.gate_trace is not None:
        try:
            options.gate_trace.open("a").close()
        except OSError as trouble:
            raise BadInput(f"--gate-trace {options.gate_trace} cannot be written: {trouble.strerror}.") from None


def _check_foxglove(port: int | None) -> None:
    """Raises BadInput for a port that cannot be used, Unavailable without the package."""
    if port is None:
        return
    if not 0 < port <= 65535:
        raise BadInput("--foxglove takes a port from 1 to 65535; Foxglove itself looks at 8765.")
    check_installed()
    with socket.socket() as trial:
        trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            trial.bind((LOOPBACK_ADDRESS, port))
        except OSError as trouble:
            raise BadInput(f"--foxglove {port} cannot be served: {trouble.strerror}. Take another port.") from None


def _check_text_files(options: Options) -> None:
    obeyed, written = options.text_files, options.write_text_files
    if obeyed is not None and written is not None and obeyed.resolve() == written.resolve():
        raise BadInput("--write-text-files needs another folder than --text-files: the robot would obey itself.")


def _check_tls(options: Options) -> None:
    """Raises BadInput for a certificate that browsers could not be shown."""
    certificate, key = options.tls_cert, options.tls_key
    if (certificate is None) != (key is None):
        raise BadInput("--tls-cert and --tls-key belong together; give both.")
    if certificate is None or key is None:
        return
    try:
        ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER).load_cert_chain(certificate, key, password=_no_password)
    except FileNotFoundError:
        missing = certificate if not certificate.exists() else key
        raise BadInput(f"{missing} is not there; --tls-cert and --tls-key take PEM files.") from None
    except (OSError, ValueError) as trouble:
        why = trouble.reason if isinstance(trouble, ssl.SSLError) and trouble.reason else trouble
        raise BadInput(
            f"{certificate} and {key} are no certificate in PEM with its own key, without a password ({why})."
        ) from None


def _no_password() -> str:
    """A console that starts by itself cannot ask for one."""
    return ""


def is_readable(options: Options) -> bool:
    """True if keys and pictures go over a network as plain text."""
    return in_address(options.host) not in LOOPBACK and options.tls_cert is None


def take_precedence(options: Options) -> None:
    """Run before other programs where a real robot may move, or where it is asked for."""
    if options.precedence or not options.robot.startswith(("sim:", "log:")):
        come_first(CONSOLE_RANK)  # all threads: each may hold what the pilot needs next


def is_simulated(url: str) -> bool:
    """True if nothing real can move."""
    return url.partition(":")[0] == "sim"


def hosts_of(*hosts: str) -> frozenset[str]:
    """The host names this console answers to: this machine's own, and these as far as one can be opened."""
    return LOOPBACK | {in_address(host) for host in hosts if not is_wildcard(host)}


def in_address(host: str) -> str:
    """A host as it stands in an address: an IPv6 address in brackets, letters small."""
    bare = host.strip("[]").lower()
    return f"[{bare}]" if ":" in bare else bare


def is_wildcard(host: str) -> bool:
    """Return whether it means every address of this machine, and none that a browser could open."""
    try:
        return ipaddress.ip_address(host.strip("[]")).is_unspecified
    except ValueError:
        return host in ("", "0")


@contextlib.contextmanager
def bound(host: str, port: int) -> Generator[socket.socket]:
    """The listening socket. Raises Unavailable when the address cannot be had."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with socket.socket(family, socket.SOCK_STREAM) as listener:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind((host, port))
        except OSError as trouble:
            raise Unavailable(f"Port {port} of {host} cannot be used ({trouble.strerror}); try --port 0.") from None
        yield listener
