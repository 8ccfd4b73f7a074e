"""Addresses to which operators may make the console connect: networks, hosts and folders, checked after resolution.

Without this rule anybody who may drive could reach every service that this computer reaches, its own ones included.
"""

import contextlib
import ipaddress
import re
import socket
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple
from urllib.parse import parse_qsl

from console.http.problems import Problem
from core.errors import BadInput, BadSettings, Unavailable
from core.robots.connect import SCHEMES, parts_of, split
from core.sentences import Statement

Network = ipaddress.IPv4Network | ipaddress.IPv6Network
Address = ipaddress.IPv4Address | ipaddress.IPv6Address

CAMERA_KINDS = ("rtsp", "http")  # ways to a camera that an operator may name
CERTIFIED_LINKS = ("foxglove", "rosbridge")  # whose robot may be asked for a certificate with another name
FILE_OPTIONS = ("ca", "cert", "key")  # options that name a file
AUTHORITY = re.compile(r"(?P<user>[^@/?#\\]*@)?(?P<host>\[[0-9A-Fa-f:.]+\]|[A-Za-z0-9._-]+)(?P<port>:[0-9]{1,5})?")
SECRET = re.compile(r"(?<=[/:])([^/:@?#]*):[^/@?#]*@|(?i:([?&](?:password|passwd|pwd|pass|token|key|secret)=))[^&#]*")
ONLY_LOCAL = Statement("connect.only_local")
NOT_FOUND = "There is no address for the name {host}; type the robot's address in digits."
WRONG_ENTRY = (
    "--connect takes an address, a network such as 10.0.0.0/8, a name, each with or without :PORT, or a folder."
)


class Entry(NamedTuple):
    """A network or a name that is allowed, on one port or on all."""

    network: Network | None
    name: str
    port: int | None

    def allows(self, address: Address, host: str, port: int | None) -> bool:
        """Return whether it covers the address that a name has; this computer's own only where it is named itself."""
        if self.port is not None and self.port != port:
            return False
        if self.network is None:
            return self.name == host.lower()
        named = self.network.num_addresses == 1 or self.network.is_loopback
        return address in self.network and (named or not is_own(address))


class Reach:
    """The rule for everybody below the role admin."""

    def __init__(self, listed: Sequence[str] = ()) -> None:
        """`listed`: what the administrator names at the start; nothing else is reached. Raises BadSettings."""
        self.folders = [Path(one) for one in listed if one.startswith("/")]
        self._entries = [read_entry(one) for one in listed if not one.startswith("/")]

    def pinned(self, url: str) -> str:
        """Check a robot's URL → the same with addresses in the place of names, so that no name is resolved twice.

        Waits for the name service: call it from a thread. Raises Problem 403, BadInput, Unavailable.
        """
        return "+".join(self._part(part) for part in parts_of(url))

    def _part(self, part: str) -> str:
        name, rest = split(part)
        before, begins, rest = rest.partition("//")
        kind, slash = "", ""
        if name == "camera":
            kind, slash, rest = rest.partition("/")
        if name not in SCHEMES or not begins or before or (name == "camera" and kind not in CAMERA_KINDS):
            raise Problem(403, ONLY_LOCAL)
        place, _, query = rest.partition("?")
        authority = place.partition("/")[0]
        found = AUTHORITY.fullmatch(authority)
        if found is None or name == "audio" or re.fullmatch(r"(?i)com\d+", authority):
            raise Problem(403, ONLY_LOCAL)
        if name != "camera" and names_a_file(query):
            raise Problem(403, ONLY_LOCAL)
        address = self._resolved(found["host"].strip("[]"), int(found["port"][1:]) if found["port"] else None)
        host = f"[{address}]" if address.version == 6 else str(address)
        pinned = f"{found['user'] or ''}{host}{found['port'] or ''}{rest[len(authority) :]}"
        if name in CERTIFIED_LINKS and is_to_be_certified(found["host"], query):
            pinned += f"&tls_name={found['host']}"
        return f"{name}://{kind}{slash}{pinned}"

    def _resolved(self, host: str, port: int | None) -> Address:
        try:
            answers = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
        except (OSError, UnicodeError, OverflowError):
            raise Unavailable(NOT_FOUND.format(host=host[:80])) from None
        addresses = [unmapped(str(answer[4][0])) for answer in answers]
        allowed = [one for one in addresses if any(entry.allows(one, host, port) for entry in self._entries)]
        if not allowed:
            raise Problem(403, Statement("connect.only_admin", what=host[:80], entry=host[:80]))
        return allowed[0]


def read_entry(text: str) -> Entry:
    """An address, a network or a name, with or without a port. Raises BadSettings."""
    before, colon, after = text.strip().rpartition(":")
    with_port = (before, int(after)) if colon and after.isdecimal() and len(after) <= 5 else None
    for host, port in filter(None, ((text.strip(), None), with_port)):
        with contextlib.suppress(ValueError):
            bare = host[1:-1] if host.startswith("[") and host.endswith("]") else host
            return Entry(ipaddress.ip_network(bare, strict=False), "", port)
        if re.fullmatch(r"[A-Za-z0-9._-]*[A-Za-z_-][A-Za-z0-9._-]*", host):
            return Entry(None, host.lower(), port)
    raise BadSettings(WRONG_ENTRY)


def unmapped(text: str) -> Address:
    """An address, that of IPv4 where it stands inside one of IPv6."""
    address = ipaddress.ip_address(text.partition("%")[0])
    inside = address.ipv4_mapped if isinstance(address, ipaddress.IPv6Address) else None
    return inside or address


def is_own(address: Address) -> bool:
    """Return whether this computer itself answers at an address: only then can it be bound."""
    family = socket.AF_INET6 if address.version == 6 else socket.AF_INET
    with socket.socket(family, socket.SOCK_DGRAM) as own:
        try:
            own.bind((str(address), 0))
        except OSError:
            return False
    return True


def is_to_be_certified(host: str, query: str) -> bool:
    """Return whether the robot's certificate has to bear this name, which is no address."""
    options = dict(parse_qsl(query, keep_blank_values=True))
    is_name = re.fullmatch(r"\[.*\]|[0-9.]+", host) is None
    return is_name and options.get("tls", "").lower() in ("1", "true") and "tls_name" not in options


def names_a_file(query: str) -> bool:
    """Return whether an option of a URL names a file, or a profile of microphones by its path."""
    options = parse_qsl(query, keep_blank_values=True)
    return any(key in FILE_OPTIONS or (key == "array" and ("/" in value or "." in value)) for key, value in options)


def masked(url: str) -> str:
    """A URL without its passwords, as it may be written down."""
    return SECRET.sub(lambda found: f"{found[2]}***" if found[2] else f"{found[1]}:***@", url)


def inside(path: Path, folders: Sequence[Path]) -> bool:
    """Return whether a path leads into one of these folders, by its words alone. Raises BadInput for `..`."""
    if ".." in path.parts:
        raise BadInput("The path of a recording has no .. in it.")
    return any(path.is_relative_to(folder) for folder in folders)
