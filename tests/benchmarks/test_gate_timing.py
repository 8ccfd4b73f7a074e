"""The gate's times held to their bounds: `pytest -m campaign`."""

import pytest

from tests.benchmarks.gate_timing import BOUNDS_MS, campaign, quantile, table


@pytest.mark.campaign
def test_the_gate_stands_in_time_idle_and_under_load() -> None:
    told = campaign(trials=20, seconds=20.0)
    for load, measured in told.items():
        for name, times in measured.items():
            worst = quantile(times, 0.99) if name == "stop" else max(times)
            assert worst <= BOUNDS_MS[name], (load, name, table(told))
