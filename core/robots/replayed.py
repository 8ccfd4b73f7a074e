"""A recording that plays as if it were a robot: it is seen and heard, but it cannot be driven."""

from abc import ABC, abstractmethod
from typing import Any, cast

import numpy as np

from core.errors import BadInput
from core.gate import Twist
from core.recording import ScanRecording, logged_stamp
from core.robots import Profile
from core.robots.requests import (
    AnswerT,
    Pause,
    Play,
    PlaybackMark,
    PlaybackMarks,
    PlaybackState,
    ReadMarks,
    ReadPlayback,
    Requests,
    RobotRequest,
    Seek,
    SetSpeed,
    finite,
    not_taken,
)
from core.sensors import Image, SensorFrame, Sound

GAP_S, GAP_PERIODS = 1.0, 5.0  # [s], and times the usual period, without a scan that are worth a mark
MOST_GAPS = 40
MIN_PLAYBACK_SPEED, MAX_PLAYBACK_SPEED = 0.1, 20.0  # times the speed of life
GAP_WORDS = "{:.1f} s without a scan"


def profile_of(recording: ScanRecording, url: str = "") -> Profile:
    """The profile of the robot that was recorded, as far as the log gives it."""
    return Profile(
        name=recording.path.name,
        url=url,
        lasers=(recording.laser,) if recording.laser else (),
        cameras=(recording.camera,) if recording.camera else (),
        capabilities=frozenset({"replay"}),
        duration=recording.duration,
        gaps=gaps_of(recording),
    )


def gaps_of(recording: ScanRecording) -> tuple[tuple[float, float], ...]:
    """Return the long gaps between a recording's scans: from and to [s] from its start, the longest ones in order."""
    stamps = np.array([logged_stamp(scan) for scan in recording.scans]) - recording.start
    apart = np.diff(stamps)
    if not len(apart):
        return ()
    long = np.flatnonzero(apart > max(GAP_S, GAP_PERIODS * float(np.median(apart))))
    longest = np.sort(long[np.argsort(apart[long])[-MOST_GAPS:]])
    return tuple((float(stamps[number]), float(stamps[number + 1])) for number in longest)


class PlayedRecording(ABC):
    """A `core.robots.Robot` that cannot be driven: how a recording plays."""

    profile: Profile  # of the robot that was recorded, as far as the log gives it
    requests: Requests = (Play, Pause, SetSpeed, Seek, ReadPlayback, ReadMarks)  # that it takes

    def __init__(self) -> None:
        self._marks: tuple[PlaybackMark, ...] = ()
        self._speed = 1.0
        self._playing = True
        self._waits = True  # after its first scan

    @property
    @abstractmethod
    def _state(self) -> PlaybackState: ...

    @property
    @abstractmethod
    def _ended(self) -> bool: ...

    @abstractmethod
    def _seek(self, share: float) -> None: ...

    def drive(self, twist: Twist) -> None:
        """Ignore the twist: a recording does not move."""
        del twist

    def close(self) -> None:
        """Play no more."""
        self._playing = False

    def ask(self, request: RobotRequest[AnswerT]) -> AnswerT:
        """Play, pause, set the speed, seek → how it plays then. Raises BadInput."""
        request_any: RobotRequest[Any] = request
        match request_any:
            case Play():
                if self._ended:
                    self._seek(0.0)
                self._playing, self._waits = True, False
            case Pause():
                self._pause()
            case SetSpeed(value=value):
                self._set_speed(finite(value, "value"))
            case Seek(value=value):
                if not 0 <= finite(value, "value") <= 1:
                    raise BadInput("The place in a recording lies between 0 (its start) and 1 (its end).")
                self._seek(value)
            case ReadMarks():
                return cast(AnswerT, PlaybackMarks(self._marks))
            case ReadPlayback():
                pass
            case _:
                raise not_taken(self.requests)
        return cast(AnswerT, self._state)

    def _pause(self) -> None:
        self._playing = self._waits = False

    def _set_speed(self, speed: float) -> None:
        if not MIN_PLAYBACK_SPEED <= speed <= MAX_PLAYBACK_SPEED:
            raise BadInput(
                f"The speed of a recording lies between {MIN_PLAYBACK_SPEED:g} and {MAX_PLAYBACK_SPEED:g}."
            )
        self._speed = speed


class ReplayedRobot(PlayedRecording):
    """Plays the scans of a recording in the log's own time; between them come frames with the wheels alone.

    It shows its first scan and waits there for a request to play, so that nobody misses its beginning.
    No scan is left out, and a frame has room for one: that bounds the speed.
    """

    def __init__(self, recording: ScanRecording, url: str):
        super().__init__()
        self._recording = recording
        self.profile = profile_of(recording, url)
        gaps = self.profile.gaps
        self._marks = tuple(PlaybackMark(since, "gap", GAP_WORDS.format(until - since)) for since, until in gaps)
        self._clock = self._shown = recording.start  # [s] log time that was played, and that of the newest frame
        self._next = 0  # number of the next scan
        self._pictured = 0  # number of the next picture
        self._heard = recording.start  # [s] log time up to which the sound was played
        self._notes = tuple(recording.report.warnings)

    def read(self) -> SensorFrame:
        """One step of 1/rate further at the chosen speed, or the next scan that is due."""
        if self._playing and self._ended:
            self._playing, self._notes = False, (*self._notes, "The recording ends here.")
        elif self._playing and not self._due:
            end = self._recording.start + self._recording.duration
            self._clock = min(self._clock + self._speed / self.profile.rate, end)
        scan = self._recording.scan(self._next) if self._playing and self._due else None
        self._next += scan is not None
        if self._playing:
            self._shown = self._clock if scan is None else logged_stamp(scan)
        notes, self._notes = self._notes, ()
        running = self._playing
        if scan is not None and self._waits:
            self._pause()
        return SensorFrame(
            stamp=self._shown,
            wheels=self._recording.wheels_at(self._shown),
            scan=scan,
            image=self._picture(),
            sound=self._sound(),
            notes=notes,
            running=running,
            progress=self._progress,
        )

    def _picture(self) -> Image | None:
        """The newest picture that is due; one that cannot be read is left out."""
        pictures, due = self._recording.pictures, None
        while self._pictured < len(pictures) and pictures[self._pictured].stamp <= self._shown:
            due = pictures[self._pictured]
            self._pictured += 1
        try:
            return None if due is None else Image(stamp=due.stamp, pixels=due.pixels)
        except BadInput:
            return None

    def _sound(self) -> Sound | None:
        """The sound since the frame before; where it is in pieces, the rest of the first of them."""
        begin = self._heard
        for piece in self._recording.sounds:
            part = piece.part(begin, self._shown)
            if len(part.samples):
                self._heard = part.newest
                return part
        return None

    @property
    def _state(self) -> PlaybackState:
        return PlaybackState(
            playing=self._playing,
            speed=min(self._speed, self.fastest),
            position_s=self._clock - self._recording.start,
            duration_s=self._recording.duration,
            progress=self._progress,
        )

    @property
    def fastest(self) -> float:
        """The speed at which every frame carries a scan, in times the speed of life."""
        scans = len(self._recording.scans)
        return self.profile.rate * self._recording.duration / (scans - 1) if scans > 1 else MAX_PLAYBACK_SPEED

    @property
    def _due(self) -> bool:
        scans = self._recording.scans
        return self._next < len(scans) and logged_stamp(scans[self._next]) <= self._clock

    @property
    def _ended(self) -> bool:
        return self._next >= len(self._recording.scans)

    @property
    def _progress(self) -> float:
        duration = self._recording.duration
        return 1.0 if self._ended or duration <= 0 else (self._clock - self._recording.start) / duration

    def _seek(self, share: float) -> None:
        """Continue from there; the next scan from there on comes next."""
        self._clock = self._shown = self._recording.start + share * self._recording.duration
        stamps = (logged_stamp(scan) for scan in self._recording.scans)
        self._next = sum(stamp < self._clock for stamp in stamps)
        self._next = min(self._next, len(self._recording.scans) - 1)
        self._pictured = sum(picture.stamp < self._clock for picture in self._recording.pictures)
        self._heard = self._clock
