"""The exported map, read back by the rule of Nav2's map server; maps of others, read as by a second reader."""

import io
import math
import zipfile

import cv2
import numpy as np
import pytest
import yaml

from core.errors import BadInput
from core.pipelines.nav2_map import Nav2Cells, laid_out, nav2_map, pgm, read_nav2_map, read_nav2_zip
from core.slam.map.occupancy import OccupancyGrid
from tests.core.pipelines.nav2_reference import reference


def make_grid(log_odds, origin=(-1.25, 2.123456), resolution=0.05):
    return OccupancyGrid(
        revision=1, resolution=resolution, origin=np.array(origin), log_odds=np.asarray(log_odds, dtype=np.float32)
    )


def load_as_nav2(text: str, pgm: bytes):
    """Nav2's map_io: p = (255 - pixel) / 255; row 0 of the picture is the highest y."""
    settings = yaml.safe_load(text)
    magic, size, depth, pixels = pgm.split(b"\n", 3)
    columns, rows = (int(word) for word in size.split())
    assert (magic, depth) == (b"P5", b"255")
    picture = np.frombuffer(pixels, np.uint8).reshape(rows, columns)
    p = (255 - picture.astype(float)) / 255
    cells = np.full((rows, columns), -1)
    cells[p >= settings["occupied_thresh"]] = 100
    cells[p <= settings["free_thresh"]] = 0
    return settings, cells[::-1]


def test_every_cell_comes_back_as_what_it_was():
    rng = np.random.default_rng(3)
    kind = rng.choice([-1, 0, 100], (17, 31))
    log_odds = np.select([kind == 100, kind == 0], [2.5, -2.5], 0.0)
    settings, cells = load_as_nav2(*nav2_map(make_grid(log_odds)))
    assert np.array_equal(cells, kind)
    assert settings["image"] == "map.pgm" and settings["mode"] == "trinary" and settings["negate"] == 0


def test_the_unknown_grey_stays_unknown():
    _, cells = load_as_nav2(*nav2_map(make_grid(np.zeros((4, 5)))))
    assert (cells == -1).all()


@pytest.mark.parametrize(("log_odds", "cell"), [(0.4, -1), (-0.4, -1), (0.8, 100), (-0.8, 0), (4.0, 100), (-4.0, 0)])
def test_a_cell_is_drawn_when_it_is_fairly_sure(log_odds, cell):
    _, cells = load_as_nav2(*nav2_map(make_grid(np.full((2, 2), log_odds))))
    assert (cells == cell).all()


def test_the_lowest_row_of_the_grid_is_the_last_of_the_picture():
    log_odds = np.zeros((3, 2))
    log_odds[0, 1] = 3.0
    _, pgm = nav2_map(make_grid(log_odds))
    assert pgm.split(b"\n", 3)[3] == bytes([205, 205, 205, 205, 205, 0])


def test_origin_and_resolution_keep_their_digits():
    settings, _ = load_as_nav2(*nav2_map(make_grid(np.zeros((1, 1)), origin=(-1.23456789, 1e-7), resolution=1 / 30)))
    assert settings["resolution"] == pytest.approx(1 / 30, abs=1e-9)
    assert settings["origin"] == pytest.approx([-1.23456789, 1e-7, 0.0], abs=1e-9)
    assert list(settings) == ["image", "mode", "resolution", "origin", "negate", "occupied_thresh", "free_thresh"]


# read


def drawn(seed: int, bands: int) -> np.ndarray:
    """A picture of every kind of pixel; (rows, columns) or (rows, columns, bands), red first."""
    rng = np.random.default_rng(seed)
    grey = rng.choice([*range(0, 101, 7), 127, 128, 204, 205, 206, 253, 254, 255], (9, 14)).astype(np.uint8)
    if bands == 1:
        return grey
    alpha = rng.choice([0, 128, 255], grey.shape).astype(np.uint8)
    return np.dstack([grey] * 3 + [alpha] * (bands == 4))


def png_of(picture: np.ndarray, kind: str = ".png") -> bytes:
    if picture.ndim == 3:
        picture = picture[..., [2, 1, 0, *range(3, picture.shape[2])]]
    return cv2.imencode(kind, picture)[1].tobytes()


def yaml_of(mode: str = "trinary", negate: object = 0, **other: object) -> str:
    told = {"image": "m.pgm", "mode": mode, "resolution": 0.05, "origin": [-1.3, 2.2, 0.0], "negate": negate}
    return yaml.safe_dump(told | {"occupied_thresh": 0.65, "free_thresh": 0.196} | other)


PICTURES = {
    "pgm": lambda: pgm(drawn(1, 1)),
    "pgm in words, with a comment": lambda: (
        b"P2\n# CREATOR: map_saver\n14 9\n255\n" + b" ".join(str(v).encode() for v in drawn(2, 1).ravel())
    ),
    "png, grey": lambda: png_of(drawn(3, 1)),
    "png, colours": lambda: png_of(drawn(4, 3)),
    "png, not opaque": lambda: png_of(drawn(5, 4)),
    "bmp": lambda: png_of(drawn(6, 1), ".bmp"),
}


@pytest.mark.parametrize("negate", [0, 1])
@pytest.mark.parametrize("mode", ["trinary", "scale", "raw"])
@pytest.mark.parametrize("kind", PICTURES)
def test_each_mode_of_each_picture_is_read_as_by_the_reference(kind: str, mode: str, negate: int) -> None:
    text, picture = yaml_of(mode, negate), PICTURES[kind]()
    read = read_nav2_map(text.encode(), picture)
    assert np.array_equal(read.values, reference(text, picture))
    assert (read.resolution, read.origin, read.mode) == (0.05, (-1.3, 2.2, 0.0), mode)


@pytest.mark.parametrize(
    ("word", "negate"), [("yes", 1), ("True", 1), ("on", 1), ("no", 0), ("off", 0), ("false", 0)]
)
def test_negate_may_be_a_word(word: str, negate: int) -> None:
    picture = pgm(drawn(1, 1))
    read = read_nav2_map(yaml_of(negate=word).encode(), picture)
    assert np.array_equal(read.values, read_nav2_map(yaml_of(negate=negate).encode(), picture).values)


def test_a_pgm_of_other_depths_is_scaled_to_its_brightest() -> None:
    levels = np.arange(16, dtype=np.uint8).reshape(2, 8)
    for most, body in ((15, levels.tobytes()), (60000, (levels.astype(np.uint16) * 4000).astype(">u2").tobytes())):
        read = read_nav2_map(yaml_of("scale").encode(), b"P5 8 2 %d\n" % most + body)
        same = read_nav2_map(yaml_of("scale").encode(), pgm(levels * 17))
        assert np.array_equal(read.values, same.values)


@pytest.mark.parametrize(
    ("head", "end"),
    [(b"P5\r\n14 9\r\n255\r\n", b""), (b"P5\n14 9\n255\n# by hand\n# twice\n", b""), (b"P5\n14 9\n255\n", b"\n")],
)
def test_lines_of_windows_and_comments_behind_the_head_shift_no_pixel(head: bytes, end: bytes) -> None:
    picture = drawn(1, 1)
    picture[0, :2] = 35, 10  # as a comment begins and ends
    read = read_nav2_map(yaml_of("raw").encode(), head + picture.tobytes() + end)
    assert np.array_equal(read.values, read_nav2_map(yaml_of("raw").encode(), pgm(picture)).values)


@pytest.mark.parametrize("times", [1, 257])
def test_a_png_of_16_bits_is_the_map_that_it_shows(times: int) -> None:
    text, picture = yaml_of("raw").encode(), drawn(3, 1)
    read = read_nav2_map(text, png_of(picture * np.uint16(times)))
    assert np.array_equal(read.values, read_nav2_map(text, png_of(picture)).values)


def test_that_the_grey_of_unknown_is_floor_by_nav2s_own_thresholds_is_said() -> None:
    saved = yaml_of(occupied_thresh=0.65, free_thresh=0.25).encode()
    grey = np.array([[0, 205, 254]], np.uint8)
    opaque = np.dstack([grey] * 3 + [np.full_like(grey, 255)])
    for picture, kept in ((pgm(grey), 0.196), (png_of(grey), 0.196), (png_of(opaque), 0.147)):
        read = read_nav2_map(saved, picture)
        assert read.values.tolist() == [[100, 0, 0]] and f"0.25: 1 cells. Write {kept}" in read.remark
        read = read_nav2_map(yaml_of(occupied_thresh=0.65, free_thresh=kept).encode(), picture)
        assert read.values.tolist() == [[100, -1, 0]] and not read.remark


@pytest.mark.parametrize(
    ("text", "picture", "says"),
    [
        (yaml_of(mode="odd"), pgm(drawn(1, 1)), "mode"),
        (yaml_of(resolution=0), pgm(drawn(1, 1)), "resolution"),
        (yaml_of(resolution="x"), pgm(drawn(1, 1)), "resolution"),
        (yaml_of(resolution=5), pgm(drawn(1, 1)), "Write metres"),
        (yaml_of(origin=[1, 2, 90.0]), pgm(drawn(1, 1)), "degrees"),
        (yaml_of(origin=[1, 2]), pgm(drawn(1, 1)), "origin"),
        (yaml_of(origin=[1, 2, float("nan")]), pgm(drawn(1, 1)), "origin"),
        (yaml_of(negate=7), pgm(drawn(1, 1)), "negate"),
        (yaml_of(free_thresh=0.7), pgm(drawn(1, 1)), "below"),
        (yaml_of().replace("occupied_thresh", "other"), pgm(drawn(1, 1)), "occupied_thresh"),
        ("{", pgm(drawn(1, 1)), "YAML"),
        (yaml_of(), pgm(drawn(1, 1))[:-5], "cut off"),
        (yaml_of(), png_of(drawn(3, 1))[:60], "cut off"),
        (yaml_of(), b"P5 13 9 255\n" + drawn(1, 1).tobytes(), "13 by 9"),
        (yaml_of(), b"P5 14 9 255\n" + drawn(1, 1).astype(">u2").tobytes(), "holds more"),
        (yaml_of(), b"P5 14 9 100\n" + drawn(1, 1).tobytes(), "brighter"),
        (yaml_of(), b"P2 2 1 255\n0 -1", "brighter"),
        (yaml_of(), b"P5 100000 100000 255\n", "cells"),
        (yaml_of(), b"P5 " + b"9" * 5000 + b" 1 255\n", "PGM"),
        (yaml_of(), b"", "PGM"),
        (yaml_of(), b"GIF89a" + bytes(40), "PGM"),
    ],
)
def test_what_is_no_map_gets_a_sentence(text: str, picture: bytes, says: str) -> None:
    with pytest.raises(BadInput, match=says):
        read_nav2_map(text.encode(), picture)


def packed(**files: bytes) -> bytes:
    box = io.BytesIO()
    with zipfile.ZipFile(box, "w") as made:
        for name, content in files.items():
            made.writestr(name.replace("_", "."), content)
    return box.getvalue()


def test_a_zip_needs_one_yaml_and_the_picture_that_it_names() -> None:
    text, picture = yaml_of().encode(), pgm(drawn(1, 1))
    whole = packed(m_yaml=text, m_pgm=picture, other_png=png_of(drawn(3, 1)))
    assert np.array_equal(read_nav2_zip(whole).values, read_nav2_map(text, picture).values)
    beside = zipfile.ZipFile(added := io.BytesIO(whole), "a")
    with beside:
        beside.writestr("__MACOSX/._m.yaml", b"\0\5\x16\7")
    assert np.array_equal(read_nav2_zip(added.getvalue()).values, read_nav2_map(text, picture).values)
    for poor in (
        b"",
        b"PK",
        whole[:-30],
        packed(m_yaml=text),
        packed(m_pgm=picture),
        packed(a_yaml=text, b_yaml=text, m_pgm=picture),
    ):
        with pytest.raises(BadInput, match="zip"):
            read_nav2_zip(poor)


def test_an_exported_map_is_the_same_after_a_round_trip() -> None:
    rng = np.random.default_rng(3)
    log_odds = rng.choice([0.0, 4.0, -4.0], (17, 31))
    text, picture = nav2_map(make_grid(log_odds, origin=(-1.25, 2.15)))
    assert nav2_map(laid_out(read_nav2_map(text.encode(), picture), 0.05)) == (text, picture)


def test_a_turned_or_finer_map_is_laid_with_all_its_walls() -> None:
    rng = np.random.default_rng(4)
    values = np.zeros((40, 60), np.int8)
    values[rng.random(values.shape) < 0.02] = 100
    for resolution, turn in ((0.05, 0.7), (0.02, 0.0), (0.1, -2.0), (0.05, math.pi / 2)):
        cells = Nav2Cells(values, resolution, (-1.313, 0.711, turn))
        grid = laid_out(cells, 0.05)
        row, column = np.argwhere(values == 100).T
        c, s = math.cos(turn), math.sin(turn)
        places = (np.column_stack((column, row)) + 0.5) * resolution @ np.array([[c, s], [-s, c]]) + (-1.313, 0.711)
        at = np.floor((places - grid.origin) / 0.05).astype(int)
        assert (grid.log_odds[at[:, 1], at[:, 0]] > 1.0).all()
        known = (grid.log_odds != 0).sum() * 0.05**2
        assert abs(known - values.size * resolution**2) < 0.1 * known
