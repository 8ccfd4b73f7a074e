"""One camera and one board of square squares: what contradicts that is found, named, and never a narrow answer."""

from dataclasses import replace

import numpy as np
import pytest

from core.calibration.board.board import Board
from core.calibration.camera.intrinsics import Calibration, calibrate
from core.calibration.camera.session import CameraSession
from core.calibration.practice import BoardPlacement, held, seen
from core.calibration.projection import project, vector_of
from core.errors import Refused
from core.message import Array
from core.optics import CameraModel
from tests.core.calibration.seen_boards import views_of

BOARD = Board(columns=9, rows=6, square=0.06)  # large, as a wall print: one view tells much
LENS = CameraModel(width=640, height=640, fx=520, fy=520, cx=330, cy=308, k1=-0.25, k2=0.09)
SIZE = (LENS.width, LENS.height)
NOISE = 0.05  # [pixel]
OTHERS = {
    "zoom or focus was moved": {"fx": 600.0, "fy": 600.0},
    "the pictures were turned by half a turn": {"cx": 639 - 330, "cy": 639 - 308},
    "the pictures were mirrored": {"cx": 639 - 330, "cy": 308},
    "the pictures were turned by a quarter": {"cx": 639 - 308, "cy": 330},
    "another camera, or its lens was moved": {"cx": 345, "cy": 290},
}


def pictures(count: int, odd: tuple[int, ...] = (), seed: int = 0, noise: float = NOISE, **other: float) -> Array:
    """Corners of `count` pictures, the odd ones of them by another camera."""
    rng = np.random.default_rng(seed)
    poses = held(rng, count, LENS, BOARD)
    pixels = seen(rng, LENS, poses, BOARD, noise)
    if odd:
        pixels[list(odd)] = seen(rng, replace(LENS, **other), poses.take(np.array(odd)), BOARD, noise)
    return pixels


def varied(kind: str, size: float, count: int, seed: int = 0) -> Array:
    """Corners of pictures that no single camera makes, by what is wrong with each: `kind` is the check's code."""
    rng = np.random.default_rng(seed)
    poses, flat = held(rng, count, LENS, BOARD), vector_of(LENS)
    pixels = project(flat, poses, BOARD.points)
    if kind == "camera.focal_varies":
        cameras = [np.concatenate((flat[:2] * (1 + rng.uniform(-size, size)), flat[2:])) for _ in range(count)]
        pixels = np.concatenate(
            [project(each, poses.take([number]), BOARD.points) for number, each in enumerate(cameras)]
        )
    elif kind == "camera.middle_varies":
        pixels = pixels + rng.uniform(-size, size, (count, 1, 2))
    elif kind == "camera.skew":
        pixels = pixels + np.tan(np.deg2rad(size)) * (pixels[:, :, [1]] - LENS.cy) * (1.0, 0.0)
    elif kind == "camera.rows_late":
        speed = rng.normal(0, size, (count, 6))  # [rad, m] while one picture is read
        for _ in range(3):
            late = pixels[:, :, 1] / LENS.height - 0.5
            moved = [
                [project(flat, each.moved(speed[[view]] * late[view, corner]), BOARD.points[[corner]])[0, 0]]
                for view in range(count)
                for each in [poses.take([view])]
                for corner in range(BOARD.count)
            ]
            pixels = np.reshape(moved, pixels.shape)
    return pixels + rng.normal(0, NOISE, pixels.shape)


def off(found: Calibration, name: str) -> float:
    """Standard deviations from the truth."""
    return abs(getattr(found.model, name) - getattr(LENS, name)) / found.sds[name]


CAMPAIGN = pytest.mark.campaign
SEEDS = pytest.mark.parametrize("seeds", [range(1), pytest.param(range(3), marks=CAMPAIGN)], ids=len)


@pytest.mark.parametrize(
    "cause", [*list(OTHERS)[:2], *(pytest.param(cause, marks=CAMPAIGN) for cause in list(OTHERS)[2:])]
)
def test_halves_of_two_settings_are_named_with_their_cause_and_not_pooled(cause: str) -> None:
    found = calibrate(views_of(pictures(12, (1, 3, 5, 7, 9, 11), **OTHERS[cause])), BOARD, SIZE)
    assert [each.code for each in found.faults] == ["camera.two_settings"]
    assert cause in found.undecided and "view 1, view 3" in found.undecided and "view 0, view 2" in found.undecided


@pytest.mark.parametrize(
    ("odd", "cause"),
    [
        ((4,), "the pictures were turned by half a turn"),
        ((2, 4, 7), "zoom or focus was moved"),
        *(
            pytest.param(odd, cause, marks=CAMPAIGN)
            for odd in ((4,), (4, 7), (2, 4, 7))
            for cause in list(OTHERS)[:2]
        ),
    ],
)
def test_few_pictures_of_another_setting_are_left_out_with_their_cause(odd: tuple[int, ...], cause: str) -> None:
    found = calibrate(views_of(pictures(12, odd, **OTHERS[cause])), BOARD, SIZE)
    assert [each.code for each in found.faults] == ["camera.odd_part"] and not found.undecided
    assert [number for number, each in enumerate(found.verdicts) if not each.used] == list(odd)
    assert all(cause in found.verdicts[number].reason for number in odd)
    assert max(off(found, name) for name in ("fx", "fy", "cx", "cy")) < 3.5


@pytest.mark.parametrize("height", [1.03, pytest.param(0.985, marks=CAMPAIGN), 1.006])
def test_squares_that_are_not_square_are_measured_and_taken_into_account(height: float) -> None:
    rng = np.random.default_rng(3)
    poses = held(rng, 12, LENS, BOARD)
    pixels = project(vector_of(LENS), poses, BOARD.points * (1.0, height, 1.0))
    found = calibrate(views_of(pixels + rng.normal(0, NOISE, pixels.shape)), BOARD, SIZE)
    assert [each.code for each in found.faults] == ["board.unequal_squares"]
    assert f"{60 * height:.1f} mm high" in found.faults[0].sentence
    assert all(each.used for each in found.verdicts)
    assert max(off(found, name) for name in ("fx", "fy", "cx", "cy")) < 3.5


@pytest.mark.parametrize("shear", [0.003, pytest.param(-0.01, marks=CAMPAIGN)])
@pytest.mark.parametrize("rise", [0.0, 0.001])
def test_a_board_that_was_printed_askew_is_no_skew_of_the_camera(shear: float, rise: float) -> None:
    rng = np.random.default_rng(5)
    away = BOARD.points[:, :2] - BOARD.centre[:2]
    shape = BOARD.points + np.column_stack(
        (shear * away[:, 1], 0 * away[:, 1], rise * np.sum(away**2, axis=1) / 0.15**2)
    )
    pixels = project(vector_of(LENS), held(rng, 14, LENS, BOARD), shape)
    found = calibrate(views_of(pixels + rng.normal(0, NOISE, pixels.shape)), BOARD, SIZE)
    assert {each.code for each in found.faults} == {"board.sheared", *(["board.bent"] if rise else [])}
    askew = next(each for each in found.faults if each.code == "board.sheared")
    assert float(askew.values["degrees"]) == pytest.approx(np.rad2deg(abs(shear)), abs=0.03)
    assert max(off(found, name) for name in ("fx", "fy", "cx", "cy")) < 3.5 and not found.undecided


@SEEDS
@pytest.mark.parametrize("tilt_deg", [0.0, 5.0, *(pytest.param(tilt, marks=CAMPAIGN) for tilt in (2.0, 10.0))])
def test_a_focal_length_that_is_hardly_decided_is_covered_by_its_deviation_or_refused(
    tilt_deg: float, seeds: range
) -> None:
    facing = BoardPlacement(nearest=0.8, farthest=1.2, most_tilt=float(np.deg2rad(tilt_deg)))
    for seed in seeds[:2]:
        poses = held(np.random.default_rng(seed), 12, LENS, BOARD, facing)
        found = calibrate(views_of(seen(np.random.default_rng(seed), LENS, poses, BOARD, 0.1)), BOARD, SIZE)
        assert off(found, "fx") < 2.5
        assert found.undecided or tilt_deg > 0


@pytest.mark.parametrize("odd", [tuple(range(1, 20, 2)), tuple(range(10, 20))])
@pytest.mark.parametrize(("share", "noise"), [(0.01, 0.1), (0.02, 0.2)])
def test_two_focal_lengths_that_hardly_raise_the_errors_are_found(
    odd: tuple[int, ...], share: float, noise: float
) -> None:
    focal = 520 * (1 + share)
    found = calibrate(views_of(pictures(20, odd, seed=1, noise=noise, fx=focal, fy=focal)), BOARD, SIZE)
    assert [each.code for each in found.faults] == ["camera.focal_varies"]
    assert "autofocus, zoom" in found.undecided
    assert found.noise < 1.1 * noise


@pytest.mark.parametrize("count", [13, pytest.param(30, marks=CAMPAIGN)])
@pytest.mark.parametrize(
    ("code", "size", "told", "extent"),
    [
        ("camera.focal_varies", 0.02, "share", 100 * 0.02 / 3**0.5),  # [%] root mean square
        ("camera.middle_varies", 10.0, "pixels", 10 * (2 / 3) ** 0.5),
        ("camera.skew", 0.5, "degrees", 0.5),
        ("camera.rows_late", 0.01, "pixels", 0.5),
    ],
)
def test_what_differs_from_picture_to_picture_is_named(
    code: str, size: float, told: str, extent: float, count: int
) -> None:
    found = calibrate(views_of(varied(code, size, count, seed=1)), BOARD, SIZE)
    assert [each.code for each in found.faults] == [code]
    assert float(found.faults[0].values[told]) == pytest.approx(extent, rel=0.4)
    assert found.warnings[0] == found.faults[0].sentence
    assert bool(found.undecided) == (code != "camera.rows_late")


def test_boards_that_move_while_rows_are_read_widen_the_deviations() -> None:
    found = [calibrate(views_of(varied("camera.rows_late", 0.01, 16, seed)), BOARD, SIZE) for seed in range(4)]
    still = calibrate(views_of(varied("", 0.0, 16)), BOARD, SIZE)
    assert still.faults == ()
    assert all([each.code for each in one.faults] == ["camera.rows_late"] for one in found)
    assert all(off(one, name) < 4 and one.sds[name] > 3 * still.sds[name] for one in found for name in ("fx", "cy"))


@pytest.mark.parametrize(("rise", "noise", "count"), [(0.0003, 0.1, 16), (0.001, 0.03, 11)])
def test_a_bent_board_is_named_and_solved_with_and_is_not_two_cameras(rise: float, noise: float, count: int) -> None:
    rng = np.random.default_rng(101)
    away = BOARD.points[:, :2] - BOARD.centre[:2]
    bent = BOARD.points + np.array([0, 0, rise]) * (1 - np.sum(away**2, axis=1) / 0.15**2)[:, None]
    poses = held(rng, count, LENS, BOARD)
    poses = poses.take(np.argsort(-poses.rotations[:, 2, 2]))  # as if somebody tilted it more and more
    pixels = project(vector_of(LENS), poses, bent)
    found = calibrate(views_of(pixels + rng.normal(0, noise, pixels.shape)), BOARD, SIZE)
    assert [each.code for each in found.faults] == ["board.bent"] and found.undecided == ""
    assert f"by {1e3 * np.ptp(bent[:, 2]):.1f} mm" in found.warnings[0]
    assert off(found, "fx") < 2.5 and found.noise < 1.1 * noise


@pytest.mark.parametrize("seed", [*range(4), *(pytest.param(seed, marks=CAMPAIGN) for seed in range(4, 12))])
def test_a_board_that_gives_way_in_the_hand_is_named_and_widens_the_deviations(seed: int) -> None:
    across = (BOARD.points[:, 0] - BOARD.centre[0]) / 0.24
    bow = np.column_stack((0 * across, 0 * across, 0.0003 * (1 - across**2)))  # 0.3 mm, more or less in every picture
    rng = np.random.default_rng(seed)
    poses = held(rng, 16, LENS, BOARD)
    heights = rng.normal(size=16)
    bent = [project(vector_of(LENS), poses.take([view]), BOARD.points + heights[view] * bow) for view in range(16)]
    found = calibrate(views_of(np.concatenate(bent) + rng.normal(0, NOISE, (16, BOARD.count, 2))), BOARD, SIZE)
    assert [each.code for each in found.faults] == ["board.flexes"] and not found.undecided
    assert float(found.faults[0].values["depth"]) == pytest.approx(0.3 * np.sqrt(np.mean(heights**2)), abs=0.15)
    assert max(off(found, name) for name in ("fx", "fy", "cx", "cy")) < 3.5


def test_a_session_does_not_accept_what_contradicts_itself() -> None:
    session = CameraSession(BOARD)
    session.size = SIZE
    views = tuple(views_of(pictures(12, (1, 3, 5, 7, 9, 11), **OTHERS["zoom or focus was moved"])))
    found = session.adopt(calibrate(views, BOARD, SIZE), ())
    assert found.undecided
    with pytest.raises(Refused):
        session.accept()


@SEEDS
@pytest.mark.parametrize("noise", [0.03, 0.3])
@pytest.mark.parametrize("count", [4, 7, 20])
def test_sound_pictures_raise_no_fault(count: int, noise: float, seeds: range) -> None:
    for seed in seeds:
        found = calibrate(views_of(pictures(count, seed=10 + seed, noise=noise)), BOARD, SIZE)
        assert found.faults == () and found.undecided == ""


@pytest.mark.parametrize("beside", [0, 1])
def test_halves_of_stereo_pictures_are_told_by_the_middle_of_the_lens(beside: int) -> None:
    pixels = pictures(12)
    width, height = SIZE
    found = calibrate(views_of(pixels + np.array([beside * width, 0.0])), BOARD, (2 * width, height))
    assert [each.code for each in found.faults] == ["camera.off_centre"]
    whole = calibrate(views_of(pixels), BOARD, SIZE)
    assert not whole.faults and found.model.fx == pytest.approx(whole.model.fx, rel=1e-6)


def test_pictures_that_were_stretched_have_that_said() -> None:
    width, height = SIZE
    stretched = pictures(12) * np.array([4 / 3, 1.0])
    found = calibrate(views_of(stretched), BOARD, (round(width * 4 / 3), height))
    assert [each.code for each in found.faults] == ["camera.stretched"] and "1.33 times as wide" in found.faults[
        0
    ].sentence
