"""Beckon's own recording that plays as if it were a robot: as recorded, as computed now, or one over the other.

The file is read where it is played, so that a long one needs no more memory than a short one. What is computed now is
computed here, in the process that reads: no frame is left out, however seldom the page takes one.
"""

import json
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from core.errors import BadInput
from core.message import Array
from core.pilot.recorded_drive import (
    COMPUTING_BUDGET_S,
    MAP,
    AsRecorded,
    Comparer,
    ComputedNow,
    ReplayFrame,
    landmarks_with,
    robot_of,
    seen_from_computed,
)
from core.pilot.replayed_sightings import ReplayedSightings
from core.pilot.trail import NO_POINTS
from core.recording import ScanRecording, open_log
from core.recording.drive import CAMERA_TOPIC, SAME_MOMENT_S, DriveMoment, DriveRecording, is_drive, text_of
from core.robots import Robot
from core.robots.frame_sender import merged
from core.robots.replayed import PlayedRecording, ReplayedRobot
from core.robots.requests import AnswerT, PlaybackMark, PlaybackState, Requests, RobotRequest, ShowWay
from core.sensors import SensorFrame
from core.sentences import Statement
from core.settings import Settings
from core.snapshot import Comparison, Snapshot

EVENTS = "/beckon/events"  # topic
LEAD_S = 2.0  # [s] before a place that are looked through for the newest of each reading
SPEED_WINDOW_S = 2.0  # [s] over which the speed that is reached is measured
TRAIL_STEP_M = 0.05
MARK_KINDS = {
    "command": "command",
    "words": "speech",
    "contact": "contact",
    "trip": "trip",
    "gate": "halt",
    "lost": "lost",
    "closure": "closure",
}
"""An event's name → the kind of its mark."""
MAX_MARKS = 400


class DriveIndex:
    """The way of the whole drive and its marks, read once in the background."""

    def __init__(self, path: Path, settings: Settings) -> None:
        self._path, self._settings = path, settings
        self._rows: list[tuple[float, float, float]] = []  # [s] from the start, x, y [m]
        self._over = threading.Event()
        self.free = threading.Event()  # not set while a place is sought: then it rests
        self.free.set()
        self.done = False
        self._thread = threading.Thread(target=self._run, name="drive-index", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End."""
        self._over.set()
        self.free.set()
        self._thread.join()

    def trail(self, until: float) -> Array:
        """The way up to a time [s] as far as it is read, (N, 2) [m]."""
        rows = np.array(list(self._rows)).reshape(-1, 3)
        return rows[rows[:, 0] <= until, 1:] if len(rows) else NO_POINTS

    def _run(self) -> None:
        drive = DriveRecording(self._path, self._settings.log)
        try:
            for at, (x, y, _) in drive.places():
                self.free.wait()
                if self._over.is_set():
                    return
                if not self._rows or np.hypot(x - self._rows[-1][1], y - self._rows[-1][2]) >= TRAIL_STEP_M:
                    self._rows.append((at, x, y))
            self.done = True
        finally:
            drive.close()


def marks_of(drive: DriveRecording) -> tuple[PlaybackMark, ...]:
    """The events of a drive on its timeline."""
    found: list[PlaybackMark] = []
    for one in drive.every(EVENTS):
        try:
            event: dict[str, Any] = json.loads(text_of(one))
        except ValueError:
            continue
        mark = _mark(one.logged - drive.start, event)
        if mark is not None and len(found) < MAX_MARKS:
            found.append(mark)
    return tuple(found)


def _mark(at: float, event: dict[str, Any]) -> PlaybackMark | None:
    kind = MARK_KINDS.get(str(event.get("event")), "")
    if not kind or (kind == "halt" and event.get("state") != "halted"):
        return None
    words = next((str(event[key]) for key in ("words", "text", "reason", "name") if event.get(key)), "")
    who = str(event.get("who") or "")
    return PlaybackMark(t_s=round(max(at, 0.0), 3), kind=kind, text=f"{who}: {words}" if who and words else words)


class ReplayedDrive(PlayedRecording):
    """A drive that was recorded with its results."""

    requests: Requests = (*PlayedRecording.requests, ShowWay)

    def __init__(self, path: Path, url: str, settings: Settings) -> None:
        """Raises BadInput where nothing of the recording can be played."""
        super().__init__()
        self._drive, self._settings = DriveRecording(path, settings.log), settings
        self._robot = robot_of(self._drive)
        self._marks = marks_of(self._drive)
        self._has_results = self._drive.has_results
        self._recorded = AsRecorded(self._robot.built)
        self._computed: ComputedNow | None = None
        self._comparer = Comparer()
        self._comparison: Comparison | None = None
        self._way: str = "recorded" if self._has_results else "computed"
        self._compares = False
        self._reached = 1.0
        self._clock = 0.0  # [s] from the start, of what was played
        self._shown = SensorFrame(stamp=0.0)
        self._snapshot: Snapshot | None = None
        self._pace: list[tuple[float, float]] = []  # [s] real time, clock
        self._index = DriveIndex(path, settings)
        self.profile = replace(
            self._robot.built,
            name=path.name,
            url=url,
            capabilities=frozenset({"replay", "results"}),
            duration=self._drive.duration,
            gaps=(),
            failsafe="",
            lock="",
            notices=(),
        )
        self._notes = tuple(self._drive.report.warnings)
        self._left_out = 0  # messages that could not be read, when that was last said
        self._moments: Iterator[DriveMoment] = iter(())
        self._next: DriveMoment | None = None
        self._carried: SensorFrame | None = None  # the newest readings before a place that was sought
        self._last: tuple[DriveMoment, Snapshot | None, Snapshot | None] | None = None  # recorded, computed
        self._go_to(0.0)

    def read(self) -> SensorFrame:
        """One step of 1/rate further at the chosen speed; where computing takes longer, as far as it came."""
        began = time.monotonic()
        frame: SensorFrame | None = None
        if self._playing and self._next is None:
            self._playing, self._clock = False, self._drive.duration
            self._notes = (*self._notes, *self._left_out_words(), "The recording ends here.")
        elif self._playing and self._next is not None:
            goal = self._time_of(self._next) if self._waits else self._clock + self._speed / self.profile.rate
            frame, complete = self._advance(goal, began + COMPUTING_BUDGET_S)
            self._clock = min(goal, self._drive.duration) if complete else self._clock
        running = self._playing
        if frame is not None and self._waits:
            self._pause()
        self._measure(began)
        self._index.free.set()
        return self._frame(frame, running=running)

    def _frame(self, frame: SensorFrame | None, *, running: bool) -> SensorFrame:
        """Return what is shown now; without a new frame, the last one without its readings."""
        notes, self._notes = self._notes, ()
        last = self._shown
        shown = frame or replace(last, scan=None, image=None, sound=None, notes=(), faults=())
        self._shown = shown
        whole: dict[str, Any] = {key: getattr(shown, key) for key in SensorFrame.__dataclass_fields__}
        whole |= {"notes": notes, "running": running, "progress": self._progress, "trouble": ""}
        if self._snapshot is None:
            return SensorFrame(**whole)
        snapshot = replace(
            self._snapshot, running=running, progress=self._progress, notices=(), endings=self._snapshot.endings
        )
        self._snapshot = replace(self._snapshot, endings=())
        return ReplayFrame(**whole, shown=snapshot, playback=self._state)

    def _advance(self, goal: float, deadline: float) -> tuple[SensorFrame | None, bool]:
        """Play every moment up to `goal` [s] → their frames as one, and False where the time was over before."""
        frame: SensorFrame | None = None
        while self._next is not None and self._time_of(self._next) <= goal:
            moment = self._next
            self._next = due = next(self._moments, None)
            newest = due is None or self._time_of(due) > goal
            taken = self._play_moment(moment, newest=newest)
            frame = taken if frame is None else merged(frame, taken)
            if self._is_computing and time.monotonic() > deadline:
                self._clock = max(self._clock, self._time_of(moment))
                return self._with_carried(frame), False
        return self._with_carried(frame), True

    def _with_carried(self, frame: SensorFrame | None) -> SensorFrame | None:
        if frame is None or self._carried is None:
            return frame
        carried, self._carried = self._carried, None
        return merged(carried, frame)

    def _time_of(self, moment: DriveMoment) -> float:
        return moment.logged - self._drive.start

    @property
    def _is_computing(self) -> bool:
        return self._way == "computed" or self._compares

    def _play_moment(self, moment: DriveMoment, *, newest: bool) -> SensorFrame:
        """One moment in the ways that are shown; `newest`: it is what the page sees of several."""
        recorded = self._recorded.take(moment, newest=newest or self._is_computing)
        computed = None
        if self._is_computing:
            if self._computed is None:
                self._computed, self._comparer = ComputedNow(self._drive, self._settings), Comparer()
            begins = self._computed.since
            computed = self._computed.take(moment)
            if self._computed.why_empty and self._computed.since != begins:
                self._notes = (*self._notes, Statement("recording.empty_map", why=self._computed.why_empty))
        if recorded is not None or computed is not None:
            self._last = moment, recorded, computed
            if recorded is not None and computed is not None and self._computed is not None:
                drawn = self._computed.recorded_from_computed
                self._comparison = self._comparer.compare(moment, recorded, computed, drawn)
            self._snapshot = self._chosen(recorded, computed)
        return moment.light_frame if not (newest or self._is_computing) else moment.frame

    def _chosen(self, recorded: Snapshot | None, computed: Snapshot | None) -> Snapshot | None:
        """The snapshot of the way that is shown, with the other one beside it where both are."""
        comparison = self._comparison
        if computed is None or self._computed is None:
            return recorded
        if recorded is None or comparison is None:
            return computed
        drawn = self._computed.recorded_from_computed
        if self._way == "recorded":
            return replace(recorded, other=comparison)
        then = replace(
            computed,
            active_command=recorded.active_command,
            goal=recorded.goal if self._computed.whole else None,
            path=recorded.path if self._computed.whole else NO_POINTS,
            endings=recorded.endings,
        )
        return replace(then, other=seen_from_computed(comparison, recorded, drawn)) if self._compares else then

    # requests

    def ask(self, request: RobotRequest[AnswerT]) -> AnswerT:
        """As any recording; or show another way. Raises BadInput."""
        if not isinstance(request, ShowWay):
            return super().ask(request)
        self._show(request.way, request.compare)
        return cast(AnswerT, self._state)

    @property
    def _state(self) -> PlaybackState:
        computed = self._computed
        return PlaybackState(
            playing=self._playing,
            speed=self._speed,
            position_s=self._clock,
            duration_s=self._drive.duration,
            progress=self._progress,
            way=self._way,
            compare=self._compares,
            ways=("recorded", "computed") if self._has_results else ("computed",),
            computed_since_s=None if computed is None else computed.since,
            reached=round(self._reached, 2),
        )

    def close(self) -> None:
        """Let go of the file."""
        self._index.close()
        self._drive.close()

    @property
    def _progress(self) -> float:
        duration = self._drive.duration
        return 1.0 if self._next is None or duration <= 0 else min(self._clock / duration, 1.0)

    @property
    def _ended(self) -> bool:
        return self._next is None

    def _set_speed(self, speed: float) -> None:
        super()._set_speed(speed)
        self._pace = []

    def _seek(self, share: float) -> None:
        self._go_to(share * self._drive.duration)
        self._show_one()

    def _show(self, way: str, compare: bool) -> None:
        """Show another way; what is computed begins where the recording stands."""
        if not self._has_results and (way == "recorded" or compare):
            raise BadInput("This recording holds readings alone; nothing was computed when it was recorded.")
        computes = self._is_computing
        self._way, self._compares = way, compare
        if computes and self._is_computing and self._last is not None:
            self._snapshot = self._chosen(*self._last[1:])
        else:
            self._go_to(self._clock)
        self._show_one()

    def _show_one(self) -> None:
        if not self._playing:
            self._playing = self._waits = True

    def _go_to(self, place: float) -> None:
        """Go on from a place [s]: what was known there is shown, and what is computed begins there."""
        self._index.free.clear()  # until the place is shown
        self._computed, self._pace, self._last, self._comparison = None, [], None, None
        grid = self._drive.latest(MAP, place)
        known = () if grid is None else landmarks_with(self._drive, grid)
        self._recorded.begin(grid, known, self._index.trail(place))
        self._clock, self._snapshot = place, None
        before: SensorFrame | None = None
        self._moments = self._drive.moments(max(place - LEAD_S, 0.0))
        held: list[DriveMoment] = []
        while (moment := next(self._moments, None)) is not None and self._time_of(moment) < place - SAME_MOMENT_S:
            held.append(moment)
        self._next = moment
        if _newest(held, "image") is None and (seen := self._drive.latest(CAMERA_TOPIC, place)) is not None:
            earlier = self._drive.moment_of(seen)  # no picture has come for long
            held[:0] = [] if earlier is None else [earlier]
        readings = (_newest(held, reading) for reading in ("image", "scan"))
        for number in sorted({number for number in readings if number is not None}):
            before = held[number].frame if before is None else merged(before, held[number].frame)
            self._recorded.take(held[number], newest=True)
        if before is not None:
            self._shown = before
        if held:
            self._snapshot = self._recorded.take(held[-1], newest=True)
        self._carried = before

    def _measure(self, now: float) -> None:
        """The speed that is reached: computing may take longer than real time."""
        self._pace.append((now, self._clock))
        while now - self._pace[0][0] > SPEED_WINDOW_S:
            self._pace.pop(0)
        real, played = now - self._pace[0][0], self._clock - self._pace[0][1]
        self._reached = played / real if real > 0.5 and self._playing else self._speed

    def _left_out_words(self) -> tuple[str, ...]:
        report = self._drive.report
        words = report.warnings if report.skipped != self._left_out else ()
        self._left_out = report.skipped
        return words


def _newest(moments: list[DriveMoment], reading: str) -> int | None:
    for number in reversed(range(len(moments))):
        record = moments[number].record
        if record is not None and getattr(record, reading) is not None:
            return number
    return None


def open_robot(rest: str, *, seed: int, settings: Settings | None) -> Robot:
    """`rest` is the path of the log after `log:`. Raises BadInput when it cannot be played."""
    del seed  # nothing is left to chance
    settings, path, url = settings or Settings(), Path(rest), f"log:{rest}"
    if is_drive(path):
        return ReplayedDrive(path, url, settings)
    recording = open_log(rest, settings.log, whole=True)
    if isinstance(recording, ScanRecording):
        return ReplayedRobot(recording, url)
    return ReplayedSightings(recording, url, settings)
