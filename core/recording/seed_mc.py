"""The paper's simulation as frozen draws: many runs of noisy controls and sightings in one archive.

`v_noisy`, `steer_noisy` (runs, steps): speed [m/s] and steer [rad] as the filter gets them; `obs` (M, 5): run, step k
(seen after k steps), id, range, bearing; `still_obs` (S, 5): run, frame, id, range, bearing at the start pose.
"""

import math

from core.errors import BadInput
from core.recording.npz import Archive
from core.recording.read_report import ReadReport
from core.recording.recording import SightingRecording
from core.recording.sightings import MOST_ROWS, Ids, SightingSteps, grouped
from core.slam.motion import Increment, MotionSettings, steered

CONTROLS = MotionSettings(model="paper")  # 40 Hz, wheelbase 0.10 m, Q of eq. 43: they made this log, whatever is set
FRAME_PERIOD_S = 0.2  # between still frames (section 6: 5 Hz)
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
    tally = ReadReport(archive.path)
    steps = SightingSteps(SIGHTING_NOISE, ids, tally)
    if still:
        _take_still_frames(archive, run, steps)
    by_step = grouped(rows[rows[:, 0] == run, 1], rows[rows[:, 0] == run, 2:])
    beyond = [k for k in by_step if not 0 <= k <= speeds.shape[1]]
    tally.skip("its step is not one of the run", count=sum(len(by_step.pop(k)) for k in beyond))
    moved = Increment()
    for k, (speed, steer) in enumerate(zip(speeds[run].tolist(), steers[run].tolist(), strict=True), start=1):
        moved = moved.then(steered(speed, steer, CONTROLS.step, CONTROLS))
        if k in by_step:
            steps.add(k * CONTROLS.step, moved, by_step[k])
            moved = Increment()
    tally.topics = [f"run {run}: speed, steer, sightings"]
    return steps.finish(archive.path, "seed-mc runs")


def _take_still_frames(archive: Archive, run: int, steps: SightingSteps) -> None:
    rows = archive.floats("still_obs", 5)
    frames = grouped(rows[rows[:, 0] == run, 1], rows[rows[:, 0] == run, 2:])
    for number, found in enumerate(frames.values()):
        steps.add((number - len(frames)) * FRAME_PERIOD_S, Increment(), found)
