"""Open connections, by address: strangers can neither use up the descriptors nor keep out who has a key.

A connection is a stranger's until a request on it has shown a valid key or login. There is always room for one more:
where an address, or all of them together, have too many, the stranger that is there longest is dropped. It hears of
that a moment later: who is turned away comes again at once, and each coming takes time of the event loop.
"""

import ipaddress
import resource
import time
from collections import deque

from console.http.incremental_parsing import IncrementalProtocol

MAX_CONNECTIONS = 600  # connections in all: three times the sockets that may be open
MOST_STRANGERS = 128  # of one address
DROPPED_SILENCE_S = 1.0  # at least, until a dropped connection is closed
CLOSING_PERIOD_S = 0.0025  # between two of them: they come again one by one
SILENT_PER_PLACE = 2  # dropped connections that are not yet closed, for each that may be open
MOST_FILES = 65536  # descriptors that are asked of the system
IPV6_NETWORK = 64  # bits: one home or one machine may have all addresses that begin alike


Guests = dict[IncrementalProtocol, None]  # the eldest first


class ConnectionLimits:
    """Lives on the event loop."""

    def __init__(self, most: int = MAX_CONNECTIONS) -> None:
        """`most`: connections in all."""
        self.most = most
        self.parsing: set[IncrementalProtocol] = set()  # those that have sent much at once
        self._open: dict[str, Guests] = {}  # by address
        self._silent_until: deque[float] = deque()  # when those that were dropped are closed, the next one first

    def __len__(self) -> int:
        return sum(len(guests) for guests in self._open.values())

    def enter(self, guest: IncrementalProtocol, address: str) -> None:
        """One more; it, or the least entitled that is there, is dropped where there are too many."""
        of_one = self._open.get(network_of(address), {})
        strangers = [other for other in of_one if other.stranger]
        if len(strangers) >= MOST_STRANGERS:
            self._drop(strangers[0], of_one)
        if len(self) >= self.most:
            victim = self._dispensable()
            if victim is None:
                guest.drop()
                return
            self._drop(*victim)
        self._open.setdefault(network_of(address), of_one)[guest] = None

    def leave(self, guest: IncrementalProtocol, address: str) -> None:
        key = network_of(address)
        of_one = self._open.get(key, {})
        of_one.pop(guest, None)
        if not of_one:
            self._open.pop(key, None)

    def _drop(self, guest: IncrementalProtocol, of_one: Guests) -> None:
        """Its place is free now; that its connection has ended is heard later, by both sides."""
        del of_one[guest]
        now = time.monotonic()
        while self._silent_until and self._silent_until[0] <= now:
            self._silent_until.popleft()
        if len(self._silent_until) < SILENT_PER_PLACE * self.most:
            last = self._silent_until[-1] if self._silent_until else now
            self._silent_until.append(max(now + DROPPED_SILENCE_S, last + CLOSING_PERIOD_S))
            guest.drop(self._silent_until[-1] - now)
        else:
            guest.drop()

    def _dispensable(self) -> tuple[IncrementalProtocol, Guests] | None:
        """The eldest stranger of the address with the most connections, else one on which nothing is under way."""
        crowded = sorted(self._open.values(), key=len, reverse=True)
        strangers = ((one, guests) for guests in crowded for one in guests if one.stranger)
        waiting = ((one, guests) for guests in crowded for one in guests if one.idle)
        return next(strangers, None) or next(waiting, None)


def network_of(address: str) -> str:
    """Return the part of an address that counts as one client."""
    try:
        parsed = ipaddress.ip_address(address.partition("%")[0])
    except ValueError:
        return address
    if parsed.version == 4:
        return address
    return str(ipaddress.ip_network((parsed, IPV6_NETWORK), strict=False))


def raise_file_limit() -> int:
    """Ask for as many descriptors as the system grants → how many connections may be open at a time."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = MOST_FILES if hard == resource.RLIM_INFINITY else min(hard, MOST_FILES)
    if soft != resource.RLIM_INFINITY and soft < wanted:
        resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))
        soft = wanted
    return MAX_CONNECTIONS if soft == resource.RLIM_INFINITY else min(MAX_CONNECTIONS, soft // 4)
