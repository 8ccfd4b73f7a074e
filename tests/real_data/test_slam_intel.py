"""A real building: the Intel Research Lab by the Freiburg relations, beside GMapping's poses."""

from pathlib import Path

import numpy as np
import pytest

from core.pipelines.slam import slam_log
from core.recording import logged_stamp
from tests.benchmarks.intel_relations import at_scans, errors

pytestmark = [pytest.mark.real_data, pytest.mark.campaign]


def test_the_scoring_gives_gmapping_what_was_published(shared_data: Path) -> None:
    folder = shared_data / "intel-lab"
    with np.load(folder / "intel.npz") as archive:
        found = errors(folder, archive["t"], archive["pose_gmapping"])
    assert found[:, 0].mean() == pytest.approx(0.0693, abs=0.0005)
    assert found[:, 0].std() == pytest.approx(0.0575, abs=0.0005)
    assert np.degrees(found[:, 1]).mean() == pytest.approx(2.4, abs=0.1)


def test_the_building_is_mapped_better_than_by_gmapping(shared_data: Path) -> None:
    folder = shared_data / "intel-lab"
    result = slam_log(folder / "intel.npz")
    stamps = np.array([logged_stamp(scan) for scan in result.recording.scans])
    found = errors(folder, stamps, np.array([pose.vector for pose in result.poses]))
    assert found[:, 0].mean() < 0.067
    assert np.median(found[:, 0]) < 0.051
    assert np.quantile(found[:, 0], 0.99) < 0.4
    assert np.degrees(found[:, 1]).mean() < 2.5
    assert found[at_scans(folder, stamps), 0].mean() < 0.025  # nothing carried on from scan to scan; GMapping: 0.036
