"""Small messages between processes: one JSON object a packet, never waiting, nothing lost halfway.

A full pipe drops the packet: everything that matters is said again, and its age is judged, not its arrival.
"""

import json
import socket
from collections.abc import Callable, Mapping
from typing import NoReturn, TypeVar

LARGEST = 1 << 18  # bytes of a packet
AT_ONCE = 512  # packets taken in one go, so that a flood cannot hold up a tick

Packet = dict[str, object]
"""A JSON object from another process, of which nothing is known yet."""

Message = TypeVar("Message")


def packet_pair() -> tuple[socket.socket, socket.socket]:
    """Two ends of a pipe that keeps packets whole. Where there is no SEQPACKET, a death shows by silence only."""
    kind = getattr(socket, "SOCK_SEQPACKET", socket.SOCK_DGRAM)
    try:
        ends = socket.socketpair(socket.AF_UNIX, kind)
    except OSError:
        ends = socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM)
    for end in ends:
        end.setblocking(False)
    return ends


def packet_socket(descriptor: int) -> socket.socket:
    """An end that this process was given by its number."""
    end = socket.socket(fileno=descriptor)
    end.setblocking(False)
    return end


def send_packet(end: socket.socket, packet: Mapping[str, object]) -> bool:
    """Send without waiting → whether it is on its way."""
    try:
        end.send(ENCODER.encode(packet).encode())
    except OSError:
        return False
    return True


def take_packets(end: socket.socket) -> tuple[list[Packet], bool]:
    """Return all valid packets that have come, without waiting, and whether the other end is there."""
    packets: list[Packet] = []
    for _ in range(AT_ONCE):
        try:
            raw = end.recv(LARGEST)
        except (BlockingIOError, InterruptedError):
            return packets, True
        except ConnectionResetError:  # said once, before its last packets, of an end that left some of ours unread
            continue
        except OSError:
            return packets, False
        if not raw:
            return packets, False
        if (packet := parse_packet(raw)) is not None:
            packets.append(packet)
    return packets, True


def parse_packet(raw: bytes) -> Packet | None:
    """One JSON object; None for anything else: NaN, Infinity, a key said twice, or no object."""
    try:
        packet = DECODER.decode(raw.decode())
    except (ValueError, RecursionError):
        return None
    return packet if isinstance(packet, dict) else None


def construct(kind: Callable[..., Message], fields: Packet) -> Message:
    """The fields of a packet → the message. Raises TypeError where one is missing or unknown."""
    return kind(**fields)


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(name)


def _refuse_twice(pairs: list[tuple[str, object]]) -> Packet:
    packet = dict(pairs)
    if len(packet) != len(pairs):
        raise ValueError("a key was said twice")
    return packet


ENCODER = json.JSONEncoder(separators=(",", ":"))
DECODER = json.JSONDecoder(parse_constant=_refuse_constant, object_pairs_hook=_refuse_twice)
