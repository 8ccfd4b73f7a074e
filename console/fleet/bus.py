"""The fleet's bus: zenoh over TLS. Its keys, who may use which, the messages, and why a connection is refused.

A robot's certificate writes under its own name only, and is asked by the router alone. The bus carries states,
pictures, stops and keys of consoles; never a setpoint.
"""

from __future__ import annotations

import contextlib
import json
import re
import socket
import ssl
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import msgspec

from console.fleet.authority import CERTIFICATE_NAME, CertificateFiles, FleetCertificate
from core.errors import BadInput, Unavailable
from core.robots.ros.zenoh_session import load_zenoh
from core.sentences import Statement

DEFAULT_PORT = 7447
LEASE_MS = 2000  # of silence after which the other side is taken for gone
MAX_MESSAGE_BYTES = 2**21
CONNECT_TIMEOUT_S = 3.0
REFUSAL_TIMEOUT_S = 0.25  # within which a router refuses a certificate that it does not take
ADDRESS = re.compile(r"tls/(\[[0-9a-fA-F:]+\]|[^\s:/\[\]]+)(?::([0-9]{1,5}))?")
ROBOT_MESSAGE_KINDS = ("put", "delete", "reply", "declare_queryable", "liveliness_token")
VIEWER_KEYS = ("state", "alive")  # what a viewer's certificate reads of every robot

StopKind = Literal["stop", "halt"]
FleetRole = Literal["viewer", "operator", "admin"]


class PoseReport(msgspec.Struct, frozen=True):
    """The pose that a robot takes itself to have, in the frame of its map."""

    x_m: float
    y_m: float
    heading_rad: float


class CommandReport(msgspec.Struct, frozen=True):
    """The command under way."""

    name: str
    heard_as: str
    who: str
    progress: float | None = None


class NoticeReport(msgspec.Struct, frozen=True):
    """The newest sentence for the operator."""

    level: str
    text: str
    code: str | None = None
    values: dict[str, str] | None = None


class MapReport(msgspec.Struct, frozen=True):
    """The map that a robot goes on in: robots whose maps have the same `id` are in one frame."""

    name: str | None  # None: a new one
    id: str = ""  # "": shared with no other robot


class RobotFacts(msgspec.Struct, frozen=True, kw_only=True):
    """The state of a robot that its console reports and the fleet's page shows."""

    robot: str = ""  # its own name
    simulated: bool = False
    robot_link: str = ""  # between console and robot: connecting, live, stale, lost
    robot_age_s: float = 0.0
    pose: PoseReport | None = None
    speed_m_s: float = 0.0
    lost: bool = False  # does not know where it is
    map: MapReport | None = None
    battery: float | None = None  # 0..1
    operator: str | None = None
    command: CommandReport | None = None
    gate: str = ""
    gate_reason: str = ""
    notice: NoticeReport | None = None
    picture: bool = False  # it has a camera


class RobotReport(RobotFacts, frozen=True, kw_only=True):
    """The state of a robot, as its console says it, on `beckon/NAME/state`."""

    address: str  # of its console, for the fleet


class FleetStopRequest(msgspec.Struct, frozen=True):
    """Stand now; `halt` stays until it is reset at the robot."""

    kind: StopKind
    by: str


class FleetStopAnswer(msgspec.Struct, frozen=True):
    """The state of the robot's own gate after it."""

    stands: bool  # the gate lets nothing through
    state: str
    reason: str = ""
    ms: float = 0.0  # from its arrival to the gate's zero


class FleetKeyRequest(msgspec.Struct, frozen=True):
    """A key for a person whom the fleet has signed in."""

    name: str
    role: FleetRole


class FleetKeyAnswer(msgspec.Struct, frozen=True):
    """A key of the robot's console, good for hours, and what that console shows before it is given the key."""

    token: str
    certificate: str = ""  # PEM, of a console that speaks HTTPS


@dataclass(frozen=True)
class FleetAddress:
    host: str
    port: int

    @classmethod
    def parse(cls, text: str) -> FleetAddress:
        """Read `tls/HOST:PORT`. Raises BadInput."""
        found = ADDRESS.fullmatch(text)
        port = int(found[2] or DEFAULT_PORT) if found else 0
        if found is None or not 0 < port < 65536:
            raise BadInput(Statement("fleet.address_refused", text=text[:80]))
        return cls(found[1].strip("[]"), port)

    @property
    def name(self) -> str:
        """host:port."""
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"


@dataclass(frozen=True)
class MemberOptions:
    """The options `--fleet`, `--name` and `--fleet-cert`."""

    address: FleetAddress
    name: str
    files: CertificateFiles

    def check(self) -> None:
        """Raises BadInput for a name that no certificate can bear, or certificates that are not there."""
        if CERTIFICATE_NAME.fullmatch(self.name) is None:
            raise BadInput(Statement("fleet.name_refused", name=self.name[:60]))
        self.files.check()


def trusting(certificate: str) -> ssl.SSLContext:
    """A client's TLS that takes this one certificate (PEM) while it lasts, and no other. Raises ValueError, SSLError.

    A console is known by the certificate that it named over the bus, no matter who signed it.
    """
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname = False  # the certificate is known itself; its address stands in the robot's report
    context.verify_flags |= ssl.VERIFY_X509_PARTIAL_CHAIN
    context.load_verify_locations(cadata=certificate)
    return context


def key_of(robot: str, what: str) -> str:
    """The key on which a robot says something, or is asked for it."""
    return f"beckon/{robot}/{what}"


def robot_of(key: str) -> str:
    return key.split("/")[1]


def _common(mode: str, endpoint: str, side: str, tls: Mapping[str, object]) -> dict[str, Any]:
    return {
        "mode": mode,
        f"{side}/endpoints": [endpoint],
        "scouting/multicast/enabled": False,
        "transport/shared_memory/enabled": False,  # it takes 16 MB for every connection on one computer
        "transport/link/tx/lease": LEASE_MS,
        "transport/link/rx/max_message_size": MAX_MESSAGE_BYTES,
        "transport/link/tls": {"enable_mtls": True, **tls},
    }


def router_settings(
    listen: FleetAddress, files: CertificateFiles, certificates: Iterable[FleetCertificate]
) -> Mapping[str, Any]:
    """The settings of the fleet's router, which lets in these certificates alone."""
    tls = {
        "root_ca_certificate": str(files.authority),
        "listen_certificate": str(files.certificate),
        "listen_private_key": str(files.key),
    }
    rules: list[dict[str, Any]] = []
    subjects: list[dict[str, Any]] = []
    policies: list[dict[str, Any]] = []
    for one in certificates:
        own = robot_rules(one.name) if one.kind == "robot" else viewer_rules(one.name)
        rules += own
        subjects.append({"id": one.name, "cert_common_names": [one.common_name]})
        policies.append({"rules": [rule["id"] for rule in own], "subjects": [one.name]})
    if not rules:  # zenoh takes no empty list; nobody has this name
        return router_settings(listen, files, [FleetCertificate("-", "viewer", 0.0, 0.0)])
    control = {"enabled": True, "default_permission": "deny"}
    return {
        **_common("router", f"tls/{listen.name}", "listen", tls),
        "access_control": {**control, "rules": rules, "subjects": subjects, "policies": policies},
        "adminspace/enabled": False,
    }


def robot_rules(name: str) -> list[dict[str, Any]]:
    """A robot says and is asked what is under its name, asks whether it is let in, and hears nothing of others."""
    own, admission = [key_of(name, "**")], [key_of(name, "admission")]
    return [
        _rule(f"{name}-says", "ingress", ROBOT_MESSAGE_KINDS, own),
        _rule(f"{name}-is-asked", "egress", ("query",), own),
        _rule(f"{name}-asks", "ingress", ("query",), admission),
        _rule(f"{name}-is-answered", "egress", ("reply",), admission),
    ]


def viewer_rules(name: str) -> list[dict[str, Any]]:
    """A viewer reads states and presence of all, and says nothing."""
    keys = [key_of("*", what) for what in VIEWER_KEYS]
    asks = ("declare_subscriber", "declare_liveliness_subscriber", "liveliness_query")
    hears = ("put", "liveliness_token", "liveliness_query")
    return [_rule(f"{name}-asks", "ingress", asks, keys), _rule(f"{name}-hears", "egress", hears, keys)]


def _rule(name: str, flow: str, messages: Iterable[str], keys: list[str]) -> dict[str, Any]:
    return {"id": name, "permission": "allow", "flows": [flow], "messages": list(messages), "key_exprs": keys}


def client_settings(address: FleetAddress, files: CertificateFiles) -> Mapping[str, Any]:
    tls = {
        "root_ca_certificate": str(files.authority),
        "connect_certificate": str(files.certificate),
        "connect_private_key": str(files.key),
    }
    return {
        **_common("client", f"tls/{address.name}", "connect", tls),
        "connect/timeout_ms": round(CONNECT_TIMEOUT_S * 1000),
        "connect/exit_on_failure": True,
        "transport/unicast/open_timeout": round(CONNECT_TIMEOUT_S * 1000),
    }


def open_session(settings: Mapping[str, Any], refused: str) -> Any:
    """A session of zenoh. Raises Unavailable with `refused` where it does not come about."""
    zenoh = load_zenoh()
    config = zenoh.Config()
    try:
        for name, value in settings.items():
            config.insert_json5(name, json.dumps(value))
        return zenoh.open(config)
    except zenoh.ZError:
        raise Unavailable(refused) from None


def check_handshake(address: FleetAddress, files: CertificateFiles) -> None:
    """Shake hands by TLS as zenoh will, because it does not say why it is refused. Raises Unavailable, BadInput."""
    files.check()
    context = ssl.create_default_context(cafile=str(files.authority))
    try:
        context.load_cert_chain(files.certificate, files.key, password=str)
    except (OSError, ValueError):
        raise BadInput(Statement("fleet.certificate_unreadable", path=files.certificate)) from None
    try:
        with (
            socket.create_connection((address.host, address.port), CONNECT_TIMEOUT_S) as line,
            context.wrap_socket(line, server_hostname=address.host) as secured,
        ):
            secured.settimeout(REFUSAL_TIMEOUT_S)
            with contextlib.suppress(TimeoutError):
                secured.recv(1)  # a router that refuses our certificate says so now; one that takes it waits
    except TimeoutError:
        raise Unavailable(Statement("fleet.unreached", address=address.name, why="it did not answer")) from None
    except ssl.SSLError as refusal:
        raise Unavailable(_refusal(refusal, address)) from None
    except OSError as trouble:
        why = trouble.strerror or "it hung up"
        raise Unavailable(Statement("fleet.unreached", address=address.name, why=why)) from None


def _refusal(refusal: ssl.SSLError, address: FleetAddress) -> str:
    if isinstance(refusal, ssl.SSLCertVerificationError):
        if "expired" in refusal.verify_message:
            return Statement("fleet.router_expired", address=address.name)
        if "ostname" in refusal.verify_message or "IP address" in refusal.verify_message:
            return Statement("fleet.wrong_host", host=address.host)
        return Statement("fleet.another_authority", address=address.name)
    reason = (refusal.reason or "").upper()
    if "EXPIRED" in reason:
        return Statement("fleet.own_expired")
    return Statement("fleet.certificate_refused", address=address.name)
