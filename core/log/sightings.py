"""What every sightings log has in common once its own columns are understood."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np

from core.errors import BadInput
from core.log.recording import Seen, SightingRecording, SightingSensor, SightingStep
from core.log.tally import Tally
from core.message import Array

Ids = Literal["given", "hidden"]
"""Whether identities in the file may be shown to the filter."""

MOST_ROWS = 5_000_000


def seen_in(rows: Array, ids: Ids, tally: Tally) -> tuple[Seen, ...]:
    """Rows (M, 3) of id, range [m], bearing [rad] → sightings. Ids below zero belong to nobody.

    Rows that no sensor can make (range not above 0, bearing beyond π) are counted.
    """
    seen: list[Seen] = []
    for number, distance, bearing in rows.tolist():
        if not (0 < distance < 1e4 and abs(bearing) < 7):
            tally.skip("its range or bearing cannot be")
            continue
        known = ids == "given" and number >= 0
        seen.append(Seen(range=distance, bearing=bearing, id=int(number) if known else None))
        tally.read += 1
    return tuple(seen)


def sighting_recording(
    path: Path, steps: list[SightingStep], noise: tuple[float, float], tally: Tally, form: str
) -> SightingRecording:
    """Steps in time order → the recording; `noise` (range [m], bearing [rad]) as standard deviations.

    The field of the sensor is what the log's own sightings span. Raises BadInput without steps.
    """
    distances = [seen.range for step in steps for seen in step.seen]
    bearings = [abs(seen.bearing) for step in steps for seen in step.seen]
    if not distances:
        raise BadInput(f"{path.name} holds no sighting that can be used. {tally.reasons()}".strip())
    sensor = SightingSensor(
        range_sd=noise[0], bearing_sd=noise[1], range_max=max(distances), half_field=min(max(bearings), np.pi)
    )
    return SightingRecording(path=path, steps=tuple(steps), sensor=sensor, report=tally.report(form))


def grouped(keys: Array, rows: Array) -> dict[int, Array]:
    """Rows (M, …) by their integer key (M,), in rising order of the key and in the file's order within one."""
    order = np.argsort(keys, kind="stable")
    values, starts = np.unique(keys[order].astype(np.int64), return_index=True)
    return dict(zip(values.tolist(), np.split(rows[order], starts[1:]), strict=True)) if len(values) else {}
