"""The paper's simulation as frozen draws: many runs of noisy controls and sightings in one archive.

`v_noisy`, `steer_noisy` (runs, steps): speed [m/s] and steer [rad] as the filter gets them; `obs` (M, 5): run, step k
(seen after k steps), id, range, bearing; `still_obs` (S, 5): run, frame, id, range, bearing at the start pose.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from core.errors import BadInput
from core.geometry import Pose
from core.log.motion import Motion
from core.log.npz import Archive
from core.log.recording import SightingRecording, SightingStep
from core.log.sightings import MOST_ROWS, Ids, grouped, seen_in, sighting_recording
from core.log.tally import Tally

STEP = 0.025  # [s] between controls (section 6: 40 Hz)
FRAME = 0.2  # [s] between still frames (section 6: 5 Hz)
WHEELBASE = 0.10  # [m]
CONTROL_NOISE = np.diag([0.2**2, math.radians(1.0) ** 2])  # of speed and steer, drawn anew every step (eq 43)
SIGHTING_NOISE = 0.08, math.radians(1.0)  # [m], [rad] (eq 43)


def read(archive: Archive, run: int, ids: Ids, still: bool) -> SightingRecording:
    """One run, the first is 0; with `still`, its still frames come first, at negative times. Raises BadInput."""
    speeds, steers = archive.floats("v_noisy", 0), archive.floats("steer_noisy", 0)
    rows = archive.floats("obs", 5)
    if speeds.shape != steers.shape or not len(speeds):
        raise BadInput(f"v_noisy and steer_noisy in {archive.path.name} do not fit together.")
    if run >= len(speeds):
        raise BadInput(f"{archive.path.name} has runs 0 to {len(speeds) - 1}; there is no run {run}.")
    if speeds.shape[1] > MOST_ROWS:
        raise BadInput(f"{archive.path.name} has more than {MOST_ROWS} steps in a run.")
    tally = Tally(Path(f"{archive.path}#{run}"))
    steps = _still_steps(archive, run, ids, tally) if still else []
    by_step = grouped(rows[rows[:, 0] == run, 1], rows[rows[:, 0] == run, 2:])
    beyond = [k for k in by_step if not 0 <= k <= speeds.shape[1]]
    tally.skip("its step is not one of the run", count=sum(len(by_step.pop(k)) for k in beyond))
    motion = Motion()
    for k, (speed, steer) in enumerate(zip(speeds[run].tolist(), steers[run].tolist(), strict=True), start=1):
        _roll(motion, speed, steer)
        if k in by_step:
            moved, covariance = motion.take()
            seen = seen_in(by_step[k], ids, tally)
            steps.append(SightingStep(stamp=k * STEP, motion=moved, motion_covariance=covariance, seen=seen))
    tally.topics = [f"run {run}: speed, steer, sightings"]
    return sighting_recording(archive.path, steps, SIGHTING_NOISE, tally, "seed-mc runs")


def _still_steps(archive: Archive, run: int, ids: Ids, tally: Tally) -> list[SightingStep]:
    rows = archive.floats("still_obs", 5)
    frames = grouped(rows[rows[:, 0] == run, 1], rows[rows[:, 0] == run, 2:])
    return [
        SightingStep(
            stamp=(number - len(frames)) * FRAME,
            motion=Pose(),
            motion_covariance=np.zeros((3, 3)),
            seen=seen_in(found, ids, tally),
        )
        for number, found in enumerate(frames.values())
    ]


def _roll(motion: Motion, speed: float, steer: float) -> None:
    """One control step of the car-like model: x += V dt cos(γ + θ), y likewise, θ += V dt sin(γ) / wheelbase."""
    c, s = math.cos(steer), math.sin(steer)
    gain = STEP * np.array([[c, -speed * s], [s, speed * c], [s / WHEELBASE, speed * c / WHEELBASE]])
    way = speed * STEP
    motion.add(Pose(way * c, way * s, way * s / WHEELBASE), gain @ CONTROL_NOISE @ gain.T)
