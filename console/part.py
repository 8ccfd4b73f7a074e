"""A part: one capability of the console, as the runtime knows it."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterator
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from core.pilot.pilot import Pilot
    from core.robots import Profile
    from core.sensors import SensorFrame
    from core.settings import Settings
    from core.snapshot import Snapshot


class Part:
    """Lives on the event loop. A part overrides what concerns it; nothing else of the console knows that it is there.

    All parts are opened when the robot is there and closed, together, when nothing steers it any more.
    """

    async def open(self) -> None:
        """Load what is on disk."""

    async def run(self) -> None:
        """Work beside the others for as long as the console runs; ended by cancelling."""

    def on_snapshot(self, snapshot: Snapshot, frame: SensorFrame) -> None:
        """Take the newest snapshot, and the frame that it was made of as the robot as built sees it."""

    def tick(self, now: float) -> None:
        """Take the time, twenty times a second; `now` [s] on the monotonic clock."""

    def calibrated(self, profile: Profile) -> Profile:
        """The robot as the parts before this one see it → as it is with what this part knows."""
        return profile

    def leave_out(self, why: str) -> list[str]:
        """Use no accepted calibration any more in this run → the files that were in use until now."""
        return []

    def equip(self, pilot: Pilot) -> None:
        """Give a pilot what it needs of this part: at its start, and when any part asks for it."""

    def adopt(self, settings: Settings) -> None:
        """Take settings that are declared live and have changed."""

    async def close(self) -> None:
        """Let go of everything, and wait until it is gone."""


class BackgroundTask(Part):
    """Work of a caller that runs beside the console and needs nothing else of it."""

    def __init__(self, work: Callable[[], Awaitable[None]]) -> None:
        self._work = work

    async def run(self) -> None:
        await self._work()


PartT = TypeVar("PartT", bound=Part)


class Parts:
    """The parts of a console, in the order in which they see each snapshot; each is found by its class."""

    def __init__(self) -> None:
        self._parts: list[Part] = []

    def __iter__(self) -> Iterator[Part]:
        return iter(self._parts)

    def __getitem__(self, kind: type[PartT]) -> PartT:
        """Raises KeyError where this console has none of the class."""
        for part in self._parts:
            if isinstance(part, kind):
                return part
        raise KeyError(kind)

    def add(self, part: PartT) -> PartT:
        self._parts.append(part)
        return part

    def calibrated(self, profile: Profile) -> Profile:
        """The robot as built → as all parts together know it."""
        for part in self._parts:
            profile = part.calibrated(profile)
        return profile

    async def open(self) -> None:
        """Open all at once. Raises what the first of them raises."""
        await asyncio.gather(*(part.open() for part in self._parts))

    async def close(self) -> None:
        await asyncio.gather(*(part.close() for part in self._parts))
