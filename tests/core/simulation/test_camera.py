"""Simulated pictures."""

import cv2
import numpy as np
import pytest

from core.geometry import OPTICAL, Pose, Transform, rotation
from core.message import Array
from core.perception.image_quality.measures import blur
from core.sensors import Camera
from core.simulation.camera import SimulatedCamera
from core.simulation.world import FLOOR, LAB, Rect, Thing, World, cast, outline

CAMERA = Camera()
PLAIN = World(name="plain", walls=outline([Rect(-3.0, -2.0, 3.0, 2.0)], [Rect(2.2, -0.3, 3.0, 0.5)]))


@pytest.fixture(scope="module")
def in_lab() -> SimulatedCamera:
    return SimulatedCamera(CAMERA, LAB, np.random.default_rng(0), snr=100.0)


def person(x: float, y: float, heading: float = 0.0) -> Thing:
    return Thing(id="p", what="person", pose=Pose(x, y, heading), length=0.4, depth=0.4, height=1.75)


def pixels_of(points: Array, pose: Pose, camera: Camera = CAMERA) -> Array:
    """Where points (N, 3) [m] of the world appear (N, 2)."""
    camera_from_world = (Transform.of_pose(pose) @ camera.mounting).inverse()
    return camera.model.project(camera_from_world.apply(points))


def corners_in_view(world: World, pose: Pose) -> Array:
    """Corners (K, 2) [m] of the walls that the camera sees well."""
    eye = pose.apply(CAMERA.mounting.translation[None, :2])[0]
    corners = world.walls[:, :2]
    pixels = pixels_of(np.column_stack((corners, np.full(len(corners), 0.16))), pose)
    rays = corners - eye
    hits = cast(eye, rays * (1 - 0.01 / np.hypot(*rays.T))[:, None], world.surfaces(0.3))
    clear = (hits.distance > 1.0) & (np.hypot(*rays.T) < 4.0)
    return corners[clear & (pixels[:, 0] > 15) & (pixels[:, 0] < 305)]


def edge_near(picture: Array, pixel: Array) -> float | None:
    """Column of the strongest vertical edge within 3 pixels of `pixel`; None where there is none."""
    column, row = np.round(pixel).astype(int)
    patch = picture[row - 2 : row + 3, column - 5 : column + 6].astype(float).mean(axis=0)
    slope = np.abs(patch[2:] - patch[:-2]).sum(axis=1)[1:-1]
    if slope.max() < 25:
        return None
    weight = np.where(np.abs(np.arange(7) - slope.argmax()) <= 1, slope, 0.0)
    return float(column - 3 + (weight * np.arange(7)).sum() / weight.sum())


def test_corners_appear_where_the_optics_project_them(in_lab: SimulatedCamera) -> None:
    gaps: list[float] = []
    for pose in (Pose(0, 0, 0.1), Pose(1, 0.5, 2.2), Pose(2, 1, -0.6), Pose(-1, -0.5, 1.0), Pose(1, -1, -2.0)):
        picture = in_lab.take(LAB, 0.0, pose).pixels
        for corner in corners_in_view(LAB, pose):
            for height in (0.2, 0.4, 0.6):
                pixel = pixels_of(np.array([[*corner, height]]), pose)[0]
                if 5 < pixel[1] < 250 and (found := edge_near(picture, pixel)) is not None:
                    gaps.append(found - float(pixel[0]))
    assert len(gaps) > 20
    assert abs(np.median(gaps)) < 0.2
    assert np.quantile(np.abs(gaps), 0.9) < 1.0


def test_the_floor_meets_the_wall_where_the_optics_say() -> None:
    camera = SimulatedCamera(CAMERA, PLAIN, np.random.default_rng(0), snr=100.0)
    pose = Pose(0.2, 1.2, 0.0)
    picture = camera.take(PLAIN, 0.0, pose).pixels.astype(float).sum(axis=2)
    for y in (0.9, 1.3, 1.6):
        column, row = pixels_of(np.array([[3.0, y, 0.0]]), pose)[0]
        strip = picture[:, round(column) - 1 : round(column) + 2].mean(axis=1)
        slope = strip[2:] - strip[:-2]  # from the dark skirting to the bright floor
        top = round(row) - 5
        assert top + 1 + slope[top : top + 10].argmax() == pytest.approx(row, abs=1.2)


def test_a_camera_that_is_turned_and_tilted_sees_what_its_mounting_says() -> None:
    tilt = np.array([[1.0, 0.0, 0.0], [0.0, np.cos(0.1), -np.sin(0.1)], [0.0, np.sin(0.1), np.cos(0.1)]])
    turned = np.eye(3)
    turned[:2, :2] = rotation(0.4)
    camera = Camera(
        mounting=Transform(rotation=turned @ OPTICAL @ tilt, translation=np.array([0.05, 0.02, 0.2])), rate=10.0
    )
    picture = SimulatedCamera(camera, PLAIN, np.random.default_rng(0), snr=100.0).take(PLAIN, 0, Pose(0, 0, -0.4))
    for height in (0.1, 0.2, 0.3):
        pixel = pixels_of(np.array([[2.2, 0.5, height]]), Pose(0, 0, -0.4), camera)[0]
        found = edge_near(picture.pixels, pixel)
        assert found is not None
        assert found == pytest.approx(pixel[0], abs=1.0)


@pytest.mark.parametrize("world", [LAB, FLOOR], ids=["lab", "floor"])
def test_canny_and_hough_find_the_vertical_edges_of_the_walls(world: World) -> None:
    camera, model = SimulatedCamera(CAMERA, world, np.random.default_rng(0)), CAMERA.model
    ideal = Camera(model=type(model)(**{k: getattr(model, k) for k in ("width", "height", "fx", "fy", "cx", "cy")}))
    found = there = 0
    for x, y, heading in ((x, y, h) for x, y in ((0.3, 0.2), (1.6, 1.0)) for h in np.linspace(-3, 3, 9)):
        pose = Pose(x, y, float(heading))
        picture = cv2.undistort(camera.take(world, 0.0, pose).pixels, model.matrix, model.distortion)
        grey = cv2.GaussianBlur(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), (3, 3), 0)
        lines = cv2.HoughLinesP(cv2.Canny(grey, 30, 80), 1, np.pi / 180, 30, minLineLength=45, maxLineGap=6)
        lines = np.zeros((0, 4)) if lines is None else lines.reshape(-1, 4)
        upright = np.abs(lines[:, 2] - lines[:, 0]) < 0.09 * np.abs(lines[:, 3] - lines[:, 1])
        columns = (lines[upright, 0] + lines[upright, 2]) / 2
        for corner in corners_in_view(world, pose):
            column = pixels_of(np.array([[*corner, 0.16]]), pose, ideal)[0, 0]
            there += 1
            found += bool(len(columns)) and bool(np.abs(columns - column).min() < 2.5)
    assert there >= 30
    assert found / there > 0.7


def test_a_person_stands_in_the_picture_where_the_laser_meets_the_legs(in_lab: SimulatedCamera) -> None:
    pose = Pose()
    empty, full = (
        in_lab.take(w, 0.0, pose).pixels.astype(int) for w in (LAB, LAB.with_thing(person(2.0, 0.3, np.pi)))
    )
    changed = np.abs(full - empty).sum(axis=2) > 60
    feet = pixels_of(np.array([[2.0, 0.3, 0.4]]), pose)[0]
    columns = np.flatnonzero(changed[round(feet[1])])
    assert columns.mean() == pytest.approx(feet[0], abs=3)
    assert 0.2 < (columns[-1] - columns[0]) / 301 * 1.96 < 0.45


def test_what_is_behind_a_wall_is_not_seen() -> None:
    camera = SimulatedCamera(CAMERA, FLOOR, np.random.default_rng(0), snr=100.0)
    next_door = FLOOR.with_thing(person(0.0, -2.5))
    empty, full = (camera.take(w, 0.0, Pose(0, 0, -np.pi / 2)).pixels.astype(int) for w in (FLOOR, next_door))
    assert np.abs(full - empty).max() <= 2


def test_noise_and_light_follow_the_settings() -> None:
    clean, noisy, dim = (
        SimulatedCamera(CAMERA, PLAIN, np.random.default_rng(0), snr=snr, light=light)
        .take(PLAIN, 0.0, Pose())
        .pixels.astype(float)
        for snr, light in ((100.0, 1.0), (42.0, 1.0), (100.0, 0.5))
    )
    middle = (clean > 20) & (clean < 235)
    assert (noisy - clean)[middle].std() == pytest.approx(255 / 10 ** (42 / 20), rel=0.05)
    np.testing.assert_allclose(dim[middle], 0.5 * clean[middle], atol=1.0)


def test_a_picture_is_the_same_for_the_same_seed_and_never_the_same_twice() -> None:
    one, other = (SimulatedCamera(CAMERA, PLAIN, np.random.default_rng(5)) for _ in range(2))
    first = one.take(PLAIN, 0.0, Pose()).pixels
    np.testing.assert_array_equal(first, other.take(PLAIN, 0.0, Pose()).pixels)
    assert (first != one.take(PLAIN, 0.1, Pose()).pixels).any()


def test_every_place_and_heading_can_be_drawn() -> None:
    crowded = LAB.with_thing(person(0.0, 1.5)).with_thing(
        Thing(id="b", what="box", pose=Pose(1.0, 0.0, 0.4), length=0.35, depth=0.35, height=0.35)
    )
    camera, rng = SimulatedCamera(CAMERA, LAB, np.random.default_rng(0)), np.random.default_rng(3)
    for _ in range(60):
        pose = Pose(*rng.uniform((-2.4, -2.4, -np.pi), (5.4, 3.4, np.pi)))
        picture = camera.take(crowded, 0.0, pose).pixels
        assert picture.shape == (256, 320, 3)


def test_turning_meanwhile_smears_the_picture_sideways_and_a_lens_out_of_focus_all_around() -> None:
    rate, exposure = 1.0, 0.03
    length = rate * exposure * CAMERA.model.fx
    chance = np.random.default_rng(0)
    pose = Pose(0, 0, 0.1)

    def blurred(turn_rate: float, **more: float) -> tuple[float, float]:
        camera = SimulatedCamera(CAMERA, LAB, chance, snr=100.0, **more)
        told = blur(cv2.cvtColor(camera.take(LAB, 0.0, pose, turn_rate).pixels, cv2.COLOR_BGR2GRAY), 0.3)
        assert told.across is not None
        assert told.down is not None
        return told.across, told.down

    sharp = blurred(rate)
    assert blurred(0.0, exposure=exposure) == pytest.approx(sharp, abs=0.05)
    smeared = blurred(-rate, exposure=exposure)
    assert smeared[0] == pytest.approx(length / np.sqrt(12), rel=0.25)
    assert smeared[1] == pytest.approx(sharp[1], abs=0.3)
    unfocused = blurred(0.0, defocus=2.0)
    assert unfocused == pytest.approx((2.0, 2.0), abs=0.5)
