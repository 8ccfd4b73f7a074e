"""Settings of the recorder."""

from dataclasses import dataclass
from typing import Annotated

from core.setting import Meta, Section


@dataclass(frozen=True)
class RecordingSettings(Section):
    """Settings of recordings: how long, how large, and what is kept in memory.

    Watch:
        from_start: size of the data folder
        ring_s: size of the data folder
        file_minutes: number of files of a long drive
        file_mb: number of files of a long drive
        folder_gb: recordings that went by themselves
        free_mb: recordings that ended by themselves
    """

    from_start: Annotated[
        bool, Meta(meaning="every session is recorded from its first frame on, which Record comes too late for")
    ] = False
    ring_s: Annotated[
        float, Meta("s", 0, 600, "the last part of every drive that can still be kept; 0: none", common=True)
    ] = 120.0
    file_minutes: Annotated[float, Meta("min", 1, 1440, "a longer recording goes on in another file")] = 30.0
    file_mb: Annotated[float, Meta("MB", 1, 100_000, "a larger recording goes on in another file")] = 2000.0
    folder_gb: Annotated[
        float, Meta("GB", 0.1, 10_000, "the oldest recordings without a note go when all are larger", common=True)
    ] = 20.0
    free_mb: Annotated[float, Meta("MB", 0, 100_000, "a recording ends when the disk has less left")] = 500.0
