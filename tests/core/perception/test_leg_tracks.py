"""Legs of a scan are shared out: who crosses keeps their own, and so does the one who is followed."""

import numpy as np

from core.geometry import Pose
from core.message import Array
from core.perception.people.leg_tracks import OtherLegs
from core.perception.people.legs import LegCluster, find_standers, stander_at

HERE = Pose()
LIMITS = (0.6, 11.8)  # [m], chi-square
SURE = 0.07**2 * np.eye(2)


def scan(*people: tuple[float, float]) -> Array:
    """The fronts of two legs of each, as a laser at the origin sees them; the nearer hides the farther."""
    legs = np.array([(x, y + side) for x, y in people for side in (-0.1, 0.1)])
    points: list[tuple[float, float]] = []
    for angle in np.radians(np.arange(-40, 40, 0.35)):
        along, across = legs @ (np.cos(angle), np.sin(angle)), legs @ (-np.sin(angle), np.cos(angle))
        hit = along - np.sqrt(np.where(np.abs(across) < 0.055, 0.055**2 - across**2, np.nan))
        far = float(np.nanmin(hit)) if np.isfinite(hit).any() else 5.0
        points.append((far * np.cos(angle), far * np.sin(angle)))
    return np.array(points)


def test_the_followed_one_keeps_their_legs_while_another_walks_by_before_them() -> None:
    others, place = OtherLegs(), np.array([2.0, 0.0])
    covariance, worst = SURE, 0.0
    for step in range(40):
        stamp, bob = 0.15 * step, (1.5, -1.4 + 0.075 * step)
        legs = others.share_out(
            stamp, HERE, find_standers(scan((2.0, 0.0), bob), every=True), (place, covariance), LIMITS
        )
        if legs is None:
            covariance = covariance + 0.05**2 * np.eye(2)
            continue
        covariance = SURE
        place = place + 0.5 * (legs.place - place)
        worst = max(worst, float(np.hypot(*(legs.place - (2.0, 0.0)))))
    assert worst < 0.15
    assert np.hypot(*(place - (2.0, 0.0))) < 0.1


def test_a_leg_of_each_of_two_is_no_third_person() -> None:
    points = scan((2.0, -0.25), (1.9, 0.15))
    every = find_standers(points, every=True)
    assert len(every) > len(find_standers(points)) or any(one.legs == 1 for one in every)
    others = OtherLegs()
    others.share_out(0.0, HERE, [stander_at(np.array([1.9, 0.15]))], (np.array([2.0, -0.25]), SURE), LIMITS)
    own = others.share_out(0.1, HERE, every, (np.array([2.0, -0.25]), SURE), LIMITS)
    assert own is not None and np.hypot(*(own.place - (2.0, -0.25))) < 0.12


def test_legs_that_a_picture_shows_to_be_anothers_are_not_the_persons() -> None:
    here, there = stander_at(np.array([2.0, 0.0])), stander_at(np.array([2.0, 0.4]))
    expected = (np.array([2.0, 0.05]), 0.2**2 * np.eye(2))
    assert OtherLegs().share_out(0.0, HERE, [here, there], expected, LIMITS) is here
    assert OtherLegs().share_out(0.0, HERE, [here, there], expected, LIMITS, barred=[here]) is there
    assert OtherLegs().share_out(0.0, HERE, [here], expected, LIMITS, barred=[here]) is None


def test_with_anothers_legs_go_all_pairs_that_need_one_of_them() -> None:
    mine, his = stander_at(np.array([2.0, 0.3]), 1, 1), stander_at(np.array([2.0, 0.0]), 2, 2, 3)
    one_of_each = stander_at(np.array([2.0, 0.15]), 2, 1, 2)
    expected = (np.array([2.0, 0.1]), 0.2**2 * np.eye(2))
    found = OtherLegs().share_out(0.0, HERE, [his, one_of_each, mine], expected, LIMITS, barred=[his])
    assert found is mine


def test_who_walks_is_told_from_what_stands_and_only_while_their_legs_are_seen() -> None:
    others, person = OtherLegs(), (np.array([1.5, 1.5]), SURE)
    for step in range(12):
        stamp, walker = 0.1 * step, stander_at(np.array([2.0, -0.5 + 0.05 * step]))
        others.share_out(stamp, HERE, [walker, stander_at(np.array([1.5, 1.0]))], person, LIMITS)
    place = np.array([2.0, 0.3])
    assert len(others.near(place, 1.1, walking=False)) == 2
    (walking,) = others.near(place, 1.1, walking=True)
    assert walking.walked > 0.3 and np.hypot(*(walking.place - (2.0, 0.05))) < 0.1
    assert others.near(place, 1.7, walking=False) == []
    others.remove(walking)
    assert others.near(place, 1.1, walking=True) == []


def test_legs_that_came_up_after_the_persons_were_gone_may_be_theirs_unless_there_are_two_or_a_strangers() -> None:
    others, person = OtherLegs(), (np.array([2.0, 0.0]), SURE)
    bob, ann = stander_at(np.array([2.0, 0.9])), stander_at(np.array([2.1, 0.5]))
    for step in range(8):
        legs = [bob] if step < 4 else [bob, ann]  # she comes out from behind something
        assert others.share_out(0.125 * step, HERE, legs, person, (0.3, 11.8)) is None
    heir = others.heir(person[0], 0.875, 0.6, 0.25)
    assert heir is not None and np.hypot(*(heir.place - (2.1, 0.5))) < 0.05
    assert others.heir(person[0], 0.875, 0.6, 0.5) is None  # hers were still seen when these came up
    assert others.heir(person[0], 0.875, 1.2, -1.0) is None  # two
    heir.is_stranger = True
    assert others.heir(person[0], 0.875, 0.6, 0.25) is None


def test_without_legs_in_reach_there_are_none() -> None:
    far: LegCluster = stander_at(np.array([2.0, 1.0]))
    assert OtherLegs().share_out(0.0, HERE, [far], (np.array([2.0, 0.0]), np.eye(2)), LIMITS) is None
    assert OtherLegs().share_out(0.0, HERE, [], (np.array([2.0, 0.0]), SURE), LIMITS) is None
