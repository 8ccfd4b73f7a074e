import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from core.calibration.board.board import Board
from core.calibration.board.printing import board_svg
from core.calibration.camera.undistortion import exact_map
from core.calibration.files.camera_files import camera_entry, read_camera
from core.calibration.files.mount_files import FORWARD, read_mount
from core.calibration.practice import BoardPlacement, ImageExposure, held, picture
from core.calibration.projection import Poses
from core.errors import BadInput
from core.geometry import Transform
from core.optics import TABLE_3
from core.pipelines.calibrate import board_in, calibrate_camera, calibrate_laser
from core.pipelines.correct import correct
from tests.core.calibration.rooms_to_practise import BOARD as PANEL
from tests.core.calibration.rooms_to_practise import a_room, error_of
from tests.core.calibration.seen_boards import BOARD

HOW = BoardPlacement(nearest=0.25, farthest=0.6, margin=10)


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("pictures")
    rng = np.random.default_rng(21)
    poses = held(rng, 12, TABLE_3, BOARD, HOW)
    paths = []
    for number in range(12):
        paths.append(folder / f"view{number:02}.png")
        cv2.imwrite(str(paths[-1]), picture(rng, TABLE_3, poses.take(slice(number, number + 1)), BOARD))
    return paths


def test_pictures_become_a_camera_in_every_form(pictures: list[Path], tmp_path: Path) -> None:
    told = calibrate_camera(pictures, BOARD, tmp_path)
    json.dumps(told, allow_nan=False)
    assert told["image_size"] == [320, 256] and told["views_used"] >= 10
    assert abs(told["fx"] - TABLE_3.fx) < 4 * told["sd"]["fx"] + 0.2
    assert set(told["sd"]) == {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"}
    assert set(told["files"]) == {"ros", "opencv", "json", "kalibr"}
    for path in told["files"].values():
        assert read_camera(Path(path)).fx == told["fx"]
    again = board_in(Path(told["files"]["json"]))
    assert (again.columns, again.rows, again.square) == (9, 6, 0.03)


def test_every_bad_picture_is_refused_with_its_reason(pictures: list[Path], tmp_path: Path) -> None:
    bad = {"text.png": b"no picture", "cut.png": pictures[0].read_bytes()[:2000], "empty.jpg": b""}
    for name, content in bad.items():
        (tmp_path / name).write_bytes(content)
    cv2.imwrite(str(tmp_path / "large.png"), cv2.resize(cv2.imread(str(pictures[1])), (640, 512)))
    cv2.imwrite(str(tmp_path / "wall.png"), np.full((256, 320), 120, np.uint8))
    facing = Poses(np.eye(3)[None], np.array([[-0.12, -0.075, 0.42]]))
    blurred = picture(np.random.default_rng(0), TABLE_3, facing, BOARD, ImageExposure(motion=10))
    cv2.imwrite(str(tmp_path / "blurred.png"), blurred)
    told = calibrate_camera([*pictures, *sorted(tmp_path.iterdir()), tmp_path / "none.png"], BOARD)
    reasons = {each["image"]: each["reason"] for each in told["views_refused"]}
    assert {"text.png", "cut.png", "empty.jpg", "large.png", "wall.png", "blurred.png", "none.png"} <= set(reasons)
    assert "640x512" in reasons["large.png"] and "Blurred" in reasons["blurred.png"]
    assert "contrast" in reasons["wall.png"] and "cut off" in reasons["cut.png"]


def test_too_few_good_pictures_end_in_a_sentence(pictures: list[Path], tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="Only 2 of 2"):
        calibrate_camera(pictures[:2], BOARD)
    with pytest.raises(BadInput, match="squares instead of inner corners"):
        calibrate_camera(pictures[:4], Board(columns=10, rows=7, square=0.03))
    with pytest.raises(BadInput, match="Only 0 of 1"):
        calibrate_camera([tmp_path / "none.png"], BOARD)


def test_pictures_are_straightened_and_the_errors_told(pictures: list[Path], tmp_path: Path) -> None:
    camera = tmp_path / "camera.json"
    camera.write_text(json.dumps(camera_entry(TABLE_3)))
    for method in ("exact", "table-1"):
        told = correct(pictures[:2], camera, tmp_path / method, method)  # type: ignore[arg-type]
        assert told["error"]["table_1"]["max_px"] < 0.42 and told["error"]["exact"]["max_px"] < 1e-3
        straight = cv2.imread(told["pictures"][0]["file"], cv2.IMREAD_GRAYSCALE)
        lookup = exact_map(TABLE_3).astype(np.float32)
        whole = cv2.imread(str(pictures[0]), cv2.IMREAD_GRAYSCALE)
        wanted = cv2.remap(whole, lookup[..., 0], lookup[..., 1], cv2.INTER_LINEAR)
        assert np.abs(straight.astype(int) - wanted).mean() < 1.5
    with pytest.raises(BadInput, match="No picture"):
        correct([camera], camera, tmp_path / "none")


def folder_of_pairs(folder: Path, seed: int, background: bool) -> Transform:
    """Twelve poses as pictures and csv scans; the true mount."""
    room = a_room(seed)
    for name in ("images", "scans"):
        (folder / name).mkdir()
    angles = room.laser.angle_min + room.laser.angle_step * np.arange(room.laser.beams)

    def csv(name: str, scans: np.ndarray) -> None:
        rows = [f"{angle:.6f},{value:.4f}" for scan in scans for angle, value in zip(angles, scan, strict=True)]
        (folder / "scans" / name).write_text("angle,range\n" + "\n".join(rows))

    if background:
        csv("background.csv", room.background(20))
    taken = 0
    while taken < 12:
        for shot in room.shots(4, 10):
            pose = Poses(shot.rotation[None], shot.translation[None])
            cv2.imwrite(str(folder / "images" / f"{taken:02}.png"), picture(room.rng, TABLE_3, pose, PANEL))
            csv(f"{taken:02}.csv", shot.scans)
            taken += 1
    return room.laser_from_camera


@pytest.mark.parametrize("background", [True, pytest.param(False, marks=pytest.mark.campaign)])
def test_pairs_of_pictures_and_scans_become_a_mount(tmp_path: Path, background: bool) -> None:
    pairs = tmp_path / "pairs"
    pairs.mkdir()
    truth = folder_of_pairs(pairs, seed=11, background=background)
    camera = tmp_path / "camera.json"
    board = {"inner_corners": [9, 6], "square_m": 0.03, "panel_m": [0.34, 0.25]}
    camera.write_text(json.dumps({"camera": camera_entry(TABLE_3), "board": board}))
    told = calibrate_laser(pairs, camera, out=tmp_path / "out")
    json.dumps(told, allow_nan=False)
    found = Transform(rotation=np.array(told["rotation"]), translation=np.array(told["translation_m"]))
    room = a_room(11)
    room.laser_from_camera = truth
    turn, shift = error_of(found, room)
    assert turn < 1.5 and shift < 10
    assert len(told["sd_rotation_deg"]) == 3 and len(told["sd_translation_m"]) == 3
    assert told["poses_used"] >= 6 and told["residual_rms_m"] < 0.02
    saved = json.loads(Path(told["files"]["json"]).read_text())
    assert np.allclose(read_mount(saved["extrinsics"]).translation, found.translation)
    assert FORWARD in saved["extrinsics"]
    assert set(told["files"]) == {"json", "urdf", "static_transform", "matrix"}
    both = json.loads(Path(told["files"]["matrix"]).read_text())
    assert both["laser_from_camera"] == saved["extrinsics"][FORWARD]


def test_a_folder_that_does_not_pair_up_is_refused(tmp_path: Path) -> None:
    camera = tmp_path / "camera.json"
    camera.write_text(json.dumps(camera_entry(TABLE_3)))
    with pytest.raises(BadInput, match="images/"):
        calibrate_laser(tmp_path, camera, BOARD)
    (tmp_path / "images").mkdir()
    (tmp_path / "scans").mkdir()
    with pytest.raises(BadInput, match="pair up"):
        calibrate_laser(tmp_path, camera, BOARD)
    with pytest.raises(BadInput, match="which board"):
        calibrate_laser(tmp_path, camera)


def test_the_printed_board_is_in_real_size_and_has_the_right_squares() -> None:
    text = board_svg(Board(columns=9, rows=6, square=0.025))
    assert 'width="297mm"' in text and text.count('width="25.000"') == 35
    assert "5 squares = 125 mm" in text and "9x6" in text
    with pytest.raises(BadInput, match="at most 2"):
        board_svg(Board(columns=9, rows=6, square=0.04))
