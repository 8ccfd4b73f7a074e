"""The Intel Research Lab by the Freiburg relations: our map beside GMapping's poses. Needs the shared recordings.

Scans lie seconds apart, most relations begin or end between them, and the `dense` poses that carry on to there are
off by 0.06 m in the mean: poses that obey scans and relations alike score 0.0637 m, about as well as an honest map
can. The few relations from scan to scan judge the map alone, so that they are told apart.

`python -m tests.benchmarks.intel_relations [--picture FILE]`
"""

import sys
import time
from pathlib import Path

import cv2
import numpy as np

from core.geometry import Pose, wrap
from core.pipelines.slam import slam_log
from core.recording import logged_stamp
from tests.benchmarks.command import print_row, run_command
from tests.conftest import REPOSITORY

AT_SCAN = 0.001  # [s] from a scan at which a relation's end is that scan: nothing has to be carried on to there
SHORT = 2.0  # [s]: what lies between scans, relations as short as this hardly depend on the map
FOLDER = REPOSITORY.parent / "shared" / "data" / "intel-lab"


def read_relations(folder: Path) -> np.ndarray:
    """Rows t1, t2 [s], x, y [m], yaw [rad]: the pose at t2 seen from that at t1."""
    return np.loadtxt(folder / "intel.relations")[:, [0, 1, 2, 3, 7]]


def errors(folder: Path, stamps: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """Stamps (N,) [s] and poses (N, 3) → error of every relation (R, 2): [m], [rad].

    Between the stamps the smooth `dense` poses carry on: pose(t) is blended in time from C_i dense(t) and
    C_{i+1} dense(t), C_i = X_i dense(t_i)⁻¹.
    """
    with np.load(folder / "intel.npz") as archive:
        dense_t, dense = archive["dense_t"], archive["dense_pose"]
    headings = np.unwrap(dense[:, 2])

    def smooth(at: float) -> Pose:
        x, y, heading = (float(np.interp(at, dense_t, c)) for c in (dense[:, 0], dense[:, 1], headings))
        return Pose(x, y, wrap(heading))

    carried = [Pose(*row) @ smooth(at).inverse() for at, row in zip(stamps, poses.tolist(), strict=True)]

    def pose(at: float) -> Pose:
        after = int(np.clip(np.searchsorted(stamps, at), 1, len(stamps) - 1))
        share = float(np.clip((at - stamps[after - 1]) / (stamps[after] - stamps[after - 1]), 0.0, 1.0))
        here = smooth(at)
        one, two = carried[after - 1] @ here, carried[after] @ here
        turn = wrap(two.heading - one.heading)
        return Pose(
            one.x + share * (two.x - one.x), one.y + share * (two.y - one.y), wrap(one.heading + share * turn)
        )

    found = []
    for t1, t2, x, y, yaw in read_relations(folder).tolist():
        move = pose(t1).inverse() @ pose(t2)
        found.append((np.hypot(move.x - x, move.y - y), abs(wrap(move.heading - yaw))))
    return np.array(found)


def at_scans(folder: Path, stamps: np.ndarray) -> np.ndarray:
    """Which relations (R,) have scans at both ends: only these judge the map alone, the others `dense`, too."""
    ends = read_relations(folder)[:, :2]
    return np.abs(ends[:, :, None] - stamps).min(axis=2).max(axis=1) < AT_SCAN


def told(name: str, found: np.ndarray) -> str:
    """One line of the table."""
    way, turn = found[:, 0], np.degrees(found[:, 1])
    return (
        f"{name:9s} {way.mean():.4f} ± {way.std():.4f} m "
        f"(median {np.median(way):.4f}, 99 % {np.quantile(way, 0.99):.3f})"
        f"  {turn.mean():.2f} ± {turn.std():.2f}° (median {np.median(turn):.2f})\n"
    )


def drawn(log_odds: np.ndarray) -> np.ndarray:
    """Log odds → grey picture, north up."""
    return np.flipud(np.clip(128 - 32 * log_odds, 0, 255).astype(np.uint8))


def main(*, picture: Path | None = None) -> None:
    if not FOLDER.is_dir():
        print_row("The recording is not here; shared/data/intel-lab is expected beside the repository.")
        return
    with np.load(FOLDER / "intel.npz") as archive:
        theirs = errors(FOLDER, archive["t"], archive["pose_gmapping"])
        sys.stdout.write(told("GMapping", theirs) + told(" at scans", theirs[at_scans(FOLDER, archive["t"])]))
    start = time.process_time()
    result = slam_log(FOLDER / "intel.npz")
    took, lasted = time.process_time() - start, result.recording.duration
    stamps = np.array([logged_stamp(scan) for scan in result.recording.scans])
    found = errors(FOLDER, stamps, np.array([pose.vector for pose in result.poses]))
    sys.stdout.write(told("Beckon", found) + told(" at scans", found[at_scans(FOLDER, stamps)]))
    short = np.abs(np.subtract(*read_relations(FOLDER)[:, :2].T)) < SHORT
    sys.stdout.write(told(" < 2 s", found[short]) + told(" > 2 s", found[~short]))
    print_row(f"{took:.1f} s of processor for {lasted:.0f} s: {lasted / took:.0f} x real time")
    if picture is not None and result.grid is not None:
        cv2.imwrite(str(picture), drawn(result.grid.log_odds))


if __name__ == "__main__":
    run_command(main)
