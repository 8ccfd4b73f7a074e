"""Whoever is followed stays the same: their looks are not mixed with a passer-by's, and are found elsewhere."""

import numpy as np
import pytest

from core.perception.people.appearance import DOUBT_TIME_S, SIGHT_PERIOD_S, SURE_RATIO, Appearance, Identity
from tests.core.perception.test_appearance import ANN, BLUE, GREEN, RED, SKIN, dressed

BOB = dressed(SKIN, GREEN, RED)


def between(share: float) -> Appearance:
    """What a picture shows of two who hide each other."""
    return Appearance(colours=(1 - share) * ANN.colours + share * BOB.colours, proportions=ANN.proportions)


def followed(seconds: float = 5.0) -> Identity:
    """Ann, after she was followed for so long with nobody near."""
    identity = Identity(0.15)
    for stamp in np.arange(0.0, seconds, SIGHT_PERIOD_S):
        identity.learn(ANN, float(stamp))
    return identity


def test_before_anybody_is_known_nobody_is_a_stranger() -> None:
    identity = Identity(0.15)
    assert identity.ratio(BOB) == 0.0 and not identity.is_strange(BOB) and not identity.is_settled
    identity.learn(None, 0.0)
    assert not identity.is_strange(BOB)
    identity.learn(ANN, 0.0)
    assert identity.is_strange(BOB) and not identity.is_strange(ANN) and not identity.is_strange(None)


def test_who_walks_by_before_the_person_is_not_learned_however_slowly_one_turns_into_the_other() -> None:
    identity = followed()
    for stamp in np.linspace(10.0, 20.0, 60).tolist():
        identity.doubt(stamp)
        identity.learn(between((stamp - 10.0) / 10.0), stamp)
    assert identity.ratio(ANN) > SURE_RATIO and identity.is_strange(BOB)
    for step in range(60):
        identity.learn(BOB, 100.0 + step)
    assert identity.ratio(ANN) > SURE_RATIO and identity.is_strange(BOB)


def test_alone_with_the_person_the_light_is_followed() -> None:
    dusk, identity = dressed(SKIN, RED, BLUE, light=0.7), followed()
    before = identity.ratio(dusk)
    for step in range(40):
        identity.learn(dusk, 10.0 + step)
    assert identity.ratio(dusk) > before


def test_a_doubt_ends() -> None:
    identity = followed()
    assert not identity.is_doubtful(3.0)
    identity.doubt(3.0)
    assert identity.is_doubtful(3.0 + 0.9 * DOUBT_TIME_S) and not identity.is_doubtful(3.0 + 1.1 * DOUBT_TIME_S)


def test_a_wrong_first_picture_and_a_part_that_one_picture_shows_are_outvoted() -> None:
    last = np.arange(3)[:, None] == 2
    feet, wrong = (
        Appearance(colours=np.where(last, one.colours, np.nan), proportions=ANN.proportions) for one in (ANN, BOB)
    )
    shirt = np.arange(3)[:, None] == 1
    mixed = Appearance(colours=np.where(shirt, BOB.colours, ANN.colours), proportions=ANN.proportions)
    identity = Identity(0.15)
    for step, seen in enumerate((wrong, feet, mixed, *3 * [feet])):
        identity.learn(seen, float(step))
    assert not identity.is_settled and identity.ratio(ANN) == pytest.approx(identity.ratio(feet))
    for step in range(8):
        identity.learn(ANN, 10.0 + step)
    assert identity.is_settled and identity.is_strange(BOB)
    assert identity.ratio(ANN) > max(identity.ratio(mixed) + SURE_RATIO, identity.ratio(feet))
