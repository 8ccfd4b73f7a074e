"""The way in for browsers: the data folder, the port, who may sign in, and the address that is printed."""

import contextlib
import os
import socket
import sys
import threading
import time
from collections.abc import Generator
from dataclasses import dataclass
from pathlib import Path

from console.access.browser import browse
from console.access.guard import Access
from console.access.logins import LINK_LIFE_S, Logins, new_token
from console.access.records import AccessFile
from console.access.token_file import read_token
from console.data_folder import home_folder, locked
from console.http import qr
from console.http.connection_limits import raise_file_limit
from console.logging_setup import start_logging
from console.options import LOOPBACK, Options, address_of, bound, hosts_of, in_address, is_readable, is_wildcard

ONCE_LIFE_S = 120.0  # in which the browser that is opened here has to come
READABLE_BY_OTHERS_WARNING = (
    "Others on the network can read along and take over: this is plain HTTP, and phones give it no microphone. "
    "Start with --tls-cert and --tls-key, or put TLS in front of it."
)


@dataclass(frozen=True)
class OpenPort:
    listener: socket.socket
    port: int
    address: str  # by which browsers open it
    access: Access
    most: int  # connections at a time
    damaged: str  # a sentence: which logins were lost; "": none


@contextlib.contextmanager
def listening(options: Options, home: Path, *, logs: bool = True) -> Generator[OpenPort]:
    """Take the data folder and the port; `logs`: and begin the log. Raises BadInput, Unavailable, Unwritable."""
    os.umask(0o077)  # what is written is its owner's alone
    most = raise_file_limit()
    with locked(home) as lock, bound(options.host, options.port) as listener:
        if logs:
            start_logging(options.log or home / "console.log", as_json=options.log_json)
        port = int(listener.getsockname()[1])
        address = address_of(options, port)
        lock.announce(port, address)
        logins = Logins(AccessFile(home), time.time() - time.monotonic())
        damaged = logins.open_file()
        elsewhere = "" if in_address(options.host) in LOOPBACK else address
        hosts = hosts_of(options.host, *options.allow_hosts)
        access = Access(logins, hosts, f"beckon_{port}", elsewhere, options.no_auth)
        yield OpenPort(listener, port, address, access, most, damaged)


def announce(options: Options, port: int, access: Access) -> None:
    """Tell the address, with a key behind the #, which no server and no log ever sees."""
    address, logins, now = address_of(options, port), access.logins, time.monotonic()
    if access.no_auth:
        sys.stdout.write(f"Beckon is at {address}\n")
    else:
        driving, watching = operator_key(options, access, now), new_token()
        logins.admit(watching, "viewer", "viewer", "start", now, end=now + LINK_LIFE_S)
        sys.stdout.write(f"Beckon is at {address}#t={driving}\nTo watch only: {address}#t={watching}\n")
        if access.address and sys.stdout.isatty():
            sys.stdout.write(f"On a phone:\n{qr.drawn(f'{address}#t={driving}')}")
    sys.stdout.flush()
    if is_readable(options):
        sys.stderr.write(f"{READABLE_BY_OTHERS_WARNING}\n")
    if options.open_browser:
        scheme = address.partition(":")[0]
        here = f"{scheme}://127.0.0.1:{port}/" if is_wildcard(options.host) else address
        once = "" if access.no_auth else f"#t={logins.issue('operator', 'admin', once=True, end=now + ONCE_LIFE_S)}"
        opening = (here + once, home_folder(options.data), ONCE_LIFE_S)
        threading.Thread(target=browse, args=opening, name="browser", daemon=True).start()


def operator_key(options: Options, access: Access, now: float) -> str:
    """The operator's key of --token-file, else a new one of the administrator: who started the console has read it.

    What such a file held before opens nothing more.
    """
    if options.token_file is None:
        token = new_token()
        access.logins.supersede_file_keys()
        access.logins.admit(token, "operator", "admin", "start", now, end=now + LINK_LIFE_S)
        return token
    token = read_token(options.token_file)
    access.logins.supersede_file_keys(access.logins.admit(token, "operator", "operator", "file", now))
    return token
