import numpy as np

from core.geometry import Pose
from core.sensors import Camera, Laser, Scan
from core.slam.association.visibility import VisibilityCheck

LASER = Laser()


def seen(ranges: np.ndarray, x: float, y: float, spread: float = 0.0, laser: Laser = LASER) -> tuple[bool, bool]:
    scan = Scan(stamp=0.0, ranges=ranges, angle_min=laser.angle_min, angle_step=laser.angle_step)
    plain, through = VisibilityCheck(scan, laser.mounting).judge(np.array([[x, y]]), np.array([spread]))
    return bool(plain[0]), bool(through[0])


def at(distance: float) -> np.ndarray:
    return np.full(LASER.beams, distance)


def test_what_ends_the_beams_is_in_plain_sight() -> None:
    assert seen(at(2.0), 2.0, 0.0) == (True, False)


def test_behind_something_nearer_nothing_is_known() -> None:
    assert seen(at(1.0), 2.0, 0.0) == (False, False)


def test_beams_that_go_on_have_seen_through() -> None:
    assert seen(at(3.0), 2.0, 0.0) == (False, True)
    assert seen(at(np.inf), 2.0, 0.0) == (False, True)


def test_one_beam_that_ends_there_is_enough_not_to_have_seen_through() -> None:
    ranges = at(3.0)
    ranges[LASER.beams // 2] = 2.02
    assert seen(ranges, 2.0, 0.0) == (True, False)


def test_failed_beams_and_places_outside_the_field_tell_nothing() -> None:
    assert seen(at(np.nan), 2.0, 0.0) == (False, False)
    assert seen(at(3.0), -2.0, 0.0) == (False, False)
    assert seen(at(np.inf), 5.8, 0.0) == (False, False)


def test_an_uncertain_landmark_is_not_seen_through_so_soon() -> None:
    assert seen(at(2.4), 2.0, 0.0) == (False, True)
    assert seen(at(2.4), 2.0, 0.0, spread=0.1) == (True, False)


def test_the_view_is_the_laser_s() -> None:
    turned = Laser(mounting=Pose(0.0, 0.0, np.pi))
    assert seen(at(3.0), -2.0, 0.0, laser=turned) == (False, True)


def test_where_a_picture_is_asked_for_nothing_outside_of_it_can_be_missing() -> None:
    camera = Camera()
    scan = Scan(stamp=0.0, ranges=at(2.0), angle_min=LASER.angle_min, angle_step=LASER.angle_step)
    places = np.array([[2.0, 0.0], [0.0, 2.0]])  # ahead, and at the side of a camera of 56°
    for asked, expected in ((None, [True, True]), (camera, [True, False])):
        plain, _ = VisibilityCheck(scan, LASER.mounting, asked).judge(places, np.zeros(2))
        assert plain.tolist() == expected
    far = Scan(stamp=0.0, ranges=at(3.5), angle_min=LASER.angle_min, angle_step=LASER.angle_step)
    assert VisibilityCheck(far, LASER.mounting, camera).judge(places, np.zeros(2))[1].tolist() == [True, False]


def test_a_scan_that_begins_ahead_or_goes_clockwise_tells_the_same_as_one_that_begins_behind() -> None:
    beams, step = 360, np.radians(1.0)
    behind = np.random.default_rng(5).uniform(0.5, 4.0, beams).round(0)
    ahead = np.roll(behind, beams // 2)
    scans = (
        Scan(stamp=0.0, ranges=behind, angle_min=-np.pi, angle_step=step),
        Scan(stamp=0.0, ranges=ahead, angle_min=0.0, angle_step=step),
        Scan(stamp=0.0, ranges=ahead[::-1], angle_min=(beams - 1) * step, angle_step=-step),
    )
    bearings = np.radians([*range(-170, -9, 2), *range(10, 171, 2)])
    places = 1.0 * np.column_stack((np.cos(bearings), np.sin(bearings)))
    first, *others = (np.array(VisibilityCheck(one, Pose()).judge(places, np.zeros(len(places)))) for one in scans)
    assert first[0, bearings < 0].any() and first[1, bearings < 0].any()
    assert all(np.array_equal(one, first) for one in others)
