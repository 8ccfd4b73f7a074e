"""Corridors driven without identities: a loop closes by landmarks that are recognised together, or not at all."""

import pytest

from tests.benchmarks.corridor_drives import drawn
from tests.benchmarks.corridor_drives import drive as driven
from tests.benchmarks.corridors import ours


@pytest.mark.parametrize("seed", [pytest.param(1002, marks=pytest.mark.campaign), 1004])
def test_a_corridor_is_driven_round_without_identities_and_no_door_is_taken_for_another(seed: int) -> None:
    """1002: several sightings of one scan fit the wrong doors; 1004: two landmarks lie together by chance."""
    drive = driven(drawn(seed), seed)
    score = ours(drive)
    assert score.landmarks == pytest.approx(drive.sighted, rel=0.05)
    assert score.nees < 10
    assert score.aligned < 1.5 * ours(drive, given=True).aligned
