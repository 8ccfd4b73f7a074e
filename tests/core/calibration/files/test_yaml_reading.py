"""YAML as other programs write it, YAML that means harm, and YAML that is none."""

import time
import warnings
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.calibration.files.camera_files import kalibr_yaml, opencv_yaml, parse_camera, read_camera, ros_yaml
from core.calibration.files.yaml_reading import MAX_CHARACTERS, MAX_NODES, read_yaml
from core.errors import BadInput
from core.optics import TABLE_3

FORMS = (ros_yaml(TABLE_3), opencv_yaml(TABLE_3, board=(9, 6, 0.03)), kalibr_yaml(TABLE_3))
LONGEST_S = 2.0


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("a: 1e-05", {"a": 1e-5}),  # as yaml-cpp writes it
        ("%YAML 1.1\n---\na: 1e-05\nb: 010\nc: 1:30", {"a": 1e-5, "b": 10, "c": "1:30"}),
        ("# made by hand\n\n%YAML 1.1\n---\na: 010", {"a": 10}),
        ("%YAML:1.0\na: 2.", {"a": 2.0}),
        ("\ufeff%YAML:1.0\r\n---\r\na: -1.\r\n", {"a": -1.0}),
        ("a: yes\nb: off\nc: true\nd: ~", {"a": "yes", "b": "off", "c": True, "d": None}),
        ("a: 'it''s'\nb: \"tab\\there\"", {"a": "it's", "b": "tab\there"}),
        ("a: http://host:80/x#y # a comment", {"a": "http://host:80/x#y"}),
        ("a: {x: 1, y: {z: [1, 2]}}", {"a": {"x": 1, "y": {"z": [1, 2]}}}),
        ('{"a": [1.5, -2], "b": "c, d"}', {"a": [1.5, -2], "b": "c, d"}),
        ("a: [1, 2,\n  3]\nb:\n- 1\n- - 2\n  - 3", {"a": [1, 2, 3], "b": [1, [2, 3]]}),
        ("a:\n  words in\n  two lines", {"a": "words in two lines"}),
        ("a: |\n  one\n  two\n", {"a": "one\ntwo\n"}),
        ("a: &zero [0, 0]\nb: *zero", {"a": [0, 0], "b": [0, 0]}),  # PyYAML writes a list that stands twice like this
        ("? a\n: 1", {"a": 1}),
        ("a:\t1\nb: 2\t# m\nc: 3 \t\r\n\t\n\t# end\nd: [1,\t2]", {"a": 1, "b": 2, "c": 3, "d": [1, 2]}),
        (
            "m: !!opencv-matrix\n   rows: 1\n   cols: 2\n   dt: d\n   data: [ 1., -2.5e-01 ]",
            {"m": {"rows": 1, "cols": 2, "dt": "d", "data": [1.0, -0.25]}},
        ),
    ],
)
def test_valid_documents_are_read_by_the_rules_of_yaml(text: str, value: dict[str, Any]) -> None:
    found = read_yaml(text)
    assert found == value and [type(each) for each in found.values()] == [type(each) for each in value.values()]


def test_every_kind_of_node_that_opencv_writes_is_read(tmp_path: Path) -> None:
    path = tmp_path / "all.yml"
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    storage.write("flat", np.arange(12.0).reshape(3, 4))
    storage.write("deep", np.zeros((2, 2, 2)))
    storage.write("pairs", np.ones((40, 1, 2), np.float32))
    storage.write("words", 'a "quoted": text')
    storage.release()
    found = read_yaml(path.read_text())
    assert found["flat"]["data"] == list(range(12)) and len(found["deep"]["data"]) == 8
    assert len(found["pairs"]["data"]) == 80 and found["words"] == 'a "quoted": text'


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a: 1\na: 2", r"same name twice \(line 2\)"),
        ("a: [1, 2", "not valid YAML"),
        ("a: !!python/object/apply:os.system [x]", "not valid YAML"),
        ("a: !camera 1", "not valid YAML"),
        ("a: 1\n---\nb: 2", "not valid YAML"),
        ("a: \x00", "not valid YAML"),
        ("a: !!int many", "cannot be read"),
        ("a: 2026-13-45", "cannot be read"),
        (f"a: {'9' * 5000}", "cannot be read"),
        ("a: &a [*a]", "more than"),
        ("a: &a {b: *a}", "more than"),
        ("a: [" + "[" * 20 + "]" * 20 + "]", "nested deeper"),
        ("- 1\n- 2", "not one mapping"),
        ("", "not one mapping"),
        ("a: " + "x" * MAX_CHARACTERS, "longer than 128 kB"),
        ("a: [" + "1, " * MAX_NODES + "]", "more than"),
    ],
)
def test_what_is_no_camera_file_is_refused_with_its_reason(text: str, words: str) -> None:
    with pytest.raises(BadInput, match=words):
        read_yaml(text)


def test_aliases_that_unfold_to_millions_of_values_are_refused_in_an_instant() -> None:
    rows = ["a0: &a0 [1, 1, 1, 1]", *(f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 4)}]" for n in range(1, 11))]
    started = time.process_time()
    with pytest.raises(BadInput, match="more than"):
        read_yaml("\n".join(rows))
    assert time.process_time() - started < 0.5


@pytest.mark.parametrize(
    "piece", ["[", "{", "[[", '{"a":', "- ", "? ", "&a ", "*a ", "!!", "a: ", ", ", "'", "\n", "#\n"]
)
def test_no_long_text_takes_long(piece: str) -> None:
    text = piece * (MAX_CHARACTERS // len(piece))
    started = time.process_time()
    for beginning in ("", "a: ", "a: ["):
        with pytest.raises(BadInput):
            parse_camera((beginning + text)[:MAX_CHARACTERS])
    assert time.process_time() - started < 3 * LONGEST_S


@settings(deadline=None, max_examples=200)
@given(
    form=st.sampled_from(FORMS),
    at=st.floats(0, 1),
    taken=st.integers(0, 12),
    put=st.text(alphabet="[]{}:,#&*!|>%@`'\"-? \n\t\\.~<=_0x9eé\x00\ufeff", max_size=8),
)
def test_a_damaged_camera_file_gives_a_camera_or_a_sentence_and_no_warning(
    form: str, at: float, taken: int, put: str
) -> None:
    place = int(at * len(form))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            parse_camera(form[:place] + put + form[place + taken :])
        except BadInput as told:
            assert 10 < len(str(told)) < 200 and "\n" not in str(told)


@settings(deadline=None, max_examples=100)
@given(text=st.text(max_size=60))
def test_any_text_gives_a_mapping_or_a_sentence(text: str) -> None:
    try:
        assert isinstance(read_yaml(text), dict)
    except BadInput as told:
        assert str(told)


@pytest.mark.real_data
def test_malformed_files_are_refused_with_their_name_and_real_ones_read(shared_data: Path) -> None:
    names = sorted(
        path for path in (shared_data / "malformed").iterdir() if path.suffix in (".yaml", ".mcap", ".png")
    )
    assert names
    for path in names:
        with pytest.raises(BadInput, match=path.name):
            read_camera(path)
    published = shared_data / "chessboard-opencv-left" / "left_intrinsics.yml"
    assert read_yaml(published.read_text())["camera_matrix"]["rows"] == 3
