"""Drives that are recorded by the recorder's own work, without its process, as fast as the pilot goes."""

import contextlib
import pickle
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np

from console.recording.moments import slimmed
from console.recording.work import NewFile, RecordedMoment, RecorderWorker
from core.errors import Refused
from core.gate.status import GateStatus
from core.pilot import Pilot
from core.pilot.drive_record import digest_of
from core.robots import Profile, Robot
from core.robots.profile_json import profile_to_json
from core.sensors import SensorFrame
from core.sensors.recordable import recordable
from core.settings import Settings
from core.snapshot import Snapshot

BEGAN_S = 1_790_000_000.0  # Unix time
MAP_EVERY = 40  # frames
BATCH = 40  # moments that go to the recorder at once


class RecordedPilot:
    """A pilot whose every frame is recorded."""

    def __init__(
        self,
        path: Path,
        profile: Profile,
        settings: Settings | None = None,
        pilot: Pilot | None = None,
        ring_s: float = 0.0,
    ) -> None:
        """`pilot`: one that is under way; its map goes into the recording. `ring_s`: that can be kept at any time."""
        self.pilot = pilot or Pilot(profile, settings)
        self.profile = profile
        self.snapshots: list[Snapshot] = []
        self.gate = GateStatus()
        self.began_s = BEGAN_S
        self.hurries = False  # goes on while the recorder still writes
        self._recorder, self._waiting = RecorderWorker(), list[RecordedMoment]()
        card = profile_to_json(profile)
        self._recorder.describe(card, card, ring_s)
        self._recorder.begin(NewFile(str(path), {"robot": profile.name}, []))
        self._map = self._view = -1.0
        self._holds_maps = pilot is not None or ring_s > 0

    def step(self, frame: SensorFrame, *, deaf: bool = False) -> Snapshot:
        """Take a frame as a driver hands it on."""
        snapshot = self.pilot.step(recordable(frame), deaf=deaf)
        number, view = len(self.snapshots), snapshot.view
        map_is_new = number % MAP_EVERY == 0 and snapshot.grid.revision != self._map
        self._map = snapshot.grid.revision if map_is_new else self._map
        with_whole = map_is_new and self._holds_maps
        view_is_new = view is not None and view.stamp != self._view
        self._view = self._view if view is None else view.stamp
        self._waiting.append(
            RecordedMoment(
                at=number / self.profile.rate,
                logged=self.began_s + number / self.profile.rate,
                snapshot=slimmed(snapshot, with_map=map_is_new),
                gate=self.gate,
                operator="Ada",
                map_is_new=map_is_new,
                view_is_new=view_is_new,
                whole_map=self._kept_map() if with_whole else b"",
            )
        )
        self.snapshots.append(snapshot)
        if len(self._waiting) >= BATCH:
            self._send()
        return snapshot

    def finish(self) -> None:
        self._send()
        self._recorder.finish()

    def _kept_map(self) -> bytes:
        with contextlib.suppress(Refused):  # there is none yet
            return self.pilot.keep_map().to_bytes()
        return b""

    def keep(self, path: Path, seconds: float) -> None:
        """Save what the ring holds."""
        self._send()
        self._recorder.keep(NewFile(str(path), {}, []), seconds)

    def leave(self) -> None:
        """The recorder's process ends, as it does when the console is gone."""
        self._recorder._leave()

    def _send(self) -> None:
        moments, self._waiting = self._waiting, []
        self._recorder.record([pickle.dumps(one) for one in moments])
        if not self.hurries:
            self._recorder._waiting.join()


def drive(
    robot: Robot,
    path: Path,
    frames: int,
    acts: Callable[[int, RecordedPilot], object],
    settings: Settings | None = None,
    deaf: Iterable[int] = (),
) -> RecordedPilot:
    """Drive a robot by its own pilot and record it; `acts` does what people do before a frame."""
    recorded, silent = RecordedPilot(path, robot.profile, settings), set(deaf)
    for number in range(frames):
        acts(number, recorded)
        snapshot = recorded.step(robot.read(), deaf=number in silent)
        robot.drive(snapshot.setpoint)
    recorded.finish()
    return recorded


def fingerprint(snapshots: Iterable[Snapshot]) -> tuple[bytes, str]:
    """Every pose with its covariance, and the last map."""
    rows = [(*vars(one.estimate.pose).values(), *one.estimate.covariance.ravel()) for one in snapshots]
    return np.array(rows).tobytes(), digest_of(list(snapshots)[-1].grid)
