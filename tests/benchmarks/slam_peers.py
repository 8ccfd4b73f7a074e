"""Accuracy and time on logs of sightings, MRPT's kf-slam run beside ours: `python -m tests.benchmarks.slam_peers`.

The five robots of MRCLAM 6 and the corridor loop, identities given and hidden, each log with the noise that its
reader tells. Error: RMS of the position at the times of sightings, after the rigid motion that fits best for both
(kf-slam does not start before its first landmark). Time: processor seconds for ours, the span between its answers for
MRPT. Real time: how many times faster than the log was recorded.
"""

import json
import math
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np

from core.message import Array
from core.recording import Ids, SightingRecording, open_log
from core.slam.ekf_slam import EkfSlam
from tests.benchmarks import mrpt
from tests.benchmarks.command import print_row, run_command
from tests.benchmarks.log_scores import CORRIDOR, ROBOTS, aligned, true_poses

DATA = Path(__file__).resolve().parents[3] / "shared" / "data"
Row = dict[str, float | str]


def ours(recording: SightingRecording, truth: Array) -> Row:
    """Our filter on a log."""
    slam, places, spent = EkfSlam(), [], []
    for step in recording:
        began = time.process_time()
        slam.advance(step.increment)
        slam.see(step.sightings)
        spent.append(time.process_time() - began)
        places.append((slam.filter.pose.x, slam.filter.pose.y))
    return told(np.array(places), truth, len(slam.landmarks), np.array(spent), recording.duration)


def theirs(recording: SightingRecording, truth: Array, limit: float) -> Row:
    """MRPT's on the same sightings, at most `limit` [s]."""
    sightings = [one for step in recording for one in step.sightings]
    first, reach = sightings[0], max(one.range for one in sightings)
    half_field = max(abs(one.bearing) for one in sightings)
    range_sd, bearing_sd = np.sqrt(np.diag(first.covariance)).tolist()
    steps = [
        mrpt.Seen(
            step.increment.pose,
            step.increment.covariance,
            np.array(
                [(mrpt.NOBODY if one.id is None else one.id, one.range, one.bearing) for one in step.sightings]
            ).reshape(-1, 3),
            reach,
            half_field,
        )
        for step in recording
    ]
    try:
        with tempfile.TemporaryDirectory() as folder:
            answer = mrpt.run(steps, Path(folder), (range_sd, bearing_sd), limit=limit)
    except subprocess.TimeoutExpired:
        return {"failed": f"not done after {limit:.0f} s"}
    except RuntimeError as trouble:
        return {"failed": str(trouble)}
    done = len(answer.poses)
    row = told(answer.poses[:, :2], truth[:done], int(answer.landmarks[-1]), answer.seconds[1:], recording.duration)
    return row if done == len(steps) else row | {"answers": f"{done} of {len(steps)}"}


def told(places: Array, truth: Array, landmarks: int, spent: Array, duration: float) -> Row:
    """Places and truth (K, 2) [m], seconds of the updates, duration of the log [s] → the figures."""
    off = aligned(places, truth) - truth
    return {
        "error_m": round(math.sqrt(float(np.mean(np.sum(off**2, axis=1)))), 3),
        "landmarks": landmarks,
        "ms_mean": round(1000 * float(spent.mean()), 2),
        "ms_p99": round(1000 * float(np.percentile(spent, 99)), 2),
        "times_real_time": round(duration / float(spent.sum())),
    }


def main(
    *,
    data: Path = DATA,  # the folder with mrclam6 and corridor-loop
    limit: float = 600.0,  # [s] that MRPT may take for one log
) -> None:
    if not data.is_dir():
        print_row(f"The logs are not here: {data.name}/ is expected in shared/ beside the repository.")
        return
    choices: tuple[Ids, ...] = ("given", "hidden")
    for ids in choices:
        errors: dict[str, list[float]] = {"ours": [], "mrpt": []}
        for log in (*ROBOTS, CORRIDOR):
            recording = open_log(data / log, ids=ids)
            assert isinstance(recording, SightingRecording)
            truth = np.array([(pose.x, pose.y) for pose in true_poses(data, log, recording)[0]])
            rows = {"ours": ours(recording, truth)}
            if mrpt.installed():
                rows["mrpt"] = theirs(recording, truth, limit)
            for who, row in rows.items():
                print_row(f"{log}, ids {ids}, {who}: {json.dumps(row)}")
                if log != CORRIDOR and isinstance(row.get("error_m"), float):
                    errors[who].append(float(row["error_m"]))
        for who, each in errors.items():
            if each:
                print_row(f"mrclam6, ids {ids}, {who}: median {np.median(each):.3f}, worst {max(each):.3f} m")
    if not mrpt.installed():
        print_row(mrpt.ABSENT)


if __name__ == "__main__":
    run_command(main)
