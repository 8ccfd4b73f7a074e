"""A slice of the table of late scans: nothing is touched, whatever the scans say of their time."""

import pytest

from tests.benchmarks.late_scans import DRIVERS, LIES, OTHER_ROBOT_TOPICS, WIRES_SHARED, drive, drive_wires

STANDS_S = 0.4  # [s] from the first lie to zero: the age at which scans end to count, and a tick or two


@pytest.mark.parametrize("lie", LIES)
@pytest.mark.parametrize("driver", DRIVERS)
def test_scans_that_fall_behind_or_lie_about_their_time_end_in_no_contact(driver: str, lie: str) -> None:
    found = drive(DRIVERS[driver](), 2.0, 0.5, LIES[lie])
    assert found.gap > 0.0
    assert found.zero is not None and found.zero < STANDS_S
    assert found.reason


@pytest.mark.parametrize("driver", DRIVERS)
@pytest.mark.parametrize("late", [0.0, 0.1])
def test_a_punctual_robot_comes_to_its_wall_and_stands_at_its_margin(driver: str, late: float) -> None:
    found = drive(DRIVERS[driver](), late, 0.3, LIES["honest"], always=True)
    assert 0.02 < found.gap < 0.06 and found.reason == "something is in the way"


@pytest.mark.parametrize(("driver", "what"), tuple(zip(WIRES_SHARED, OTHER_ROBOT_TOPICS, strict=True)))
def test_readings_of_another_robot_under_the_same_name_stop_it_before_it_touches_anything(
    driver: str, what: str
) -> None:
    found = drive(DRIVERS[driver](), 0.0, 0.5, LIES["honest"], stranger=what)
    assert found.gap > 0.0 and found.zero is not None and found.zero < 1.0
    assert found.reason == "the robot cannot be driven now"


def test_scans_that_fall_behind_on_a_real_wire_end_in_no_contact() -> None:
    found = drive_wires("serial+scip", 2.0, 0.5, LIES["honest"])
    assert found.gap > 0.0 and found.zero is not None and found.reason
