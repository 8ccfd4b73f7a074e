"""Sixty corridors without identities, ours and the plain rule: `python -m tests.benchmarks.corridors [--seeds 0 60]`.

The corridors of `corridor_drives`: sizes, widths, doors, false sightings, detection, odometry and loops drawn from
the seed. For each: our filter as it is set; the plain rule of `plain_rule` on the same sightings with the same
noises; our filter with the identities given, as a bound; and MRPT's kf-slam (nearest neighbour) where it is
installed, for the first of the seeds only (`--mrpt-seeds 3`), as its time grows with every false landmark. Error:
RMS of the position over all updates after the rigid motion that fits best, and without any (all but MRPT are given
the start). Landmarks beside those that were sighted three times or more. NEES of the pose, ideal 3. The settings were
found with other seeds. `--plans`: random storeys with corners found in scans (`plan_drives`) instead of corridors.
"""

import math
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import astuple, dataclass, replace
from pathlib import Path

import numpy as np

from core.geometry import Pose
from core.message import Array
from core.recording.archives import CORRIDOR_NOISE
from core.slam.consistency import squared_error
from core.slam.ekf_slam import EkfSettings, EkfSlam
from tests.benchmarks import mrpt
from tests.benchmarks.command import print_row, run_command
from tests.benchmarks.corridor_drives import HALF_FIELD, REACH, Corridor, Drive, drawn, drive
from tests.benchmarks.log_scores import aligned
from tests.benchmarks.long_log import LASER
from tests.benchmarks.plain_rule import PlainRule
from tests.benchmarks.plan_drives import plan_drive

LOST = 10.0  # NEES from which a run counts as one with wrong matches


@dataclass(frozen=True)
class Score:
    aligned: float  # [m] RMS of the position after the best turn and shift
    plain: float  # [m] ... without
    landmarks: int
    nees: float  # mean over the updates; NaN: not told


def ours(told: Drive, *, given: bool = False, settings: EkfSettings | None = None) -> Score:
    """Our filter; `given`: with the identities."""
    slam, places, squared = EkfSlam(settings), [], []
    for step, names, row in zip(told.steps, told.names, told.truth.tolist(), strict=True):
        slam.advance(step.increment)
        named = (replace(one, id=name) for one, name in zip(step.sightings, names, strict=True) if name >= 0)
        slam.see(tuple(named) if given else step.sightings)
        places.append((slam.filter.pose.x, slam.filter.pose.y))
        squared.append(slam.nees(Pose(*row)))
    return scored(np.array(places), told.truth, len(slam.landmarks), squared)


def plain(told: Drive) -> Score:
    rule, places, squared = PlainRule(), [], []
    for step, row in zip(told.steps, told.truth.tolist(), strict=True):
        rule.advance(step.increment)
        rule.see(step.sightings)
        state = rule.filter
        state.settle()
        places.append((state.pose.x, state.pose.y))
        squared.append(squared_error(state.error(Pose(*row)), state.covariance.block(0, 3)))
    return scored(np.array(places), told.truth, len(rule.filter.places), squared)


def theirs(told: Drive, limit: float) -> Score | str:
    """MRPT's kf-slam, at most `limit` [s]; where that is not enough, the reason."""
    steps = [
        mrpt.Seen(
            step.increment.pose,
            step.increment.covariance,
            np.array([(mrpt.NOBODY, one.range, one.bearing) for one in step.sightings]).reshape(-1, 3),
            (REACH if told.corridor else LASER.range_max) + 0.2,
            HALF_FIELD + math.radians(3) if told.corridor else math.pi,
        )
        for step in told.steps
    ]
    try:
        with tempfile.TemporaryDirectory() as folder:
            answer = mrpt.run(steps, Path(folder), CORRIDOR_NOISE, limit=limit)
    except subprocess.TimeoutExpired:
        return f"not done after {limit:.0f} s"
    except RuntimeError as trouble:
        return str(trouble)
    done = len(answer.poses)
    return scored(answer.poses[:, :2], told.truth[:done], int(answer.landmarks[-1]), [math.nan])


def scored(places: Array, truth: Array, landmarks: int, squared: list[float]) -> Score:
    """Places (K, 2) beside the truth (K, 3)."""
    off, left = places - truth[:, :2], aligned(places, truth[:, :2]) - truth[:, :2]
    return Score(rms(left), rms(off), landmarks, float(np.nanmean(squared)) if len(squared) > 1 else math.nan)


def rms(off: Array) -> float:
    """Root mean square length of vectors (K, 2)."""
    return math.sqrt(float((off**2).sum(axis=1).mean()))


def words(corridor: Corridor) -> str:
    """What was drawn, in one line."""
    return (
        f"{corridor.length:.0f}x{corridor.breadth:.0f} m, {corridor.width:.1f} m wide, doors {corridor.door:.2f} m,"
        f" loops {corridor.loops}, detection {corridor.detection:.2f}, clutter {corridor.clutter:.2f},"
        f" bias {math.degrees(corridor.bias):+.2f} deg/m"
    )


def summary(name: str, scores: list[Score], rule: list[Score], sighted: list[int]) -> str:
    """The figures of one column over all seeds, beside the plain rule's."""
    table = np.array([astuple(one) for one in scores])
    beside = table[:, :2] / np.array([astuple(one)[:2] for one in rule])
    share, nees = table[:, 2] / sighted, table[:, 3]
    lines = [f"{name}:"]
    for k, frame in enumerate(("aligned", "as it stands")):
        error, ratio = table[:, k], beside[:, k]
        lines.append(
            f"error {frame}: median {np.median(error):.3f}, mean {error.mean():.3f}, worst {error.max():.3f} m;"
            f" beside the plain rule: median ratio {np.median(ratio):.2f}, worst {ratio.max():.2f}, more than 10 %"
            f" worse on {(ratio > 1.1).sum()} of {len(ratio)}"
        )
    lines.append(
        f"landmarks: median {np.median(share):.3f} of the true number, at most {share.max():.2f}, within 5 % on"
        f" {(np.abs(share - 1) <= 0.05).sum()} of {len(share)}"
    )
    lines.append(
        f"NEES: median {np.median(nees):.2f}, mean {nees.mean():.2f}, worst {nees.max():.1f}, above {LOST:g} on"
        f" {(nees > LOST).sum()}"
    )
    return "\n    ".join(lines) + "\n"


def main(
    *,
    seeds: Sequence[int] = (0, 60),  # the first, and the first not
    plans: bool = False,  # random storeys instead of corridors
    mrpt_seeds: int = 0,  # so many seeds are given to MRPT too
    limit: float = 600.0,  # [s] that MRPT may take for one seed
) -> None:
    columns: dict[str, list[Score]] = {"ours": [], "plain rule": [], "identities given": []}
    sighted: list[int] = []
    for number, seed in enumerate(range(*seeds)):
        told = plan_drive(seed) if plans else drive(drawn(seed), seed)
        sighted.append(told.sighted)
        place = "a storey" if told.corridor is None else words(told.corridor)
        print_row(f"{seed}: {place}; {told.sighted} landmarks")
        rows: dict[str, Score | str] = {
            "ours": ours(told),
            "plain rule": plain(told),
            "identities given": ours(told, given=True),
        }
        if number < mrpt_seeds:
            rows["MRPT"] = theirs(told, limit) if mrpt.installed() else mrpt.ABSENT
        for name, one in rows.items():
            if isinstance(one, str):
                print_row(f"    {name:16s} {one}")
                continue
            columns.get(name, []).append(one)
            print_row(
                f"    {name:16s} {one.aligned:.3f} m aligned, {one.plain:.3f} m as it stands,"
                f" {one.landmarks} landmarks, NEES {one.nees:.1f}"
            )
    for name, scores in columns.items():
        sys.stdout.write(summary(name, scores, columns["plain rule"], sighted))


if __name__ == "__main__":
    run_command(main)
