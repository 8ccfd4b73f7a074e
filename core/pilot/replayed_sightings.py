"""A log of sightings that plays as if it were a robot: each step goes to the estimator when it is due."""

import time
from dataclasses import replace

from core.gate import ZERO, Twist
from core.geometry import Pose
from core.pilot.recorded_drive import COMPUTING_BUDGET_S, EMPTY_GRID, NO_COVARIANCE, ReplayFrame
from core.pilot.trail import NO_POINTS, Trail
from core.recording import SightingRecording, SightingStep
from core.robots import Profile
from core.robots.replayed import PlayedRecording
from core.robots.requests import PlaybackState
from core.settings import Settings
from core.slam.ekf_slam import EkfSlam
from core.slam.estimate import Estimate
from core.slam.motion import Increment
from core.snapshot import Snapshot

TRAIL_STEP_M = 0.05


class ReplayedSightings(PlayedRecording):
    """Pose and landmarks are estimated here, as `beckon slam` does it: the log holds nothing that could be drawn.

    It shows its first step and waits. A place before the one that is shown is reached from the start again; where
    that takes longer than a frame, the page is shown how far it has come.
    """

    def __init__(self, recording: SightingRecording, url: str, settings: Settings) -> None:
        super().__init__()
        self._recording, self._settings = recording, settings
        self.profile = Profile(
            name=recording.path.name, url=url, capabilities=frozenset({"replay"}), duration=recording.duration
        )
        self._notes = tuple(recording.report.warnings)
        self._goal = 0.0  # [s] from the start, to which it is to be estimated
        self._begin()

    def _begin(self) -> None:
        self._slam = EkfSlam(self._settings.ekf)
        self._trail, self._drifted, self._by_wheels = Trail(TRAIL_STEP_M), Trail(TRAIL_STEP_M), Pose()
        self._clock = 0.0  # [s] from the start, of what is shown
        self._next = 0  # number of the next step
        self._shown = self._snapshot(ZERO)

    def read(self) -> ReplayFrame:
        """One step of 1/rate further at the chosen speed; where estimating takes longer, as far as it came."""
        deadline = time.monotonic() + COMPUTING_BUDGET_S
        if self._playing and self._ended:
            self._playing, self._notes = False, (*self._notes, "The recording ends here.")
        elif self._playing and self._clock >= self._goal:
            further = 0.0 if self._waits else self._speed / self.profile.rate
            self._goal = min(self._goal + further, self._recording.duration)
        running = self._playing
        self._estimate_until(deadline)
        if self._waits:
            self._pause()
        notes, self._notes = self._notes, ()
        state, stamp = self._state, self._recording.start + self._clock
        shown = replace(self._shown, stamp=stamp, running=running, progress=state.progress)
        return ReplayFrame(
            stamp=stamp, notes=notes, running=running, progress=state.progress, shown=shown, playback=state
        )

    def _estimate_until(self, deadline: float) -> None:
        """Take every step up to the goal, or until the time is over."""
        step, start = None, self._recording.start
        while not self._ended and self._recording.steps[self._next].stamp - start <= self._goal:
            if step is not None and time.monotonic() > deadline:
                self._clock = step.stamp - start
                break
            step = self._recording.steps[self._next]
            self._take(step)
        else:
            self._clock = self._goal
        if step is not None:
            self._shown = self._snapshot(self._velocity(step))

    def _take(self, step: SightingStep) -> None:
        self._next += 1
        self._slam.advance(step.increment)
        self._slam.see(step.sightings)
        self._by_wheels = self._by_wheels @ step.increment.pose
        self._trail.add(self._slam.pose.x, self._slam.pose.y)
        self._drifted.add(self._by_wheels.x, self._by_wheels.y)

    def _velocity(self, step: SightingStep) -> Twist:
        """Over the step that was taken last."""
        before = self._recording.steps[max(self._next - 2, 0)]
        elapsed, move = step.stamp - before.stamp, step.increment.pose
        return Twist(move.x / elapsed, move.heading / elapsed) if elapsed > 0 else ZERO

    def _snapshot(self, velocity: Twist) -> Snapshot:
        """Return everything that is shown of the estimate as it is now."""
        slam = self._slam
        return Snapshot(
            stamp=self._recording.start + self._clock,
            estimate=slam.estimate,
            dead_reckoning=Estimate(pose=self._by_wheels, covariance=NO_COVARIANCE),
            increment=Increment(),
            velocity=velocity,
            setpoint=ZERO,
            scan_points=NO_POINTS,
            landmarks=slam.landmarks,
            associations=slam.associations,
            slam=slam.health,
            grid=EMPTY_GRID,
            trail=self._trail.points,
            dead_reckoning_trail=self._drifted.points,
            path=NO_POINTS,
        )

    @property
    def _state(self) -> PlaybackState:
        duration = self._recording.duration
        return PlaybackState(
            playing=self._playing,
            speed=self._speed,
            position_s=self._clock,
            duration_s=duration,
            progress=1.0 if self._ended or duration <= 0 else self._clock / duration,
        )

    @property
    def _ended(self) -> bool:
        return self._next >= len(self._recording.steps)

    def _seek(self, share: float) -> None:
        self._goal = share * self._recording.duration
        if self._goal < self._clock:
            self._begin()
