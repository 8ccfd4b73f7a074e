"""A short whole session over wires; tests.benchmarks.real_sessions has long ones for every driver."""

import numpy as np
import pytest

from tests.benchmarks.real_sessions import DRIFT, WALLS, motions, occupied_cells, session, to_surfaces, watched


@pytest.mark.campaign
def test_a_robot_on_two_wires_turns_by_rest_and_maps_the_room_where_it_is() -> None:
    with session("serial+scip") as here:
        with watched(here):
            turned = next(motions(here))
        off = to_surfaces(occupied_cells(here.running), here.plan())
    assert turned.good, turned
    assert np.median([apart for apart, _ in here.errors]) < DRIFT
    assert len(off) > 100 and np.median(off) < WALLS
