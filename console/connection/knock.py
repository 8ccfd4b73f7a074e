"""Knock at an address where robots are: a connection is opened and closed, nothing is sent."""

import asyncio
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlsplit

from core.robots.connect import SCHEMES

ANSWER_S = 1.0  # [s]
PORT_SCHEMES = ("foxglove", "rosbridge", "zenoh", "srv1")  # those that have a port of their own
SERIAL_PATTERNS = (("serial", "ttyUSB*"), ("scip", "ttyACM*"))  # kind of device, and how its ports are called


def host_of(url: str) -> str:
    """The host that a URL names; "" where it names none."""
    try:
        return urlsplit(url).hostname or ""
    except ValueError:
        return ""


def urls_at(host: str) -> list[str]:
    """The URLs of every kind of link at a host, each at its usual port."""
    ports = {name: urlsplit(SCHEMES[name].example).port for name in PORT_SCHEMES}
    return [f"{name}://{f'[{host}]' if ':' in host else host}:{port}" for name, port in ports.items()]


def serial_ports() -> list[str]:
    """The URLs of devices at this computer's serial ports, as far as their names say what they are."""
    return [f"{kind}://{path}" for kind, name in SERIAL_PATTERNS for path in sorted(Path("/dev").glob(name))]


@dataclass(frozen=True)
class Knock:
    """An address that may answer."""

    url: str

    @property
    def host(self) -> str:
        """Its host."""
        return host_of(self.url)

    @property
    def port(self) -> int:
        """Its port."""
        return urlsplit(self.url).port or 0

    async def answers(self) -> bool:
        """Return whether a connection opens within `ANSWER_S`."""
        try:
            async with asyncio.timeout(ANSWER_S):
                _, writer = await asyncio.open_connection(self.host, self.port)
        except (OSError, TimeoutError):
            return False
        writer.close()
        return True
