"""Options that can be followed, and what follows from them."""

import contextlib
import ipaddress
import socket
import ssl
from collections.abc import Generator
from pathlib import Path

from console.access.guard import HOST_NAME
from console.access.token_file import read_token
from console.connection.reach import Reach
from console.data_folder import SETTINGS_FILE, home_folder
from console.declared_options import Options
from console.fleet.authority import CertificateFiles
from console.fleet.bus import FleetAddress, MemberOptions
from core.errors import BadInput, Unavailable
from core.recording.foxglove_server import LOOPBACK_ADDRESS, check_installed
from core.robots.ros.zenoh_session import load_zenoh
from core.sentences import Statement

LOOPBACK = frozenset({"127.0.0.1", "localhost", "[::1]"})


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
        ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER).load_cert_chain(certificate, key, password=str)  # nobody is asked
    except FileNotFoundError:
        missing = certificate if not certificate.exists() else key
        raise BadInput(f"{missing} is not there; --tls-cert and --tls-key take PEM files.") from None
    except (OSError, ValueError) as trouble:
        why = trouble.reason if isinstance(trouble, ssl.SSLError) and trouble.reason else trouble
        raise BadInput(
            f"{certificate} and {key} are no certificate in PEM with its own key, without a password ({why})."
        ) from None


def settings_file(options: Options, home: Path) -> Path | None:
    """The file with changed settings: the one that was named, else that of the data folder where there is one."""
    own = home / SETTINGS_FILE
    return options.settings or (own if own.is_file() else None)


def member_options(options: Options) -> MemberOptions | None:
    """How this console joins a fleet; None: it joins none. Raises BadInput."""
    if not options.fleet:
        if options.fleet_name or options.fleet_cert is not None:
            raise BadInput(Statement("fleet.options_belong_together"))
        return None
    folder = options.fleet_cert or home_folder(options.data) / "fleet" / options.fleet_name
    return MemberOptions(FleetAddress.parse(options.fleet), options.fleet_name, CertificateFiles(folder))


def address_of(options: Options, port: int) -> str:
    scheme = "http" if options.tls_cert is None else "https"
    return f"{scheme}://{in_address(options.allow_hosts[0] if is_wildcard(options.host) else options.host)}:{port}/"


def is_readable(options: Options) -> bool:
    """True if keys and pictures go over a network as plain text."""
    return in_address(options.host) not in LOOPBACK and options.tls_cert is None


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
