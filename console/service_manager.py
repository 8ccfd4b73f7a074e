"""Word to the service manager that started the console (systemd): that it is ready, lives, ends.

sd_notify(3) is one datagram to the socket that the environment names. Without one nothing is sent.
"""

import contextlib
import os
import socket

from console.part import Part

SOCKET, WATCHDOG = "NOTIFY_SOCKET", "WATCHDOG_USEC"
SIGNS_PER_TIMEOUT = 4  # so that a late one ends nothing
US_PER_S = 1e6


def notify(word: str) -> None:
    """Send one word, `READY=1`. Nobody listens, or not any more: that ends nothing."""
    address = os.environ.get(SOCKET, "")
    if not address:
        return
    if address.startswith("@"):
        address = "\0" + address[1:]  # in the abstract namespace of Linux
    with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as line:
        line.setblocking(False)
        line.sendto(word.encode(), address)


class ServiceManagerWatchdog(Part):
    """A sign of life from the event loop: where it stands still, the service manager starts the console again."""

    def __init__(self) -> None:
        timeout_us = os.environ.get(WATCHDOG, "")
        self._period = int(timeout_us) / US_PER_S / SIGNS_PER_TIMEOUT if timeout_us.isdecimal() else None
        self._due = 0.0

    def tick(self, now: float) -> None:
        if self._period is not None and now >= self._due:
            self._due = now + self._period
            notify("WATCHDOG=1")

    async def close(self) -> None:
        """Say that the end has begun."""
        notify("STOPPING=1")
