"""Picture quality: what is measured, what is done about it, and that it helps."""

import itertools
import math
from collections.abc import Callable

import cv2
import numpy as np
import pytest

from core.geometry import Pose
from core.message import Array
from core.perception.image_quality.measures import blur, exposure, noise_sd
from core.perception.image_quality.quality import PictureQuality, PictureSettings, gradient_noise, judge
from core.perception.landmarks.edges import NOTHING, Preprocessing, find_edges
from core.sensors import Camera, Image
from core.simulation.camera import SimulatedCamera
from core.simulation.world import LAB
from tests.core.perception.corner_room import picture

CAMERA = Camera()
SHADES = [-0.4, -0.25, -0.11, 0.07, 0.2, 0.35]
STATES = ("good", "mended", "poor", "unusable")


@pytest.fixture(scope="module")
def scene() -> Array:
    """Upright borders, a floor and a ceiling: nearly without noise."""
    return cv2.cvtColor(picture(CAMERA, SHADES, np.random.default_rng(1)), cv2.COLOR_BGR2GRAY)


@pytest.fixture(scope="module")
def lab() -> Array:
    """The simulated laboratory without noise."""
    return SimulatedCamera(CAMERA, LAB, np.random.default_rng(0), snr=100.0).take(LAB, 0.0, Pose(0, 0, 0.1)).pixels


def noisy(grey: Array, sd: float, seed: int = 3) -> Array:
    drawn = grey + np.random.default_rng(seed).normal(0, sd, grey.shape)
    return np.clip(np.round(drawn), 0, 255).astype(np.uint8)


def quality(pixels: Array, turn_rate: float = 0.0) -> PictureQuality:
    return judge(Image(stamp=0.0, pixels=pixels), turn_rate=turn_rate)


@pytest.mark.parametrize("sd", [1.0, 3.0, 8.0, 20.0])
def test_the_noise_is_told_whatever_the_picture_shows(lab: Array, sd: float) -> None:
    assert noise_sd(noisy(cv2.cvtColor(lab, cv2.COLOR_BGR2GRAY), sd)) == pytest.approx(sd, rel=0.15, abs=0.2)


@pytest.mark.parametrize("sd", [2.0, 10.0])
def test_noise_that_is_cut_off_at_black_is_still_told(sd: float) -> None:
    assert noise_sd(noisy(np.full((256, 320), 10.0), sd)) == pytest.approx(sd, rel=0.2)


@pytest.mark.parametrize("width", [1.0, 2.0, 3.0, 4.0])
def test_the_blur_of_steps_is_told_in_pixels(scene: Array, width: float) -> None:
    drawn = cv2.GaussianBlur(scene, (0, 0), width)
    told = blur(noisy(drawn, 1.0), 1.0).across
    assert told == pytest.approx(width, rel=0.15, abs=0.25)


def test_the_blur_of_motion_has_a_direction(lab: Array) -> None:
    grey = cv2.cvtColor(lab, cv2.COLOR_BGR2GRAY)
    sideways = blur(cv2.blur(grey, (9, 1)), 1.0)
    upwards = blur(cv2.blur(grey, (1, 9)), 1.0)
    assert sideways.across is not None
    assert upwards.down is not None
    assert sideways.across == pytest.approx(9 / math.sqrt(12), abs=0.7)
    assert sideways.across > 1.6 * (sideways.down or 0)
    assert upwards.down > 1.6 * (upwards.across or 0)


def test_a_blank_wall_has_no_blur_to_tell() -> None:
    told = blur(noisy(np.full((256, 320), 120.0), 2.0), 2.0)
    assert told.across is None
    assert told.down is None


def test_levels_are_those_of_the_pixels() -> None:
    ramp = np.tile(np.repeat(np.arange(256, dtype=np.uint8), 2), (50, 1))
    light = exposure(ramp)
    assert light.mean == pytest.approx(127.5)
    assert (light.low, light.high) == pytest.approx((2.06, 252.94), abs=0.1)
    assert light.level == pytest.approx(0.9 * 255 / 2, abs=0.5)
    assert (light.dark_share, light.bright_share) == pytest.approx((3 / 256, 3 / 256))


def test_lamps_and_windows_do_not_change_the_level() -> None:
    room = np.full((100, 100), 60, np.uint8)
    lit = room.copy()
    lit[:9] = 255
    assert exposure(lit).level == pytest.approx(exposure(room).level)


@pytest.mark.parametrize(
    "spoil",
    [
        lambda grey, k: noisy(np.round(grey * (1.0, 0.7, 0.4, 0.2, 0.1, 0.05, 0.02)[k]), 1.5),
        lambda grey, k: noisy(grey, (1.0, 4.0, 8.0, 16.0, 30.0, 60.0, 90.0)[k]),
        lambda grey, k: noisy(cv2.GaussianBlur(grey, (0, 0), (0.1, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0)[k]), 1.5),
    ],
    ids=["light", "noise", "blur"],
)
def test_what_gets_worse_is_never_judged_better(scene: Array, spoil: Callable[[Array, int], Array]) -> None:
    pictures = [Image(stamp=0.0, pixels=spoil(scene, k)) for k in range(7)]
    margins = [judge(one, settings=PictureSettings(prepare=False)).margin for one in pictures]
    assert all(later < 1.03 * earlier for earlier, later in itertools.pairwise(margins))
    judged = [judge(one) for one in pictures]
    assert all(one.margin > 0.97 * margin for one, margin in zip(judged, margins, strict=True))
    ranks = [STATES.index(one.state) for one in judged]
    assert ranks == sorted(ranks)
    assert ranks[0] == 0
    assert ranks[-1] > 0


@pytest.mark.parametrize(("across", "along"), [(1.0, 1.0), (1.0, 6.0), (2.0, 6.0)])
def test_the_noise_of_a_slope_is_as_the_model_has_it(across: float, along: float) -> None:
    white = np.random.default_rng(0).normal(0, 1, (300, 300)).astype(np.float32)
    slope = cv2.Sobel(cv2.GaussianBlur(white, (0, 0), sigmaX=across, sigmaY=along), cv2.CV_32F, 1, 0) / 8
    assert slope.std() == pytest.approx(gradient_noise(across, along), rel=0.3)
    assert slope.std() < 1.1 * gradient_noise(across, along)


def test_clean_pictures_are_taken_as_they_come(lab: Array) -> None:
    chance = np.random.default_rng(1)
    clean = np.clip(lab + chance.normal(0, 2, lab.shape), 0, 255).astype(np.uint8)
    judged = quality(clean)
    assert judged.preparation.idle
    assert (judged.state, judged.label, judged.words, judged.complaint) == ("good", "good", "Good.", "")
    image = Image(stamp=0.0, pixels=clean)
    plain, prepared = find_edges(image, CAMERA), find_edges(image, CAMERA, None, judged.preparation)
    assert [edge.bearing for edge in plain] == [edge.bearing for edge in prepared]


@pytest.mark.parametrize(
    ("light", "snr", "defocus"), [(0.25, 42.0, 0.0), (0.1, 42.0, 0.0), (0.25, 30.0, 0.0), (1.0, 18.0, 0.0)]
)
def test_prepared_pictures_show_edges_that_were_lost(light: float, snr: float, defocus: float) -> None:
    chance = np.random.default_rng(1)
    bad = SimulatedCamera(CAMERA, LAB, chance, light=light, snr=snr, defocus=defocus)
    clean = SimulatedCamera(CAMERA, LAB, chance, snr=100.0)
    plain = prepared = true = 0
    for heading in (0.1, 1.3, 2.6, -2.0, -1.0):
        pose = Pose(0.5, 0.2, heading)
        there = np.array([edge.bearing for edge in find_edges(clean.take(LAB, 0.0, pose), CAMERA)])
        image = bad.take(LAB, 0.0, pose)
        true += len(there)
        for preparation in (NOTHING, judge(image).preparation):
            seen = np.array([edge.bearing for edge in find_edges(image, CAMERA, None, preparation)])
            met = np.count_nonzero((np.abs(there[:, None] - seen[None, :]) < 0.01).any(axis=1))
            plain, prepared = (plain, prepared + met) if preparation is not NOTHING else (plain + met, prepared)
    assert prepared > plain + 0.1 * true
    assert prepared > 0.75 * true


def test_a_dark_picture_is_brightened_before_it_is_rounded() -> None:
    pixels = np.random.default_rng(0).integers(0, 6, (40, 40, 3)).astype(np.uint8)
    grey = Preprocessing(gain=10.0).grey(pixels)
    assert len(np.unique(grey)) > len(np.unique(10 * Preprocessing().grey(pixels)))
    assert grey.mean() == pytest.approx(10 * (pixels @ np.array([0.114, 0.587, 0.299])).mean(), rel=0.01)


def test_darks_are_lifted_where_windows_forbid_more_light(scene: Array) -> None:
    backlit = (scene * 0.25).astype(np.uint8)
    backlit[:, 140:180] = 250
    done = quality(backlit).preparation
    assert done.gain == 1.0
    assert done.gamma < 0.9
    level = exposure(backlit).level
    step = (
        done.grey(np.full((1, 1), round(level) + 4, np.uint8)).astype(int)
        - done.grey(np.full((1, 1), round(level) - 4, np.uint8))
    ).item() / 8
    assert step == pytest.approx(done.slope(level), rel=0.15)


def test_the_verdict_is_told_in_words(scene: Array) -> None:
    dark = quality(noisy(scene * 0.2, 1.5))
    assert dark.words.startswith("Too dark: brightened.")
    assert dark.label == "dark"
    smeared = cv2.blur(scene, (11, 1))
    assert "turning too fast for the exposure" in quality(noisy(smeared, 1.0), 1.0).words
    assert "moving too fast for the exposure" in quality(noisy(smeared, 1.0)).words
    assert quality(noisy(cv2.GaussianBlur(scene, (0, 0), 2.5), 1.0)).words.startswith("Blurred: contrast raised.")
    white = quality(np.full((256, 320), 255, np.uint8))
    assert (white.state, white.label) == ("unusable", "bright")
    black = quality(np.zeros((256, 320, 3), np.uint8))
    assert black.state == "unusable"
    assert black.complaint == (
        "The camera's pictures cannot be used: black. "
        "Please see whether something covers the lens, or switch on a light."
    )


def test_without_preparation_a_picture_is_judged_as_it_comes(scene: Array) -> None:
    image = Image(stamp=0.0, pixels=noisy(scene * 0.2, 1.5))
    judged = judge(image, settings=PictureSettings(prepare=False))
    assert judged.preparation.idle
    assert judged.state == "unusable"
    assert judged.words == "Too dark."
