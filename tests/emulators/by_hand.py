"""Serve an emulator until Ctrl+C."""

import time
from typing import Protocol


class Part(Protocol):
    def start(self) -> None: ...

    def stop(self) -> None: ...


class Served(Part, Protocol):
    @property
    def url(self) -> str: ...


def serve(device: Served, *others: Part) -> None:
    """Start all, say how to reach the device, and stop at Ctrl+C."""
    parts = (*others, device)
    for part in parts:
        part.start()
    print(f"beckon run --robot {device.url}", flush=True)  # noqa: T201
    try:
        while True:
            time.sleep(1.0)
    except KeyboardInterrupt:
        for part in reversed(parts):
            part.stop()
