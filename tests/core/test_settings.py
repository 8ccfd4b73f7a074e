"""Settings: a TOML file changes some of them, and every fault in it is a sentence."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.errors import BadInput
from core.settings import FORMER, Settings, load, read


def test_no_file_means_the_defaults() -> None:
    assert load(None) == Settings()
    assert read("") == Settings()


def test_a_file_changes_what_it_names_and_nothing_else(tmp_path: Path) -> None:
    file = tmp_path / "robot.toml"
    file.write_text('[steering]\nlookahead = 0.3\nsettle = 1\n[simulation]\nwheel_noise = "paper"\ncamera = false\n')
    changed = load(file)
    assert changed.steering == dataclasses.replace(Settings().steering, lookahead=0.3, settle=1.0)
    assert (changed.simulation.wheel_noise, changed.simulation.camera) == ("paper", False)
    assert changed.planner == Settings().planner


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("[steerin]\nlookahead = 1.0", "no section [steerin]; did you mean [steering]?"),
        ("[zzz]", "no section [zzz]; known are corners"),
        ("steering = 3", "must be a section"),
        ("[steering]\nlookahed = 1.0", "no setting lookahed; did you mean lookahead?"),
        ("[steering]\nlookahead = true", "lookahead must be a finite number"),
        ("[steering]\nlookahead = '0.3'", "lookahead must be a finite number"),
        ("[steering]\nlookahead = nan", "lookahead must be a finite number"),
        ("[steering]\nlookahead = inf", "lookahead must be a finite number"),
        ("[steering]\nlookahead = 40.0", "lookahead must lie between 0.05 and 1"),
        ("[steering]\nlookahead = -1.0", "lookahead must lie between 0 and"),
        ("[planner]\nstride = 0.0", "stride must lie between 0.02 and 1"),
        ("[corners]\npoints = 6.5", "points must be a whole number"),
        ("[corners]\npoints = true", "points must be a whole number"),
        ("[simulation]\nwheel_noise = 'loud'", "wheel_noise must be one of encoder, paper, none"),
        ("[simulation]\ncamera = 1", "camera must be true or false"),
        ("[limits]\nmax_speed = 99.0", "max_speed must be a number between"),
        ("[limits]\nguard = 'no'", "guard must be true or false"),
        ("[motion]\nmodel = 7", "model must be one of encoder, paper"),
        ("[steering", "is not valid TOML"),
        ("[steering]\nlookahead = ", "is not valid TOML"),
        ("a = " + "[" * 5000, "is not valid TOML"),
        ("lookahead = 9" + "9" * 5000, "is not valid TOML"),
        ("\x00", "is not valid TOML"),
    ],
)
def test_a_fault_is_told_in_a_sentence(text: str, sentence: str) -> None:
    with pytest.raises(BadInput) as told:
        read(text)
    assert sentence in str(told.value)
    assert len(str(told.value)) < 400


def test_a_missing_file_a_folder_and_a_binary_file_are_told_in_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    (tmp_path / "large.toml").write_bytes(b"#" * 1_000_001)
    for name in ("none.toml", "", "binary.toml", "large.toml"):
        with pytest.raises(BadInput, match=r"\.$"):
            load(tmp_path / name)


@given(st.text(max_size=200))
def test_any_text_gives_settings_or_a_sentence(text: str) -> None:
    for whole in (text, f"[steering]\nlookahead = {text}", f"[{text}]\nx = 1"):
        try:
            read(whole)
        except BadInput as told:
            assert str(told)


def test_every_default_would_be_accepted_from_a_file() -> None:
    for section in dataclasses.fields(Settings):
        part = getattr(Settings(), section.name)
        lines = [f"[{section.name}]"]
        for setting in dataclasses.fields(part):
            value = getattr(part, setting.name)
            if value is not None:
                lines.append(f"{setting.name} = {_toml(value)}")
        assert getattr(read("\n".join(lines)), section.name) == part


def _toml(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else repr(value)


@pytest.mark.parametrize(("former", "present"), FORMER.items())
def test_a_former_section_is_read_with_a_sentence(
    former: str, present: str, caplog: pytest.LogCaptureFixture
) -> None:
    assert read(f"[{former}]\n", "my.toml") == Settings()
    assert f"my.toml: [{former}] is now [{present}]" in caplog.text


def test_a_section_under_both_names_is_refused() -> None:
    with pytest.raises(BadInput, match=r"leave only \[submaps\]"):
        read("[floor]\n[submaps]\n")
