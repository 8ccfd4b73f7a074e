"""Limits have hard ranges and cannot be switched off."""

import math
from dataclasses import fields, replace

import pytest

from core.errors import BadInput
from core.gate import Limits
from core.gate.limits import is_count, is_number, speed_cap

NUMBERS = [field.name for field in fields(Limits) if field.name != "guard"]


@pytest.mark.parametrize("name", NUMBERS)
@pytest.mark.parametrize("value", [0, 0.0, -0.1, math.nan, math.inf, -math.inf, 1e9, True, "0.3", None])
def test_no_limit_can_be_switched_off(name: str, value: object) -> None:
    with pytest.raises(BadInput, match=name):
        Limits.of({name: value})


@pytest.mark.parametrize("value", [0.099, 1.001])
def test_the_deadman_stays_between_a_tenth_and_one_second(value: float) -> None:
    with pytest.raises(BadInput, match=r"between 0\.1 and 1"):
        Limits(deadman=value)


def test_an_unknown_limit_is_named() -> None:
    with pytest.raises(BadInput, match="no limit called 'max_sped'"):
        Limits.of({"max_sped": 0.2})


def test_a_guard_that_is_no_bool_is_refused() -> None:
    with pytest.raises(BadInput, match="guard"):
        Limits.of({"guard": 0})


def test_the_defaults_are_the_sheet_of_the_gate() -> None:
    limits = Limits()
    assert (limits.deadman, limits.nonce_age, limits.scan_age, limits.heartbeat) == (0.25, 0.4, 0.3, 0.15)


def test_a_late_operator_drives_slower() -> None:
    fast = Limits(max_speed=1.0)
    assert speed_cap(fast, 0.0) == pytest.approx(0.744, abs=1e-3)
    assert speed_cap(fast, 0.2) == pytest.approx(0.618, abs=1e-3)
    assert speed_cap(fast, 0.4) == pytest.approx(0.521, abs=1e-3)
    assert speed_cap(Limits(), 0.4) == 0.3


def test_without_a_guard_the_robot_is_slow() -> None:
    assert speed_cap(replace(Limits(), guard=False), 0.0) == 0.2


@pytest.mark.parametrize("value", [True, False, math.nan, math.inf, "1", None, [1.0], 10**400])
def test_what_is_no_number_is_no_number(value: object) -> None:
    assert not is_number(value)
    assert not is_count(value)


def test_numbers_are_numbers_and_counts_are_whole() -> None:
    assert is_number(0) and is_number(-0.5) and is_count(0) and is_count(2**53 - 1)
    assert not is_count(-1) and not is_count(2**53) and not is_count(1.0)
