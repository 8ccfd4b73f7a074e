"""Each snapshot → the moment that goes to the recorder's process: what has not changed since the last stays out."""

import asyncio
import contextlib
import pickle
import time
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from console.control.lease import Lease
from console.recording.events import DriveEvents
from console.recording.work import RecordedMoment
from console.robot.supervisor import RobotSupervisor
from core.errors import Refused
from core.pilot.pilot import Pilot
from core.pilot.trail import NO_POINTS
from core.recording.frame_record import TurnAct
from core.sensors import SensorFrame
from core.slam.map.map_file import SavedMap
from core.slam.map.occupancy import OccupancyGrid
from core.snapshot import Snapshot

NO_LASER = np.zeros((0, 3))
NO_GRID = OccupancyGrid(revision=0, resolution=0.05, origin=np.zeros(2), log_odds=np.zeros((0, 0), np.float32))
NEVER_S = -1e9  # before every stamp and time
MAP_PERIOD_S = 2.0  # [s] between two maps, at least
WHOLE_MAP_PERIOD_S = 20.0  # [s] between two maps to go on in, at least
MAX_WHOLE_MAP_RATE_B_S = 50_000  # bytes of such maps in a second of the recording


class MomentBuilder:
    """Lives on the event loop."""

    def __init__(self, robot: RobotSupervisor, lease: Lease) -> None:
        self.events = DriveEvents(robot.status())
        self._robot, self._lease = robot, lease
        self._pilot: Pilot | None = None
        self._unix_from_monotonic = 0.0  # [s]
        self._map_stamp = self._view_stamp = NEVER_S  # [s], of the newest
        self._grid_revision = self._voice_id = -1
        self._whole_map = b""  # to go on in, for the next moment
        self._whole_map_due_s = NEVER_S  # monotonic

    def equip(self, pilot: Pilot) -> None:
        """Its map goes into what is recorded."""
        self._pilot, self._whole_map_due_s = pilot, NEVER_S

    def moment(self, snapshot: Snapshot, frame: SensorFrame, *, running: bool) -> RecordedMoment:
        """The moment of this snapshot. A recording that is `running` keeps the clock that it began with."""
        stamp, view, holder = snapshot.stamp, snapshot.view, self._lease.holder
        if any(isinstance(act, SavedMap | TurnAct) for act in (snapshot.inputs.acts if snapshot.inputs else ())):
            self._whole_map_due_s = NEVER_S
        whole_map, self._whole_map = self._whole_map, b""
        map_is_new = snapshot.grid.revision != self._grid_revision and not 0 <= stamp - self._map_stamp < MAP_PERIOD_S
        if map_is_new:
            self._grid_revision, self._map_stamp = snapshot.grid.revision, stamp
        view_is_new = view is not None and view.stamp != self._view_stamp
        self._view_stamp = self._view_stamp if view is None else view.stamp
        azimuth, voices = None, () if snapshot.hearing is None else snapshot.hearing.voices
        if voices and voices[0].id != self._voice_id:
            azimuth, self._voice_id = voices[0].azimuth, voices[0].id
        now = time.monotonic()
        if not running:
            self._unix_from_monotonic = time.time() - now
        at = min(frame.sensed or now, now)
        return RecordedMoment(
            at=at,
            logged=self._unix_from_monotonic + at,
            snapshot=slimmed(snapshot, with_map=map_is_new),
            gate=self._robot.status(),
            operator="" if holder is None else holder.name,
            map_is_new=map_is_new,
            view_is_new=view_is_new,
            azimuth=azimuth,
            whole_map=whole_map,
            texts=self.events.taken(),
        )

    async def take_whole_map(self, *, when_due: bool = False) -> None:
        """Put the map that what is computed later goes on in into the next moment, with its cells and landmarks."""
        pilot = self._pilot
        if pilot is None or (when_due and time.monotonic() <= self._whole_map_due_s):
            return
        with contextlib.suppress(Refused):  # there is none yet
            self._whole_map = await asyncio.to_thread(lambda: pilot.keep_map().to_bytes())
            self._grid_revision, self._map_stamp = -1, NEVER_S
            period_s = max(WHOLE_MAP_PERIOD_S, len(self._whole_map) / MAX_WHOLE_MAP_RATE_B_S)
            self._whole_map_due_s = time.monotonic() + period_s


def pickled(moments: Iterable[RecordedMoment]) -> list[bytes]:
    """Pickle each by itself: between two of them the pilot may have the interpreter."""
    found: list[bytes] = []
    for one in moments:
        found.append(pickle.dumps(one, pickle.HIGHEST_PROTOCOL))
        time.sleep(0)
    return found


def slimmed(snapshot: Snapshot, *, with_map: bool) -> Snapshot:
    """A snapshot without what is large and is not recorded: of a picture that is packed, its pixels."""
    inputs, view = snapshot.inputs, snapshot.view
    image = None if inputs is None else inputs.frame.image
    if inputs is not None and image is not None and image.packed:
        frame = replace(inputs.frame, image=replace(image, pixels=image.pixels[:0]))
        inputs = replace(inputs, frame=frame)
    return replace(
        snapshot,
        scan_points=NO_POINTS,
        trail=NO_POINTS,
        dead_reckoning_trail=NO_POINTS,
        associations=(),
        landmarks=snapshot.landmarks if with_map else (),
        grid=snapshot.grid if with_map else NO_GRID,
        notices=(),
        sensors=(),
        inputs=inputs,
        view=None if view is None else replace(view, laser=NO_LASER, quality=None),
    )
