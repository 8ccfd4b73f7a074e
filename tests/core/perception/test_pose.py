"""People by their landmarks: parts and K of eq. 34, squares that are looked at, and the networks where they are."""

import dataclasses
import math
import os

import numpy as np
import pytest

from core.errors import BadInput
from core.geometry import OPTICAL, Transform
from core.models import find
from core.optics import CameraModel
from core.perception.people.body import overlap, share_inside, weigh
from core.perception.people.brightness import levelled
from core.perception.people.engines import MODEL, open_detector, sees_people
from core.perception.people.looking import LookQuestion
from core.perception.people.parts import PeopleSettings
from core.perception.people.person_pictures import only_legs_show
from core.perception.people.pose.detector import PoseDetector
from core.perception.people.pose.faces import anchors, without_doubles
from core.perception.people.pose.landmarks import body_of, landmarks_of
from core.perception.people.pose.networks import LiteRtNetworks, OpenCvNetworks, has_litert
from core.perception.people.pose.squares import ImagePyramid, Square, picture_from_crop
from core.perception.people.pose.view import Viewpoint
from core.sensors import Camera
from core.simulation.world import LAB
from tests.core.perception.stick_figures import StickNetworks, white_body
from tests.drawn_people import ROBOTS, WEBCAM, Stage

PHOTO = Camera(
    model=CameraModel(width=640, height=480, fx=550.0, fy=550.0, cx=319.5, cy=239.5),
    mounting=Transform(rotation=OPTICAL, translation=np.array([0.0, 0.0, 1.15])),
)


def asked(picture, bearing=None, distance=None, **more) -> LookQuestion:
    distances = () if distance is None else (distance,)
    return LookQuestion(
        pixels=picture, camera=PHOTO, bearing=bearing, distances=distances, **{"on_floor": False, **more}
    )


def sticks() -> PoseDetector:
    return PoseDetector(StickNetworks())


def test_the_parts_of_a_body_are_weighed_as_in_equation_34() -> None:
    picture = white_body(640, 480, 320.0, 60.0, 330.0)
    (found,) = sticks().look(asked(picture, 0.0, 550 * 1.7 / 330))
    k1, k2, k3 = (part.likelihood for part in found.parts)
    assert None not in (k1, k2, k3)
    assert found.value == pytest.approx(0.3 * k1 + 0.6 * k2 + 0.1 * k3)  # type: ignore[operator]
    head, torso, feet = (part.box for part in found.parts)
    assert head[1] < torso[1] < feet[1] < feet[3]
    assert abs(found.bearing) < 0.01 and found.bearing_sd is not None and found.bearing_sd < 0.02


def test_parts_outside_the_picture_are_left_out_and_the_others_are_normed() -> None:
    rows, sure = StickNetworks().landmarks(white_body(256, 256, 128.0, 10.0, 230.0))
    upright = landmarks_of(rows, sure, picture_from_crop(Square(x=128.0, y=128.0, side=256.0)))
    whole = weigh(body_of(upright), 256, 256)
    assert None not in whole.likelihoods and whole.shown == pytest.approx(1.0, abs=0.02)
    no_feet = weigh(body_of(upright), 256, 130)
    assert no_feet.likelihoods[2] is None
    assert no_feet.value == pytest.approx(whole.value, abs=0.02)
    beyond = dataclasses.replace(upright, points=upright.points - (0.0, 70.0))  # the head is above the rim
    assert weigh(body_of(beyond), 256, 256).likelihoods[0] is None


@pytest.mark.parametrize("aside", [-0.3, 0.0, 0.3])
def test_the_direction_is_left_positive_and_comes_back_surer(aside: float) -> None:
    column = 319.5 - 550 * math.tan(aside)
    picture = white_body(640, 480, column, 80.0, 300.0)
    (found,) = sticks().look(asked(picture, aside + 0.03, 3.1))
    assert found.bearing == pytest.approx(aside, abs=0.01)
    assert sticks().look(asked(picture, aside + (0.4 if aside < 0 else -0.4), 3.1)) == ()


def test_a_body_of_another_size_than_the_distance_foretells_is_nobody() -> None:
    picture = white_body(640, 480, 320.0, 150.0, 180.0)
    assert len(sticks().look(asked(picture, 0.0, 5.2))) == 1
    assert sticks().look(asked(picture, 0.0, 2.2)) == ()


class OneWay(StickNetworks):
    """Is sure of a body with red on its left only: of what looks like one as it stands, not in a mirror."""

    def landmarks(self, crop):
        rows, sure = super().landmarks(crop)
        shaded = crop[:, : crop.shape[1] // 2, 2].sum() > crop[:, crop.shape[1] // 2 :, 2].sum()
        return rows, sure if shaded else min(sure, 0.3)


def test_where_nothing_foretells_anybody_a_body_must_be_one_in_the_mirror_too() -> None:
    picture = white_body(640, 480, 320.0, 60.0, 330.0)
    assert len(sticks().look(asked(picture, 0.0))) == 1
    picture[:, 320:, 2] = 0  # its right half is without red
    assert len(sticks().look(asked(picture, 0.0))) == 1
    assert PoseDetector(OneWay()).look(asked(picture, 0.0)) == ()
    assert len(PoseDetector(OneWay()).look(asked(picture, 0.0, 550 * 1.7 / 330))) == 1


def test_what_lies_or_has_no_legs_is_nobody() -> None:
    flat = np.zeros((480, 640, 3), np.uint8)
    flat[200:260, 100:540] = 255
    assert sticks().look(asked(flat, 0.0, 4.0)) == ()


def test_on_the_robots_floor_legs_alone_are_no_small_person_far_away() -> None:
    lower = white_body(320, 256, 155.0, 10.0, 80.0)  # what a network makes of two legs
    question = LookQuestion(pixels=lower, camera=ROBOTS, bearing=0.0, distances=())
    assert sticks().look(question) == ()
    assert all(only_legs_show(ROBOTS, 0.0, distance) for distance in (0.15, 0.33, 0.6, 1.2))
    assert not only_legs_show(ROBOTS, 2.0, 0.33)
    assert not only_legs_show(ROBOTS, 0.0, 3.0)
    assert not only_legs_show(WEBCAM, 0.0, 1.2)


def test_a_place_on_the_floor_and_its_pixel_belong_together() -> None:
    view = Viewpoint(ROBOTS)
    place, metre = view.pixel(0.2, 3.0, 0.93)
    assert view.bearing(*place.tolist()) == pytest.approx(0.2, abs=0.02)
    assert ROBOTS.mounting.translation[2] + 3.0 * view.elevation(*place.tolist()) == pytest.approx(0.93, abs=0.02)
    assert metre == pytest.approx(ROBOTS.model.fx / (3.0 * math.cos(0.2)), rel=0.02)
    assert math.isnan(view.column(2.5))


def test_a_square_is_cut_where_its_map_says() -> None:
    picture = np.zeros((900, 1200, 3), np.uint8)
    picture[400:432, 600:632] = 255
    for square in (Square(x=616.0, y=416.0, side=800.0), Square(x=560.0, y=450.0, side=500.0, turn=0.4)):
        crop = ImagePyramid(picture).cut(square)
        grey = crop[:, :, 0].astype(float)
        rows, columns = np.indices(grey.shape)
        matrix = picture_from_crop(square)
        middle = matrix[:, :2] @ (np.average(columns, weights=grey), np.average(rows, weights=grey)) + matrix[:, 2]
        assert np.abs(middle - (615.5, 415.5)).max() < 0.25


def test_the_detectors_anchors_are_those_of_three_grids() -> None:
    grid = anchors()
    assert grid.shape == (2254, 2)
    assert grid[0].tolist() == [0.5 / 28, 0.5 / 28] and grid[-1].tolist() == [6.5 / 7, 6.5 / 7]
    rows = np.array([[0, 0, 10, 10, 1, 1, 2, 2], [1, 0, 11, 10, 3, 3, 4, 4], [50, 50, 60, 60, 5, 5, 6, 6]], float)
    kept = without_doubles(rows, np.array([0.8, 0.8, 0.9]))
    assert [score for _, score in kept] == [0.9, 0.8]
    assert kept[1][0] == pytest.approx([0.5, 0, 10.5, 10, 2, 2, 3, 3])


def test_boxes_share_and_overlap() -> None:
    assert share_inside((-5.0, 0.0, 5.0, 10.0), 100, 100) == pytest.approx(0.5)
    assert overlap((0.0, 0.0, 2.0, 2.0), (1.0, 0.0, 3.0, 2.0)) == pytest.approx(1 / 3)


def test_damaged_networks_are_named(tmp_path) -> None:
    for name in ("pose_landmark/pose_landmark_full.tflite", "pose_detection/pose_detection.tflite"):
        (tmp_path / name).parent.mkdir()
        (tmp_path / name).write_bytes(b"TFL3" * 100)
    with pytest.raises(BadInput, match="beckon models get people"):
        OpenCvNetworks(tmp_path)
    if has_litert():
        with pytest.raises(BadInput, match="beckon models get people"):
            LiteRtNetworks(tmp_path)


def test_without_the_networks_the_embedded_detector_says_what_it_knows(monkeypatch, tmp_path) -> None:
    monkeypatch.setenv("BECKON_HOME", str(tmp_path))
    if find(MODEL) is not None:
        pytest.skip("the networks belong to an installed package")
    settings = PeopleSettings()
    assert not sees_people(settings)
    detector = open_detector(settings)
    assert (
        detector.name == "drawn" and "drawn figures" in detector.says and "beckon models get people" in detector.says
    )
    stage = Stage(LAB, np.random.default_rng(3), cameras=(ROBOTS,))
    scene = next(
        one for one in iter(lambda: stage.scene(1, nearest=3.0, clutter=0), None) if one.people[0].shown > 0.9
    )
    (someone,) = scene.people
    question = LookQuestion(
        pixels=scene.pixels, camera=ROBOTS, bearing=someone.bearing, distances=(someone.distance,)
    )
    assert detector.look(question)[0].bearing == pytest.approx(someone.bearing, abs=0.1)


@pytest.mark.parametrize("networks", [OpenCvNetworks, LiteRtNetworks])
def test_the_networks_find_drawn_people_and_agree(networks) -> None:
    model = find(MODEL)
    if model is None:
        why = "The pose networks are not here: beckon models get people"
        pytest.fail(why) if os.environ.get("BECKON_REQUIRE_PEOPLE") else pytest.skip(why)
    if networks is LiteRtNetworks and not has_litert():
        pytest.skip("LiteRT is not installed: pip install ai-edge-litert")
    stage = Stage(LAB, np.random.default_rng(17), cameras=(WEBCAM,))
    detector, found, many = PoseDetector(networks(model.folder)), 0, 0
    while many < 5:
        scene = stage.scene(1, nearest=2.0, reach=4.0, clutter=1)
        someone = scene.people[0]
        if someone.shown < 0.9:
            continue
        many += 1
        question = LookQuestion(
            pixels=scene.pixels, camera=WEBCAM, bearing=someone.bearing + 0.02, distances=(someone.distance,)
        )
        people = detector.look(question)
        found += bool(people) and abs(people[0].bearing - someone.bearing) < 0.05
    assert found >= 4
    crop = ImagePyramid(levelled(scene.pixels)).cut(Square(x=320.0, y=240.0, side=480.0))
    rows, sure = networks(model.folder).landmarks(crop)
    other, also = OpenCvNetworks(model.folder).landmarks(crop)
    assert sure == pytest.approx(also, abs=1e-3)
    assert np.abs(rows - other)[:, :2].max() < 0.2
