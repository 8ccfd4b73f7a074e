"""The processor time of a pilot's step, part by part, by samples of a drive in the simulator or of a recorded one."""

import signal
import time
from collections import defaultdict
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

import numpy as np

from core.errors import BadInput
from core.experiments.rehearsal import Rehearsal
from core.experiments.tour import ROUTE
from core.message import message
from core.pilot.recorded_drive import ComputedNow
from core.recording.drive import DriveRecording
from core.robots.requests import Speak
from core.settings import Settings

SLOWER_TIMES = 4  # times a small board's core takes for the same
SAMPLE_S = 0.001  # of processor time between two samples
SIMULATED_S = 60.0  # of the drive in the simulator
VOICE_PERIOD_S = 10.0  # between two voices in it
PARTS_OF_MODULES = (
    ("core.perception.landmarks", "corners and edges"),
    ("core.perception.people", "people"),
    ("core.perception.sound", "direction of sound"),
    ("core.slam.ekf", "filter"),
    ("core.slam.association", "association"),
    ("core.slam.bearings", "bearings of edges"),
    ("core.slam.odometry", "scan matching"),
    ("core.slam.scan_matching", "scan matching"),
    ("core.slam.relocalization", "finding itself"),
    ("core.slam.loop_closure", "closed loops"),
    ("core.slam", "map"),
    ("core.navigation", "steering"),
    ("core.commands", "steering"),
    ("core.sensors", "checks of readings"),
    ("core.pilot", "the rest of the step"),
)
"""Prefixes of modules, the special ones first, and what their time is called. A helper's time is its caller's."""


@message
class StepProfile:
    source: str
    steps: int
    rate_hz: float  # of the frames
    mean_ms: float
    p50_ms: float
    p95_ms: float
    p99_ms: float
    rooms: tuple[tuple[str, float], ...]  # what, mean of all steps [ms]; the longest first


class StepSampler:
    """Samples what a thread works on by the time that its processor spent on it. Main thread only."""

    def __init__(self) -> None:
        self.spent: dict[str, float] = defaultdict(float)  # [s] by room
        self.steps: list[float] = []  # [s] processor time of each
        self._last = 0.0  # [s]
        self._stepping = False

    @contextmanager
    def sampling(self) -> Generator[None]:
        before = signal.signal(signal.SIGPROF, self._sample)
        signal.setitimer(signal.ITIMER_PROF, SAMPLE_S, SAMPLE_S)
        try:
            yield
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            signal.signal(signal.SIGPROF, before)

    @contextmanager
    def step(self) -> Generator[None]:
        began = self._last = time.process_time()
        self._stepping = True
        try:
            yield
        finally:
            self._stepping = False
            self.steps.append(time.process_time() - began)

    def _sample(self, _: int, frame: FrameType | None) -> None:
        """A sample stands for the time since the one before: Python tells of it when a long call of C is over."""
        if self._stepping:
            now = time.process_time()
            self.spent[room_of(frame)] += now - self._last
            self._last = now

    def profile(self, source: str, rate: float) -> StepProfile:
        """Return what was sampled, in parts of what the steps took."""
        took = 1e3 * np.array(self.steps)
        p50, p95, p99 = np.percentile(took, (50, 95, 99)).tolist()
        share = 1e3 * sum(self.steps) / max(sum(self.spent.values()), 1e-9) / len(took)
        rooms = sorted(((name, spent * share) for name, spent in self.spent.items()), key=lambda one: -one[1])
        return StepProfile(
            source=source,
            steps=len(took),
            rate_hz=rate,
            mean_ms=float(took.mean()),
            p50_ms=p50,
            p95_ms=p95,
            p99_ms=p99,
            rooms=tuple(rooms),
        )


def room_of(frame: FrameType | None) -> str:
    """Return the room of the innermost function that belongs to one."""
    while frame is not None:
        module = frame.f_globals.get("__name__", "")
        for prefix, name in PARTS_OF_MODULES:
            if module.startswith(prefix):
                return name
        frame = frame.f_back
    return PARTS_OF_MODULES[-1][1]


def simulated_profile() -> StepProfile:
    """A minute of a tour of `sim:lab`, with a voice now and then."""
    sampler, drive = StepSampler(), Rehearsal("sim:lab")
    drive.around_step = sampler.step
    words, next_voice = iter(ROUTE), VOICE_PERIOD_S
    number = drive.tell(next(words))
    with sampler.sampling():
        for snapshot in drive.frames(SIMULATED_S):
            if any(ended.id == number for ended in snapshot.endings):
                number = drive.tell(next(words))
            if snapshot.stamp > next_voice:
                next_voice += VOICE_PERIOD_S
                drive.robot.ask(Speak(text="hello robot", x_m=1.5, y_m=1.0))
    return sampler.profile("sim:lab", drive.robot.profile.rate)


def recorded_profile(path: Path, settings: Settings) -> StepProfile:
    """The steps of a recorded drive, computed now. Raises BadInput."""
    sampler, drive = StepSampler(), DriveRecording(path)
    computed, stamps = ComputedNow(drive, settings), []
    with sampler.sampling():
        for moment in drive.moments():
            _ = moment.frame  # decoded before the time counts
            with sampler.step():
                stamps.append(computed.take(moment).stamp)
    if len(stamps) < 2:
        raise BadInput(f"{path.name} holds no drive: record one with Beckon, of a minute or more.")
    return sampler.profile(path.name, (len(stamps) - 1) / max(stamps[-1] - stamps[0], 1e-9))


def lines_of(profile: StepProfile) -> Iterator[str]:
    """The profile in lines: a table in Markdown, and what it means for a slower processor."""
    yield f"{profile.source}: {profile.steps} steps of {profile.rate_hz:.0f} Hz, processor time of one core."
    yield ""
    yield "| part of a step | mean [ms] | share |"
    yield "|---|---|---|"
    for name, spent in profile.rooms:
        yield f"| {name} | {spent:.2f} | {100 * spent / profile.mean_ms:.0f} % |"
    yield f"| **a step** | {profile.mean_ms:.2f} | 100 % |"
    yield ""
    p50, p95, p99 = profile.p50_ms, profile.p95_ms, profile.p99_ms
    yield f"Half of the steps take up to {p50:.1f} ms, 95 % {p95:.1f}, 99 % {p99:.1f}."
    period, mean, most = 1e3 / profile.rate_hz, SLOWER_TIMES * profile.mean_ms, SLOWER_TIMES * p95
    fits = "fit" if most < period else "do not fit"
    yield (
        f"With a quarter of this processor's speed, as a small board has: {mean:.1f} ms a step, "
        f"{100 * mean / period:.0f} % of a core; 95 % of the steps take up to {most:.1f} ms and {fits} into "
        f"the {period:.0f} ms of a frame. This is multiplied, not measured."
    )
