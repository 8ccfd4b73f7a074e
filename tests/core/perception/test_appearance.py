"""Who looks like whom: the light may change, clothes, proportions and height tell people apart."""

import math

import numpy as np
import pytest

from core.message import Array
from core.perception.people.appearance import NO_LIMBS, Appearance, alike, likelihood_ratio, mean_of, tones_of
from core.perception.people.enrollment import HeightGauge
from core.perception.people.legs import stander_at
from core.perception.people.pose.view import Viewpoint
from tests.drawn_people import ROBOTS

RNG = np.random.default_rng(3)
WHOLE = np.ones((40, 30), bool)


def cloth(blue: int, green: int, red: int) -> Array:
    """A piece of cloth with some noise."""
    return np.clip(np.array([blue, green, red]) + RNG.normal(0, 4, (40, 30, 3)), 0, 255).astype(np.uint8)


def dressed(*colours: tuple[int, int, int], light: Array | float = 1.0, **more: object) -> Appearance:
    """A person with a head, a shirt and trousers of these colours, in some light."""
    lit = [np.clip(cloth(*colour) * light, 0, 255).astype(np.uint8) for colour in colours]
    rows = np.array([tones_of(pixels, WHOLE) for pixels in lit])
    return Appearance(colours=rows, **{"proportions": NO_LIMBS, **more})  # type: ignore[arg-type]


SKIN, RED, BLUE, GREEN = (120, 150, 200), (60, 60, 190), (150, 80, 50), (70, 140, 70)
ANN = dressed(SKIN, RED, BLUE)


@pytest.mark.parametrize("light", [0.6, 1.25, np.array([0.85, 1.0, 1.1])])
def test_the_light_makes_nobody_a_stranger(light: Array | float) -> None:
    assert alike(ANN, dressed(SKIN, RED, BLUE, light=light)) > 0.9
    assert alike(ANN, dressed(SKIN, GREEN, BLUE, light=light)) < 0.1
    assert alike(ANN, dressed(SKIN, BLUE, RED, light=light)) < 0.1


def test_what_is_not_in_the_picture_says_nothing() -> None:
    nothing = Appearance(colours=np.full((3, 4), np.nan), proportions=NO_LIMBS)
    assert alike(ANN, nothing) == 0.5 and not nothing.known and ANN.known
    torso = Appearance(colours=np.where(np.arange(3)[:, None] == 1, ANN.colours, np.nan), proportions=NO_LIMBS)
    assert 0.5 < alike(ANN, torso) < alike(ANN, ANN)
    assert tones_of(cloth(*RED), np.zeros((40, 30), bool)) == pytest.approx([math.nan] * 4, nan_ok=True)


def test_proportions_and_height_tell_people_in_the_same_clothes_apart_but_never_alone() -> None:
    taught = dressed(SKIN, RED, BLUE, proportions=np.array([0.3, -0.1, -1.0]), height=1.65)
    same = dressed(SKIN, RED, BLUE, proportions=np.array([0.33, -0.1, -1.05]), height=1.68)
    taller = dressed(SKIN, RED, BLUE, proportions=np.array([0.33, -0.1, -1.05]), height=1.93)
    longer = dressed(SKIN, RED, BLUE, proportions=np.array([0.75, 0.3, -0.4]), height=1.68)
    ratios = [likelihood_ratio(taught, one) for one in (same, taller, longer)]
    assert ratios[0] > ratios[1] + 1.0 and ratios[0] > ratios[2] + 1.0
    assert all(likelihood_ratio(ANN, same) - ratio <= 2.0 + 1e-9 for ratio in ratios)


def test_sights_of_one_person_are_averaged() -> None:
    blind = Appearance(colours=np.full((3, 4), np.nan), proportions=np.array([0.2, np.nan, np.nan]), height=1.8)
    both = mean_of([ANN, blind])
    assert both.colours == pytest.approx(ANN.colours) and both.height == 1.8
    assert both.proportions == pytest.approx([0.2, math.nan, math.nan], nan_ok=True)


def test_the_height_is_measured_by_the_lasers_distance() -> None:
    standers = (stander_at(np.array([3.2, 0.4])), stander_at(np.array([2.0, -1.5])))
    view, at = Viewpoint(ROBOTS), standers[0].place - ROBOTS.mounting.translation[:2]
    crown, _ = view.pixel(math.atan2(at[1], at[0]), math.hypot(*at), 1.62)
    gauge = HeightGauge(camera=ROBOTS, standers=standers)
    assert gauge.height(*crown.tolist()) == pytest.approx(1.62, abs=0.02)
    assert math.isnan(HeightGauge(camera=ROBOTS, standers=standers[1:]).height(*crown.tolist()))
