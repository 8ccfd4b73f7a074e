"""People in pictures, in scans and over time."""

import dataclasses
import math

import numpy as np
import pytest

from core.errors import BadInput
from core.geometry import Pose, Ray, Transform
from core.message import Array
from core.perception.people.brightness import levelled
from core.perception.people.camera_geometry import eye, off_axis
from core.perception.people.detector import Rectangle, edge_cells, find_people
from core.perception.people.enrollment import contour_of, learn, person_image
from core.perception.people.fusion import along, fuse
from core.perception.people.legs import find_standers
from core.perception.people.parts import PARTS, PeopleSettings
from core.perception.people.search import Search
from core.perception.people.vertical_plane import VerticalPlanes
from core.sensors import Camera, Laser
from core.simulation.camera import SimulatedCamera
from core.simulation.laser import SimulatedLaser
from core.simulation.world import LAB, Rect, Thing, World, outline
from tests.drawn_people import ROBOTS, WEBCAM, Stage

SETTINGS = PeopleSettings()
HALL = World(name="hall", walls=outline([Rect(-4.0, -4.0, 6.0, 4.0)], []))


def person(x: float, y: float, *, look: str = "", gesture: str = "", heading: float = math.pi) -> Thing:
    pose = Pose(x, y, heading)
    return Thing(id="p", what="person", pose=pose, length=0.4, depth=0.4, height=1.75, look=look, gesture=gesture)


def post(x: float, y: float) -> Thing:
    """A table's leg."""
    return Thing(id="leg", what="pillar", pose=Pose(x, y, 0.0), length=0.05, depth=0.05, height=0.75)


def off(x: float, y: float, world: World) -> list[float]:
    """How far [m] from (x, y) stands what a scan from the origin takes for legs."""
    scan = SimulatedLaser(Laser(), np.random.default_rng(5)).scan(world, 0.0, np.zeros(1), np.zeros((1, 3)))
    ends = np.column_stack((np.cos(scan.angles), np.sin(scan.angles))) * scan.ranges[:, None]
    return [math.hypot(*(one.place - (x, y))) for one in find_standers(ends[scan.valid])]


@pytest.fixture(scope="module")
def webcam() -> SimulatedCamera:
    return SimulatedCamera(WEBCAM, HALL, np.random.default_rng(0))


def picture(camera: SimulatedCamera, *people: Thing) -> Array:
    world = HALL
    for number, one in enumerate(people):
        world = world.with_thing(dataclasses.replace(one, id=f"p {number}"))
    return camera.take(world, 0.0, Pose()).pixels.copy()


def test_the_three_parts_are_weighed_as_in_equation_34() -> None:
    assert [part.weight for part in PARTS] == [0.3, 0.6, 0.1]
    stage = Stage(LAB, np.random.default_rng(3), cameras=(ROBOTS,))
    scene = next(
        one for one in iter(lambda: stage.scene(1, nearest=3.0, clutter=0), None) if one.people[0].shown > 0.9
    )
    someone = scene.people[0]
    (found,) = find_people(VerticalPlanes(levelled(scene.pixels), ROBOTS), someone.bearing, 0.05, SETTINGS)[:1]
    told = {part.name: part.likelihood for part in found.parts}
    assert None not in told.values()
    assert found.value == pytest.approx(0.3 * told["head"] + 0.6 * told["torso"] + 0.1 * told["feet"], abs=0.03)  # type: ignore[operator]
    assert found.distance == pytest.approx(someone.distance, rel=0.2)
    head, torso, feet = (part.box for part in found.parts)
    assert head[1] < torso[1] < feet[1]
    assert torso[0] < found.centre[0] < torso[2]


EMPTY = 30  # pictures without anybody


@pytest.mark.campaign
def test_most_people_are_found_where_they_speak_and_hardly_anybody_where_nobody_is() -> None:
    stage = Stage(LAB, np.random.default_rng(11))
    found = alarms = many = 0
    for number in range(EMPTY + 8):
        scene = stage.scene(number >= EMPTY, nearest=1.6)
        boards = VerticalPlanes(levelled(scene.pixels), scene.camera)
        if not scene.people:
            alarms += len(find_people(boards, 0.1, 0.1, SETTINGS))
        elif scene.people[0].shown > 0.65:
            many += 1
            told = find_people(boards, scene.people[0].bearing + 0.03, 0.1, SETTINGS)
            found += bool(told) and abs(told[0].bearing - scene.people[0].bearing) * scene.people[0].distance < 0.25
    assert many >= 4
    assert found >= 0.8 * many
    assert alarms <= 0.2 * EMPTY


def test_only_rectangles_in_whose_head_the_sound_falls_are_looked_at(webcam: SimulatedCamera) -> None:
    boards = VerticalPlanes(picture(webcam, person(3.0, 0.6), person(3.2, -0.7, look="green/black")), WEBCAM)
    left = find_people(boards, math.atan2(0.6, 3.0), 0.04, SETTINGS)
    right = find_people(boards, math.atan2(-0.7, 3.2), 0.04, SETTINGS)
    between = find_people(boards, 0.0, 0.02, SETTINGS)
    assert [round(one.bearing, 1) for one in left] == [0.2]
    assert [round(one.bearing, 1) for one in right] == [-0.2]
    assert between == ()


def test_a_person_is_enrolled_from_gestures_and_told_from_others(webcam: SimulatedCamera) -> None:
    background = picture(webcam)
    ann = [picture(webcam, person(3.4, 0.0, look="green/black", gesture=one)) for one in ("", "wave", "hips", "wide")]
    mask = contour_of(ann[0], background)
    assert 0.02 < mask.mean() < 0.2
    who = learn("Ann", [person_image(one, background) for one in ann])
    assert who.pictures == 4
    two = VerticalPlanes(
        picture(webcam, person(3.0, 0.6, look="green/black"), person(3.2, -0.7, look="red/blue")), WEBCAM
    )
    own = find_people(two, math.atan2(0.6, 3.0), 0.05, SETTINGS, who=who)
    other = find_people(two, math.atan2(-0.7, 3.2), 0.05, SETTINGS, who=who)
    anybody = find_people(two, math.atan2(-0.7, 3.2), 0.05, SETTINGS)
    assert (len(own), len(other), len(anybody)) == (1, 0, 1)


def test_what_a_floor_mirrors_is_no_part_of_the_body() -> None:
    eye = SimulatedCamera(ROBOTS, LAB, np.random.default_rng(0))
    background = eye.take(LAB, 0.0, Pose()).pixels.copy()
    for look, turn in (("green/black", math.pi / 2), ("white/grey", 0.0)):
        one = person(3.9, 0.0, look=look, heading=math.pi + turn)
        told = person_image(eye.take(LAB.with_thing(one), 0.0, Pose()).pixels.copy(), background)
        feet = VerticalPlanes(background, ROBOTS).pixels_of(
            3.9 - ROBOTS.mounting.translation[0], 0.0, np.array([[0.0, 0.0]])
        )
        assert told.boxes[2][3] == pytest.approx(feet[0, 1], abs=0.1 * (told.boxes[2][3] - told.boxes[0][1]))


def test_what_cannot_be_enrolled_is_told(webcam: SimulatedCamera) -> None:
    background = picture(webcam)
    with pytest.raises(BadInput, match="at least 3 pictures"):
        learn("Ann", [])
    with pytest.raises(BadInput, match="Nobody is in the picture"):
        person_image(background, background)
    with pytest.raises(BadInput, match="cut off"):
        person_image(picture(webcam, person(1.0, 0.0)), background)
    with pytest.raises(BadInput, match="different size"):
        contour_of(background[:100], background)


def test_a_picture_is_looked_through_a_few_planes_at_a_time(webcam: SimulatedCamera) -> None:
    boards = VerticalPlanes(picture(webcam, person(3.0, 0.0)), WEBCAM)
    hinted = Search(boards, (0.0, 0.05), [3.0], SETTINGS, None)
    first = hinted.go_on()
    assert first is not None
    assert first[0].distance == pytest.approx(3.0, rel=0.1)
    blind = Search(boards, (0.0, 0.05), [], SETTINGS, None)
    told = [blind.go_on() for _ in range(6)]
    assert told[:5] == [None] * 5
    assert told[5] is not None
    assert told[5][0].distance == pytest.approx(3.0, rel=0.15)


def test_feet_at_what_may_be_legs_do_not_end_the_search(
    webcam: SimulatedCamera, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Those may be a table's, and the person stands behind it."""
    boards = VerticalPlanes(picture(webcam, person(3.0, 0.0)), WEBCAM)
    body = find_people(boards, 0.0, 0.05, SETTINGS)[0]
    feet = dataclasses.replace(body, distance=1.0, shown=0.08, value=0.55, rank=0.2, bearing=0.2)

    def seen(_boards: object, _towards: object, planes: list[float], *_: object) -> list[Rectangle]:
        return [one for one in (feet, body) if any(abs(far - one.distance) < 0.04 * far for far in planes)]

    monkeypatch.setattr("core.perception.people.search.everybody", seen)
    search = Search(boards, (0.0, 0.05), [1.0], SETTINGS, None)
    told = None
    while told is None:
        told = search.go_on()
    assert told[0].distance == body.distance


def test_edges_are_counted_in_the_direction_in_which_they_change() -> None:
    upright = np.zeros((16, 16, 3), np.uint8)
    upright[:, 8:] = 200
    told = edge_cells(upright)
    assert told.shape == (4, 4, 9)
    assert told[1, 2].argmax() in (0, 8)
    assert edge_cells(upright.transpose(1, 0, 2).copy())[2, 1].argmax() == 4
    np.testing.assert_allclose(told[:, ::-1][:, 0], edge_cells(upright[:, ::-1].copy())[:, 0][:, ::-1], atol=1e-6)


@pytest.mark.parametrize("heading", [0.0, 0.8, math.pi / 2, 2.5])
def test_the_laser_finds_legs_within_a_decimetre_from_every_side(heading: float) -> None:
    world = HALL.with_thing(person(1.8, 0.5, heading=heading))
    assert min(off(1.8, 0.5, world)) < 0.12


@pytest.mark.parametrize("far", [0.6, 1.0, 1.4])
def test_a_tables_leg_that_is_seen_whole_is_nobodys(far: float) -> None:
    assert min(off(0.0, far, HALL.with_thing(post(0.0, far))), default=math.inf) > 0.5


@pytest.mark.parametrize("heading", [0.0, 0.8, math.pi / 2, 2.5])
def test_a_tables_leg_is_not_paired_with_someones(heading: float) -> None:
    world = HALL.with_thing(person(0.3, 1.3, heading=heading)).with_thing(post(-0.05, 1.2))
    assert max(one for one in off(0.3, 1.3, world) if one < 0.5) < 0.12


def test_fusing_is_surer_than_each_sense_and_leaves_out_what_contradicts() -> None:
    truth = np.array([2.0, 1.0])
    laser = np.array([2.04, 0.95]), 0.05**2 * np.eye(2)
    camera = Ray(x=0.0, y=0.0, azimuth=math.atan2(1.0, 2.0) + 0.005, sd=0.015)
    sound = Ray(x=0.0, y=0.0, azimuth=math.atan2(1.0, 2.0) - 0.03, sd=0.06)
    fused = fuse(laser, (("camera", camera), ("sound", sound)))
    assert fused.used == ("laser", "camera", "sound")
    assert np.trace(fused.covariance) < np.trace(laser[1])
    assert np.hypot(*(fused.position - truth)) < np.hypot(*(laser[0] - truth))
    behind = Ray(x=0.0, y=0.0, azimuth=math.atan2(1.0, 2.0) + math.pi, sd=0.06)
    assert fuse(laser, (("sound", behind),)).used == ("laser",)
    place, spread = along(camera, 2.2, 0.3)
    assert math.atan2(place[1], place[0]) == pytest.approx(camera.azimuth)
    assert np.sqrt(np.linalg.eigvalsh(spread)) == pytest.approx([2.2 * 0.015, 0.3])


@pytest.mark.parametrize("y", [0.3, -0.3])
def test_a_camera_that_looks_back_has_the_people_on_both_sides_of_its_axis_near_it(y: float) -> None:
    back = Transform.of_pose(Pose(0.0, 0.0, np.pi)) @ Camera().mounting
    camera = Camera(mounting=back)
    assert off_axis(eye(Pose(), camera).bearing_to(-3.0, y), camera) == pytest.approx(0.1, abs=0.01)
