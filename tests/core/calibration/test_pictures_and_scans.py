import math
import struct
import time
from pathlib import Path

import cv2
import numpy as np
import pytest

from core.calibration.files.pictures import decode, look, read_colour, read_grey, read_upright
from core.calibration.files.scan_files import read_scans
from core.errors import BadInput

SHAPES = np.add.outer(np.arange(120) * 2, np.arange(160)).astype(np.uint8)


def encoded(form: str, picture: np.ndarray = SHAPES) -> bytes:
    return cv2.imencode(form, picture)[1].tobytes()


def turned(orientation: int) -> bytes:
    """A JPEG with an EXIF orientation."""
    plain = encoded(".jpg")
    tiff = b"II*\0" + struct.pack("<IHHHIHHI", 8, 1, 0x0112, 3, 1, orientation, 0, 0)
    block = b"Exif\0\0" + tiff
    return plain[:2] + b"\xff\xe1" + struct.pack(">H", len(block) + 2) + block + plain[2:]


@pytest.mark.parametrize("form", [".jpg", ".png", ".bmp", ".webp", ".pgm"])
def test_common_pictures_are_read(form: str) -> None:
    content = encoded(form)
    header = look(content)
    assert header is not None and (header.width, header.height, header.complete) == (160, 120, True)
    pixels, remark = decode(content, cv2.IMREAD_GRAYSCALE)
    assert pixels.shape == (120, 160) and remark == ""


@pytest.mark.parametrize("form", [".jpg", ".png", ".bmp", ".webp", ".pgm"])
@pytest.mark.parametrize("share", [0.0, 0.02, 0.4, 0.9])
def test_a_picture_that_is_cut_off_is_refused(form: str, share: float) -> None:
    content = encoded(form)
    with pytest.raises(BadInput):
        decode(content[: int(len(content) * share)], cv2.IMREAD_GRAYSCALE)


@pytest.mark.parametrize("damage", [bytes(40), b"\xff" * 40, b"\xff\xd3", bytes(range(7, 207))])
@pytest.mark.parametrize("share", [0.3, 0.6, 0.8])
def test_a_jpeg_that_is_damaged_in_its_middle_is_refused(damage: bytes, share: float, capfd) -> None:
    noise = np.random.default_rng(3).integers(0, 60, SHAPES.shape)
    content = encoded(".jpg", (SHAPES // 2 + noise).astype(np.uint8))
    place = int(len(content) * share)
    with pytest.raises(BadInput, match="damaged"):
        decode(content[:place] + damage + content[place + len(damage) :], cv2.IMREAD_GRAYSCALE)
    assert capfd.readouterr().err == ""


def test_bytes_that_webcams_put_before_the_end_are_no_damage(capfd) -> None:
    content = encoded(".jpg")
    assert decode(content[:-2] + bytes(2) + content[-2:], cv2.IMREAD_GRAYSCALE)[0].shape == (120, 160)
    assert decode(content[:-2] + bytes(9) + content[-2:], cv2.IMREAD_GRAYSCALE, live=True)[0].shape == (120, 160)


@pytest.mark.parametrize(
    "content",
    [
        b"P5\r\n160 120\r\n255\r\n" + SHAPES.tobytes(),
        b"P5\n160 120\n255\n# by a camera\n" + SHAPES.tobytes(),
        b"P5 160 120 1023\n" + (SHAPES * np.uint16(4) + 3).astype(">u2").tobytes(),
        b"P2\n# by hand\n160 120 255\n" + b" ".join(b"%d" % level for level in SHAPES.ravel().tolist()),
        encoded(".png", SHAPES.astype(np.uint16) * 257),
        encoded(".png", SHAPES.astype(np.uint16) * 16 + 15),
        encoded(".png", SHAPES.astype(np.uint16)),
    ],
)
def test_pictures_of_other_depths_and_heads_show_the_same(content: bytes) -> None:
    assert np.abs(decode(content, cv2.IMREAD_GRAYSCALE)[0].astype(int) - SHAPES).max() <= 1
    colours = decode(content, cv2.IMREAD_COLOR)[0]
    assert colours.shape == (120, 160, 3) and np.abs(colours.astype(int) - SHAPES[..., None]).max() <= 1


def test_what_git_leaves_in_place_of_a_picture_is_named() -> None:
    with pytest.raises(BadInput, match="git lfs pull"):
        decode(b"version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 9\n", cv2.IMREAD_GRAYSCALE)


@pytest.mark.parametrize(
    "content", [b"P5 159 120 255\n" + SHAPES.tobytes(), b"P5 160 120 255\n" + SHAPES.astype(">u2").tobytes()]
)
def test_a_head_that_does_not_fit_its_pixels_is_refused(content: bytes) -> None:
    with pytest.raises(BadInput, match="fewer pixels"):
        decode(content, cv2.IMREAD_GRAYSCALE)


def test_a_lying_header_is_refused_before_decoding() -> None:
    content = bytearray(encoded(".jpg"))
    place = content.index(b"\xff\xc0") + 5
    content[place : place + 4] = struct.pack(">HH", 20000, 20000)
    begun = time.process_time()
    with pytest.raises(BadInput, match="20000x20000"):
        decode(bytes(content), cv2.IMREAD_GRAYSCALE)
    assert time.process_time() - begun < 0.1


def test_the_sensors_own_orientation_is_kept_and_told() -> None:
    pixels, remark = decode(turned(6), cv2.IMREAD_GRAYSCALE)
    assert pixels.shape == (120, 160) and "turned" in remark
    assert decode(turned(1), cv2.IMREAD_GRAYSCALE)[1] == ""


@pytest.mark.parametrize(
    ("orientation", "shape"), [(1, (120, 160)), (3, (120, 160)), (6, (160, 120)), (8, (160, 120))]
)
def test_a_photograph_is_turned_as_it_is_shown(orientation: int, shape: tuple[int, int], tmp_path: Path) -> None:
    (tmp_path / "photo.jpg").write_bytes(turned(orientation))
    pixels = read_upright(tmp_path / "photo.jpg")
    assert pixels.shape[:2] == shape
    corner = {1: (0, 0), 3: (-1, -1), 6: (0, -1), 8: (-1, 0)}[orientation]  # where the darkest one is now
    assert pixels[corner][0] < 12


def test_a_film_after_a_telephones_picture_is_no_damage() -> None:
    content = encoded(".jpg")
    film = np.random.default_rng(1).integers(0, 255, 20_000).astype(np.uint8).tobytes()
    assert decode(content + film, cv2.IMREAD_GRAYSCALE)[0].shape == (120, 160)
    with pytest.raises(BadInput, match="cut off"):
        decode(content[:-40], cv2.IMREAD_GRAYSCALE)


@pytest.mark.parametrize(
    "content", [b"", b"text", b"\xff\xd8\xff", b"\x89PNG\r\n\x1a\n", b"BM", b"RIFF....WEBP", b"P5 x y"]
)
def test_what_is_no_picture_is_refused(content: bytes) -> None:
    with pytest.raises(BadInput):
        decode(content, cv2.IMREAD_COLOR)


def test_noise_never_comes_through_as_an_error_of_another_kind() -> None:
    rng = np.random.default_rng(0)
    heads = [encoded(form)[:30] for form in (".jpg", ".png", ".bmp", ".webp", ".pgm")] + [turned(3)[:60]]
    for number in range(150):
        content = heads[number % len(heads)] + rng.integers(0, 256, 200, dtype=np.uint8).tobytes()
        with pytest.raises(BadInput):
            decode(content, cv2.IMREAD_GRAYSCALE)


def test_tiny_and_missing_pictures_are_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="only 32x32"):
        decode(encoded(".png", SHAPES[:32, :32]), cv2.IMREAD_GRAYSCALE)
    with pytest.raises(BadInput, match="no such file"):
        read_grey(tmp_path / "none.png")
    with pytest.raises(BadInput, match="a folder; give the pictures in it"):
        read_colour(tmp_path)


def write(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


def test_several_scans_in_one_csv_are_told_apart(tmp_path: Path) -> None:
    rows = "".join(f"{angle},{2 + scan}\n" for scan in range(3) for angle in (-0.2, 0.0, 0.2, 0.4))
    bearings, ranges = read_scans(write(tmp_path / "scan.csv", "angle_rad,range_m\n" + rows))
    assert np.allclose(bearings, (-0.2, 0, 0.2, 0.4)) and ranges.shape == (3, 4)
    assert np.allclose(ranges[:, 0], (2, 3, 4))


def test_points_become_bearings_and_ranges_without_a_heading(tmp_path: Path) -> None:
    bearings, ranges = read_scans(write(tmp_path / "scan.csv", "x,y\n1,1\n2,0\n1,-1\n"))
    assert np.allclose(bearings, (-np.pi / 4, 0, np.pi / 4)) and np.allclose(ranges[0, 1], 2)
    bearings, ranges = read_scans(write(tmp_path / "bare.csv", "0.0,1.5\n0.1,1.6\n0.2,nan\n0.3,1.7\n0.4,0\n"))
    assert np.allclose(bearings, (0, 0.1, 0.3)) and np.allclose(ranges[0], (1.5, 1.6, 1.7))


@pytest.mark.parametrize(
    "content",
    [
        b"angle,range\n-0.5,2\n0,2.5\n0.5,3\n",
        b"\xef\xbb\xbfangle,range\r\n-0.5,2\r\n0,2.5\r\n0.5,3\r\n",
        b"# a laser\n\nangle;range\n-0,5;2\n0;2,5\n0,5;3\n",
        "angle\trange\n-0,5\t2\n0\t2,5\n0,5\t3\n".encode("utf-16"),
        b"angle  range\n -0.5  2\n 0  2.5\n 0.5  3\n",
        b"-0.5 2\n0 2.5\n0.5 3\n",
    ],
)
def test_a_table_is_read_whatever_program_wrote_it(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "scan.csv").write_bytes(content)
    bearings, ranges = read_scans(tmp_path / "scan.csv")
    assert bearings == pytest.approx([-0.5, 0.0, 0.5]) and ranges == pytest.approx(np.array([[2.0, 2.5, 3.0]]))


def test_pcd_in_both_spellings_says_the_same(tmp_path: Path) -> None:
    points = np.array([[1.0, 0.2, 0.0], [1.1, 0.0, 0.0], [1.2, -0.3, 0.0]], np.float32)
    head = (
        "# .PCD\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 3\nHEIGHT 1\nPOINTS 3\nDATA "
    )
    ascii_rows = "\n".join(" ".join(map(str, point)) for point in points)
    (tmp_path / "a.pcd").write_text(head + "ascii\n" + ascii_rows)
    (tmp_path / "b.pcd").write_bytes((head + "binary\n").encode() + points.tobytes())
    one, other = read_scans(tmp_path / "a.pcd"), read_scans(tmp_path / "b.pcd")
    assert np.allclose(one[0], other[0]) and np.allclose(one[1], other[1])
    (tmp_path / "c.pcd").write_bytes((head + "binary\n").encode() + points.tobytes()[:20])
    with pytest.raises(BadInput, match="cut off"):
        read_scans(tmp_path / "c.pcd")


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.csv", ""),
        ("b.csv", "left,right\n1,2\n3,4\n5,6\n"),
        ("c.csv", "angle,range\nx,y\n"),
        ("d.pcd", "hello"),
        ("e.pcd", "FIELDS x y\nPOINTS 99999999999\nDATA ascii\n1 2\n"),
        ("f.pcd", "FIELDS x\nPOINTS 1\nDATA ascii\n1\n"),
        ("g.pcd", "FIELDS x y\nSIZE 4 4\nTYPE F F\nPOINTS 2\nDATA binary_compressed\n"),
        ("h.csv", "angle,range\n0,1\n0.1,1\n"),
        ("i.pcd", "FIELDS x y\nSIZE 4\nTYPE F F\nPOINTS 3\nDATA binary\n" + "a" * 60),
    ],
)
def test_what_is_no_scan_is_refused_in_words(tmp_path: Path, name: str, text: str) -> None:
    with pytest.raises(BadInput):
        read_scans(write(tmp_path / name, text))


@pytest.mark.parametrize(
    ("heading", "angle", "distance"),
    [
        ("angle,range", 1.0, 1.0),
        ("angle_deg,range_mm", 180 / np.pi, 1e3),
        ("Angle [deg],Range [cm]", 180 / np.pi, 1e2),
        ("bearing_rad,distance (m)", 1.0, 1.0),
    ],
)
def test_a_scan_is_read_in_the_units_that_its_columns_name(
    tmp_path: Path, heading: str, angle: float, distance: float
) -> None:
    rows = [f"{bearing * angle},{2.5 * distance}" for bearing in np.linspace(-2, 2, 41)]
    (tmp_path / "scan.csv").write_text("\n".join([heading, *rows]))
    bearings, ranges = read_scans(tmp_path / "scan.csv")
    assert np.allclose(bearings, np.linspace(-2, 2, 41)) and np.allclose(ranges, 2.5)


def test_degrees_that_no_column_names_are_refused_as_degrees(tmp_path: Path) -> None:
    (tmp_path / "scan.csv").write_text("angle,range\n" + "\n".join(f"{bearing},2.5" for bearing in range(-135, 136)))
    with pytest.raises(BadInput, match="from -135 to 135, more than a full turn"):
        read_scans(tmp_path / "scan.csv")


@pytest.mark.parametrize("heading", ["angle,range", "angle_deg,range"])
@pytest.mark.parametrize("begin", [0.0, math.pi / 2, -math.pi])
def test_angles_count_from_anywhere(tmp_path: Path, heading: str, begin: float) -> None:
    angles = np.radians(np.arange(-135.0, 135.5, 1.0))
    ranges = 2 + 0.5 * np.cos(angles)
    counted = (angles - begin) % (2 * math.pi) + begin
    unit = 180 / math.pi if "deg" in heading else 1.0
    for order in (np.arange(len(angles)), np.argsort(counted)):
        file = tmp_path / "scan.csv"
        rows = np.column_stack((unit * counted, ranges))[order]
        file.write_text("\n".join([heading, *(f"{angle:.6f},{distance:.6f}" for angle, distance in rows)]))
        bearings, found = read_scans(file)
        assert bearings == pytest.approx(angles, abs=1e-5)
        assert np.nanmean(found, axis=0) == pytest.approx(ranges, abs=1e-5)
