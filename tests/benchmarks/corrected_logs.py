"""Beckon's path beside the corrected one in a CARMEN log: `python -m tests.benchmarks.corrected_logs LOG …`.

Logs on whose path others have worked are public: the repository of FLIRT has three with the robot's own odometry and
the nodes of a pose graph (`VERTEX2`), that of PLE has thirteen whose scans stand at the poses of GMapping, which are
then the only odometry there is. What is printed is the RMSE of the place after the best turn and shift, and how many
times faster than the drive it went, by processor time. The corrected path is another estimate, no truth.
"""

import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from core.message import Array
from core.pipelines.slam import slam_log
from tests.benchmarks.command import print_row, run_command


def corrected_places(log: Path) -> Array:
    """The corrected places (N, 2) [m] of a log, scan by scan."""
    lines = log.read_text(errors="replace").splitlines()
    nodes = [line.split()[2:4] for line in lines if line.startswith("VERTEX2")]
    return np.array(nodes or list(_beside_scans(lines)), float)


def _beside_scans(lines: list[str]) -> Iterator[list[str]]:
    for line in lines:
        if line.startswith("FLASER"):
            words = line.split()
            after = 2 + int(words[1])
            yield words[after : after + 2]


def aligned(places: Array, onto: Array) -> Array:
    """Places (N, 2) [m], turned and shifted onto others as well as can be."""
    middle, others = places.mean(axis=0), onto.mean(axis=0)
    left, _, right = np.linalg.svd((places - middle).T @ (onto - others))
    left[:, -1] *= np.sign(np.linalg.det(left @ right))
    return (places - middle) @ (left @ right) + others


def main(logs: Sequence[Path]) -> None:
    for log in logs:
        began = time.process_time()
        result = slam_log(log)
        took = time.process_time() - began
        places, corrected = np.array([(pose.x, pose.y) for pose in result.poses]), corrected_places(log)
        assert len(places) == len(corrected), f"{log.name}: scans were left out"
        off = np.hypot(*(aligned(places, corrected) - corrected).T)
        print_row(
            {
                "log": log.name,
                "scans": len(places),
                "way_m": round(float(np.hypot(*np.diff(corrected, axis=0).T).sum())),
                "rmse_m": round(float(np.sqrt((off**2).mean())), 3),
                "worst_m": round(float(off.max()), 2),
                "times_real_time": round(result.recording.duration / took, 1),
                "said": [one.code for one in result.recording.report.faults],
            }
        )


if __name__ == "__main__":
    run_command(main)
