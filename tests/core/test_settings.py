"""Settings: a TOML file changes some of them, and every fault in it is a sentence."""

import dataclasses
import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.errors import BadInput, BadSettings
from core.perception.landmarks.corners import CornerSettings
from core.setting import DeclaredSetting, declared_settings, thresholds_of
from core.settings import FORMER, Settings, changed, load, read
from core.slam.ekf_slam import EkfSettings

SECTIONS = {one.name: type(getattr(Settings(), one.name)) for one in dataclasses.fields(Settings)}
NUMBERS = [
    (section, setting)
    for section, kind in SECTIONS.items()
    for setting in declared_settings(kind)
    if setting.kind in (int, float)
]
PARTNERS = {
    ("edges", "canny_low"): "canny_high = 1000.0",
    ("edges", "canny_high"): "canny_low = 1.0",
    ("direction_finding", "lowest"): "highest = 20000.0",
    ("direction_finding", "highest"): "lowest = 20.0",
    ("people", "nearest"): "farthest = 12.0",
}
"""What a setting at its bound needs beside it."""


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
        ("lookahead = 0.3", "lookahead stands before any section; write it under [steering]"),
        ("steering = 3", "must be a section"),
        ("[steering]\nlookahed = 1.0", "no setting lookahed; did you mean lookahead?"),
        ("[steering]\nlookahead = true", "lookahead must be a number, not true"),
        ("[steering]\nlookahead = '0.3'", "lookahead must be a number, not 0.3"),
        ("[steering]\nlookahead = nan", "lookahead must lie between 0.05 and 1 m, not nan"),
        ("[steering]\nlookahead = inf", "lookahead must lie between 0.05 and 1 m, not inf"),
        ("[steering]\nlookahead = 40.0", "[steering] lookahead must lie between 0.05 and 1 m, not 40.0."),
        ("[steering]\nlookahead = -1.0", "lookahead must lie between 0.05 and 1 m, not -1.0"),
        ("[planner]\nguard = 0.0", "guard must lie between 0.03 and 0.5 m, not 0.0"),
        ("[corners]\npoints = 6.5", "points must be a whole number, not 6.5"),
        ("[corners]\npoints = true", "points must be a whole number"),
        ("[simulation]\nwheel_noise = 'loud'", "wheel_noise must be one of encoder, paper, none, not loud"),
        ("[simulation]\ncamera = 1", "camera must be true or false"),
        ("[limits]\nmax_speed = 99.0", "max_speed must lie between 0.01 and 1 m/s, not 99.0"),
        ("[limits]\nguard = 'no'", "guard must be true or false"),
        ("[motion]\nmodel = 7", "model must be one of encoder, paper"),
        ("[steering]\nlookahead = 0x" + "f" * 5000, "lookahead must lie between 0.05 and 1 m, not a huge number"),
        ("[corners]\npoints = 1e400", "points must be a whole number, not inf"),
        ("[voice]\nvoice = 'klingon\u202e'", "voice must be one of en-us, "),
        ("[edges]\ncanny_low = 90.0", "canny_low must not exceed canny_high"),
        ("[people]\nnearest = 3.0\nfarthest = 2.0", "nearest must lie below farthest: 3 and 2 m."),
        ("[direction_finding]\nlowest = 900.0\nhighest = 800.0", "lowest must lie below highest"),
        ("[occupancy]\nresolution = 0.02\nwidest = 200.0", "widest must not exceed 5000 cells: 100 m."),
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
        for setting in declared_settings(type(part)):
            value = getattr(part, setting.name)
            if value is not None:
                lines.append(f"{setting.name} = {_toml(value)}")
        assert getattr(read("\n".join(lines)), section.name) == part


def _toml(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else repr(value)


def test_a_file_of_an_older_version_is_read_but_for_what_is_no_setting_any_more(
    caplog: pytest.LogCaptureFixture,
) -> None:
    """Every former setting stands in it, with a value that would not be accepted."""
    lines = [
        line
        for section, kind in SECTIONS.items()
        for line in (f"[{section}]", *(f"{name} = -7777.5" for name in sorted(thresholds_of(kind))))
    ]
    assert read("\n".join([*lines, ""]), "old.toml") == Settings()
    sentences = [one.message for one in caplog.records]
    assert len(sentences) == sum(bool(thresholds_of(kind)) for kind in SECTIONS.values()) > 20
    assert all("no longer" in one and "remove" in one for one in sentences)
    read("[ekf]\nsoft_slack = 3.0\ngate = 9.0", "older.toml")
    assert "older.toml: [ekf] soft_slack is no longer a setting: it is fixed at 2.0; remove it." in caplog.text


def test_an_option_that_is_no_setting_any_more_is_refused_with_its_value() -> None:
    with pytest.raises(
        BadSettings, match=r"^ekf\.soft_slack is no longer a setting: it is fixed at 2\.0; remove it\.$"
    ):
        changed(Settings(), {"ekf.soft_slack": 3.0})
    with pytest.raises(BadSettings, match=r"no setting ekf\.gatee; near are ekf\.gate, ekf\.soft_gate"):
        changed(Settings(), {"ekf.gatee": 3.0})


@pytest.mark.parametrize(("former", "present"), FORMER.items())
def test_a_former_section_is_read_with_a_sentence(
    former: str, present: str, caplog: pytest.LogCaptureFixture
) -> None:
    assert read(f"[{former}]\n", "my.toml") == Settings()
    assert f"my.toml: [{former}] is now [{present}]" in caplog.text


def test_a_section_under_both_names_is_refused() -> None:
    with pytest.raises(BadInput, match=r"leave only \[submaps\]"):
        read("[floor]\n[submaps]\n")


@pytest.mark.parametrize("name", SECTIONS)
def test_every_setting_declares_its_bounds_its_meaning_and_what_to_watch(name: str) -> None:
    declared = declared_settings(SECTIONS[name])
    assert {setting.name for setting in declared} == {*vars(SECTIONS[name]())} - thresholds_of(SECTIONS[name])
    for setting in declared:
        assert setting.meta.meaning and setting.watch, setting.name
        assert setting.fit(setting.default) == setting.default
        if setting.kind in (int, float):
            assert math.isfinite(setting.meta.low) and math.isfinite(setting.meta.high), setting.name
            assert setting.meta.low < setting.meta.high, setting.name


@pytest.mark.parametrize(("section", "setting"), NUMBERS, ids=lambda one: getattr(one, "name", one))
def test_a_setting_is_accepted_at_its_bounds_and_refused_just_outside(section: str, setting: DeclaredSetting) -> None:
    partner = PARTNERS.get((section, setting.name), "")
    for bound, beyond in ((setting.meta.low, -math.inf), (setting.meta.high, math.inf)):
        value = int(bound) if setting.kind is int else float(bound)
        outside = value + (1 if beyond > 0 else -1) if isinstance(value, int) else math.nextafter(value, beyond)
        accepted = read(f"[{section}]\n{setting.name} = {value!r}\n{partner}")
        assert getattr(getattr(accepted, section), setting.name) == value
        with pytest.raises(BadInput) as told:
            read(f"[{section}]\n{setting.name} = {outside!r}\n{partner}", "my.toml")
        sentence = (
            f"my.toml: [{section}] {setting.name} must lie between {setting.meta.low:g} and {setting.meta.high:g}"
        )
        assert str(told.value).startswith(sentence)
        assert str(told.value).endswith(f"{setting.meta.unit}, not {outside!r}.")


def test_a_section_made_in_code_is_checked_like_one_from_a_file() -> None:
    with pytest.raises(BadInput, match=r"lookahead must lie between 0\.05 and 1 m, not 1\.5\."):
        dataclasses.replace(Settings().steering, lookahead=1.5)
    with pytest.raises(BadInput, match="points must be a whole number"):
        CornerSettings(points=6.5)  # type: ignore[arg-type]
    with pytest.raises(BadInput, match="most must lie between"):
        EkfSettings(most=1)  # declared in a base of the section
