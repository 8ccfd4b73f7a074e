import numpy as np
import pytest

from core.slam.ekf.robust import AdaptiveGate


def test_surprises_as_promised_change_nothing() -> None:
    usual = AdaptiveGate(memory=80, slack=2.0)
    usual.note(np.random.default_rng(0).chisquare(2, 80).tolist())
    assert usual.factor == 1.0


def test_a_few_outliers_change_nothing_either() -> None:
    usual = AdaptiveGate(memory=80, slack=2.0)
    usual.note([*np.random.default_rng(0).chisquare(2, 56).tolist(), *[400.0] * 24])
    assert usual.factor == 1.0


def test_when_most_surprise_the_gate_widens_with_them() -> None:
    usual = AdaptiveGate(memory=80, slack=2.0)
    usual.note([100.0, 120.0])
    assert usual.factor == 1.0  # too few to tell
    usual.note((36.0 * np.random.default_rng(0).chisquare(2, 2000)).tolist())
    assert usual.factor == pytest.approx(36 / 2.0, rel=0.3)


def test_what_was_long_ago_is_forgotten() -> None:
    usual = AdaptiveGate(memory=20, slack=2.0)
    usual.note([500.0] * 20)
    assert usual.factor > 100
    usual.note([1.0] * 20)
    assert usual.factor == 1.0
